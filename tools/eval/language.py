#!/usr/bin/env python3
"""language.py SCANS --hggmap BIN [--part tune|held|all] [--nearness RULE] [--show N] [--json F]: how well `hggmap query` finds what people mean.

SCANS is a folder of scans, one JSON each: {"scene", "objects": [...], "queries": [{"text", "target", "set", ...}]}. Each
is imported (`hggmap import`) and asked all its texts (`hggmap query --batch`); nothing else of a query is given to the
system. A fifth of the places (all scans of a place together) is held out: look at it last.
"""
import argparse
import collections
import hashlib
import json
import pathlib
import random
import subprocess
import sys
import tempfile

BINS = 10  # of the calibration error


def is_held_out(scene):
    """Whether a scan belongs to the held-out fifth: by its place, the name without the number of the scan."""
    return int(hashlib.sha1(scene.rsplit("_", 1)[0].encode()).hexdigest(), 16) % 5 == 0


def ask(hggmap, scan, work, options=()):
    """The answers to all texts of one scan, in their order."""
    graph, batch, out = work / "graph.json", work / "batch.jsonl", work / "map.hgg"
    graph.write_text(json.dumps({"objects": scan["objects"]}))
    batch.write_text("".join(json.dumps({"text": q["text"]}) + "\n" for q in scan["queries"]))
    subprocess.run([hggmap, "import", str(graph), "-o", str(out)], check=True, stdout=subprocess.DEVNULL)
    done = subprocess.run([hggmap, "query", str(out), "--batch", str(batch), "--no-goal", *options], check=True, capture_output=True, text=True)
    return [json.loads(line) for line in done.stdout.splitlines()]


def calibration_error(rows):
    """Expected calibration error of the first answers: mean over bins of |confidence - share right|."""
    bins = collections.defaultdict(list)
    for confidence, right in rows:
        bins[min(int(confidence * BINS), BINS - 1)].append((confidence, right))
    return sum(abs(sum(c for c, _ in b) - sum(r for _, r in b)) for b in bins.values()) / max(len(rows), 1)


def risk_coverage(rows):
    """[(coverage, share right)] when only the surest answers are given."""
    rows = sorted(rows, reverse=True)
    steps = [max(1, round(len(rows) * k / 10)) for k in range(1, 11)] if rows else []
    return [(round(n / len(rows), 2), round(sum(r for _, r in rows[:n]) / n, 3)) for n in steps]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scans", type=pathlib.Path)
    parser.add_argument("--hggmap", required=True)
    parser.add_argument("--part", choices=["tune", "held", "all"], default="tune")
    parser.add_argument("--nearness", default="surfaces", help="as hggmap query has it: surfaces, edges, centroids")
    parser.add_argument("--show", type=int, default=0, help="print so many wrong answers of each set (never of the held-out part)")
    parser.add_argument("--json", type=pathlib.Path)
    options = parser.parse_args()
    groups = collections.defaultdict(list)
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        for path in sorted(options.scans.glob("*.json")):
            scan = json.loads(path.read_text())
            if options.part != "all" and is_held_out(scan["scene"]) != (options.part == "held"):
                continue
            labels = {o["id"]: o["label"] for o in scan["objects"]}
            for query, answer in zip(scan["queries"], ask(options.hggmap, scan, pathlib.Path(folder), ["--nearness", options.nearness]), strict=True):
                first = answer["answers"][0] if answer["answers"] else {"id": -1, "probability": 0.0}
                right = first["id"] == query["target"]
                row = (first["probability"], right, [a["id"] for a in answer["answers"]], query["target"], answer["status"])
                names = [query["set"], f"{query['set']} status {answer['status']}"]
                if "relation" in query:
                    names.append(f"{query['set']} {query['relation']}")
                if answer["answers"]:
                    names.append(f"{query['set']} class {'right' if labels[first['id']] == labels[query['target']] else 'wrong'}")
                for name in names:
                    groups[name].append(row)
                if not right:
                    wrong.append((query["set"], scan["scene"], query["text"], query["target"], labels[query["target"]], answer))
    report = {}
    for name in sorted(groups):
        rows = groups[name]
        pairs = [(r[0], r[1]) for r in rows]
        report[name] = {"queries": len(rows), "r1": round(sum(r[1] for r in rows) / len(rows), 4),
                        "r3": round(sum(r[3] in r[2][:3] for r in rows) / len(rows), 4),
                        "ece": round(calibration_error(pairs), 4)}
        print(f"{name:32} n {len(rows):5}  R@1 {100 * report[name]['r1']:5.1f} %  R@3 {100 * report[name]['r3']:5.1f} %  "
              f"ECE {report[name]['ece']:.3f}  mean confidence {sum(p[0] for p in pairs) / len(pairs):.3f}")
    for name in ("nr3d", "sr3d"):
        report[name]["risk_coverage"] = risk_coverage([(r[0], r[1]) for r in groups[name]])
    everything = [(r[0], r[1]) for name in ("nr3d", "sr3d") for r in groups[name]]
    report["both"] = {"ece": round(calibration_error(everything), 4), "risk_coverage": risk_coverage(everything)}
    print(f"both: ECE {report['both']['ece']:.3f}, share right at coverage: {report['both']['risk_coverage']}")
    if options.json:
        options.json.write_text(json.dumps(report, indent=1) + "\n")
    if options.show and options.part == "tune":
        random.Random(len(wrong)).shuffle(wrong)
        for name in ("sr3d", "nr3d"):
            for _, scene, text, target, label, answer in [w for w in wrong if w[0] == name][:options.show]:
                got = ", ".join(f"{a['id']} {a['name']} {a['probability']:.2f}" for a in answer["answers"][:3])
                print(f"{scene} | {text} | {target} {label} | {answer['status']} {got} | {answer['parse'].get('reading', '')}")


if __name__ == "__main__":
    sys.exit(main())
