#!/usr/bin/env python3
"""Measures everything: simulates the worlds, maps them, holds the maps against the truth, writes docs/evaluation.md and .html.

examples: tools/evaluate.py                      the whole matrix (hours; stops and goes on where it was)
          tools/evaluate.py --quick              a small matrix, for CI (minutes)
          tools/evaluate.py --only niw,retrieval  some tables, printed and not written to the document

Logs, maps and results are kept in --out, each under the hash of what made it (programs, arguments, config): a run that was
interrupted goes on, a changed program is measured again, a changed hgg-eval on the maps there are. Standard library only.
Exit codes: 0 done, 1 something failed (the tables say where, the end says why), 2 bad usage, 130 stopped.
"""
import argparse
import concurrent.futures
import dataclasses
import datetime
import hashlib
import json
import math
import os
import platform
import re
import shutil
import signal
import statistics
import subprocess
import sys
import threading
import time
from pathlib import Path

REPO = Path(__file__).resolve().parent.parent
INDOOR = {"apartment", "office", "hall"}
ODOMETRY = ["true", "excellent", "good", "poor"]
SENSOR_WORLDS = ["street", "office"]  # --full and --worlds take others
SENSOR_FRAMES = 300
NOT_YET = "not yet"
FAILED = "failed"


# ---- what is run -----------------------------------------------------------------------------------------------------

@dataclasses.dataclass(frozen=True)
class Drive:
    """One log: a world and what the robot carries. It holds odometry of every quality."""
    world: str
    sensor: str
    seed: int
    frames: int = 0
    busy: bool = False
    path: tuple = ()  # true and odometry poses of a real drive, instead of a world
    confusion: float = 0  # share of objects a frame under a wrong name; 0: as a good segmenter has it

    def arguments(self):
        where = ["--path", *self.path] if self.path else [self.world]
        return [*where, "--sensor", self.sensor, "--seed", str(self.seed), "--frames", str(self.frames),
                *(["--dynamics"] if self.busy else []), *(["--confusion", str(self.confusion)] if self.confusion else [])]

    def identity(self):
        """What the log depends on: the arguments, with files by their content."""
        paths = set(self.path)
        return [hash_of(a) if a in paths else a for a in self.arguments()]

    def name(self):
        return f"{self.world} {self.sensor} {'busy ' if self.busy else ''}{f'confusion {self.confusion} ' if self.confusion else ''}seed {self.seed}"


@dataclasses.dataclass(frozen=True)
class Run:
    """A drive, mapped with odometry of some quality and some switches of the config: (("ablation.symmetric_merge", "true"),)."""
    drive: Drive
    odometry: str
    switches: tuple = ()

    def channel(self):
        return "POSE_ODOM" if self.drive.path else f"POSE_ODOM_{self.odometry.upper()}"

    def name(self):
        return f"{self.drive.name()} {self.odometry} odometry" + "".join(f" {key}={value}" for key, value in self.switches)


def is_indoor(world):
    return world in INDOOR


def main_sensor(world):
    return "rgbd" if is_indoor(world) else "lidar64"


def radius_of(world):
    return 0.5 if is_indoor(world) else 1.5


def spacing_of(world):
    return 0.05 if is_indoor(world) else 0.1


def beam_spacing_of(sensor, world):
    """Degrees between beams, which clustering has to bridge; None keeps the shipped value."""
    indoor = {"lidar16": 2.0, "lidar64": 0.72, "rig": 0.72, "lidar128": 0.36, "solid": 0.26}
    outdoor = {"lidar16": 2.0, "lidar128": 0.32, "solid": 0.26}
    return (indoor if is_indoor(world) else outdoor).get(sensor)


# ---- the workshop: programs, cache, commands ----------------------------------------------------------------------------

def digest(*parts):
    return hashlib.sha1("\0".join(parts).encode()).hexdigest()[:16]


def hash_of(path):
    return hashlib.sha1(Path(path).read_bytes()).hexdigest()


def set_keys(toml, values):
    """The TOML text with "section.key" -> value set; keys it does not have are appended to their section, which is made where it is missing."""
    section, left, parts = "", dict(values), {"": []}
    for line in toml.splitlines():
        if line.startswith("["):
            section = line[1:line.index("]")]
        name = line.split("=")[0].strip() if "=" in line and not line.startswith("#") else ""
        key = f"{section}.{name}" if section else name
        parts.setdefault(section, []).append(f"{name} = {left.pop(key)}" if key in left else line)
    for key, value in left.items():
        section, _, name = key.rpartition(".")
        lines = parts.setdefault(section, [f"[{section}]"])
        end = len(lines)
        while end > 0 and not lines[end - 1].strip():
            end -= 1
        lines.insert(end, f"{name} = {value}")
    return "\n".join(line for lines in parts.values() for line in lines) + "\n"


class CommandFailed(Exception):
    pass


class Stopped(KeyboardInterrupt):
    """Somebody asked for the end; nothing may take it for a failure."""


FAULTS = (CommandFailed, OSError, ValueError, LookupError, TypeError, AttributeError, ArithmeticError)  # what a bad answer can lead to


def told(error):
    return str(error) if isinstance(error, CommandFailed) else f"{type(error).__name__}: {error}"


def parsed(text, command):
    try:
        return json.loads(text)
    except ValueError as error:
        raise CommandFailed(f"{command}: not JSON: {error}") from error


class Workshop:
    """Runs programs and remembers what came out."""

    def __init__(self, build, out, keep_gb, threads):
        self.build, self.out, self.keep_bytes, self.threads = Path(build), Path(out), keep_gb * 1e9, threads
        self.programs = {name: hash_of(self.build / name) for name in ("hgg-sim", "hggmap", "hgg-eval")}
        self.config_keys = self._config_keys()
        self.commands = self._commands()
        self.pinned, self.in_use = set(), []  # drives
        self.errors = []
        self._lock, self._stopping, self._children = threading.Lock(), False, set()

    def _config_keys(self):
        printed = subprocess.run([self.build / "hggmap", "run", "--print-config"], capture_output=True, text=True).stdout
        keys, section = set(), ""
        for line in printed.splitlines():
            section = line[1:line.index("]")] + "." if line.startswith("[") else section
            if " = " in line and not line.startswith("#"):
                keys.add(section + line.split(" = ")[0])
        return keys

    def _commands(self):
        """The subcommands in the help; `hggmap WORD --help` succeeds for every word."""
        text = subprocess.run([self.build / "hggmap", "--help"], capture_output=True, text=True).stdout
        return set(re.findall(r"^  (\w+)", text.partition("\nSubcommands:\n")[2].partition("\n\n")[0], re.M))

    def has_switches(self, switches):
        return all(key in self.config_keys for key, _ in switches)

    def execute(self, command, accept=(0,)):
        """What the command printed. It is out of the terminal's reach: Ctrl-C ends it through halt(), never half way to success."""
        command = list(map(str, command))
        with self._lock:
            if self._stopping:
                raise Stopped
            child = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                     start_new_session=True)
            self._children.add(child)
        try:
            printed, complaints = child.communicate()
        except BaseException:
            child.kill()
            child.wait()
            raise
        finally:
            self._children.discard(child)
        if self._stopping:
            raise Stopped
        if child.returncode not in accept:
            reason = (complaints.strip().splitlines() or [f"exit {child.returncode}"])[-1]
            raise CommandFailed(f"{' '.join(command)}: {reason}")
        return printed

    def call(self, program, *arguments, accept=(0,)):
        return self.execute([self.build / program, *arguments], accept)

    def halt(self):
        """Ends what is running and lets nothing start any more."""
        with self._lock:
            self._stopping = True
            children = list(self._children)
        for child in children:
            child.terminate()
        patience = time.monotonic() + 5
        while any(child.poll() is None for child in children) and time.monotonic() < patience:
            time.sleep(0.05)
        for child in children:
            child.kill()

    def tried(self, what, make):
        """make(), or None with the reason kept for the end."""
        try:
            return make()
        except FAULTS as error:
            self.errors.append(f"{what}: {told(error)}")
            return None

    def drive_dir(self, drive):
        return self.out / "drives" / f"{self.programs['hgg-sim'][:8]}-{digest(*drive.identity())}"

    def simulate(self, drive):
        """Makes log.lcm and truth/ where they are missing."""
        where = self.drive_dir(drive)
        if (where / "done").exists():
            return where
        shutil.rmtree(where, ignore_errors=True)
        where.mkdir(parents=True)
        self.call("hgg-sim", *drive.arguments(), "-o", where / "log.lcm", "--truth", where / "truth", "--threads", self.threads)
        (where / "done").write_text(" ".join(drive.arguments()) + "\n")
        return where

    def release(self):
        """Drops logs while the cache is too large, those of another hgg-sim first, then the oldest; the results stay."""
        with self._lock:
            kept = {self.drive_dir(drive).name for drive in [*self.pinned, *self.in_use]}
            found, size = [], 0
            for log in (self.out / "drives").glob("*/log.lcm"):
                try:
                    stat = log.stat()
                except OSError:
                    continue  # another process was faster
                size += stat.st_size
                ours = log.parent.name.startswith(self.programs["hgg-sim"][:8] + "-")
                if log.parent.name not in kept:
                    found.append((ours, stat.st_mtime, stat.st_size, log.parent))
            for _, _, bytes_, where in sorted(found):
                if size <= self.keep_bytes:
                    break
                (where / "done").unlink(missing_ok=True)
                shutil.rmtree(where, ignore_errors=True)
                size -= bytes_

    def config(self, run):
        space = "indoor" if is_indoor(run.drive.world) else "semantickitti"
        folder = REPO / "firmware_cfg" / space
        values = {"classes": json.dumps(str(folder / "classes.toml")), "lcm.odometry": json.dumps(run.channel()),
                  **dict(run.switches)}
        beams = beam_spacing_of(run.drive.sensor, run.drive.world)
        if beams is not None:
            values["creation.beam_spacing_deg"] = str(beams)
        return set_keys((folder / "hggmap.toml").read_text(), values)

    # What the programs are told. The names of files are arguments here, so that the same lines make the command and its key.

    def replay_command(self, drive, where, out):
        return ["replay", drive / "log.lcm", "--config", where / "config.toml", "--out", out]

    def query_command(self, drive, where):
        return ["query", where / "map.hgg", "--batch", drive / "truth" / "queries.jsonl"]

    def score_command(self, run, drive, where, out, answers):
        return ["--map", where / "map.hgg", "--truth", drive / "truth", "--trajectory", where / "trajectory.tum",
                "--log", drive / "log.lcm", "--odometry-channel", run.channel(), "--radius", radius_of(run.drive.world),
                "--spacing", spacing_of(run.drive.world), "--html", out / "report.html", "--title", run.name(), "--json",
                *(["--answers", out / "answers.jsonl"] if answers else [])]

    def align_command(self, a, b):
        return ["align", a / "map.hgg", b / "map.hgg", "--json"]

    def map_dir(self, run):
        drive, where = Path("DRIVE"), Path("MAP")
        classes = hash_of(REPO / "firmware_cfg" / ("indoor" if is_indoor(run.drive.world) else "semantickitti") / "classes.toml")
        return self.out / "maps" / digest(self.drive_dir(run.drive).name, self.programs["hgg-sim"], self.programs["hggmap"],
                                          *words(self.replay_command(drive, where, where)), self.config(run), classes)

    def run_dir(self, run):
        drive, where, out = Path("DRIVE"), Path("MAP"), Path("OUT")
        asked = "query" in self.commands
        return self.out / "runs" / digest(self.map_dir(run).name, self.programs["hgg-eval"],
                                          *words(self.score_command(run, drive, where, out, asked)),
                                          *(words(self.query_command(drive, where)) if asked else []))

    def map(self, run):
        """The folder of the run's map, which is made where it is missing."""
        where = self.map_dir(run)
        if (where / "done").exists():
            return where
        drive = self.simulate(run.drive)
        shutil.rmtree(where, ignore_errors=True)
        where.mkdir(parents=True)
        (where / "config.toml").write_text(self.config(run))
        self.call("hggmap", *self.replay_command(drive, where, where))
        (where / "done").write_text(run.name() + "\n")
        return where

    def evaluate(self, run):
        """The figures of a run, from the cache or by making them. The report stays beside them."""
        out = self.run_dir(run)
        result = out / "result.json"
        if result.exists():
            return json.loads(result.read_text())
        drive, where = self.simulate(run.drive), self.map(run)
        shutil.rmtree(out, ignore_errors=True)
        out.mkdir(parents=True)
        answers = "query" in self.commands and (drive / "truth" / "queries.jsonl").exists()
        if answers:
            (out / "answers.jsonl").write_text(self.call("hggmap", *self.query_command(drive, where), accept=(0, 1)))
        command = self.score_command(run, drive, where, out, answers)
        figures = compact(self.call("hgg-eval", *command), f"hgg-eval {' '.join(words(command))}")
        save(result, figures)
        return figures

    def time(self, run):
        """stats.json of a replay that had the machine to itself."""
        where = self.map(run)
        result = where / f"alone_{digest(machine())}.json"
        if not result.exists():
            drive = self.simulate(run.drive)
            self.call("hggmap", *self.replay_command(drive, where, where / "alone"))
            save(result, parsed((where / "alone" / "stats.json").read_text(), f"hggmap replay of {run.name()}, stats.json"))
            shutil.rmtree(where / "alone")
        return json.loads(result.read_text())

    def align(self, run_a, run_b):
        """The answer of hggmap align, cached beside map b."""
        a, b = self.map(run_a), self.map(run_b)
        result = b / f"align_{digest(a.name, *words(self.align_command(Path('A'), Path('B'))))}.json"
        if not result.exists():
            answer = parsed(self.call("hggmap", *self.align_command(a, b), accept=(0, 1)), f"hggmap align of {run_a.name()} and {run_b.name()}")
            if not isinstance(answer, dict) or "accepted" not in answer:
                raise CommandFailed(f"hggmap align of {run_a.name()} and {run_b.name()}: the answer does not say if it is accepted")
            save(result, answer)
        return json.loads(result.read_text())


def words(arguments):
    return list(map(str, arguments))


def save(path, data):
    """Whole or not at all, so that an interrupted run leaves nothing half."""
    part = path.with_suffix(".part")
    part.write_text(json.dumps(data))
    part.rename(path)


def compact(printed, command):
    """hgg-eval's answer without its lists of objects and loops."""
    scores = parsed(printed, command)
    try:
        for score in [scores["overall"], *scores["classes"]]:
            score["missed"], score["ghosts"] = len(score["missed"]), len(score["ghosts"])
            del score["matches"]
        (scores.get("cost") or {}).pop("loops", None)
    except (LookupError, TypeError, AttributeError) as error:
        raise CommandFailed(f"{command}: its JSON is not as expected: {told(error)}") from error
    return scores


class Progress:
    """A bar on a terminal, a line a step elsewhere."""

    def __init__(self, total):
        self.total, self.done, self.start = total, 0, time.monotonic()
        self._lock = threading.Lock()

    def step(self, text):
        with self._lock:
            self.done += 1
            left = (time.monotonic() - self.start) / self.done * (self.total - self.done)
            bar = "#" * (24 * self.done // self.total)
            line = f"[{bar:.<24}] {self.done}/{self.total} {text}, {left / 60:.0f} min left"
            end = "" if sys.stderr.isatty() and self.done < self.total else "\n"
            print(("\r\x1b[K" if sys.stderr.isatty() else "") + line, end=end, file=sys.stderr, flush=True)


def run_all(workshop, runs, jobs):
    """Figures by run. Runs that share a drive share its log; {"error": text} where something failed."""
    by_drive = {}
    for run in dict.fromkeys(runs):
        by_drive.setdefault(run.drive, []).append(run)
    progress, figures = Progress(sum(map(len, by_drive.values()))), {}

    def work(drive):
        workshop.in_use.append(drive)
        try:
            for run in by_drive[drive]:
                try:
                    figures[run] = workshop.evaluate(run)
                except FAULTS as error:
                    figures[run] = {"error": f"{run.name()}: {told(error)}"}
                progress.step(run.name())
        except Stopped:
            return
        workshop.in_use.remove(drive)
        try:
            workshop.release()
        except OSError:
            pass  # a file of a drive is missing; its runs have said so

    drives = sorted(by_drive, key=lambda d: d not in workshop.pinned)
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        try:
            list(pool.map(work, drives))
        except KeyboardInterrupt:
            workshop.halt()
            raise
    return figures


# ---- figures to text -----------------------------------------------------------------------------------------------------

def dig(figures, path):
    """A number inside the figures; None where it is missing."""
    for key in path.split("."):
        figures = figures.get(key) if isinstance(figures, dict) else None
    return figures if isinstance(figures, (int, float)) else None


def spread(values, digits=2):
    """Mean and sample deviation: "0.91 ± 0.02"; "0.91 ± 0.02 (2 of 3)" where one has no value."""
    there = [v for v in values if v is not None]
    if not there:
        return "–"
    mean = statistics.fmean(there)
    text = f"{mean:.{digits}f}" if abs(mean) < 1e4 else f"{mean:.2e}"
    if len(there) > 1:
        deviation = statistics.stdev(there)
        text += f" ± {deviation:.{digits}f}" if abs(mean) < 1e4 else f" ± {deviation:.0e}"
    return text if len(there) == len(values) else f"{text} ({len(there)} of {len(values)})"


def cells(results, columns):
    """A cell per (path, digits) column over the seeds' figures; path None: a column no stage fills yet."""
    if not results:
        return ["not run"] * len(columns)
    if any("error" in r for r in results):
        return [FAILED] * len(columns)
    return [spread([dig(r, path) for r in results], digits) if any(dig(r, path) is not None for r in results) else NOT_YET
            for path, digits in columns]


def over_seeds(results, columns):
    """A cell per (path, how, digits) column: how, such as sum or max, makes one figure of all seeds'."""
    if not results:
        return ["not run"] * len(columns)
    if any("error" in r for r in results):
        return [FAILED] * len(columns)
    return [of_all([dig(r, path) for r in results], how, digits) if any(dig(r, "loops.asked") is not None for r in results) else NOT_YET
            for path, how, digits in columns]


def of_all(values, how, digits):
    there = [v for v in values if v is not None]
    return f"{how(there):.{digits}f}" if there else "–"


LOOP_COLUMNS = [("loops.accepted", sum, 0), ("loops.false", sum, 0)]
LOOP_DETAILS = [("loops.asked", sum, 0), *LOOP_COLUMNS, ("loops.worst_m", max, 2), ("loops.worst_deg", max, 2),
                ("loops.revisits", sum, 0), ("loops.revisits_asked", sum, 0), ("loops.revisits_closed", sum, 0)]


@dataclasses.dataclass
class Table:
    name: str
    title: str
    text: str
    header: list
    rows: list
    left: int = 1  # columns of words

    def markdown(self):
        rule = ["---"] * self.left + ["---:"] * (len(self.header) - self.left)
        return "\n".join("| " + " | ".join(map(str, row)) + " |" for row in [self.header, rule, *self.rows])


OBJECT_COLUMNS = [("overall.truth", 0), ("overall.position_error.mean", 2), ("overall.recall", 2), ("overall.precision", 2),
                  ("overall.f1", 2), ("overall.extent_error.mean", 2), ("overall.calibration.mean_over_3", 0),
                  ("overall.calibration.inside_90", 2), ("overall.calibration.mean_sigma", 2)]
OBJECT_HEADER = ["objects", "position, m", "recall", "precision", "F1", "extent, m", "NEES / 3", "inside 90 %", "sigma, m"]


class Matrix:
    """Which runs each table needs, and the table once they are there."""

    def __init__(self, workshop, args):
        self.workshop, self.args, self.figures, self.timing = workshop, args, {}, {}

    # What to run: a method a table, all from these.

    def runs(self, world, sensor=None, odometry="good", switches=(), busy=False, frames=None):
        frames = self.args.frames if frames is None else frames
        return [Run(Drive(world, sensor or main_sensor(world), seed, frames, busy), odometry, switches) for seed in self.args.seeds]

    def results(self, runs):
        return [self.figures[run] for run in runs if run in self.figures]

    def object_runs(self):
        return [run for world in self.args.worlds for odometry in self.args.odometry
                for run in self.runs(world, None, odometry)]

    def sensors_of(self, world):
        fit = [s for s in self.args.sensors if s != "rgbd" or is_indoor(world)]
        return fit if self.args.full or self.args.quick else [s for s in fit if s not in ("lidar16", "lidar128") or not is_indoor(world)]

    def sensor_odometry(self):
        return self.args.odometry if self.args.full else [o for o in self.args.odometry if o == "good"] or self.args.odometry[:1]

    def sensor_runs(self):
        return [run for world in self.args.sensor_worlds for sensor in self.sensors_of(world) for odometry in self.sensor_odometry()
                for run in self.runs(world, sensor, odometry, frames=self.sensor_frames())]

    def sensor_frames(self):
        """Short drives: sensors are compared with each other, not with the other tables."""
        return self.args.frames or (0 if self.args.full else SENSOR_FRAMES)

    def busy_runs(self):
        return [run for world in self.args.worlds for run in self.runs(world, busy=True)]

    NIW = [("evidence (NIW)", ()), ("symmetric average", (("ablation.symmetric_merge", "true"),)),
           ("symmetric average, uniform weights", (("ablation.symmetric_merge", "true"), ("ablation.uniform_weights", "true")))]

    def niw_odometry(self):
        return [o for o in ("true", "good") if o in self.args.odometry]

    def niw_runs(self):
        return [run for world in self.args.worlds for odometry in self.niw_odometry() for _, switches in self.NIW
                if self.workshop.has_switches(switches) for run in self.runs(world, None, odometry, switches)]

    CORRECTION = [(False, False), (True, False), (False, True), (True, True)]  # EM, loops
    # Poses are odometry's and the map is never asked, so that there is drift to close. The others say how good that odometry is:
    # the shipped values are those of wheels, wide enough for alignment to correct.
    ODOMETRY_POSE = (("ablation.odometry_pose", "true"), ("alignment.odometry_drift", "0.01"), ("alignment.odometry_turn_deg", "0.03"))
    POSES = {"map": (), "odometry": ODOMETRY_POSE}
    LOOP_WORLDS = ["hall", "street"]  # columns alike, and houses alike

    PAIRING = [(cost, (("ablation.cost", json.dumps(cost)),)) for cost in ("wasserstein", "centroid", "iou")]
    CONFUSION, CONFUSED_ODOMETRY = 0.05, ["true", "good", "poor"]

    def confusion_runs_of(self, world, odometry):
        return [Run(Drive(world, main_sensor(world), seed, self.args.frames, confusion=self.CONFUSION), odometry) for seed in self.more_seeds()]

    def confusion_odometry(self):
        return [o for o in self.CONFUSED_ODOMETRY if o in self.args.odometry]

    def confusion_runs(self):
        return [run for world in self.args.sensor_worlds for odometry in self.confusion_odometry() for run in self.confusion_runs_of(world, odometry)]

    def more_seeds(self):
        """For tables whose rows differ little: at least MORE_SEEDS."""
        seeds = self.args.seeds if self.args.quick else [*self.args.seeds, *(s for s in range(1, 100) if s not in self.args.seeds)]
        return seeds[:max(len(self.args.seeds), self.MORE_SEEDS)]

    GATES = {"shipped": lambda world: (), "three times": lambda world: (("alignment.gate", "3.0" if is_indoor(world) else "9.0"),)}
    MORE_SEEDS = 5

    def pairing_runs_of(self, world, gate, switches):
        return [Run(Drive(world, main_sensor(world), seed, self.args.frames), self.correction_odometry(), (*switches, *self.GATES[gate](world)))
                for seed in self.more_seeds()]

    def pairing_runs(self):
        return [run for world in self.args.sensor_worlds for gate in self.GATES for _, switches in self.PAIRING
                if self.workshop.has_switches(switches) for run in self.pairing_runs_of(world, gate, switches)]

    def correction_switches(self, em, loops):
        """None where a stage that is to run is missing; one that is not to run may be."""
        wanted = (("correction.em", em), ("correction.loop_closure", loops))
        switches = tuple((key, str(on).lower()) for key, on in wanted if on or self.workshop.has_switches([(key, on)]))
        return switches if self.workshop.has_switches(switches) else None

    def drift_switches(self, loops):
        return (*self.ODOMETRY_POSE, ("correction.loop_closure", str(loops).lower()))

    def correction_odometry(self):
        return "poor" if "poor" in self.args.odometry else self.args.odometry[-1]

    def correction_runs(self):
        kinds = [self.correction_switches(*row) for row in self.CORRECTION] + [self.drift_switches(loops) for loops in (False, True)]
        return [run for world in self.args.worlds for switches in kinds if switches is not None and self.workshop.has_switches(switches)
                for run in self.runs(world, None, self.correction_odometry(), switches)]

    def loop_rows(self):
        """(words of the row, its runs): whole ways, as a loop takes one."""
        rows = {}
        for poses, switches in self.POSES.items():
            for run in self.path_runs():
                rows.setdefault((run.drive.world, run.odometry, poses), []).append(dataclasses.replace(run, switches=switches))
            for world in (w for w in self.args.worlds if self.args.quick or w in self.LOOP_WORLDS):
                for odometry in self.loop_odometry():
                    rows[world, odometry, poses] = [Run(Drive(world, main_sensor(world), seed, self.args.frames if self.args.quick else 0), odometry, switches)
                                                    for seed in self.more_seeds()]
        return sorted(rows.items(), key=lambda row: (not row[0][0].startswith("along"), row[0][:2]))

    def loop_odometry(self):
        return [o for o in ("good", "poor") if o in self.args.odometry] or self.args.odometry[-1:]

    def loop_runs(self):
        return [run for _, runs in self.loop_rows() for run in runs if self.workshop.has_switches(run.switches)]

    WINDOWS = {"as shipped": (), "without window": (("correction.window", "false"),)}

    def calibration_rows(self):
        """(world, window, its runs): the two worlds that are judged first."""
        judged = [w for w in SENSOR_WORLDS if w in self.args.worlds]
        return [(world, window, [Run(Drive(world, main_sensor(world), seed, self.args.frames), self.calibration_odometry(), switches)
                                 for seed in self.more_seeds()])
                for world in [*judged, *(w for w in self.args.worlds if w not in judged)] for window, switches in self.WINDOWS.items()
                if not switches or world in self.args.sensor_worlds]

    def calibration_odometry(self):
        return "good" if "good" in self.args.odometry else self.args.odometry[0]

    def calibration_runs(self):
        return [run for _, _, runs in self.calibration_rows() for run in runs if self.workshop.has_switches(run.switches)]

    def path_runs(self):
        folder = self.args.data / "kitti_trajectories"
        if self.args.quick or not folder.is_dir():
            return []
        files = [(n, str(folder / f"{n}_gt.txt"), str(folder / f"{n}_odometry.txt")) for n in self.args.paths]
        return [Run(Drive(f"along KITTI {n}", "lidar64", seed, 0, False, (gt, odometry)), "real front-end")
                for n, gt, odometry in files for seed in self.args.seeds]

    def timing_runs(self):
        return [self.runs(world)[0] for world in self.args.worlds]

    # The tables.

    def objects(self):
        rows = [[world, main_sensor(world), odometry, *cells(self.results(self.runs(world, None, odometry)), OBJECT_COLUMNS)]
                for world in self.args.worlds for odometry in self.args.odometry]
        return Table("objects", "Objects, by world and odometry", f"""
Things of the same class within {radius_of('street')} m (outdoors) or {radius_of('office')} m (indoors), closest pairs first. The map is laid over the truth by its trajectory
before matching. Extent: 2-Wasserstein distance to the true Gaussian. NEES / 3: mean normalised squared position error over
its degrees of freedom, 1 for an honest belief, larger for one that trusts itself too much; the 90 % region should hold 0.9.
Sigma: the standard deviation of position the map publishes, an axis, root mean square; an honest one is the position error's size.
"(2 of 3)": that many seeds have the figure.""",
                     ["world", "sensor", "odometry", *OBJECT_HEADER], rows, 3)

    def sensors(self):
        rows = [[world, sensor, odometry, *cells(self.results(self.runs(world, sensor, odometry, frames=self.sensor_frames())), OBJECT_COLUMNS)]
                for world in self.args.sensor_worlds for sensor in self.sensors_of(world) for odometry in self.sensor_odometry()]
        frames = self.sensor_frames()
        return Table("sensors", "Objects, by sensor", f"""
{"One world out of doors and one in, seen" if self.args.sensor_worlds == SENSOR_WORLDS else "Worlds seen"} through other eyes{f", {frames} frames of each drive" if frames else ""}. The config is the one shipped for the label set; only the angle between beams is the
sensor's. `rig` labels the LiDAR's points through three cameras.{" `--full` adds the other worlds and odometry." if not self.args.full else ""}""", ["world", "sensor", "odometry", *OBJECT_HEADER], rows, 3)

    def busy(self):
        rows = [[world, main_sensor(world), *cells(self.results(self.runs(world, busy=True)), [*OBJECT_COLUMNS, ("overall.set_aside", 0)])]
                for world in self.args.worlds]
        return Table("busy", "Objects, while the world moves", """
People and cars move, and objects are moved or taken away between laps (`hgg-sim --dynamics`). True objects that move or are
taken away do not count. For each of them one map object that matches it is set aside, neither found nor a ghost; only what the
map holds of it beyond that one, such as a trail, is a ghost.""", ["world", "sensor", *OBJECT_HEADER, "set aside"], rows, 2)

    def trajectory(self):
        columns = [("trajectory.share", 2), ("odometry.ate_rmse", 2), ("trajectory.ate_rmse", 2), ("odometry.relative.translation_m_per_100m", 2),
                   ("trajectory.relative.translation_m_per_100m", 2), ("odometry.relative.rotation_deg_per_100m", 2),
                   ("trajectory.relative.rotation_deg_per_100m", 2)]
        runs = {(world, odometry): self.runs(world, None, odometry) for world in self.args.worlds for odometry in self.args.odometry
                if odometry != "true"}
        for run in self.path_runs():
            runs.setdefault((run.drive.world, run.odometry), []).append(run)
        rows = [[*key, *cells(self.results(r), columns)] for key, r in runs.items()]
        return Table("trajectory", "Trajectory", f"""
Poses: the share of true poses that have an estimate. ATE: RMSE of positions after the best rigid fit. Drift: error of the motion over stretches of 100 m of true path (half the path
where it is shorter than 200 m), per 100 m. In: the odometry that was fed in; out: what the mapper made of it. "Along KITTI":
a made-up world along the whole true way of that drive, with the odometry of a real front-end.""",
                     ["world", "odometry", "poses, share", "ATE in, m", "ATE out, m", "drift in, m/100 m", "drift out", "turn in, deg/100 m", "turn out"], rows, 2)

    def geometry(self):
        columns = [("geometry.chamfer", 3), ("geometry.accuracy", 3), ("geometry.completeness", 3)]
        rows = [[world, main_sensor(world), odometry, *cells(self.results(self.runs(world, None, odometry)), columns)]
                for world in self.args.worlds for odometry in self.args.odometry]
        return Table("geometry", "Geometry", """
Points of all leaves, stuff included, against the reference cloud: the reference is cropped to 3 m around the estimate, the two
are aligned (ICP), vegetation is left out. Map accuracy: mean distance from the estimate to the reference; completeness: the
other way; Chamfer: mean of the two. Distances to a cloud of points do not go to zero: about half the points' spacing is the
best there is (0.1 m outdoors, 0.05 m indoors).""",
                     ["world", "sensor", "odometry", "Chamfer, m", "map accuracy, m", "completeness, m"], rows, 3)

    def niw(self):
        columns = OBJECT_COLUMNS[1:]
        rows = []
        for world in self.args.worlds:
            for odometry in self.niw_odometry():
                for name, switches in self.NIW:
                    ready = self.workshop.has_switches(switches)
                    rows.append([world, odometry, name, *(cells(self.results(self.runs(world, None, odometry, switches)), columns)
                                                          if ready else [NOT_YET] * len(columns))])
        return Table("niw", "What the evidence is worth", """
The paper's NIW ablation: beliefs merge half and half, whatever was seen of each (`[ablation] symmetric_merge`), and factors
of the correction weigh the same.""", ["world", "odometry", "merge", *OBJECT_HEADER[1:]], rows, 3)

    def confusion(self):
        columns = [("odometry.ate_rmse", 2), ("trajectory.ate_rmse", 2), *OBJECT_COLUMNS[:5]]
        rows = [[world, odometry, *cells(self.results(self.confusion_runs_of(world, odometry)), columns)]
                for world in self.args.sensor_worlds for odometry in self.confusion_odometry()]
        return Table("confusion", "Objects under wrong names", f"""
{self.CONFUSION:.0%} of the objects of a frame are taken for another class as a whole (`hgg-sim --confusion`), the rest is as a good segmenter has it;
{len(self.more_seeds())} seeds. Whatever became a node and is no true object costs precision.""",
                     ["world", "odometry", "ATE in, m", "ATE out, m", *OBJECT_HEADER[:5]], rows, 2)

    def pairing(self):
        columns, rows = OBJECT_COLUMNS[1:5], []
        for world in self.args.sensor_worlds:
            for gate in self.GATES:
                for cost, switches in self.PAIRING:
                    ready = self.workshop.has_switches(switches)
                    rows.append([world, gate, cost, *(cells(self.results(self.pairing_runs_of(world, gate, switches)), columns)
                                                      if ready else [NOT_YET] * len(columns))])
        return Table("pairing", "What the cost of a pair is worth", f"""
The paper's cost ablation: things are paired with the map's by the Wasserstein distance of their Gaussians, by the distance of
their means, or by how little their boxes overlap (`[ablation] cost`), with {self.correction_odometry()} odometry and {len(self.more_seeds())} seeds. F1 is that of the
objects of the final map, after nodes that are one object were merged. The wide gate lets neighbours be candidates too.""",
                     ["world", "gate", "cost", *OBJECT_HEADER[1:5]], rows, 3)

    def correction(self):
        columns = [("geometry.chamfer", 3), ("geometry.accuracy", 3), ("overall.f1", 2), ("odometry.ate_rmse", 2), ("trajectory.ate_rmse", 2)]
        kinds = [["map", "yes" if em else "", "yes" if loops else "", self.correction_switches(em, loops)] for em, loops in self.CORRECTION]
        kinds += [["odometry", "shipped", "yes" if loops else "", self.drift_switches(loops)] for loops in (False, True)]
        rows = []
        for world in self.args.worlds:
            for *words_, switches in kinds:
                ready = switches is not None and self.workshop.has_switches(switches)
                results = self.results(self.runs(world, None, self.correction_odometry(), switches)) if ready else []
                rows.append([world, *words_, *([*cells(results, columns), *over_seeds(results, LOOP_COLUMNS)] if ready else [NOT_YET] * 7)])
        return Table("correction", "What correction is worth", f"""
EM on the leaves and loop closure, each on and off, with {self.correction_odometry()} odometry. Poses: of the map, as a robot has them, which hardly
drift where the map is met again; or odometry's ({" ".join(f"`{key} = {value}`" for key, value in self.ODOMETRY_POSE)}), which leaves all of
its drift to the loops, EM being as shipped. Accepted and false loops are those of all seeds together; false: more than 1 m or 3 degrees off.""",
                     ["world", "poses", "EM", "loops", "Chamfer, m", "map accuracy, m", "F1", "ATE in, m", "ATE out, m", "accepted", "false"], rows, 4)

    def loops(self):
        columns = [("odometry.ate_rmse", 2), ("trajectory.ate_rmse", 2), ("overall.f1", 2)]
        rows = []
        for row, runs in self.loop_rows():
            ready = self.workshop.has_switches(runs[0].switches)
            results = self.results(runs) if ready else []
            rows.append([*row, len(runs), *([*cells(results, columns), *over_seeds(results, LOOP_DETAILS)] if ready else [NOT_YET] * 11)])
        return Table("loops", "Loops", f"""
{"Whole ways, whatever `--frames` says: a loop takes one. " if not self.args.quick else ""}"Along KITTI": a made-up world along the true way of that drive, with the odometry of a real
front-end. Poses: of the map or odometry's, as in the table of correction. Loops and revisits are those of all seeds together. Asked:
questions, most of which are to be refused; accepted ones more than 1 m or 3 degrees off the truth are false; worst: of the accepted.
Revisits: stretches of the true way within 10 m (indoors 3 m) of a place left more than 100 m (15 m) of way before; asked about, closed:
with a question, or an accepted loop that is not false, in time. A revisit may need no loop: where alignment never lost the old part of
the map there is nothing to ask, so recall is closed of asked about where poses are the map's.""",
                     ["world", "odometry", "poses", "drives", "ATE in, m", "ATE out, m", "F1", "asked", "accepted", "false", "worst, m", "worst, deg", "revisits",
                      "asked about", "closed"], rows, 3)

    def calibration(self):
        figures = [("mean_over_3", 2), ("median_over_3", 2), ("inside_90", 2), ("mean_sigma", 3)]
        columns = [("overall.position_error.mean", 3), *((f"overall.{name}.{figure}", digits) for figure, digits in figures
                                                        for name in ("calibration_by_points", "calibration"))]
        rows = []
        for world, window, runs in self.calibration_rows():
            ready = self.workshop.has_switches(runs[0].switches)
            rows.append([world, window, *(cells(self.results(runs), columns) if ready else [NOT_YET] * len(columns))])
        return Table("calibration", "Whether positions keep their word", f"""
Positions of found objects against the covariance the map publishes for them, with {self.calibration_odometry()} odometry and {len(self.more_seeds())} seeds. Before: the
extent's covariance over the number of points, as if every point were a new look; after: what is published. NEES / 3: mean and median
of the normalised squared position error over 3 (honest: 1 and 0.79); the 90 % region should hold 0.9. Without window:
`correction.window = false`.""",
                     ["world", "correction", "position, m", "NEES / 3, before", "after", "median, before", "after", "inside 90 %, before", "after",
                      "sigma, m, before", "after"], rows, 2)

    def alignment(self):
        header = ["maps", "pairs", "accepted", "right", "position, m", "turn, deg", "ms"]
        kinds = ["same place, two drives", "different places"]
        if "align" not in self.workshop.commands:
            rows = [[kind, *[NOT_YET] * 6] for kind in kinds]
        else:
            rows = [[kind, *self.align_cells(pairs)] for kind, pairs in zip(kinds, self.align_pairs())]
        return Table("alignment", "Alignment of two maps", """
`hggmap align` without an initial guess. Same place: the maps of one world from two odometry qualities; right means accepted
and within 0.5 m and 5 degrees of the true transform. Different places: accepting is wrong.""", header, rows)

    def align_pairs(self):
        """(pairs of the same place, pairs of different places), each (run a, run b)."""
        first, second = (self.args.odometry * 2)[0], self.args.odometry[-1]
        same = [(a, b) for world in self.args.worlds for a, b in zip(self.runs(world, None, first), self.runs(world, None, second))]
        others = [(v, w) for v in self.args.worlds for w in self.args.worlds if v < w and is_indoor(v) == is_indoor(w)]
        different = [(a, b) for v, w in others for a, b in zip(self.runs(v, None, first), self.runs(w, None, first))]
        return same, different

    def align_cells(self, pairs):
        if not pairs:
            return ["not run"] * 6
        if any("error" in self.figures[run] for pair in pairs for run in pair):
            return [FAILED] * 6
        answers = [self.workshop.tried(f"alignment of {a.name()} and {b.name()}", lambda: self.align_answer(a, b)) for a, b in pairs]
        if None in answers:
            return [FAILED] * 6
        accepted = [x for x in answers if x[0]["accepted"]]
        right = [x for x in accepted if x[1] <= 0.5 and x[2] <= 5]
        return [len(answers), len(accepted), len(right), spread([x[1] for x in right]), spread([x[2] for x in right]),
                spread([dig(x[0], "ms") for x in answers], 1)]

    def align_answer(self, a, b):
        """The answer and its error; a refusal has no transform to be wrong."""
        answer = self.workshop.align(a, b)
        error = align_error(answer, self.figures[a], self.figures[b]) if answer["accepted"] else (None, None)
        return answer, *error

    def retrieval(self):
        columns = [("retrieval.queries", 0), ("retrieval.mapped", 0), ("retrieval.r1", 2), ("retrieval.r2", 2), ("retrieval.r3", 2)]
        rows = [[world, odometry, *cells(self.results(self.runs(world, None, odometry)), columns)]
                for world in self.args.worlds for odometry in self.niw_odometry() or self.args.odometry[:1]]
        return Table("retrieval", "Finding objects by their description", """
The world's own queries, each with exactly one right answer. An answer counts when the node matched to that object is among the
first one, two, three; a target the map does not hold counts as missed.""",
                     ["world", "odometry", "queries", "in the map", "R@1", "R@2", "R@3"], rows, 2)

    def cost(self):
        rows = []
        for run in self.timing_runs():
            stats = self.timing.get(run)
            row = self.workshop.tried(f"timing of {run.name()}", lambda: self.cost_cells(stats)) if stats is not None else None
            rows.append([run.drive.world, run.drive.sensor, *(row or [FAILED] * 9)])
        return Table("cost", "Time and memory", """
One replay at a time with nothing else running; all work of a frame, decode included. Map: the graph itself after half and
after all of the frames; process: resident, everything included.""",
                     ["world", "sensor", "frames", "frame p50, ms", "p99", "creation", "alignment", "correction", "map MB, half", "map MB, all", "process MB"],
                     rows, 2)

    def cost_cells(self, stats):
        ms = [stats["stage_ms"].get(stage, {}).get("p50") for stage in ("creation", "alignment", "correction")]
        return [stats["frames"], f"{stats['frame_ms']['p50']:.1f}", f"{stats['frame_ms']['p99']:.1f}",
                *(NOT_YET if x is None else f"{x:.1f}" for x in ms), *memory_cells(stats)]

    def real(self):
        rows = real_rows(self.workshop, self.args.data) if self.args.data.is_dir() and not self.args.quick else []
        return Table("real", "Real LiDAR", """
108 Velodyne frames (KITTI raw drive 0001), labelled by rules, against the 12 annotated parked cars, radius 1.5 m; the commands
are those of `tests/kitti_test.sh`. The data is not part of the repository; without it this table is empty.""",
                     ["odometry", "cars", "position, m", "recall", "precision", "F1", "ATE, m", "frame p50, ms", "p99"], rows)

    def needed(self, name):
        return {"objects": self.object_runs, "trajectory": lambda: self.object_runs() + self.path_runs(), "geometry": self.object_runs,
                "sensors": self.sensor_runs, "busy": self.busy_runs, "confusion": self.confusion_runs, "niw": self.niw_runs, "pairing": self.pairing_runs, "correction": self.correction_runs,
                "loops": self.loop_runs, "calibration": self.calibration_runs,
                "alignment": self.object_runs if "align" in self.workshop.commands else list, "cost": self.timing_runs,
                "retrieval": self.object_runs if "query" in self.workshop.commands else list, "real": list}[name]()


TABLES = ["objects", "sensors", "busy", "confusion", "trajectory", "geometry", "niw", "pairing", "correction", "loops", "calibration", "alignment", "retrieval", "cost", "real"]


def memory_cells(stats):
    curve = stats.get("memory") or []
    half = curve[len(curve) // 2]["map_mb"] if curve else None
    return [spread([half]), spread([stats.get("map_mb")]), spread([stats.get("peak_rss_mb")], 0)]


def pose(rows):
    """3x4 rows -> (rotation rows, translation)."""
    return [rows[0:3], rows[4:7], rows[8:11]], [rows[3], rows[7], rows[11]]


def align_error(answer, figures_a, figures_b):
    """Metres and degrees between the answer and the truth, T_a_b = T_truth_a^-1 T_truth_b."""
    (Ra, ta), (Rb, tb), (R, t) = (pose(rows) for rows in (figures_a["trajectory"]["T_truth_map"], figures_b["trajectory"]["T_truth_map"], answer["T_a_b"]))
    turned = lambda M, v: [sum(M[k][i] * v[k] for k in range(3)) for i in range(3)]  # M^T v
    t_true = turned(Ra, [tb[i] - ta[i] for i in range(3)])
    R_true = [[sum(Ra[k][i] * Rb[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
    trace = sum(R_true[k][i] * R[k][i] for i in range(3) for k in range(3))
    return math.dist(t_true, t), math.degrees(math.acos(max(-1.0, min(1.0, (trace - 1) / 2))))


REAL_POSES = {"true poses": "poses.txt", "a real front-end's": "odometry.txt"}


def real_rows(workshop, data):
    """KITTI raw drive 0001 with true poses and with a real front-end's odometry."""
    if not (data / "kitti_0001").is_dir():
        return []
    found = workshop.tried("real data", lambda: real_figures(workshop, data))
    columns = [("overall.truth", 0), ("overall.position_error.mean", 3), ("overall.recall", 2), ("overall.precision", 2), ("overall.f1", 2),
               ("trajectory.ate_rmse", 2), ("cost.frame_ms.p50", 1), ("cost.frame_ms.p99", 1)]
    return [[name, *cells([(found or {}).get(name, {"error": ""})], columns)] for name in REAL_POSES]


def real_commands(where, data, poses):
    """How one kind of poses is mapped and scored."""
    log, out = where / f"{poses}.lcm", where / poses.replace(".txt", "")
    config = REPO / "firmware_cfg" / "semantickitti" / "hggmap.toml"
    return [["hgg-convert", "semantickitti", where / "kitti", "-o", log, "--poses", where / "kitti" / poses],
            ["hggmap", "replay", log, "--config", config, "--out", out],
            ["hgg-eval", "--map", out / "map.hgg", "--truth", where / "truth", "--class", "car", "--radius", "1.5", "--trajectory",
             out / "trajectory.tum", "--times", where / "kitti" / "times.txt", "--log", log, "--json"]]


def real_preparation(where, data):
    return [[sys.executable, data / "unpack.py", data / "kitti_0001", where / "kitti"],
            ["hgg-convert", "kitti-truth", where / "kitti", "-o", where / "truth", "--boxes", data / "kitti_0001" / "boxes.csv"]]


def real_figures(workshop, data):
    """From the cache, whose key is all that goes in, or by running it."""
    named, config = (Path("OUT"), Path("DATA")), REPO / "firmware_cfg" / "semantickitti"
    commands = [*real_preparation(*named), *(c for poses in REAL_POSES.values() for c in real_commands(*named, poses))]
    files = [f for f in sorted((data / "kitti_0001").iterdir()) if f.is_file()]
    frames = [f"{f.name} {f.stat().st_size}" for f in sorted((data / "kitti_0001" / "frames").glob("*"))]
    where = workshop.out / "real" / digest(
        workshop.programs["hggmap"], workshop.programs["hgg-eval"], hash_of(workshop.build / "hgg-convert"), hash_of(data / "unpack.py"),
        hash_of(config / "hggmap.toml"), hash_of(config / "classes.toml"), *(f.name + hash_of(f) for f in files), *frames,
        *(word for command in commands for word in words(command)), machine())
    if not (where / "result.json").exists():
        save_real(workshop, data, where)
    return json.loads((where / "result.json").read_text())


def save_real(workshop, data, where):
    shutil.rmtree(where, ignore_errors=True)
    where.mkdir(parents=True)
    unpack, truth = real_preparation(where, data)
    workshop.execute(unpack)
    workshop.call(*truth)
    figures = {}
    for name, poses in REAL_POSES.items():
        convert, replay, score = real_commands(where, data, poses)
        workshop.call(*convert)
        workshop.call(*replay)
        figures[name] = compact(workshop.call(*score), " ".join(words(score)))
        (where / f"{poses}.lcm").unlink(missing_ok=True)
    shutil.rmtree(where / "kitti", ignore_errors=True)
    save(where / "result.json", figures)


# ---- the document ----------------------------------------------------------------------------------------------------------

DOCUMENT = """# Evaluation

<!-- Written by tools/evaluate.py; change the text there. -->

What the mapper does in worlds whose truth is known, measured by one command. The same figures to look at: [evaluation.html](evaluation.html).

    {command}

| | |
|---|---|
| commit | {commit} |
| programs | {programs} |
| machine | {machine} |
| date | {date} |
| seeds | {seeds}; figures are mean ± sample deviation over them |
| frames | {frames} |

A seed changes where objects stand, what the sensors get wrong and how odometry drifts. Labels are those of a good segmenter
(`hgg-sim --labels good`: speckle, bleeding borders, confused and missed objects), except in the real data. "{not_yet}": the
stage that would fill the figure does not exist yet.

A log holds odometry of every quality, on the channels `POSE_ODOM_TRUE`, `_EXCELLENT`, `_GOOD` and `_POOR`; `lcm.odometry` of
the config picks one. A run out of doors and one indoors by hand, as in the table of objects (with other sensors than these the
config's `creation.beam_spacing_deg` is theirs):

    sed 's/^odometry = "[A-Z_]*"/odometry = "POSE_ODOM_GOOD"/' firmware_cfg/semantickitti/hggmap.toml > firmware_cfg/semantickitti/good.toml
    hgg-sim street -o street.lcm --truth street_truth --sensor lidar64 --seed 1
    hggmap replay street.lcm --config firmware_cfg/semantickitti/good.toml --out out/street
    hgg-eval --map out/street/map.hgg --truth street_truth --trajectory out/street/trajectory.tum --log street.lcm --odometry-channel POSE_ODOM_GOOD --radius 1.5 --spacing 0.1 --html street.html

    sed 's/^odometry = "[A-Z_]*"/odometry = "POSE_ODOM_GOOD"/' firmware_cfg/indoor/hggmap.toml > firmware_cfg/indoor/good.toml
    hgg-sim office -o office.lcm --truth office_truth --sensor rgbd --seed 1
    hggmap replay office.lcm --config firmware_cfg/indoor/good.toml --out out/office
    hgg-eval --map out/office/map.hgg --truth office_truth --trajectory out/office/trajectory.tum --log office.lcm --odometry-channel POSE_ODOM_GOOD --radius 0.5 --spacing 0.05 --html office.html

`hgg-eval --help` says how it scores; [method.md](method.md) says what is measured.

{tables}
"""


def section(table, info):
    return (f"## {table.title}\n\n{table.text.strip()}\n\n{table.markdown() if table.rows else 'Nothing was run for this table.'}\n\n"
            f"`{info['script']} --only {table.name}` · {info['commit']} · {info['machine']}\n")


def git(*arguments):
    done = subprocess.run(["git", "-C", REPO, *arguments], capture_output=True, text=True)
    return done.stdout.strip() if done.returncode == 0 else ""


def commit():
    head = git("rev-parse", "--short=10", "HEAD")
    return (head or "unknown") + (" with uncommitted changes" if git("status", "--porcelain", "--untracked-files=no") else "")


def machine():
    model, memory = platform.processor() or platform.machine(), 0
    if Path("/proc/cpuinfo").exists():
        names = re.findall(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
        model = names[0] if names else model
        memory = int(re.search(r"MemTotal:\s*(\d+)", Path("/proc/meminfo").read_text()).group(1)) / 2**20
    return f"{' '.join(model.split())}, {os.cpu_count()} cores, {memory:.0f} GB"


def charts(matrix):
    """What the page draws: a value per seed for every world and odometry, and a curve per world."""
    measures = {"F1": "overall.f1", "position error, m": "overall.position_error.mean", "ATE, m": "trajectory.ate_rmse", "Chamfer, m": "geometry.chamfer"}
    groups = [{"world": world, "odometry": odometry,
               **{name: [v for v in (dig(r, path) for r in matrix.results(matrix.runs(world, None, odometry))) if v is not None]
                  for name, path in measures.items()}}
              for world in matrix.args.worlds for odometry in matrix.args.odometry]
    curves = [{"world": run.drive.world, "memory": [[m["frame"], m["map_mb"]] for m in stats.get("memory", [])],
               "time": [[t["frame"], t["mean_ms"]] for t in stats.get("time", [])]} for run, stats in matrix.timing.items()]
    return {"measures": list(measures), "groups": groups, "odometry": matrix.args.odometry, "worlds": matrix.args.worlds, "curves": curves}


def page(tables, info, drawings):
    parts = REPO / "tools" / "eval" / "page"
    data = {**info, "tables": [dataclasses.asdict(t) for t in tables], "charts": drawings}
    script = (parts / "charts.js").read_text() + (parts / "matrix.js").read_text()
    text = (parts / "run.html").read_text()
    for mark, content in (("/*STYLE*/", (parts / "style.css").read_text()), ("/*SCRIPT*/", script),
                          ("/*DATA*/", json.dumps(data).replace("<", "\\u003c"))):
        text = text.replace(mark, content, 1)
    return text


# ---- the command -----------------------------------------------------------------------------------------------------------

def listed(workshop_build):
    """Worlds and sensors of hgg-sim --list."""
    text = subprocess.run([workshop_build / "hgg-sim", "--list"], capture_output=True, text=True).stdout
    found, part = {"worlds": [], "sensors": []}, None
    for line in text.splitlines():
        if line.endswith(":"):
            part = line[:-1]
        elif part in found and line.strip():
            found[part].append(line.split()[0])
    return found["worlds"], found["sensors"]


def parse(argv):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    names = lambda text: [w for w in text.split(",") if w]
    parser.add_argument("--build", type=Path, default=REPO / "build", help="folder of the programs")
    parser.add_argument("--out", type=Path, default=REPO / "out" / "evaluation", help="folder of logs, maps and results")
    parser.add_argument("--data", type=Path, default=Path(os.environ.get("HGG_DATA", REPO.parent / "shared" / "data")), help="folder of the real data")
    parser.add_argument("--worlds", type=names, help="default: all but the toy; table 'sensors': " + " and ".join(SENSOR_WORLDS))
    parser.add_argument("--sensors", type=names, help="default: all")
    parser.add_argument("--odometry", type=names, default=ODOMETRY)
    parser.add_argument("--paths", type=names, default=["05", "07"], help="KITTI drives in DATA/kitti_trajectories to lay worlds along; '': none [05,07]")
    parser.add_argument("--seeds", type=lambda text: [int(s) for s in names(text)], default=None, help="default: 1,2,3")
    parser.add_argument("--frames", type=int, default=None, help="of each drive; 0, the default: the world's whole tour; paths and the table of loops are always whole")
    parser.add_argument("--only", type=names, default=None, help="tables to make: " + ",".join(TABLES))
    parser.add_argument("--skip", type=names, default=[], help="tables to leave out of the document")
    parser.add_argument("--full", action="store_true", help="every sensor in every world with every odometry")
    parser.add_argument("--quick", action="store_true", help="a small matrix: one world in and one out of doors, short drives")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="runs at a time (timing always runs alone)")
    parser.add_argument("--keep-gb", type=float, default=40, help="logs beyond this are dropped once they are used [40]")
    parser.add_argument("--doc", type=Path, help="default: docs/evaluation.md; with --quick OUT/evaluation.md")
    args = parser.parse_args(argv)
    worlds, sensors = listed(args.build) if (args.build / "hgg-sim").exists() else ([], [])
    if not worlds:
        parser.error(f"no hgg-sim in {args.build}: run make build, or name the folder with --build")
    quick = args.quick
    args.sensor_worlds = args.worlds
    args.worlds = args.worlds or (["yard", "apartment"] if quick else [w for w in worlds if w != "yard"])
    args.sensor_worlds = args.sensor_worlds or (args.worlds if quick or args.full else [w for w in SENSOR_WORLDS if w in worlds])
    args.sensors = args.sensors or (["lidar16", "rgbd"] if quick else sensors)
    args.odometry = [o for o in args.odometry if not quick or o in ("true", "good")]
    args.seeds = args.seeds or ([1, 2] if quick else [1, 2, 3])
    args.frames = args.frames if args.frames is not None else 60 if quick else 0
    args.doc = args.doc or (args.out / "evaluation.md" if quick else REPO / "docs" / "evaluation.md")
    for given, known, what in ((args.worlds, worlds, "world"), (args.sensors, sensors, "sensor"), (args.odometry, ODOMETRY, "odometry"),
                               (args.only or [], TABLES, "table"), (args.skip, TABLES, "table")):
        for name in given:
            if name not in known:
                parser.error(f"there is no {what} {name!r}: {', '.join(known)}")
    return args


def describe(args, argv):
    shown = [a if " " not in a else repr(a) for a in argv]
    frames = "each world's whole tour" if args.frames == 0 else f"the first {args.frames} of each drive"
    options = [a for i, a in enumerate(shown) if a != "--only" and (i == 0 or shown[i - 1] != "--only") and not a.startswith("--only=")]
    return {"command": " ".join(["tools/evaluate.py", *shown]), "script": " ".join(["tools/evaluate.py", *options]), "commit": commit(),
            "machine": machine(), "date": datetime.date.today().isoformat(), "seeds": ", ".join(map(str, args.seeds)), "frames": frames}


def measure(workshop, args, info):
    matrix, names = Matrix(workshop, args), [name for name in args.only or TABLES if name not in args.skip]
    workshop.pinned = {run.drive for run in matrix.timing_runs()} if "cost" in names else set()
    runs = [run for name in names for run in matrix.needed(name)]
    matrix.figures = run_all(workshop, runs, max(1, args.jobs))
    if "cost" in names:
        print("timing, one at a time", file=sys.stderr)
        timed = {run: workshop.tried(f"timing of {run.name()}", lambda: workshop.time(run))
                 for run in matrix.timing_runs() if "error" not in matrix.figures[run]}
        matrix.timing = {run: stats for run, stats in timed.items() if stats is not None}
    tables = [workshop.tried(f"table {name}", getattr(matrix, name)) or Table(name, name.capitalize(), "", ["table"], [[FAILED]]) for name in names]
    for table in tables:
        print(section(table, info))
    if args.only is None:
        written = args.doc.with_suffix(".html")
        args.doc.parent.mkdir(parents=True, exist_ok=True)
        args.doc.write_text(DOCUMENT.format(tables="\n".join(section(t, info) for t in tables), not_yet=NOT_YET, **info))
        drawings = workshop.tried("charts", lambda: charts(matrix)) or {"measures": [], "groups": [], "odometry": [], "worlds": [], "curves": []}
        workshop.tried("page", lambda: written.write_text(page(tables, info, drawings)))
        print(f"written: {args.doc} and {written}; a report of every run is in {args.out / 'runs'}")
    errors = sorted({*workshop.errors, *(figures["error"] for figures in matrix.figures.values() if "error" in figures)})
    for error in errors:
        print(f"evaluate.py: failed: {error}", file=sys.stderr)
    return 1 if errors else 0


def interrupted(number, frame):
    raise KeyboardInterrupt


def main(argv):
    args, workshop = parse(argv), None
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, interrupted)
    try:
        args.out.mkdir(parents=True, exist_ok=True)
        workshop = Workshop(args.build, args.out, args.keep_gb, max(1, (os.cpu_count() or 1) // max(1, args.jobs)))
        info = {**describe(args, argv), "programs": ", ".join(f"{name} {made[:8]}" for name, made in workshop.programs.items())}
        return measure(workshop, args, info)
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        if workshop:
            workshop.halt()
        print("\nstopped; the same command goes on where it was" if sys.stderr.isatty() else
              "stopped; the same command goes on where it was", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
