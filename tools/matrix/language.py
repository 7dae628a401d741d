"""The table of what is found by its description on mapped graphs: its runs and what came of them. Part of Matrix."""
from matrix.answers import KINDS
from matrix.figures import FAILED, NOT_YET, Table
from matrix.workshop import Drive, Run, main_sensor

LANGUAGE_WORLDS = ["apartment", "office", "hall", "street"]
MERGES = [("evidence (NIW)", ()), ("symmetric average", (("ablation.symmetric_merge", "true"),))]
RULES = ["surfaces", "edges", "centroids"]  # of hggmap query --nearness
def shares(counts):
    """R@1 and R@3 over all queries, and over those whose target the map has."""
    queries, mapped, first, third = counts
    return [f"{first / queries:.2f} / {third / queries:.2f} of {queries}" if queries else "–",
            f"{first / mapped:.2f} / {third / mapped:.2f} of {mapped}" if mapped else "–"]


class Language:
    def language_worlds(self):
        return self.args.sensor_worlds if self.args.worlds_named or self.args.quick else [w for w in LANGUAGE_WORLDS if w in self.args.known_worlds]

    def language_runs_of(self, world, switches):
        return [Run(Drive(world, main_sensor(world), seed, self.args.frames), "good", switches) for seed in self.args.seeds]

    def can_ask(self):
        return "query" in self.workshop.commands and "--nearness" in self.workshop.call("hggmap", "query", "--help")

    def language_runs(self):
        return [run for world in self.language_worlds() for _, switches in MERGES if self.workshop.has_switches(switches)
                for run in self.language_runs_of(world, switches)] if self.can_ask() else []

    def language_cells(self, world, switches, rule):
        runs = self.language_runs_of(world, switches)
        if not self.can_ask() or not self.workshop.has_switches(switches):
            return [NOT_YET] * (len(KINDS) + 2)
        asked = [self.workshop.tried(f"questions to {run.name()}", lambda run=run: self.workshop.ask(run, rule)) for run in runs
                 if "error" not in self.figures[run]]
        if len(asked) < len(runs) or None in asked:
            return [FAILED] * (len(KINDS) + 2)
        sums = {kind: [sum(a[kind][k] for a in asked) for k in range(4)] for kind in KINDS}
        everything = [sum(s[k] for s in sums.values()) for k in range(4)]
        return [*(shares(sums[kind])[0] for kind in KINDS), *shares(everything)]

    def language(self):
        ways = [(merge, switches, RULES[0]) for merge, switches in MERGES[:1]] + [(*MERGES[0], rule) for rule in RULES[1:]] + [(*MERGES[1], RULES[0])]
        rows = [[world, merge, rule, *self.language_cells(world, switches, rule)] for world in self.language_worlds() for merge, switches, rule in ways]
        return Table("language", "Goals in words on mapped graphs", """
The world's own queries (R@1 / R@3 of so many, all seeds together), good odometry. Unique: the only one of its class; relational: next
to, closest to, farthest from; disambiguation: largest, smallest, tallest. Nearness: by surfaces as shipped; the paper's, neighbours
of the anchor in the graph first, in the order of the edge weight; by the distance of the middles. A target that the map does not hold
counts as missed, but in the last column. Merge: the paper's ablation of the evidence.""",
                     ["world", "merge", "nearness", *KINDS, "all", "all that are in the map"], rows, 3)
