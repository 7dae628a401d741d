"""The table of where one can walk: its runs and what came of them. Part of Matrix."""
from matrix.figures import FAILED, NOT_YET, Table, cells
from matrix.workshop import GROUNDS, PLANS, Drive, Run

WALK_WORLDS = ["street", "campus", "office", "corridor", *GROUNDS]
WALK_SENSOR = "lidar64"  # what a robot on legs carries
WALK_FRAMES = 500
GRID = [("grid.strict.blocked_called_walkable", 4), ("grid.strict.precision", 4), ("grid.strict.recall", 3),
        ("grid.tolerant.blocked_called_walkable", 4), ("grid.tolerant.precision", 4), ("grid.tolerant.recall", 3),
        ("grid.local.strict.blocked_called_walkable", 4), ("grid.local.strict.precision", 4), ("grid.local.strict.recall", 3)]
PLANNED = [("plans.share", 3), ("plans.through_blocked", 1), ("plans.off_ground", 1), ("plans.mean_ratio", 3), ("plans.longer", 1)]


class Walks:
    def walk_worlds(self):
        """Those named; else those that have something to tell."""
        return self.args.sensor_worlds if self.args.worlds_named or self.args.quick else [w for w in WALK_WORLDS if w in self.args.known_worlds]

    def walk_runs_of(self, world):
        return [Run(Drive(world, WALK_SENSOR, seed, self.args.frames or WALK_FRAMES), "good") for seed in self.args.seeds]

    def walk_runs(self):
        return [run for world in self.walk_worlds() for run in self.walk_runs_of(world)] if self.workshop.can_walk() else []

    def walk_cells(self, world):
        if not self.workshop.can_walk():
            return [NOT_YET] * (len(GRID) + len(PLANNED))
        runs = self.walk_runs_of(world)
        if any("error" in self.figures[run] for run in runs):
            return [FAILED] * (len(GRID) + len(PLANNED))
        walks = [self.workshop.tried(f"walks of {run.name()}", lambda: self.workshop.walk(run)) for run in runs]
        return cells([walk or {"error": ""} for walk in walks], GRID + PLANNED)

    def traversability(self):
        rows = [[world, WALK_SENSOR, *self.walk_cells(world)] for world in self.walk_worlds()]
        return Table("traversability", "Where one can walk", f"""
The grid of `hggmap export --format grid` at 0.1 m against the truth's, with good odometry. Asked are cells of the ground that a beam
came back from (docs/simulator.md). Blocked: the share of truly blocked cells that the map calls walkable. Precision: the share of its
walkable cells that can be walked on. Recall: of truly free cells within 12 m of the way, those it calls walkable. Cell for cell; then
right when any of the 3 x 3 cells is; then cell for cell with the map laid over the truth by the nearest pose, so that drift does not
count. Plans: {PLANS} pairs a drive, between which the truth has a way for a robot of 0.3 m radius with 0.1 m margin: the share
found, paths over truly blocked cells, paths where there is no ground, their length over the truth's shortest, and paths of more than 1.1 times it.""",
                     ["world", "sensor", "blocked", "precision", "recall", "blocked, one off", "precision", "recall", "blocked, no drift",
                      "precision", "recall", "plans found", "through blocked", "off ground", "length", "longer"], rows, 2)
