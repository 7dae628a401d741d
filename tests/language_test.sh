#!/usr/bin/env bash
# What people say of the objects of real scans, on the tuning part of ../shared/data/language; and halves of a fifth of the scans,
# aligned graph to graph.
# usage: tests/language_test.sh [BUILD_DIR]     Data: $HGG_DATA, else ../shared/data beside the repository. Exit 77: absent.
set -euo pipefail
repo=$(cd "$(dirname "$0")/.." && pwd)
build=${1:-$repo/build}
scans=${HGG_DATA:-$repo/../shared/data}/language
[[ -d $scans ]] || { echo "skipped: $scans is not there"; exit 77; }
report=$(mktemp)
trap 'rm -f "$report"' EXIT
python3 -B "$repo/tools/eval/language.py" "$scans" --hggmap "$build/hggmap" --part tune --json "$report"
python3 -B - "$report" <<'PY'
import json, sys
report = json.load(open(sys.argv[1]))
for name, least in (("sr3d", 0.97), ("nr3d", 0.73)):
    assert report[name]["r1"] >= least, f"{name}: R@1 {report[name]['r1']} is below {least}"
for name in ("sr3d", "nr3d", "both"):
    assert report[name]["ece"] <= 0.08, f"{name}: calibration error {report[name]['ece']}"
PY
python3 -B "$repo/tools/eval/graph_pairs.py" "$scans" --hggmap "$build/hggmap" --every 5 --seeds 1 --others 2 --show 5
