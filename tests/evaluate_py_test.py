#!/usr/bin/env python3
"""tools/evaluate.py: its arithmetic, its cache and its document, with programs made of a few lines of shell."""
import importlib.util
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

REPO = Path(__file__).resolve().parent.parent
spec = importlib.util.spec_from_file_location("evaluate", REPO / "tools" / "evaluate.py")
sys.dont_write_bytecode = True
evaluate = importlib.util.module_from_spec(spec)  # a script: nothing else imports it
sys.modules["evaluate"] = evaluate
spec.loader.exec_module(evaluate)

SCORES = {"overall": {"truth": 4, "f1": 0.5, "recall": 1.0, "precision": 0.4, "position_error": {"mean": 0.25}, "extent_error": {"mean": 0.3},
                      "calibration": {"mean_over_3": 12, "inside_90": 0.1}, "matches": [{"id": 1}], "missed": [], "ghosts": [7]},
          "classes": [], "odometry": None, "geometry": None, "retrieval": None,
          "trajectory": {"ate_rmse": 0.5, "T_truth_map": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]}}
STATS = {"frames": 5, "frame_ms": {"p50": 3, "p99": 9}, "stage_ms": {"creation": {"p50": 2}}, "map_mb": 1.5, "peak_rss_mb": 20,
         "memory": [{"frame": 1, "map_mb": 1}, {"frame": 5, "map_mb": 1.5}], "time": [{"frame": 1, "mean_ms": 3, "max_ms": 4}]}

SIM = r"""#!/bin/sh
[ "$1" = --list ] && { printf 'worlds:\n  apartment\n  yard\nsensors:\n  lidar16 beams\n  lidar64 beams\n  rgbd camera\n'; exit 0; }
echo "sim $*" >> CALLS
for a in "$@"; do [ "$a" = BROKEN ] && { echo 'hgg-sim: broken on purpose' >&2; exit 2; }; done
while [ $# -gt 0 ]; do
  [ "$1" = -o ] && echo log > "$2"
  [ "$1" = --truth ] && mkdir -p "$2"
  shift
done
"""
MAP = r"""#!/bin/sh
case "$1" in
  run) printf '[ablation]\nsymmetric_merge = false  # x\n'; exit 0;;
  replay) ;;
  *) exit 2;;
esac
echo "map $*" >> CALLS
while [ $# -gt 0 ]; do [ "$1" = --out ] && mkdir -p "$2" && echo 'STATS' > "$2/stats.json"; shift; done
"""
EVAL = "#!/bin/sh\necho \"eval $*\" >> CALLS\necho 'SCORES'\n"


class Arithmetic(unittest.TestCase):
    def test_spread_is_mean_and_sample_deviation(self):
        self.assertEqual(evaluate.spread([1.0, 2.0, 3.0]), "2.00 ± 1.00")
        self.assertEqual(evaluate.spread([0.25]), "0.25")
        self.assertEqual(evaluate.spread([None, 0.25]), "0.25")
        self.assertEqual(evaluate.spread([]), "–")
        self.assertEqual(evaluate.spread([20000.0, 30000.0], 0), "2.50e+04 ± 7e+03")

    def test_cells_tell_missing_from_failed_from_not_run(self):
        columns = [("a.b", 1), ("c", 0)]
        self.assertEqual(evaluate.cells([{"a": {"b": 1}, "c": None}, {"a": {"b": 2}}], columns), ["1.5 ± 0.7", "not yet"])
        self.assertEqual(evaluate.cells([], columns), ["not run", "not run"])
        self.assertEqual(evaluate.cells([{"a": {"b": 1}}, {"error": "x"}], columns), ["failed", "failed"])

    def test_alignment_error_is_against_the_truth(self):
        turn = lambda a, t: [math.cos(a), -math.sin(a), 0, t[0], math.sin(a), math.cos(a), 0, t[1], 0, 0, 1, t[2]]
        figures = lambda T: {"trajectory": {"T_truth_map": T}}
        a, b = figures(turn(0.3, [1, 2, 0])), figures(turn(0.5, [1, 2, 0]))
        self.assertAlmostEqual(evaluate.align_error({"T_a_b": turn(0.2, [0, 0, 0])}, a, b)[1], 0, places=5)
        metres, degrees = evaluate.align_error({"T_a_b": turn(0.3, [0, 0, 2])}, a, b)
        self.assertAlmostEqual(metres, 2)
        self.assertAlmostEqual(degrees, math.degrees(0.1))
        c = figures(turn(0.3 + math.pi / 2, [1, 5, 0]))  # 3 m along the truth's y, seen from a map turned by 0.3
        self.assertAlmostEqual(evaluate.align_error({"T_a_b": turn(math.pi / 2, [3 * math.sin(0.3), 3 * math.cos(0.3), 0])}, a, c)[0], 0)

    def test_config_keys_are_set_in_their_section(self):
        toml = 'classes = "c.toml"  # path\n[frame]\nrange = 1.0  # [m] far\n[map]\nrange = 2.0\n'
        text = evaluate.set_keys(toml, {"classes": '"/x"', "map.range": "5", "ablation.symmetric_merge": "true"})
        self.assertEqual(text, 'classes = "/x"\n[frame]\nrange = 1.0  # [m] far\n[map]\nrange = 5\n[ablation]\nsymmetric_merge = true\n')

    def test_tables_are_markdown(self):
        table = evaluate.Table("t", "T", "", ["world", "F1"], [["yard", "1.00"]])
        self.assertEqual(table.markdown(), "| world | F1 |\n| --- | ---: |\n| yard | 1.00 |")


class Command(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.dir = Path(scratch.name)
        self.calls = self.dir / "calls.txt"
        self.build = self.dir / "build"
        self.build.mkdir()
        for name, text in (("hgg-sim", SIM), ("hggmap", MAP), ("hgg-eval", EVAL), ("hgg-convert", EVAL)):
            self.program(name, text)

    def program(self, name, text):
        text = text.replace("CALLS", str(self.calls)).replace("STATS", json.dumps(STATS)).replace("SCORES", json.dumps(SCORES))
        (self.build / name).write_text(text)
        (self.build / name).chmod(0o755)

    def run_it(self, *arguments):
        command = [sys.executable, REPO / "tools" / "evaluate.py", "--build", self.build, "--out", self.dir / "out", "--data", self.dir / "none",
                   "--jobs", "2", *arguments]
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True, env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})
        return done.returncode, done.stdout, done.stderr

    def count(self, program):
        return sum(line.startswith(program) for line in self.calls.read_text().splitlines())

    def test_quick_fills_the_document(self):
        code, _, errors = self.run_it("--quick")
        self.assertEqual(code, 0, errors)
        text = (self.dir / "out" / "evaluation.md").read_text()
        for part in ("## Objects, by world and odometry", "| yard | lidar64 | true | 4 ± 0 | 0.25 ± 0.00 | 1.00 ± 0.00 | 0.40 ± 0.00 | 0.50 ± 0.00 |",
                     "| apartment | good | symmetric average, uniform weights | not yet |", "| yard | yes | yes | not yet |",
                     "same place, two drives | not yet", "| yard | lidar64 | 5 | 3.0 | 9.0 | 2.0 | not yet | not yet | 1.50 | 1.50 | 20 |",
                     "--quick --only objects", "seeds | 1, 2"):
            self.assertIn(part, text)

    def test_page_is_one_file(self):
        self.run_it("--quick")
        page = (self.dir / "out" / "evaluation.html").read_text()
        self.assertIsNone(re.search(r"https?:|<link|src=|url\(|@import|fetch\(", page))
        data = json.loads(re.search(r'type="application/json">(.*?)</script>', page, re.S).group(1))
        self.assertEqual([t["name"] for t in data["tables"]], evaluate.TABLES)
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
