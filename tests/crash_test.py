#!/usr/bin/env python3
"""Kills `hggmap run` while a log is played to it, again and again, and checks that no more than the last seconds are lost.

usage: crash_test.py KILLS BUILD_DIR OUT      e.g. crash_test.py 200 build build/crash   (`make crash`)

A world of hgg-sim is played four times as fast as it was over LCM, under a memory budget that sends far parts of the map to disk, in a network namespace of its own (root, or user namespaces allowed). Two thirds of
the runs are killed (SIGKILL) at a random moment of mapping, the others while they save after Ctrl-C. Each run goes on from what the one
before left (--resume), every fifth begins anew. After each kill the directory must hold a map that loads and that has all that was
published up to the last write of the journal but one. Deterministic but for the scheduler: the moments are drawn with a fixed seed.
"""
import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

SNAPSHOT_S = 0.5
SPEED = 4  # s of the log in a second
SLACK_S = 2.0  # from one keyframe to the next, and for writing on a busy machine
# Near-sighted and with little memory, so that pages leave within a hundred metres.
KEYS = {"snapshot_s": SNAPSHOT_S, "budget_mb": 1.0, "range_max": 20.0, "active_radius": 20.0}
URL = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304"


def fail(text):
    sys.exit(f"crash_test: FAILED: {text}")


def call(*words):
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr


def prepare(build, out):
    """The log, and a config that writes the journal often."""
    if not (out / "street.lcm").exists():
        code, _, errors = call(build / "hgg-sim", "street", "--frames", 300, "--sensor", "lidar16", "-o", out / "street.lcm", "--truth", out / "truth", "--no-walk-grid")
        if code != 0:
            fail(f"hgg-sim: {errors}")
    _, config, _ = call(build / "hggmap", "run", "--print-config")
    lines = [f"{line.split()[0]} = {KEYS[line.split()[0]]}" if line and line.split()[0] in KEYS else line for line in config.splitlines()]
    (out / "hggmap.toml").write_text("\n".join(lines) + "\n")


def start(build, out, resumes):
    log = open(out / "run.log", "w")
    words = [build / "hggmap", "run", "--config", out / "hggmap.toml", "--lcm-url", URL, "--out", out / "run", *(["--resume"] if resumes else [])]
    mapper = subprocess.Popen([str(w) for w in words], stdout=log, stderr=log)
    for _ in range(400):
        if "listening to" in (out / "run.log").read_text():
            return mapper
        if mapper.poll() is not None:
            break
        time.sleep(0.05)
    fail(f"hggmap run does not listen: {(out / 'run.log').read_text()[-500:]}")


def last_published(run):
    """The stamp of the last pose that reached the disk, s; 0 where none did."""
    part = run / "live.tum.part"
    lines = [line for line in part.read_text().splitlines(keepends=True) if line.endswith("\n")] if part.exists() else []
    return float(lines[-1].split()[0]) if lines else 0


def keyframes_of(build, path, out):
    """The stamps of a map's keyframes in the order they were made, s."""
    code, _, errors = call(build / "hggmap", "export", path, "--format", "json", "-o", out / "map.json")
    if code != 0 and path.suffix == ".db" and (path.stat().st_size == 0 or "holds no map" in errors):
        return []  # killed before anything was written
    if code != 0:
        fail(f"{path} does not load: {errors}")
    return [k["utime"] / 1e6 for k in json.loads((out / "map.json").read_text())["keyframes"]]


def check(build, out, mapped_s, saves, before):
    """What became of the run; `before`: how many keyframes the map had when it began."""
    run = out / "run"
    maps = [p for p in (run / "journal.db", run / "map.hgg") if p.exists()]
    loaded = [keyframes for p in maps if (keyframes := keyframes_of(build, p, out))]
    if saves or mapped_s < SNAPSHOT_S + SLACK_S:
        return "loads" if loaded else "too early for a map"
    if not loaded or len(loaded[0]) <= before:
        fail(f"nothing is left of {mapped_s:.1f} s")
    lost = (last_published(run) - loaded[0][-1]) / SPEED
    if lost > 2 * SNAPSHOT_S + SLACK_S:
        fail(f"{lost:.1f} s are lost")
    return f"{max(lost, 0):.1f} s lost"


def one_kill(build, out, draw, number):
    resumes = number % 5 != 0
    saves = number % 3 == 2
    left = [keyframes_of(build, p, out) for p in (out / "run" / "journal.db", out / "run" / "map.hgg") if p.exists()]
    before = next((len(keyframes) for keyframes in left if keyframes), 0) if resumes else 0
    mapper = start(build, out, resumes)
    player = subprocess.Popen(["lcm-logplayer", "-s", str(SPEED), f"--lcm-url={URL}", str(out / "street.lcm")], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    mapped_s = draw.uniform(0.3, 5.0)
    time.sleep(mapped_s)
    if saves:
        mapper.send_signal(signal.SIGINT)
        time.sleep(draw.uniform(0.0, 0.3))
    mapper.kill()
    mapper.wait()
    player.kill()
    player.wait()
    return f"{'saving' if saves else 'mapping'} after {mapped_s:.1f} s: {check(build, out, mapped_s, saves, before)}"


def main(argv):
    if len(argv) == 4:
        root = [] if os.getuid() == 0 else ["--map-root-user"]
        os.execvp("unshare", ["unshare", "--net", *root, sys.executable, argv[0], "--inside", *argv[1:]])
    if len(argv) != 5 or argv[1] != "--inside":
        print(__doc__)
        return 2
    kills, build, out = int(argv[2]), Path(argv[3]).resolve(), Path(argv[4]).resolve()
    call("rm", "-rf", out / "run")
    out.mkdir(parents=True, exist_ok=True)
    call("ip", "link", "set", "lo", "up")
    call("ip", "route", "add", "224.0.0.0/4", "dev", "lo")
    prepare(build, out)
    draw = random.Random(1)
    for number in range(kills):
        print(f"[{number + 1}/{kills}] {one_kill(build, out, draw, number)}", flush=True)
    mapper = start(build, out, True)
    mapper.send_signal(signal.SIGINT)
    mapper.wait()
    left = [p.name for p in (out / "run").iterdir() if p.name.endswith(".tmp")]
    if left:
        fail(f"temporary files are left: {left}")
    print(f"crash_test: passed: {kills} kills, every map loads")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv))
