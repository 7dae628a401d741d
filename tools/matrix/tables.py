"""Which runs each table needs, and the tables."""
import dataclasses
import json
import math

from matrix.figures import FAILED, NOT_YET, Table, cells, dig, over_seeds, spread
from matrix.language import Language
from matrix.lies import Lies
from matrix.real import real_rows
from matrix.things import Things
from matrix.walks import Walks
from matrix.workshop import Drive, Run, is_indoor, main_sensor, radius_of

SENSOR_WORLDS = ["street", "office"]  # --full and --worlds take others
SENSOR_FRAMES = 300

LOOP_COLUMNS = [("loops.accepted", sum, 0), ("loops.false", sum, 0)]
LOOP_DETAILS = [("loops.asked", sum, 0), *LOOP_COLUMNS, ("loops.worst_m", max, 2), ("loops.worst_deg", max, 2),
                ("loops.revisits", sum, 0), ("loops.revisits_asked", sum, 0), ("loops.revisits_closed", sum, 0)]
OBJECT_COLUMNS = [("overall.truth", 0), ("overall.position_error.mean", 2), ("overall.recall", 2), ("overall.precision", 2),
                  ("overall.f1", 2), ("overall.extent_error.mean", 2), ("overall.calibration.mean_over_3", 0),
                  ("overall.calibration.inside_90", 2), ("overall.calibration.mean_sigma", 2)]
OBJECT_HEADER = ["objects", "position, m", "recall", "precision", "F1", "extent, m", "NEES / 3", "inside 90 %", "sigma, m"]


class Matrix(Language, Lies, Things, Walks):
    """Which runs each table needs, and the table once they are there."""

    def __init__(self, workshop, args):
        self.workshop, self.args, self.figures, self.timing = workshop, args, {}, {}
        self.figures_before = {}  # of the mapper of --before

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

    CORRECTION = [(False, False), (True, False), (False, True), (True, True)]  # EM (where poses are odometry's: the window), loops
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

    def more_seeds_told(self):
        number = len(self.more_seeds())
        return f"{number} seeds" if number > 1 else "one seed"

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

    def ways_told(self):
        """A world is met again in its second lap, which short drives do not reach."""
        frames = self.args.loop_frames
        return "" if frames == self.args.frames else f" over the first {frames} frames" if frames else " over whole tours"

    def drift_switches(self, window, loops):
        return (*self.ODOMETRY_POSE, ("correction.window", str(window).lower()), ("correction.loop_closure", str(loops).lower()))

    def correction_odometry(self):
        return "poor" if "poor" in self.args.odometry else self.args.odometry[-1]

    def correction_runs(self):
        kinds = [self.correction_switches(*row) for row in self.CORRECTION] + [self.drift_switches(*row) for row in self.CORRECTION]
        return [run for world in self.correction_worlds() for switches in kinds if switches is not None and self.workshop.has_switches(switches)
                for run in self.correction_runs_of(world, switches)]

    def correction_worlds(self):
        """Those of the sensors, and those that are hard on loops: a whole tour takes long."""
        return self.args.worlds if self.args.full else [w for w in self.args.worlds if w in (*self.args.sensor_worlds, *self.LOOP_WORLDS)]

    def correction_runs_of(self, world, switches):
        return self.runs(world, None, self.correction_odometry(), switches, frames=self.args.loop_frames)

    def loop_rows(self):
        """(words of the row, its runs)."""
        rows = {}
        for poses, switches in self.POSES.items():
            for run in self.path_runs():
                rows.setdefault((run.drive.world, run.odometry, poses), []).append(dataclasses.replace(run, switches=switches))
            for world in (w for w in self.args.worlds if self.args.quick or w in self.LOOP_WORLDS):
                for odometry in self.loop_odometry() if poses == "map" else self.loop_odometry()[:1]:
                    rows[world, odometry, poses] = [Run(Drive(world, main_sensor(world), seed, self.args.loop_frames), odometry, switches)
                                                    for seed in self.more_seeds()]
        return sorted(rows.items(), key=lambda row: (not row[0][0].startswith("along"), row[0][:2]))

    def loop_odometry(self):
        return [o for o in ("good", "poor") if o in self.args.odometry] or self.args.odometry[-1:]

    def loop_runs(self):
        return [run for _, runs in self.loop_rows() for run in runs if self.workshop.has_switches(run.switches)]

    def calibration_rows(self):
        """(world, its runs): the two worlds that are judged first."""
        judged = [w for w in SENSOR_WORLDS if w in self.args.worlds]
        return [(world, [Run(Drive(world, main_sensor(world), seed, self.args.frames), self.calibration_odometry()) for seed in self.more_seeds()])
                for world in [*judged, *(w for w in self.args.worlds if w not in judged)]]

    def calibration_odometry(self):
        return "good" if "good" in self.args.odometry else self.args.odometry[0]

    def calibration_runs(self):
        return [run for _, runs in self.calibration_rows() for run in runs]

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
{self.more_seeds_told()}. Whatever became a node and is no true object costs precision.""",
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
their means, or by how little their boxes overlap (`[ablation] cost`), with {self.correction_odometry()} odometry and {self.more_seeds_told()}. F1 is that of the
objects of the final map, after nodes that are one object were merged. The wide gate lets neighbours be candidates too.""",
                     ["world", "gate", "cost", *OBJECT_HEADER[1:5]], rows, 3)

    def correction(self):
        columns = [("geometry.chamfer", 3), ("geometry.accuracy", 3), ("overall.f1", 2), ("odometry.ate_rmse", 2), ("trajectory.ate_rmse", 2)]
        said = lambda on: "yes" if on else ""
        kinds = [["map", "shipped", said(em), said(loops), self.correction_switches(em, loops)] for em, loops in self.CORRECTION]
        kinds += [["odometry", said(window), "shipped", said(loops), self.drift_switches(window, loops)] for window, loops in self.CORRECTION]
        rows = []
        for world in self.correction_worlds():
            for *words_, switches in kinds:
                ready = switches is not None and self.workshop.has_switches(switches)
                results = self.results(self.correction_runs_of(world, switches)) if ready else []
                rows.append([world, *words_, *([*cells(results, columns), *over_seeds(results, LOOP_COLUMNS)] if ready else [NOT_YET] * 7)])
        return Table("correction", "What correction is worth", f"""
Window, EM on the leaves and loop closure, each on and off, with {self.correction_odometry()} odometry{self.ways_told()}. Poses: of the map, as a robot has them, which hardly
drift where the map is met again; or odometry's ({" ".join(f"`{key} = {value}`" for key, value in self.ODOMETRY_POSE)}), which leaves all of
its drift to window and loops. Accepted and false loops are those of all seeds together; false: more than 1 m or 3 degrees off.""",
                     ["world", "poses", "window", "EM", "loops", "Chamfer, m", "map accuracy, m", "F1", "ATE in, m", "ATE out, m", "accepted", "false"], rows, 5)

    def loops(self):
        columns = [("odometry.ate_rmse", 2), ("trajectory.ate_rmse", 2), ("overall.f1", 2)]
        rows = []
        for row, runs in self.loop_rows():
            ready = self.workshop.has_switches(runs[0].switches)
            results = self.results(runs) if ready else []
            rows.append([*row, len(runs), *([*cells(results, columns), *over_seeds(results, LOOP_DETAILS)] if ready else [NOT_YET] * 11)])
        return Table("loops", "Loops", f"""
"Along KITTI": a made-up world along the whole true way of that drive, with the odometry of a real front-end; the others{self.ways_told() or " by drives as in the other tables"}. Poses: of the map or odometry's, as in the table of correction. Loops and revisits are those of all seeds together. Asked:
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
        for world, runs in self.calibration_rows():
            rows.append([world, *cells(self.results(runs), columns)])
        return Table("calibration", "Whether positions keep their word", f"""
Positions of found objects against the covariance the map publishes for them, with {self.calibration_odometry()} odometry and {self.more_seeds_told()}. Before: the
extent's covariance over the number of points, as if every point were a new look; after: what is published. NEES / 3: mean and median
of the normalised squared position error over 3 (honest: 1 and 0.79); the 90 % region should hold 0.9.""",
                     ["world", "position, m", "NEES / 3, before", "after", "median, before", "after", "inside 90 %, before", "after",
                      "sigma, m, before", "after"], rows, 1)

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
                "sensors": self.sensor_runs, "busy": self.busy_runs, "confusion": self.confusion_runs, "things": self.thing_runs, "mechanisms": self.mechanism_runs, "niw": self.niw_runs, "pairing": self.pairing_runs, "correction": self.correction_runs,
                "loops": self.loop_runs, "lies": self.lies_runs, "kidnapping": self.kidnapping_runs, "faults": self.faults_runs, "beliefs": self.beliefs_runs,
                "corridor": self.corridor_runs, "traversability": self.walk_runs, "calibration": self.calibration_runs,
                "alignment": self.object_runs if "align" in self.workshop.commands else list, "cost": self.timing_runs,
                "retrieval": self.object_runs if "query" in self.workshop.commands else list, "language": self.language_runs, "real": list}[name]()


LYING = ["lies", "kidnapping", "faults", "beliefs", "corridor"]  # the tables of --only odometry, measured --before as well
TABLES = ["objects", "sensors", "busy", "confusion", "things", "mechanisms", "trajectory", "geometry", "niw", "pairing", "correction", "loops", *LYING, "traversability", "calibration", "alignment", "retrieval", "language", "cost", "real"]


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
