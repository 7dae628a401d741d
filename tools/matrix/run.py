#!/usr/bin/env python3
"""Measures everything: simulates the worlds, maps them, holds the maps against the truth, writes docs/evaluation.md and .html.

examples: tools/matrix/run.py                      the whole matrix (hours; stops and goes on where it was)
          tools/matrix/run.py --quick              a small matrix, for CI (minutes)
          tools/matrix/run.py --only niw,retrieval  some tables, printed and not written to the document
          tools/matrix/run.py --only niw --write    and written to it, in place of those it has; each names its commit

Logs, maps and results are kept in --out, each under the hash of what made it (programs, arguments, config): a run that was
interrupted goes on, a changed program is measured again, a changed hgg-eval on the maps there are. Standard library only.
Exit codes: 0 done, 1 something failed (the tables say where, the end says why), 2 bad usage, 130 stopped.
"""
import argparse
import datetime
import os
import signal
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True  # beside the sources
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from matrix.figures import FAILED, NOT_YET, Table
from matrix.page import DOCUMENT, charts, page, section, with_section
from matrix.tables import LYING, SENSOR_WORLDS, TABLES, Matrix
from matrix.workshop import GROUNDS, REPO, Workshop, machine, run_all

# Options that a figure does not depend on, and whether a value follows.
OF_THIS_MACHINE = {"--only": True, "--write": False, "--build": True, "--out": True, "--data": True, "--jobs": True, "--keep-gb": True, "--doc": True}
ODOMETRY = ["true", "excellent", "good", "poor"]


def git(*arguments):
    done = subprocess.run(["git", "-C", REPO, *arguments], capture_output=True, text=True)
    return done.stdout.strip() if done.returncode == 0 else ""


def commit():
    head = git("rev-parse", "--short=10", "HEAD")
    return (head or "unknown") + (" with uncommitted changes" if git("status", "--porcelain", "--untracked-files=no") else "")


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
    parser.add_argument("--worlds", type=names, help="default: all but the toy and passes, which is for the table 'things'; table 'sensors': " + " and ".join(SENSOR_WORLDS) +
                        "; table 'traversability' also " + ", ".join(GROUNDS))
    parser.add_argument("--sensors", type=names, help="default: all")
    parser.add_argument("--odometry", type=names, default=ODOMETRY)
    parser.add_argument("--paths", type=names, default=["05", "07"], help="KITTI drives in DATA/kitti_trajectories to lay worlds along; '': none [05,07]")
    parser.add_argument("--seeds", type=lambda text: [int(s) for s in names(text)], default=None, help="default: 1,2,3")
    parser.add_argument("--frames", type=int, default=None, help="of each drive; 0, the default: the world's whole tour; paths are always whole")
    parser.add_argument("--loop-frames", type=int, default=None,
                        help="of each drive of the tables correction and loops, where worlds are met again in a second lap; 0, the default: the whole tour")
    parser.add_argument("--only", type=names, default=None, help="tables to make: " + ",".join(TABLES) + "; odometry: " + ",".join(LYING))
    parser.add_argument("--write", action="store_true", help="put the tables of --only into the document; the page is left as it is")
    parser.add_argument("--skip", type=names, default=[], help="tables to leave out of the document")
    parser.add_argument("--before", type=Path, default=None, help="folder of another hggmap: the tables of odometry show its figures beside")
    parser.add_argument("--kidnaps", type=int, default=None, help="drives a world that are carried away [20; 2 with --quick]")
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
    args.sensor_worlds, args.worlds_named, args.known_worlds = args.worlds, bool(args.worlds), worlds
    args.worlds = args.worlds or (["yard", "apartment"] if quick else [w for w in worlds if w not in ("yard", "passes", *GROUNDS)])
    args.sensor_worlds = args.sensor_worlds or (args.worlds if quick or args.full else [w for w in SENSOR_WORLDS if w in worlds])
    args.sensors = args.sensors or (["lidar16", "rgbd"] if quick else sensors)
    args.odometry = [o for o in args.odometry if not quick or o in ("true", "good")]
    args.kidnaps = args.kidnaps if args.kidnaps is not None else 2 if quick else 20
    args.only = args.only and [table for name in args.only for table in (LYING if name == "odometry" else [name])]
    if args.write and not args.only:
        parser.error("--write is for the tables of --only; without --only the document is written anyway")
    if args.before and not (args.before / "hggmap").exists():
        parser.error(f"no hggmap in {args.before} (--before)")
    args.seeds = args.seeds or ([1, 2] if quick else [1, 2, 3])
    args.frames = args.frames if args.frames is not None else 60 if quick else 0
    args.loop_frames = args.loop_frames if args.loop_frames is not None else args.frames if quick else 0
    args.doc = args.doc or (args.out / "evaluation.md" if quick else REPO / "docs" / "evaluation.md")
    for given, known, what in ((args.worlds, worlds, "world"), (args.sensors, sensors, "sensor"), (args.odometry, ODOMETRY, "odometry"),
                               (args.only or [], TABLES, "table"), (args.skip, TABLES, "table")):
        for name in given:
            if name not in known:
                parser.error(f"there is no {what} {name!r}: {', '.join(known)}")
    return args


def describe(args, argv):
    shown = [a if " " not in a else repr(a) for a in argv]
    frames = "each world's whole tour" if args.frames == 0 else f"the first {args.frames} of each drive{'' if args.quick else '; those of correction and loops are told there'}"
    options, skip = [], False
    for word in shown:  # those that figures depend on
        name, has_value = word.partition("=")[0], "=" in word
        if not skip and name not in OF_THIS_MACHINE:
            options.append(word)
        skip = not skip and OF_THIS_MACHINE.get(name, False) and not has_value
    return {"command": " ".join(["tools/matrix/run.py", *shown]), "script": " ".join(["tools/matrix/run.py", *options]), "commit": commit(),
            "machine": machine(), "date": datetime.date.today().isoformat(), "seeds": ", ".join(map(str, args.seeds)), "frames": frames}


def measure(workshop, args, info):
    matrix, names = Matrix(workshop, args), [name for name in args.only or TABLES if name not in args.skip]
    workshop.pinned = {run.drive for run in matrix.timing_runs()} if "cost" in names else set()
    runs = [run for name in names for run in matrix.needed(name)]
    matrix.figures = run_all(workshop, runs, max(1, args.jobs))
    if args.before:
        before = Workshop(args.build, args.out, args.keep_gb, workshop.threads, args.before)
        matrix.figures_before = run_all(before, [run for name in names if name in LYING for run in matrix.needed(name)], max(1, args.jobs))
    if "cost" in names:
        print("timing, one at a time", file=sys.stderr)
        timed = {run: workshop.tried(f"timing of {run.name()}", lambda: workshop.time(run))
                 for run in matrix.timing_runs() if "error" not in matrix.figures[run]}
        matrix.timing = {run: stats for run, stats in timed.items() if stats is not None}
    tables = [workshop.tried(f"table {name}", getattr(matrix, name)) or Table(name, name.capitalize(), "", ["table"], [[FAILED]]) for name in names]
    for table in tables:
        print(section(table, info))
    if args.write:
        document = args.doc.read_text() if args.doc.exists() else DOCUMENT.format(tables="", not_yet=NOT_YET, **info)
        for table in tables:
            document = with_section(document, table, info)
        args.doc.write_text(document)
        print(f"written: {args.doc}")
    elif args.only is None:
        written = args.doc.with_suffix(".html")
        args.doc.parent.mkdir(parents=True, exist_ok=True)
        args.doc.write_text(DOCUMENT.format(tables="\n".join(section(t, info) for t in tables), not_yet=NOT_YET, **info))
        drawings = workshop.tried("charts", lambda: charts(matrix)) or {"measures": [], "groups": [], "odometry": [], "worlds": [], "curves": []}
        workshop.tried("page", lambda: written.write_text(page(tables, info, drawings)))
        print(f"written: {args.doc} and {written}; a report of every run is in {args.out / 'runs'}")
    made = [*matrix.figures.values(), *matrix.figures_before.values()]
    errors = sorted({*workshop.errors, *(figures["error"] for figures in made if "error" in figures)})
    for error in errors:
        print(f"run.py: failed: {error}", file=sys.stderr)
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
