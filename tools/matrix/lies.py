"""The tables of odometry that lies: their runs and what came of them. Part of Matrix."""
import dataclasses

from matrix.figures import FAILED, NOT_YET, Table, cells, dig, over_seeds
from matrix.workshop import CARRY_S, Drive, Run

LATE, EARLY, HALF = ("--odometry-delay", "0.1"), ("--odometry-delay", "-0.1"), ("--every", "2")
# What is wrong with odometry: options of hgg-sim, and how late it is, s.
LIES = {"as is": ((), 0.0), "late by 0.1 s": (LATE, 0.1), "early by 0.1 s": (EARLY, -0.1), "every 2nd frame": (HALF, 0.0),
        "late, every 2nd": (HALF + LATE, 0.1), "bursts in five turns, every 2nd": (HALF + ("--odometry-bursts", "5"), 0.0),
        "wheels, late": (("--odometry", "wheel") + LATE, 0.1)}
FAULT_KINDS = ["jump", "yaw-jump", "slip", "frozen", "xyzw"]
KIDNAP_WORLDS, FAULT_WORLDS = ["street", "hall", "apartment"], ["street", "office", "hall"]
BELIEF_WORLDS = ["street", "campus", "office", "apartment", "hall"]
ALL_ROUND = "lidar64"  # sees what there is to recognise, whichever way the robot looks
BACK_S, SAID_S = 20.0, 2.0  # within which a carried robot is to be back, and a fault is to be told


class Lies:
    """Tables whose runs are made with the mapper of --before as well."""

    def before(self, runs):
        return [self.figures_before[run] for run in runs if run in self.figures_before]

    def both(self, runs, columns, of=cells):
        """Cells of `runs`, each behind that of the mapper of --before where there is one."""
        after = of(self.results(runs), columns)
        return [cell for pair in zip(of(self.before(runs), columns), after) for cell in pair] if self.args.before else after

    def headed(self, names):
        return [text for name in names for text in (f"{name}, before", "after")] if self.args.before else names

    def ways(self):
        """(name, drives) of the real paths; without them, or quickly, of the first world."""
        ways = {}
        for run in self.path_runs():
            ways.setdefault(run.drive.world, []).append(run.drive)
        return ways or {world: [run.drive for run in self.runs(world)] for world in self.args.worlds[:1]}

    def lying(self, drives, options, odometry=None):
        return [Run(dataclasses.replace(d, faults=options), odometry or ("real front-end" if d.path else "good")) for d in drives]

    def lies_rows(self):
        kinds = LIES if self.path_runs() else {name: lie for name, lie in LIES.items() if "--odometry" not in lie[0]}  # worlds' channels have no wheels
        return [(way, name, late, self.lying(drives, options)) for way, drives in self.ways().items() for name, (options, late) in kinds.items()]

    def lies_runs(self):
        return [run for *_, runs in self.lies_rows() for run in runs]

    def lies(self):
        rows = [[way, name, len(runs), *cells(self.results(runs), [("odometry.ate_rmse", 2)]),
                 *self.both(runs, [("trajectory.ate_rmse", 3), ("overall.f1", 2)]),
                 *self.both(runs, [("loops.accepted", sum, 0), ("loops.false", sum, 0)], over_seeds),
                 f"{late:.1f}", *cells(self.results(runs), [("cost.odometry_delay_s", 3)])] for way, name, late, runs in self.lies_rows()]
        return Table("lies", "When odometry lies", """
Worlds along real ways with the odometry of a real front-end, made worse (`hgg-sim --help`): late or early poses, every second frame, bursts in
which the five sharpest turns leave the track by 6 degrees and 0.3 to 1 m and come back, and wheels without an IMU (2 % of the way, 1 degree in
10 m) that are late as well. Loops are those of all seeds together. Late: how late odometry is, and what the mapper took it for.""",
                     ["way", "odometry", "drives", "ATE in, m", *self.headed(["ATE out, m", "F1", "accepted", "false"]), "late, s", "estimated, s"], rows, 2)

    # Carried away.

    def kidnap_rows(self):
        worlds = self.args.worlds[:1] if self.args.quick else [w for w in KIDNAP_WORLDS if w in self.args.worlds]
        return [(world, mode, *(self.kidnap_runs_of(world, mode, m) for m in (mode, "true"))) for world in worlds for mode in ("on", "zero")]

    def kidnap_runs_of(self, world, mode, odometry):
        """A place and a time for each seed; every other one has its odometry restarted. "true": undisturbed on the same way."""
        seeds = [seed for seed in range(1, self.args.kidnaps + 1) if (seed % 2 == 0) == (mode == "zero")]
        runs = []
        for seed in seeds:
            time = 2.5 if self.args.quick else round(20 + 7.3 * seed % 20, 1)  # s; a short drive has to be over the carrying
            drive = Drive(world, ALL_ROUND, seed, 60 if self.args.quick else 600, fault_s=time + CARRY_S,
                          faults=("--kidnap", str(time), "--kidnap-odometry", odometry))
            runs.append(Run(drive, "good"))
        return runs

    def kidnapping_runs(self):
        return [run for *_, carried, undisturbed in self.kidnap_rows() for run in carried + undisturbed]

    def kidnapping(self):
        rows = []
        for world, mode, carried, undisturbed in self.kidnap_rows():
            columns = [("back", back_share, 2), ("median", back_median, 1), ("wrong", wrong_places, 0)]
            rows.append([world, {"on": "goes on", "zero": "restarts at zero"}[mode], len(carried), *self.both(carried, columns, told_over),
                         *self.both(carried, [("overall.f1", 2)]), *cells(self.results(undisturbed), [("overall.f1", 2)])])
        return Table("kidnapping", "Carried to another place", f"""
After 20 to 40 s the robot is carried for {CARRY_S:.0f} s to a place it has been at, 5 to 60 m away, without sensing. Back: the share that is within 0.3 m
of the truth, and stays so, within {BACK_S:.0f} s of being put down, and the median of that time, by the poses as they were published. Wrong: drives that
were more than 1 m off for more than {SAID_S:.0f} s while the status said aligned. Told: the same way with odometry that knows where the robot was
carried. After so long without sensing the mapper trusts neither odometry, so that this differs only where recognising fails.""",
                     ["world", "odometry", "drives", *self.headed(["back", "after, s", "wrong", "F1"]), "F1, told"], rows, 2)

    # Faults at a time.

    def fault_rows(self):
        worlds = self.args.worlds[:1] if self.args.quick else [w for w in FAULT_WORLDS if w in self.args.worlds]
        time, frames = (2.0, 60) if self.args.quick else (20.0, 500)
        rows = []
        for world in worlds:
            for kind in FAULT_KINDS:
                told, at = (kind, 0.0) if kind == "xyzw" else (f"{kind}@{time:g}", time)
                rows.append((world, kind, [Run(Drive(world, ALL_ROUND, seed, frames, faults=("--odometry-fault", told), fault_s=at), "good")
                                           for seed in self.args.seeds]))
        return rows

    def faults_runs(self):
        return [run for *_, runs in self.fault_rows() for run in runs]

    def faults(self):
        columns = [("said", said_worst, 1), ("back", back_median, 1), ("wrong", wrong_places, 0), ("end", end_worst, 2)]
        rows = [[world, kind, *self.both(runs, columns, told_over), *self.both(runs, [("overall.f1", 2)])] for world, kind, runs in self.fault_rows()]
        return Table("faults", "Odometry that breaks", f"""
One fault a drive: a jump of 4 to 8 m, a turn of 30 to 120 degrees, wheels that slip or odometry that stands still for 5 s; xyzw: all quaternions in
the wrong order, from the start. Said: s until the status is other than aligned, the slowest; back: s until the published pose is within 0.3 m of the
truth and stays so, median. Wrong: drives more than 1 m off for more than {SAID_S:.0f} s while the status said aligned.""",
                     ["world", "fault", *self.headed(["said, s", "back, s", "wrong", "m off in the end", "F1"])], rows, 2)

    # What beliefs are worth.

    def belief_rows(self):
        worlds = [w for w in (self.args.worlds if self.args.quick else BELIEF_WORLDS) if w in self.args.worlds]
        more = self.more_seeds()
        ways = {world: [dataclasses.replace(self.runs(world)[0].drive, seed=seed) for seed in more] for world in worlds}
        for run in self.path_runs():
            ways[run.drive.world] = [dataclasses.replace(run.drive, seed=seed) for seed in more]
        return [(way, name, self.lying(drives, options)) for way, drives in ways.items() for name, options in (("as is", ()), ("late by 0.1 s", LATE))]

    def beliefs_runs(self):
        return [run for *_, runs in self.belief_rows() for run in runs]

    def beliefs(self):
        columns = [(f"positions.{which}.{figure}", 2) for which in ("from_start", "neighbours") for figure in ("mean_over_3", "inside_90")]
        rows = [[way, name, *self.both(runs, columns)] for way, name, runs in self.belief_rows()]
        return Table("beliefs", "Whether positions keep their word over a long way", f"""
Positions of found objects against the published covariance, the map laid over the truth at the first pose, from where beliefs grow; and of pairs
within 30 m against one another, under the covariance of their difference. {self.more_seeds_told().capitalize()}. NEES / 3: honest 1;
the 90 % region should hold 0.9.""", ["way", "odometry", *self.headed(["NEES / 3", "inside 90 %", "neighbours, NEES / 3", "neighbours, inside 90 %"])], rows, 2)

    # A place with little to hold on to.

    def corridor_rows(self):
        return [(o, self.runs("corridor", None, o)) for o in ("true", "good", "poor") if o in self.args.odometry and "corridor" in self.args.worlds]

    def corridor_runs(self):
        return [run for _, runs in self.corridor_rows() for run in runs]

    def corridor(self):
        columns = [("trajectory.ate_rmse", 3), ("trajectory.height_worst", 3), ("overall.f1", 2)]
        rows = [[o, *cells(self.results(runs), [("odometry.ate_rmse", 3)]), *self.both(runs, columns)] for o, runs in self.corridor_rows()]
        return Table("corridor", "Good odometry is not made worse", """
A corridor with eight rooms and a solid-state LiDAR (120 degrees, 64 beams, 8 mm of range noise, 25 m). Height: the largest error along the vertical.""",
                     ["odometry", "ATE in, m", *self.headed(["ATE out, m", "height, m", "F1"])], rows, 1)


def told_over(results, columns):
    """A cell per (name, how, digits) column: how makes a number or a word of all drives' figures."""
    if not results:
        return ["not run"] * len(columns)
    if any("error" in r for r in results):
        return [FAILED] * len(columns)
    if any(not r.get("recovery") for r in results):
        return [NOT_YET] * len(columns)
    made = [(how(results), digits) for _, how, digits in columns]
    return [f"{value:.{digits}f}" if isinstance(value, (int, float)) else value for value, digits in made]


def back_times(results):
    return [dig(r, "recovery.back_after_s") for r in results]


def back_share(results):
    return sum(t is not None and t <= BACK_S for t in back_times(results)) / len(results)


def back_median(results):
    times = sorted(float("inf") if t is None else t for t in back_times(results))
    middle = times[(len(times) - 1) // 2]
    return "never" if middle == float("inf") else middle


def said_worst(results):
    times = [dig(r, "recovery.said_after_s") for r in results]
    return "never" if None in times else max(times)


def wrong_places(results):
    return sum((dig(r, "recovery.longest_wrong_s") or 0) > SAID_S for r in results)


def end_worst(results):
    return max(dig(r, "recovery.end_error") or 0 for r in results)
