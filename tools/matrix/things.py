"""The table of things as they are: small, moving, gone, seen again, under wrong names. Part of Matrix."""
from matrix.figures import NOT_YET, Table, cells
from matrix.workshop import Drive, Run, radius_of

THING_WORLDS = {"street": "lidar64", "campus": "lidar64", "passes": "lidar64", "corridor": "solid64", "office": "solid64"}
WITH_PLATES = {"street", "campus"}  # small signs on poles as an option; passes has them anyway
COMMON = [0.05, 0.10]  # shares that are taken for another common class
WITHOUT = [("nothing: as shipped", ()), ("free space", (("ablation.blind_to_free_space", "true"),)), ("movers", (("ablation.blind_to_motion", "true"),)),
           ("small things", (("ablation.single_frames", "true"),)), ("pieces", (("ablation.loose_pieces", "true"),))]
CAUSES = ["second", "mover", "gone", "surface", "nothing"]
THING_COLUMNS = [("overall.truth", 0), ("overall.f1", 3), ("overall.recall", 3), ("overall.precision", 3), ("overall.position_error.mean", 3),
                 ("by_class.traffic-sign.recall", 2), ("overall.twins", 1), ("overall.ghosts", 1), *((f"overall.ghost_causes.{c}", 1) for c in CAUSES)]


class Things:
    def thing_worlds(self):
        """Those named; quickly or where none of them is there, those of the other tables with their own sensor."""
        named = [w for w in THING_WORLDS if w in (self.args.worlds if self.args.worlds_named else self.args.known_worlds)]
        return named if named and not self.args.quick else self.args.worlds

    def thing_odometry(self):
        return [o for o in ("good", "poor") if o in self.args.odometry] or self.args.odometry[-1:]

    def thing_rows(self):
        """(world, share, odometry, runs)."""
        sensor = lambda world: THING_WORLDS.get(world, "lidar64")
        drive = lambda world, seed, share: Drive(world, sensor(world), seed, self.args.frames, busy=True, common=share, plates=world in WITH_PLATES)
        return [(world, share, odometry, [Run(drive(world, seed, share), odometry) for seed in self.more_seeds()])
                for world in self.thing_worlds() for share in COMMON for odometry in self.thing_odometry()]

    def thing_runs(self):
        return [run for *_, runs in self.thing_rows() for run in runs]

    def things(self):
        by_name = lambda r: {**r, "by_class": {c["name"]: c for c in r.get("classes", []) if c.get("truth")}}
        rows = [[world, runs[0].drive.sensor, f"{share:.0%}", odometry, *cells([by_name(r) for r in self.results(runs)], THING_COLUMNS)]
                for world, share, odometry, runs in self.thing_rows()]
        return Table("things", "Things as they are", f"""
Worlds in traffic (`hgg-sim --dynamics`), with cars that park and leave, signs of 0.35 m on poles (`--plates`; `passes` has them anyway), 1.5 % speckle and
a share of things and stretches of stuff under the name of another common class for 5 to 20 frames at a time (`--confusion-common`); {self.more_seeds_told()}.
`passes` drives one road out, back on the other lane, and out again. Twins: pairs of nodes of one class within 0.5 m that are one true thing. Ghosts, by
what they come from: a second node or piece of a thing that is found; left by something that moves; of a thing that was taken away; on a surface
of another class; at nothing. Radius {radius_of('street')} m outdoors, {radius_of('office')} m indoors.""",
                     ["world", "sensor", "confused", "odometry", "objects", "F1", "recall", "precision", "position, m", "sign recall", "twins", "ghosts",
                      "second", "moving", "gone", "other surface", "nothing"], rows, 4)

    def mechanism_runs_of(self, world, switches):
        odometry = self.thing_odometry()[0]
        return [Run(Drive(world, THING_WORLDS.get(world, "lidar64"), seed, self.args.frames, busy=True, common=COMMON[0], plates=world in WITH_PLATES),
                    odometry, switches) for seed in self.more_seeds()]

    def mechanism_runs(self):
        return [run for world in self.thing_worlds() for _, switches in WITHOUT if self.workshop.has_switches(switches)
                for run in self.mechanism_runs_of(world, switches)]

    def mechanisms(self):
        columns = THING_COLUMNS[1:]
        by_name = lambda r: {**r, "by_class": {c["name"]: c for c in r.get("classes", []) if c.get("truth")}}
        rows = [[world, name, *(cells([by_name(r) for r in self.results(self.mechanism_runs_of(world, switches))], columns)
                                if self.workshop.has_switches(switches) else [NOT_YET] * len(columns))]
                for world in self.thing_worlds() for name, switches in WITHOUT]
        return Table("mechanisms", "What each mechanism is worth", f"""
The worlds of the table before with {COMMON[0]:.0%} under other names and {self.thing_odometry()[0]} odometry, with one mechanism switched off in each row:
beams that pass where a thing would be (`[ablation] blind_to_free_space`), following what moves (`blind_to_motion`), gathering what is too
small for one frame (`single_frames`), making one of parts that touch and of a thing and other names for it (`loose_pieces`); {self.more_seeds_told()}.""",
                     ["world", "without", "F1", "recall", "precision", "position, m", "sign recall", "twins", "ghosts",
                      "second", "moving", "gone", "other surface", "nothing"], rows, 2)
