#!/usr/bin/env bash
# What people say of the objects of real scans, on the tuning part of ../shared/data/language.
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
for name, least in (("sr3d", 0.93), ("nr3d", 0.50)):
    assert report[name]["r1"] >= least, f"{name}: R@1 {report[name]['r1']} is below {least}"
assert report["both"]["ece"] <= 0.08, report["both"]["ece"]
PY
