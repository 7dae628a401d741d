"""What is run, and the workshop that runs it: programs, cache, commands."""
import concurrent.futures
import dataclasses
import hashlib
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path

from matrix.answers import lines_of, score

REPO = Path(__file__).resolve().parent.parent.parent
CARRY_S = 3.0  # of hgg-sim --kidnap
GROUNDS = ["stairs", "ramp", "hole", "bridge", "walk"]  # worlds whose ground is what they are about
INDOOR = {"apartment", "corridor", "office", "hall", *GROUNDS}
SPECKLE = 0.015  # share of points, where things are confused with common classes
PLANS = 200  # pairs of places a drive
MAIN_SENSOR = {"corridor": "solid64", **dict.fromkeys(GROUNDS, "lidar64")}  # where it is not that of the other worlds


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
    faults: tuple = ()  # options of hgg-sim that make odometry lie
    fault_s: float = 0  # s after the start: when they begin to show
    common: float = 0  # share under the name of another common class, instead of the class it is likely taken for
    plates: bool = False  # small signs on poles as well

    def arguments(self):
        where = ["--path", *self.path] if self.path else [self.world]
        return [*where, "--sensor", self.sensor, "--seed", str(self.seed), "--frames", str(self.frames),
                *(["--dynamics"] if self.busy else []), *(["--confusion", str(self.confusion)] if self.confusion else []),
                *(["--confusion", "0", "--confusion-common", str(self.common), "--speckle", str(SPECKLE)] if self.common else []),
                *(["--plates"] if self.plates else []), *self.faults]

    def identity(self):
        """What the log depends on: the arguments, with files by their content."""
        paths = set(self.path)
        return [hash_of(a) if a in paths else a for a in self.arguments()]

    def name(self):
        return f"{self.world} {self.sensor} {'busy ' if self.busy else ''}{f'confusion {self.confusion} ' if self.confusion else ''}{f'common {self.common} ' if self.common else ''}{''.join(f'{word} ' for word in self.faults)}seed {self.seed}"


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
    return MAIN_SENSOR.get(world, "rgbd" if is_indoor(world) else "lidar64")


def radius_of(world):
    return 0.5 if is_indoor(world) else 1.5


def spacing_of(world):
    return 0.05 if is_indoor(world) else 0.1


def beam_spacing_of(sensor, world):
    """Degrees between beams, which clustering has to bridge; None keeps the shipped value."""
    indoor = {"lidar16": 2.0, "lidar64": 0.72, "rig": 0.72, "lidar128": 0.36, "solid": 0.26, "solid64": 0.63}
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


def without_unknown(toml, known):
    """The TOML text without the keys and sections a mapper does not know."""
    section, kept = "", []
    for line in toml.splitlines():
        section = line[1:line.index("]")] + "." if line.startswith("[") else section
        has_key = "=" in line and not line.startswith(("#", "["))
        is_known = section + line.split("=")[0].strip() in known if has_key else any(key.startswith(section) for key in known)
        if is_known:
            kept.append(line)
    return "\n".join(kept) + "\n"


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

    def __init__(self, build, out, keep_gb, threads, mapper=None):
        """`mapper`: the folder of another hggmap, older than the configs of this repository."""
        self.build, self.out, self.keep_bytes, self.threads = Path(build), Path(out), keep_gb * 1e9, threads
        self.mapper = Path(mapper) if mapper else None
        self.programs = {name: hash_of(self.place(name) / name) for name in ("hgg-sim", "hggmap", "hgg-eval")}
        self.config_keys = self._config_keys()
        self.commands = self._commands()
        self.pinned, self.in_use = set(), []  # drives
        self.errors = []
        self._lock, self._stopping, self._children = threading.Lock(), False, set()

    def place(self, program):
        return self.mapper if self.mapper and program == "hggmap" else self.build

    def _config_keys(self):
        printed = subprocess.run([self.place("hggmap") / "hggmap", "run", "--print-config"], capture_output=True, text=True).stdout
        keys, section = set(), ""
        for line in printed.splitlines():
            section = line[1:line.index("]")] + "." if line.startswith("[") else section
            if " = " in line and not line.startswith("#"):
                keys.add(section + line.split(" = ")[0])
        return keys

    def _commands(self):
        """The subcommands in the help; `hggmap WORD --help` succeeds for every word."""
        text = subprocess.run([self.place("hggmap") / "hggmap", "--help"], capture_output=True, text=True).stdout
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
        return self.execute([self.place(program) / program, *arguments], accept)

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
        text = set_keys((folder / "hggmap.toml").read_text(), values)
        return without_unknown(text, self.config_keys) if self.mapper else text

    # What the programs are told. The names of files are arguments here, so that the same lines make the command and its key.

    def replay_command(self, drive, where, out):
        return ["replay", drive / "log.lcm", "--config", where / "config.toml", "--out", out]

    def query_command(self, drive, where):
        return ["query", where / "map.hgg", "--batch", drive / "truth" / "queries.jsonl"]

    def score_command(self, run, drive, where, out, answers):
        return ["--map", where / "map.hgg", "--truth", drive / "truth", "--trajectory", where / "trajectory.tum",
                "--log", drive / "log.lcm", "--odometry-channel", run.channel(), "--radius", radius_of(run.drive.world),
                "--spacing", spacing_of(run.drive.world), "--html", out / "report.html", "--title", run.name(), "--json",
                *(["--answers", out / "answers.jsonl"] if answers else []),
                *(["--fault", run.drive.fault_s] if run.drive.fault_s else [])]

    def ask_command(self, drive, where, rule):
        return ["query", where / "map.hgg", "--batch", drive / "truth" / "queries.jsonl", "--nearness", rule, "--no-goal"]

    def match_command(self, run, drive, where):
        return ["--map", where / "map.hgg", "--truth", drive / "truth", "--trajectory", where / "trajectory.tum", "--log", drive / "log.lcm",
                "--odometry-channel", run.channel(), "--radius", radius_of(run.drive.world), "--json"]

    def align_command(self, a, b):
        return ["align", a / "map.hgg", b / "map.hgg", "--json"]

    def grid_command(self, where, out):
        return ["export", where / "map.hgg", "--format", "grid", "--resolution", "0.1", "-o", out / "grid"]

    def walk_command(self, run, drive, where, out, *more):
        return ["--map", where / "map.hgg", "--truth", drive / "truth", "--trajectory", where / "trajectory.tum", "--log", drive / "log.lcm",
                "--odometry-channel", run.channel(), "--radius", radius_of(run.drive.world), "--json", "--plan-requests", out / "requests.jsonl", *more]

    def scored_walk(self, out):
        return ["--grid", out / "grid.layers.json", "--plan-answers", out / "answers.jsonl"]

    def walk_dir(self, run):
        drive, where, out = Path("DRIVE"), Path("MAP"), Path("OUT")
        return self.out / "walks" / digest(self.map_dir(run).name, self.programs["hgg-eval"], str(PLANS), *words(self.grid_command(where, out)),
                                           *words(self.walk_command(run, drive, where, out, *self.scored_walk(out))))

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

    def cached(self, out, make):
        """The figures in a folder, or those of make(), which fills it: what hgg-eval says to the command that it returns."""
        result = out / "result.json"
        if result.exists():
            return json.loads(result.read_text())
        shutil.rmtree(out, ignore_errors=True)
        out.mkdir(parents=True)
        command = make()
        figures = compact(self.call("hgg-eval", *command), f"hgg-eval {' '.join(words(command))}")
        save(result, figures)
        return figures

    def evaluate(self, run):
        """The figures of a run, from the cache or by making them. The report stays beside them."""
        out = self.run_dir(run)

        def make():
            drive, where = self.simulate(run.drive), self.map(run)
            answers = "query" in self.commands and (drive / "truth" / "queries.jsonl").exists()
            if answers:
                (out / "answers.jsonl").write_text(self.call("hggmap", *self.query_command(drive, where), accept=(0, 1)))
            return self.score_command(run, drive, where, out, answers)

        return self.cached(out, make)

    def can_walk(self):
        return {"export", "plan"} <= self.commands and "grid" in self.call("hggmap", "export", "--help")

    def plan(self, where, requests):
        """An answer a line. A mapper without --batch is asked line by line."""
        if "--batch" in self.call("hggmap", "plan", "--help"):
            return self.call("hggmap", "plan", where / "map.hgg", "--batch", requests, accept=(0, 1))
        place = lambda p: ",".join(map(str, p))
        asked = [json.loads(line) for line in requests.read_text().splitlines()]
        return "".join(self.call("hggmap", "plan", where / "map.hgg", "--from", place(r["from"]), "--to", place(r["to"]), "--json", accept=(0, 1))
                       .replace("\n", "") + "\n" for r in asked)

    def walk(self, run):
        """The figures of where one can walk, from the cache or by making them. Grid and plans stay beside them."""
        out = self.walk_dir(run)

        def make():
            drive, where = self.simulate(run.drive), self.map(run)
            self.call("hggmap", *self.grid_command(where, out))
            self.call("hgg-eval", *self.walk_command(run, drive, where, out, "--plans", PLANS))
            (out / "answers.jsonl").write_text(self.plan(where, out / "requests.jsonl"))
            return self.walk_command(run, drive, where, out, *self.scored_walk(out))

        return self.cached(out, make)

    def ask(self, run, rule):
        """Right answers to the world's queries by kind (matrix.language.score), cached beside the map."""
        drive, where = self.drive_dir(run.drive), self.map(run)
        key = digest(self.programs["hgg-eval"], *words(self.ask_command(Path("DRIVE"), Path("MAP"), rule)), *words(self.match_command(run, Path("DRIVE"), Path("MAP"))))
        result = where / f"language_{key}.json"
        if not result.exists():
            drive = self.simulate(run.drive)
            answers = lines_of(self.call("hggmap", *self.ask_command(drive, where, rule), accept=(0, 1)))
            scored = parsed(self.call("hgg-eval", *self.match_command(run, drive, where)), f"hgg-eval of {run.name()}")
            save(result, score(lines_of((drive / "truth" / "queries.jsonl").read_text()), answers, scored["overall"]["matches"]))
        return json.loads(result.read_text())

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
        scores.pop("ghosts", None), scores.pop("twins", None)
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


def machine():
    model, memory = platform.processor() or platform.machine(), 0
    if Path("/proc/cpuinfo").exists():
        names = re.findall(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
        model = names[0] if names else model
        memory = int(re.search(r"MemTotal:\s*(\d+)", Path("/proc/meminfo").read_text()).group(1)) / 2**20
    return f"{' '.join(model.split())}, {os.cpu_count()} cores, {memory:.0f} GB"
