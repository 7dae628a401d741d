#!/usr/bin/env python3
"""tools/matrix/run.py: its arithmetic, its cache and its document, with programs made of a few lines of shell."""
import json
import math
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import types
import unittest
from pathlib import Path

REPO = Path(__file__).resolve().parent.parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(REPO / "tools"))
from matrix import answers, figures, language, lies, tables, workshop  # noqa: E402
from matrix.figures import Table  # noqa: E402
from matrix.page import section, with_section  # noqa: E402
from matrix.run import describe  # noqa: E402

SCORES = {"overall": {"truth": 4, "f1": 0.5, "recall": 1.0, "precision": 0.4, "position_error": {"mean": 0.25}, "extent_error": {"mean": 0.3},
                      "calibration": {"mean_over_3": 12, "inside_90": 0.1, "mean_sigma": 0.07}, "set_aside": 6, "matches": [{"id": 1}], "missed": [], "ghosts": [7]},
          "cost": {"frames": 5, "loops": [{"before_us": 1}]},
          "loops": {"asked": 9, "accepted": 2, "false": 1, "worst_m": 1.25, "worst_deg": None, "revisits": 3, "revisits_asked": 2, "revisits_closed": 1},
          "grid": {"strict": {"blocked_called_walkable": 0.01, "precision": 0.99, "recall": 0.9}},
          "plans": {"share": 0.5, "through_blocked": 2, "off_ground": 0, "mean_ratio": 1.02, "longer": 1},
          "classes": [], "odometry": None, "geometry": None, "retrieval": None,
          "trajectory": {"ate_rmse": 0.5, "share": 0.75, "T_truth_map": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]}}
STATS = {"frames": 5, "frame_ms": {"p50": 3, "p99": 9}, "stage_ms": {"creation": {"p50": 2}}, "map_mb": 1.5, "peak_rss_mb": 20,
         "memory": [{"frame": 1, "map_mb": 1}, {"frame": 5, "map_mb": 1.5}], "time": [{"frame": 1, "mean_ms": 3, "max_ms": 4}]}

SIM = r"""#!/bin/sh
[ "$1" = --list ] && { printf 'worlds:\n  apartment\n  campus\n  office\n  street\n  yard\nsensors:\n  lidar16 beams\n  lidar64 beams\n  rgbd camera\n'; exit 0; }
echo "sim $*" >> CALLS
for a in "$@"; do [ "$a" = BROKEN ] && { echo 'hgg-sim: broken on purpose' >&2; exit 2; }; done
while [ $# -gt 0 ]; do
  [ "$1" = -o ] && echo log > "$2"
  [ "$1" = --truth ] && mkdir -p "$2"
  shift
done
"""
HELP = """hggmap: LiDAR and odometry in, a probabilistic scene graph out
Usage: hggmap [OPTIONS] SUBCOMMAND

Options:
  -h,--help                   Print this help message and exit

Subcommands:
  run                         Map live from LCM until Ctrl-C, then save
  replay                      Map an LCM log, deterministically and
                              align nothing, query nothing
MORE
Exit status: 0 done, 1 the answer is no, 2 bad input or usage.
"""
MAP = r"""#!/bin/sh
for a in "$@"; do case "$a" in --help) cat <<'END'
HELP
END
exit 0;; esac; done  # as CLI11 does: help wins over an unknown subcommand
case "$1" in
  run) printf '[ablation]\nsymmetric_merge = false  # x\n'; exit 0;;
  replay) ;;
  # align
  *) exit 2;;
esac
echo "map $*" >> CALLS
while [ $# -gt 0 ]; do [ "$1" = --out ] && mkdir -p "$2" && echo 'STATS' > "$2/stats.json"; shift; done
"""
EVAL = "#!/bin/sh\necho \"eval $*\" >> CALLS\necho 'SCORES'\n"


class Arithmetic(unittest.TestCase):
    def test_spread_is_mean_and_sample_deviation(self):
        self.assertEqual(figures.spread([1.0, 2.0, 3.0]), "2.00 ± 1.00")
        self.assertEqual(figures.spread([0.25]), "0.25")
        self.assertEqual(figures.spread([None, 0.25]), "0.25 (1 of 2)")
        self.assertEqual(figures.spread([1.0, None, 3.0]), "2.00 ± 1.41 (2 of 3)")
        self.assertEqual(figures.spread([]), "–")
        self.assertEqual(figures.spread([20000.0, 30000.0], 0), "2.50e+04 ± 7e+03")

    def test_cells_tell_missing_from_failed_from_not_run(self):
        columns = [("a.b", 1), ("c", 0)]
        self.assertEqual(figures.cells([{"a": {"b": 1}, "c": None}, {"a": {"b": 2}}], columns), ["1.5 ± 0.7", "not yet"])
        self.assertEqual(figures.cells([], columns), ["not run", "not run"])
        self.assertEqual(figures.cells([{"a": {"b": 1}}, {"error": "x"}], columns), ["failed", "failed"])

    def test_alignment_error_is_against_the_truth(self):
        turn = lambda a, t: [math.cos(a), -math.sin(a), 0, t[0], math.sin(a), math.cos(a), 0, t[1], 0, 0, 1, t[2]]
        of_map = lambda T: {"trajectory": {"T_truth_map": T}}
        a, b = of_map(turn(0.3, [1, 2, 0])), of_map(turn(0.5, [1, 2, 0]))
        self.assertAlmostEqual(tables.align_error({"T_a_b": turn(0.2, [0, 0, 0])}, a, b)[1], 0, places=5)
        metres, degrees = tables.align_error({"T_a_b": turn(0.3, [0, 0, 2])}, a, b)
        self.assertAlmostEqual(metres, 2)
        self.assertAlmostEqual(degrees, math.degrees(0.1))
        c = of_map(turn(0.3 + math.pi / 2, [1, 5, 0]))  # 3 m along the truth's y, seen from a map turned by 0.3
        self.assertAlmostEqual(tables.align_error({"T_a_b": turn(math.pi / 2, [3 * math.sin(0.3), 3 * math.cos(0.3), 0])}, a, c)[0], 0)

    def test_config_keys_are_set_in_their_section(self):
        toml = 'classes = "c.toml"  # path\n[frame]\nrange = 1.0  # [m] far\n[map]\nrange = 2.0\n'
        text = workshop.set_keys(toml, {"classes": '"/x"', "map.range": "5", "ablation.symmetric_merge": "true"})
        self.assertEqual(text, 'classes = "/x"\n[frame]\nrange = 1.0  # [m] far\n[map]\nrange = 5\n[ablation]\nsymmetric_merge = true\n')

    def test_keys_a_section_lacks_join_it(self):
        toml = 'classes = "c.toml"\n\n[correction]\ndrift_reach = 0.5  # [m]\n\n[ablation]\ncost = "iou"\n'
        text = workshop.set_keys(toml, {"correction.em": "true", "ablation.odometry_pose": "true", "new.key": "1", "new.other": "2", "top": "3"})
        self.assertEqual(text, 'classes = "c.toml"\ntop = 3\n\n[correction]\ndrift_reach = 0.5  # [m]\nem = true\n\n[ablation]\ncost = "iou"\n'
                               'odometry_pose = true\n[new]\nkey = 1\nother = 2\n')

    def test_figures_over_seeds_are_sums_and_worst(self):
        columns = [("loops.accepted", sum, 0), ("loops.worst_m", max, 2)]
        loops = lambda accepted, worst: {"loops": {"asked": 5, "accepted": accepted, "worst_m": worst}}
        self.assertEqual(figures.over_seeds([loops(2, 0.3), loops(0, None)], columns), ["2", "0.30"])
        self.assertEqual(figures.over_seeds([loops(0, None)], columns), ["0", "–"])
        self.assertEqual(figures.over_seeds([{"loops": None}], columns), ["not yet", "not yet"])
        self.assertEqual(figures.over_seeds([loops(2, 0.3), {"error": "x"}], columns), ["failed", "failed"])
        self.assertEqual(figures.over_seeds([], columns), ["not run", "not run"])

    def test_a_path_is_known_by_what_is_in_its_files(self):
        with tempfile.TemporaryDirectory() as folder:
            files = Path(folder) / "gt.txt", Path(folder) / "odometry.txt"
            for file in files:
                file.write_text("1 0 0 0\n")
            drive = workshop.Drive("along", "lidar64", 1, 0, False, tuple(map(str, files)))
            before = drive.identity()
            self.assertEqual(drive.identity(), before)
            files[1].write_text("1 0 0 1\n")
            self.assertNotEqual(drive.identity(), before)

    def test_tables_are_markdown(self):
        table = figures.Table("t", "T", "", ["world", "F1"], [["yard", "1.00"]])
        self.assertEqual(table.markdown(), "| world | F1 |\n| --- | ---: |\n| yard | 1.00 |")


    def test_a_table_takes_the_place_of_the_one_it_was(self):
        info = {"script": "run.py", "commit": "abc", "machine": "m"}
        table = lambda name, title, value: Table(name, title, "Text.", ["a"], [[value]])
        document = "# All\n\n" + "\n".join(section(table(n, t, "old"), info) for n, t in (("one", "First"), ("two", "Second"), ("three", "Third")))
        for name, title in (("one", "First"), ("two", "Second"), ("three", "Third")):
            changed = with_section(document, table(name, title, "new"), info)
            self.assertEqual(changed.count("| new |"), 1)
            self.assertEqual(changed.count("| old |"), 2)
            self.assertEqual([l for l in changed.splitlines() if l.startswith("## ")], ["## First", "## Second", "## Third"])
        self.assertTrue(with_section(document, table("four", "Fourth", "new"), info).startswith(document.rstrip()))

    def test_a_command_is_told_without_what_is_of_a_machine(self):
        args = types.SimpleNamespace(frames=0, quick=False, seeds=[1])
        told = describe(args, ["--build", "/b", "--only", "lies", "--write", "--paths", "07", "--out=/o", "--jobs", "1"])
        self.assertEqual(told["script"], "tools/matrix/run.py --paths 07")


class Answers(unittest.TestCase):
    def test_are_counted_by_what_was_asked(self):
        texts = ["the door", "the bed next to the desk", "the tallest chair", "the lamp farthest from the door"]
        queries = [{"text": text, "target": 10 + k} for k, text in enumerate(texts)]
        said = [[1], [7, 2], [7, 8, 9, 3], []]  # nodes, best first
        matches = [{"truth": 10, "id": 1}, {"truth": 11, "id": 2}, {"truth": 12, "id": 3}]  # the lamp is not in the map
        counts = answers.score(queries, [{"answers": [{"id": i} for i in ids]} for ids in said], matches)
        self.assertEqual(counts, {"unique": [1, 1, 1, 1], "relational": [2, 1, 0, 1], "disambiguation": [1, 1, 0, 0]})
        self.assertEqual(language.shares(counts["relational"]), ["0.00 / 0.50 of 2", "0.00 / 1.00 of 1"])
        self.assertEqual(language.shares([0, 0, 0, 0]), ["–", "–"])


class Command(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.dir = Path(scratch.name)
        self.calls = self.dir / "calls.txt"
        self.build = self.dir / "build"
        self.build.mkdir()
        self.commands = []
        for name, text in (("hgg-sim", SIM), ("hggmap", MAP), ("hgg-eval", EVAL), ("hgg-convert", EVAL)):
            self.program(name, text)

    def program(self, name, text):
        text = text.replace("HELP", HELP.strip()).replace("MORE\n", "".join(f"  {word}  Does it\n" for word in self.commands) + "\n")
        text = text.replace("CALLS", str(self.calls)).replace("STATS", json.dumps(STATS)).replace("SCORES", json.dumps(SCORES))
        (self.build / name).write_text(text)
        (self.build / name).chmod(0o755)

    def aligning(self, answer):
        """A mapper that has the command align."""
        self.commands = ["align"]
        self.program("hggmap", MAP.replace("# align", f"align) {answer};;"))

    def walking(self, batch):
        """A mapper that exports grids and plans, whose answers are one word of JSON."""
        self.commands = ["export", "plan"]
        text = MAP.replace("HELP\nEND", f"HELP\n  --format json|grid\n{'  --batch' if batch else ''}\nEND")
        text = text.replace("# align", "export) ;;\n  plan) echo '{\"found\": false}';;")
        self.program("hggmap", text)
        asks = "for a in \"$@\"; do case $a in */requests.jsonl) r=$a;; --plans) p=1;; esac; done\n"
        line = '{"from":[1,2,3],"to":[4,5,6],"shortest":7}'
        self.program("hgg-eval", EVAL.replace("echo 'SC", asks + f"[ -n \"$p\" ] && printf '{line}\\n{line}\\n' > $r\necho 'SC"))

    def command(self, *arguments):
        command = [sys.executable, REPO / "tools" / "matrix" / "run.py", "--build", self.build, "--out", self.dir / "out", "--data", self.dir / "none",
                   "--jobs", "2", *arguments]
        return {"args": list(map(str, command)), "text": True, "env": {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}}

    def run_it(self, *arguments):
        done = subprocess.run(capture_output=True, **self.command(*arguments))
        return done.returncode, done.stdout, done.stderr

    def document(self):
        return (self.dir / "out" / "evaluation.md").read_text()

    def workshop(self, keep_gb=1):
        return workshop.Workshop(self.build, self.dir / "out", keep_gb, 1)

    def count(self, program):
        return sum(line.startswith(program) for line in self.calls.read_text().splitlines())

    def test_quick_fills_the_document(self):
        code, _, errors = self.run_it("--quick")
        self.assertEqual(code, 0, errors)
        text = (self.dir / "out" / "evaluation.md").read_text()
        for part in ("## Objects, by world and odometry", "| yard | lidar64 | true | 4 ± 0 | 0.25 ± 0.00 | 1.00 ± 0.00 | 0.40 ± 0.00 | 0.50 ± 0.00 | 0.30 ± 0.00 | 12 ± 0 | 0.10 ± 0.00 | 0.07 ± 0.00 |\n",
                     "| 0.07 ± 0.00 | 6 ± 0 |\n", "| yard | good | 0.75 ± 0.00 | not yet |", "| programs | hgg-sim ",
                     "| apartment | good | symmetric average, uniform weights | not yet |", "| yard | map | shipped | yes | yes | not yet |",
                     "same place, two drives | not yet", "| yard | lidar64 | 5 | 3.0 | 9.0 | 2.0 | not yet | not yet | 1.50 | 1.50 | 20 |",
                     "--quick --only objects", "seeds | 1, 2"):
            self.assertIn(part, text)

    def test_page_is_one_file(self):
        self.run_it("--quick")
        page = (self.dir / "out" / "evaluation.html").read_text()
        self.assertIsNone(re.search(r"https?:|<link|src=|url\(|@import|fetch\(", page))
        data = json.loads(re.search(r'type="application/json">(.*?)</script>', page, re.S).group(1))
        self.assertEqual([t["name"] for t in data["tables"]], tables.TABLES)
        self.assertEqual(data["charts"]["groups"][0]["F1"], [0.5, 0.5])

    def test_a_second_call_runs_nothing_again(self):
        self.run_it("--quick")
        before = self.calls.read_text()
        self.assertEqual(self.run_it("--quick")[0], 0)
        self.assertEqual(self.calls.read_text(), before)

    def test_a_changed_mapper_is_measured_again_on_the_same_logs(self):
        self.run_it("--quick")
        sims, maps = self.count("sim"), self.count("map")
        self.program("hggmap", MAP + "# changed\n")
        self.run_it("--quick")
        self.assertEqual(self.count("sim"), sims)
        self.assertEqual(self.count("map"), 2 * maps)

    def test_runs_that_share_a_drive_share_its_log(self):
        self.run_it("--quick", "--only", "niw", "--worlds", "yard")
        self.assertEqual(self.count("sim"), 2)  # a drive a seed holds every odometry quality
        self.assertEqual(self.count("map"), 8)  # with and without the switch

    def test_a_changed_evaluator_scores_the_same_maps_again(self):
        self.run_it("--quick", "--only", "objects")
        sims, maps, evals = self.count("sim"), self.count("map"), self.count("eval")
        self.program("hgg-eval", EVAL + "# changed\n")
        self.run_it("--quick", "--only", "objects")
        self.assertEqual((self.count("sim"), self.count("map"), self.count("eval")), (sims, maps, 2 * evals))

    def test_a_log_that_was_dropped_is_simulated_again_for_the_score(self):
        self.run_it("--quick", "--only", "objects", "--keep-gb", "0")
        sims, maps = self.count("sim"), self.count("map")
        self.program("hgg-eval", EVAL.replace("echo 'SC", "for a in \"$@\"; do case $a in *.lcm) cat $a > /dev/null || exit 2;; esac; done; echo 'SC"))
        code, _, errors = self.run_it("--quick", "--only", "objects")
        self.assertEqual(code, 0, errors)
        self.assertEqual((self.count("sim"), self.count("map")), (2 * sims, maps))

    def test_keys_cover_arguments_config_and_machine(self):
        ours, run = self.workshop(), workshop.Run(workshop.Drive("yard", "lidar64", 1), "good")
        self.addCleanup(lambda kept=dict(vars(workshop)): vars(workshop).update(kept))
        key, score = ours.map_dir(run), ours.run_dir(run)
        workshop.radius_of = lambda world: 2.5
        self.assertNotEqual(ours.run_dir(run), score)
        self.assertEqual(ours.map_dir(run), key)
        workshop.beam_spacing_of = lambda sensor, world: 7.0
        self.assertNotEqual(ours.map_dir(run), key)
        ours.time(run)
        workshop.machine = lambda: "another"
        ours.time(run)
        self.assertEqual(len(list(ours.map_dir(run).glob("alone_*.json"))), 2)

    def test_commands_are_those_the_help_lists(self):
        self.assertEqual(self.workshop().commands, {"run", "replay"})
        self.aligning("exit 0")
        self.assertEqual(self.workshop().commands, {"run", "replay", "align"})

    def test_where_one_can_walk_is_asked_of_grid_and_planner(self):
        for batch in (False, True):
            self.calls.write_text("")
            self.walking(batch)
            code, out, errors = self.run_it("--only", "traversability", "--worlds", "street", "--seeds", "1,2")
            self.assertEqual(code, 0, errors)
            self.assertIn("| street | lidar64 | 0.0100 ± 0.0000 | 0.9900 ± 0.0000 |", out)
            self.assertIn("| 0.500 ± 0.000 | 2.0 ± 0.0 |", out)
            asked = [line for line in self.calls.read_text().splitlines() if line.startswith("map plan")]
            self.assertEqual(len(asked), 2 if batch else 4)
            self.assertTrue(all(("--batch" in line) == batch and (batch or "--from 1,2,3 --to 4,5,6 --json" in line) for line in asked), asked)
            evals = self.count("eval")
            self.run_it("--only", "traversability", "--worlds", "street", "--seeds", "1,2")
            self.assertEqual(self.count("eval"), evals, "kept")

    def test_worlds_of_grounds_are_for_walking_alone(self):
        self.program("hgg-sim", SIM.replace("  yard", "  walk\\n  yard"))
        self.walking(True)
        self.run_it("--only", "objects,traversability", "--seeds", "1")
        worlds = lambda program: {word for line in self.calls.read_text().splitlines() if line.startswith(program) for word in line.split()[1:2]}
        self.assertIn("walk", worlds("sim"))
        drives = [line for line in self.calls.read_text().splitlines() if line.startswith("sim walk")]
        self.assertEqual(len(drives), 1)
        self.assertIn("--sensor lidar64", drives[0])
        self.assertNotIn("yard", worlds("sim"))

    def test_a_mapper_that_cannot_walk_yet(self):
        code, out, errors = self.run_it("--only", "traversability", "--worlds", "street", "--seeds", "1")
        self.assertEqual(code, 0, errors)
        self.assertIn("| street | lidar64 | not yet |", out)
        self.assertFalse(self.calls.exists())

    def test_a_failed_timing_leaves_the_document(self):
        self.program("hggmap", MAP.replace("replay) ;;", "replay) case \"$*\" in */alone) echo no time >&2; exit 2;; esac;;"))
        code, _, errors = self.run_it("--quick")
        self.assertEqual(code, 1)
        self.assertIn("no time", errors)
        self.assertIn("| yard | lidar64 | failed |", self.document())
        self.assertIn("| yard | lidar64 | true | 4 ± 0 |", self.document())

    def test_a_failed_alignment_leaves_the_document(self):
        for answer, told in (("echo no maps >&2; exit 2", "no maps"), ("echo '{}'", "does not say"), ("echo nonsense", "not JSON"),
                             ("echo '{\"accepted\": true, \"T_a_b\": null}'", "TypeError")):
            self.aligning(answer)
            code, _, errors = self.run_it("--quick")
            self.assertEqual(code, 1, answer)
            self.assertIn(told, errors)
            self.assertIn("| same place, two drives | failed |", self.document())

    def test_a_refused_alignment_has_no_transform(self):
        self.aligning("echo '{\"accepted\": false, \"T_a_b\": null, \"ms\": 2}'; exit 1")
        code, _, errors = self.run_it("--quick")
        self.assertEqual(code, 0, errors)
        self.assertIn("| same place, two drives | 4 | 0 | 0 | – | – | 2.0 ± 0.0 |", self.document())

    def test_an_evaluator_that_says_something_else_leaves_the_document(self):
        for scores in ("{}", "[]", '{"overall": {}, "classes": []}', "", '{"overall": {"missed": 1, "ghosts": [], "matches": []}, "classes": []}'):
            self.program("hgg-eval", EVAL.replace("SCORES", scores))
            code, _, errors = self.run_it("--quick")
            self.assertEqual(code, 1, scores)
            self.assertIn("hgg-eval --map", errors)
            self.assertIn("| yard | lidar64 | true | failed |", self.document())

    def real_data(self):
        data = self.dir / "data"
        (data / "kitti_0001" / "frames").mkdir(parents=True)
        for name in ("poses.txt", "odometry.txt", "boxes.csv"):
            (data / "kitti_0001" / name).write_text("1\n")
        (data / "unpack.py").write_text("")
        return data

    def test_real_data_that_fails_is_told(self):
        data = self.real_data()
        arguments = ["--only", "real", "--data", data]
        code, _, errors = self.run_it(*arguments)
        self.assertEqual(code, 0, errors)
        self.program("hgg-convert", "#!/bin/sh\necho no boxes >&2; exit 2\n")
        code, out, errors = self.run_it(*arguments)
        self.assertEqual(code, 1)
        self.assertIn("no boxes", errors)
        self.assertIn("| true poses | failed |", out)
        (data / "unpack.py").write_text("import sys; sys.exit('no frames')")
        code, out, errors = self.run_it(*arguments)
        self.assertEqual(code, 1)
        self.assertIn("no frames", errors)

    def test_real_data_is_known_by_its_content(self):
        data = self.real_data()
        self.run_it("--only", "real", "--data", data)
        maps = self.count("map")
        self.run_it("--only", "real", "--data", data)
        self.assertEqual(self.count("map"), maps)
        for times, name in enumerate(("poses.txt", "boxes.csv"), 2):
            (data / "kitti_0001" / name).write_text("2\n")
            self.run_it("--only", "real", "--data", data)
            self.assertEqual(self.count("map"), times * maps, name)

    def test_logs_of_another_simulator_go_first_then_the_oldest(self):
        ours = self.workshop(keep_gb=20e-9)
        drives = [workshop.Drive("yard", "lidar64", seed) for seed in (1, 2, 3)]
        folders = [ours.simulate(drive) for drive in drives]
        foreign = ours.out / "drives" / "0123abcd-0"
        foreign.mkdir()
        for age, folder in enumerate([*folders, foreign]):
            (folder / "log.lcm").write_text("ten bytes\n")
            os.utime(folder / "log.lcm", (1000 + age, 1000 + age))
        (ours.out / "drives" / "gone").mkdir()
        (ours.out / "drives" / "gone" / "log.lcm").symlink_to("nowhere")
        ours.in_use = [drives[0]]
        ours.release()
        self.assertEqual([f.exists() for f in [*folders, foreign]], [True, False, True, False])

    def test_sensors_are_compared_in_two_worlds(self):
        self.assertEqual(self.run_it("--only", "sensors", "--seeds", "1")[0], 0)
        worlds = lambda: {line.split()[1] for line in self.calls.read_text().splitlines() if line.startswith("sim")}
        self.assertEqual(worlds(), {"street", "office"})
        self.run_it("--only", "sensors", "--seeds", "1", "--worlds", "campus")
        self.assertEqual(worlds(), {"street", "office", "campus"})
        self.run_it("--only", "sensors", "--seeds", "1", "--full")
        self.assertEqual(worlds(), {"street", "office", "campus", "apartment"})

    def correcting(self, *keys):
        """A mapper whose config has these keys."""
        sections = {}
        for key in keys:
            sections.setdefault(key.split(".")[0], []).append(f"{key.split('.')[1]} = true  # x")
        printed = "".join(f"[{name}]\\n" + "".join(f"{line}\\n" for line in lines) for name, lines in sections.items())
        self.program("hggmap", MAP.replace(r"[ablation]\nsymmetric_merge = false  # x\n", printed))

    def configs(self, *lines):
        """How many maps were made with all of these lines in their config."""
        texts = [f.read_text().splitlines() for f in (self.dir / "out" / "maps").glob("*/config.toml")]
        return sum(all(line in text for line in lines) for text in texts)

    LOOP_KEYS = ["ablation.odometry_pose", "alignment.odometry_drift", "alignment.odometry_turn_deg", "correction.window",
                 "correction.loop_closure"]

    def test_correction_is_taken_apart_as_far_as_the_mapper_has_it(self):
        self.correcting(*self.LOOP_KEYS)
        arguments = ["--only", "correction", "--worlds", "yard", "--seeds", "1,2"]
        code, out, errors = self.run_it(*arguments)
        self.assertEqual(code, 0, errors)
        measured = "not yet | not yet | 0.50 ± 0.00 | not yet | 0.50 ± 0.00 | 4 | 2 |"
        shipped, none = "map | shipped | ", "not yet | not yet | not yet |"
        for row in (shipped + " |  | " + measured, shipped + "yes |  | " + none, shipped + " | yes | " + measured, shipped + "yes | yes | " + none,
                    "odometry |  | shipped |  | " + measured, "odometry |  | shipped | yes | " + measured, "odometry | yes | shipped | yes | " + measured):
            self.assertIn("| yard | " + row, out)
        self.assertEqual(self.configs("loop_closure = false"), 6)
        self.assertEqual(self.configs("loop_closure = true", "odometry_pose = true", "odometry_drift = 0.01", 'odometry = "POSE_ODOM_POOR"'), 4)
        self.correcting(*self.LOOP_KEYS, "correction.em")
        self.assertIn("| yard | map | shipped | yes | yes | " + measured, self.run_it(*arguments)[1])
        self.assertEqual(self.configs("loop_closure = true", "em = false"), 2)

    def test_loops_are_counted_over_all_seeds_and_whole_ways(self):
        folder = self.dir / "data" / "kitti_trajectories"
        folder.mkdir(parents=True)
        for name in ("05_gt", "05_odometry", "07_gt", "07_odometry"):
            (folder / f"{name}.txt").write_text(f"{name}\n")
        self.correcting(*self.LOOP_KEYS)
        arguments = ["--only", "loops", "--seeds", "1", "--frames", "7", "--worlds", "street,office", "--data", self.dir / "data"]
        code, out, errors = self.run_it(*arguments)
        self.assertEqual(code, 0, errors)
        for row in ("| along KITTI 05 | real front-end | map | 1 | not yet | 0.50 | 0.50 | 9 | 2 | 1 | 1.25 | – | 3 | 2 | 1 |",
                    "| along KITTI 07 | real front-end | odometry | 1 |",
                    "| street | good | odometry | 5 | not yet | 0.50 ± 0.00 | 0.50 ± 0.00 | 45 | 10 | 5 | 1.25 | – | 15 | 10 | 5 |"):
            self.assertIn(row, out)
        self.assertNotIn("| office |", out)
        self.assertNotIn("--frames 7", self.calls.read_text())
        self.assertIn("the others over whole tours.", out)
        self.run_it(*arguments, "--loop-frames", "8")
        self.assertIn("street --sensor lidar64 --seed 1 --frames 8", self.calls.read_text())
        self.assertNotIn("KITTI 05", self.run_it(*arguments, "--paths", "07")[1])

    def test_calibration_is_shown_before_and_after(self):
        points = {"mean_over_3": 99, "median_over_3": 50, "inside_90": 0.01, "mean_sigma": 0.002}
        scores = {**SCORES, "overall": {**SCORES["overall"], "calibration_by_points": points}}
        self.program("hgg-eval", EVAL.replace("SCORES", json.dumps(scores)))
        arguments = ["--only", "calibration", "--worlds", "apartment,street", "--seeds", "3"]
        code, out, errors = self.run_it(*arguments)
        self.assertEqual(code, 0, errors)
        self.assertIn("| street | 0.250 ± 0.000 | 99.00 ± 0.00 | 12.00 ± 0.00 | 50.00 ± 0.00 | not yet | 0.01 ± 0.00 | 0.10 ± 0.00 |", out)
        self.assertLess(out.index("| street |"), out.index("| apartment |"))
        self.assertEqual(self.count("map"), 10)

    def test_things_are_seen_under_other_common_names(self):
        overall = {**SCORES["overall"], "twins": 3, "ghost_causes": {"second": 2, "mover": 1, "gone": 0, "surface": 4, "nothing": 0}}
        sign = {"name": "traffic-sign", "truth": 4, "recall": 0.75, "missed": [5], "ghosts": [], "matches": []}
        scores = {**SCORES, "overall": overall, "classes": [sign, {**sign, "name": "car"}], "twins": [{"ids": [1, 2]}], "ghosts": [{"id": 7}]}
        self.program("hgg-eval", EVAL.replace("SCORES", json.dumps(scores)))
        self.program("hgg-sim", SIM.replace("  yard", "  passes\\n  yard").replace("  lidar64 beams", "  lidar64 beams\\n  solid64 beams"))
        code, out, errors = self.run_it("--only", "things", "--seeds", "1", "--worlds", "street,passes,office")
        self.assertEqual(code, 0, errors)
        row = "0.500 ± 0.000 | 1.000 ± 0.000 | 0.400 ± 0.000 | 0.250 ± 0.000 | 0.75 ± 0.00 | 3.0 ± 0.0 | 1.0 ± 0.0 | 2.0 ± 0.0 | 1.0 ± 0.0 | 0.0 ± 0.0 | 4.0 ± 0.0 | 0.0 ± 0.0 |"
        for words in ("street | lidar64 | 5% | good", "passes | lidar64 | 10% | poor", "office | solid64 | 10% | good"):
            self.assertIn(f"| {words} | 4 ± 0 | {row}", out)
        drives = [line for line in self.calls.read_text().splitlines() if line.startswith("sim")]
        self.assertEqual(len(drives), 3 * 2 * 5)  # worlds, shares, seeds; odometry shares a log
        self.assertTrue(all("--dynamics --confusion 0 --confusion-common 0." in line for line in drives), drives[0])
        self.assertTrue(all(("--plates" in line) == (" street " in line) for line in drives))

    def test_a_map_without_signs_has_no_recall_of_them(self):
        code, out, errors = self.run_it("--only", "things", "--seeds", "1", "--worlds", "office", "--odometry", "good")
        self.assertEqual(code, 0, errors)
        self.assertIn("| office | solid64 | 5% | good | 4 ± 0 | 0.500 ± 0.000 | 1.000 ± 0.000 | 0.400 ± 0.000 | 0.250 ± 0.000 | not yet |", out)

    def test_mechanisms_are_switched_off_one_at_a_time(self):
        self.correcting("ablation.blind_to_free_space", "ablation.single_frames")
        code, out, errors = self.run_it("--only", "mechanisms", "--seeds", "1", "--worlds", "office", "--odometry", "good")
        self.assertEqual(code, 0, errors)
        for name in ("nothing: as shipped", "free space", "small things"):
            self.assertIn(f"| office | {name} | 0.500 ± 0.000 |", out)
        self.assertIn("| office | movers | not yet |", out)  # this mapper cannot do without
        self.assertIn("| office | pieces | not yet |", out)
        self.assertEqual(self.configs("blind_to_free_space = true"), 5)  # seeds
        self.assertEqual(self.configs("blind_to_free_space = true", "single_frames = true"), 0)

    def test_worlds_for_one_table_are_in_no_other(self):
        self.program("hgg-sim", SIM.replace("  yard", "  passes\\n  yard"))
        self.run_it("--only", "objects", "--seeds", "1", "--odometry", "good")
        self.assertNotIn("sim passes", self.calls.read_text())

    def real_paths(self):
        folder = self.dir / "data" / "kitti_trajectories"
        folder.mkdir(parents=True)
        for name in ("05_gt", "05_odometry", "07_gt", "07_odometry"):
            (folder / f"{name}.txt").write_text(f"{name}\n")
        return ["--data", self.dir / "data"]

    def test_odometry_lies_in_every_way_along_every_path(self):
        scores = {**SCORES, "odometry": {"ate_rmse": 1.5}, "cost": {"frames": 5, "odometry_delay_s": 0.104}}
        self.program("hgg-eval", EVAL.replace("SCORES", json.dumps(scores)))
        code, out, errors = self.run_it("--only", "lies", "--seeds", "1,2", *self.real_paths())
        self.assertEqual(code, 0, errors)
        row = "| along KITTI 07 | late, every 2nd | 2 | 1.50 ± 0.00 | 0.500 ± 0.000 | 0.50 ± 0.00 | 4 | 2 | 0.1 | 0.104 ± 0.000 |"
        self.assertIn(row, out)
        self.assertEqual(self.count("sim"), 2 * 2 * len(lies.LIES))
        self.assertIn("--every 2 --odometry-delay 0.1 -o", self.calls.read_text())
        self.assertIn("| along KITTI 05 | wheels, late | 2 |", out)

    def test_the_mapper_of_before_stands_beside_on_the_same_logs(self):
        before = self.dir / "before"
        before.mkdir()
        self.program("../before/hggmap", MAP + "# older\n")
        code, out, errors = self.run_it("--quick", "--only", "odometry,objects", "--before", before)
        self.assertEqual(code, 0, errors)
        self.assertIn("| ATE out, m, before | after | F1, before | after |", out)
        self.assertIn("| yard | late by 0.1 s | 2 | not yet | 0.500 ± 0.000 | 0.500 ± 0.000 | 0.50 ± 0.00 | 0.50 ± 0.00 | 4 | 4 | 2 | 2 | 0.1 |", out)
        for name in tables.LYING:
            self.assertIn(f"--only {name}`", out)
        sims = [line for line in self.calls.read_text().splitlines() if line.startswith("sim")]
        self.assertEqual(len(sims), len({line.split(" -o ")[0] for line in sims}))  # no log was made twice
        configs = [f.read_text() for f in (self.dir / "out" / "maps").glob("*/config.toml")]
        self.assertTrue(any("drift_reach" in text for text in configs) and any("drift_reach" not in text for text in configs))  # the older one does not print it
        self.assertEqual(self.run_it("--quick", "--before", self.dir / "nowhere")[0], 2)

    def test_keys_an_older_mapper_does_not_know_are_left_out(self):
        toml = 'classes = "c"\nnews = 1\n\n[a]\n# b = 2\nb = 3\nnew = 4\n[fresh]\nLIDAR = [0, 0]\n'
        self.assertEqual(workshop.without_unknown(toml, {"classes", "a.b"}), 'classes = "c"\n\n[a]\n# b = 2\nb = 3\n')

    def recovering(self, back, wrong=0.0, said=1.5):
        recovery = {"end_error": 0.25, "back_after_s": back, "longest_wrong_s": wrong, "said_after_s": said}
        self.program("hgg-eval", EVAL.replace("SCORES", json.dumps({**SCORES, "recovery": recovery})))

    def test_a_carried_robot_is_back_or_not(self):
        arguments = ["--only", "kidnapping", "--worlds", "street", "--kidnaps", "4"]
        self.recovering(7.25, wrong=3.0)
        code, out, errors = self.run_it(*arguments)
        self.assertEqual(code, 0, errors)
        self.assertIn("| street | goes on | 2 | 1.00 | 7.2 | 2 | 0.50 ± 0.00 | 0.50 ± 0.00 |", out)
        self.assertIn("--kidnap 27.3 --kidnap-odometry on", self.calls.read_text())
        self.assertIn("--fault 30.3", self.calls.read_text())
        self.recovering(None)
        self.assertIn("| street | restarts at zero | 2 | 0.00 | never | 0 |", self.run_it(*arguments)[1])

    def test_a_fault_is_said_and_survived_or_not(self):
        arguments = ["--only", "faults", "--worlds", "street", "--seeds", "1"]
        self.recovering(0.5)
        code, out, errors = self.run_it(*arguments)
        self.assertEqual(code, 0, errors)
        self.assertIn("| street | slip | 1.5 | 0.5 | 0 | 0.25 | 0.50 |", out)
        self.assertIn("--odometry-fault slip@20 -o", self.calls.read_text())
        self.recovering(0.5, said=None)
        self.assertIn("| street | xyzw | never | 0.5 |", self.run_it(*arguments)[1])

    def test_beliefs_are_those_of_worlds_and_paths_with_and_without_lag(self):
        calibration = {"mean_over_3": 1.25, "inside_90": 0.875}
        scores = {**SCORES, "positions": {"from_start": calibration, "neighbours": calibration}}
        self.program("hgg-eval", EVAL.replace("SCORES", json.dumps(scores)))
        code, out, errors = self.run_it("--only", "beliefs", "--worlds", "street", *self.real_paths())
        self.assertEqual(code, 0, errors)
        figures_ = "1.25 ± 0.00 | 0.88 ± 0.00 | 1.25 ± 0.00 | 0.88 ± 0.00 |"
        for row in ("street | as is", "street | late by 0.1 s", "along KITTI 07 | late by 0.1 s"):
            self.assertIn(f"| {row} | {figures_}", out)
        self.assertEqual(self.count("map"), 3 * 2 * 5)

    def test_results_are_kept_without_the_list_of_loops(self):
        self.run_it("--quick", "--only", "objects")
        kept = [json.loads(f.read_text()) for f in (self.dir / "out" / "runs").glob("*/result.json")]
        self.assertTrue(kept)
        self.assertEqual(kept[0]["cost"], {"frames": 5})

    def test_real_paths_are_chosen_by_name(self):
        folder = self.dir / "data" / "kitti_trajectories"
        folder.mkdir(parents=True)
        for name in ("05_gt", "05_odometry", "07_gt", "07_odometry"):
            (folder / f"{name}.txt").write_text(f"{name}\n")
        arguments = ["--only", "trajectory", "--seeds", "1", "--worlds", "yard", "--data", self.dir / "data"]
        self.assertIn("along KITTI 05", self.run_it(*arguments)[1])
        self.assertNotIn("along KITTI 05", self.run_it(*arguments, "--paths", "07")[1])
        self.assertNotIn("along KITTI", self.run_it(*arguments, "--paths", "")[1])

    def test_an_interrupt_ends_everything_with_one_line(self):
        self.program("hggmap", MAP.replace("replay) ;;", f"replay) echo $$ >> {self.dir}/pids; exec sleep 60;;"))
        work = subprocess.Popen(stdout=subprocess.PIPE, stderr=subprocess.PIPE, **self.command("--quick"),
                                preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
        pids, patience = self.dir / "pids", time.monotonic() + 20
        while (not pids.exists() or len(pids.read_text().split()) < 2) and time.monotonic() < patience:
            time.sleep(0.02)
        work.send_signal(signal.SIGINT)
        _, errors = work.communicate(timeout=20)
        self.assertEqual((work.returncode, errors), (130, "stopped; the same command goes on where it was\n"))
        self.assertEqual(len(pids.read_text().split()), 2)  # nothing was started after it
        for pid in pids.read_text().split():
            self.assertRaises(ProcessLookupError, os.kill, int(pid), 0)
        self.program("hggmap", MAP)
        self.assertEqual(self.run_it("--quick")[0], 0)

    def test_a_failed_run_is_shown_and_told(self):
        self.program("hgg-sim", SIM.replace("BROKEN", "apartment"))
        code, _, errors = self.run_it("--quick")
        self.assertEqual(code, 1)
        self.assertIn("broken on purpose", errors)
        text = (self.dir / "out" / "evaluation.md").read_text()
        self.assertIn("| apartment | rgbd | true | failed |", text)
        self.assertIn("| yard | lidar64 | true | 4 ± 0 |", text)

    def test_logs_beyond_the_limit_are_dropped_but_not_those_to_be_timed(self):
        self.run_it("--quick", "--keep-gb", "0")
        logs = list((self.dir / "out" / "drives").rglob("log.lcm"))
        self.assertEqual(len(logs), 2)  # one a world, for the timing
        self.assertEqual(self.run_it("--quick", "--keep-gb", "0")[0], 0)

    def test_only_prints_and_leaves_the_document_alone(self):
        code, out, _ = self.run_it("--quick", "--only", "objects")
        self.assertEqual(code, 0)
        self.assertIn("## Objects, by world and odometry", out)
        self.assertFalse((self.dir / "out" / "evaluation.md").exists())

    def test_unknown_names_are_bad_usage(self):
        for bad in (["--worlds", "atlantis"], ["--only", "everything"], ["--odometry", "superb"], ["--sensors", "nose"]):
            code, _, errors = self.run_it(*bad)
            self.assertEqual(code, 2, bad)
            self.assertIn("there is no", errors)


if __name__ == "__main__":
    unittest.main()
