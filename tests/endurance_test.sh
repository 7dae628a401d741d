#!/bin/bash
# Drives a ring road of two kilometres under a small budget, and a small ring six times, and holds what was promised.
# usage: endurance_test.sh BUILD_DIR OUT
set -u
repo=$(cd "$(dirname "$0")/.." && pwd)
[ $# -eq 2 ] || { sed -n '2,3s/^# \{0,1\}//p' "$0" >&2; exit 2; }
build=$1 out=$2
mkdir -p "$out" || exit 2

hold() {  # NAME KEY OP VALUE: a number of the report
  python3 - "$out/$1/endurance.json" "$2" "$3" "$4" <<'EOF' || { echo "failed: $*" >&2; exit 1; }
import json, sys
path, key, op, value = sys.argv[1:]
report = json.load(open(path))
x = eval(key, {"r": report, "sum": sum, "int": int})
print(f"{key} = {x} ({op} {value})")
sys.exit(0 if {"<": x < float(value), ">": x > float(value), "<=": x <= float(value)}[op] else 1)
EOF
}

"$build/hgg-endurance" --kilometres 2 --budget-mb 6 --out "$out/ring" > /dev/null || exit 1
hold ring 'r["peak_map_mb"]' '<=' 6
hold ring 'sum(n for k, n in r["start_things_by_nodes_last"].items() if int(k) > 1)' '<=' 1
hold ring 'r["loops"]' '>' 0
"$build/hggmap" info "$out/ring/map.hgg" > /dev/null || { echo "failed: the map does not load" >&2; exit 1; }

"$build/hgg-endurance" --kilometres 0.2 --laps 6.1 --beyond 0 --out "$out/laps" > /dev/null || exit 1
hold laps '(r["laps"][5]["map_mb"] - r["laps"][4]["map_mb"]) / r["laps"][0]["map_mb"]' '<' 0.005
hold laps 'r["laps"][5]["keyframes"] - r["laps"][4]["keyframes"]' '<=' 0
echo "endurance_test: passed"
