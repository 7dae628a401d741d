#!/bin/bash
# Prints a hash of what replays of five fixed logs leave behind, so that a refactoring can be held against the commit before
# it: run it with the programs of both and compare. Hashes of different machines may differ (libm, compiler), so none are
# stored.
# usage: tests/golden_maps.sh BUILD_DIR [WORK_DIR] [NAME...]   WORK_DIR keeps the logs (6 GB) for the next run.
#        tests/golden_maps.sh build-before work > before; tests/golden_maps.sh build work > after; diff before after
# Names: kitti_0001 and path05 need ../shared/data (HGG_DATA names another folder); street, office, hall (closes a loop).
# Exit: 0 done, 2 a command failed.
set -u
repo=$(cd "$(dirname "$0")/.." && pwd)
[ $# -ge 1 ] || { sed -n '2,9s/^# \{0,1\}//p' "$0" >&2; exit 2; }
build=$1 work=${2:-$(mktemp -d)}
[ $# -ge 2 ] && shift 2 || shift 1
data=${HGG_DATA:-$repo/../shared/data}
names=("$@")
[ ${#names[@]} -gt 0 ] || names=(kitti_0001 street office hall path05)
mkdir -p "$work" || exit 2

quietly() { "$@" > "$work/said" 2>&1 || { echo "failed: $*" >&2; cat "$work/said" >&2; exit 2; }; }
sim() { quietly "$build/hgg-sim" "$@" --truth "$work/${log##*/}_truth"; }

make_log() {
  case $1 in
    kitti_0001)
      quietly python3 "$data/unpack.py" "$data/kitti_0001" "$work/kitti"
      quietly "$build/hgg-convert" semantickitti "$work/kitti" -o "$log" ;;
    street) sim street -o "$log" --sensor lidar64 --seed 11 --frames 400 ;;
    office) sim office -o "$log" --sensor rgbd --seed 11 --frames 400 ;;
    hall) sim hall -o "$log" --sensor rgbd --seed 1 ;;
    path05) sim --path "$data/kitti_trajectories/05_gt.txt" "$data/kitti_trajectories/05_odometry.txt" -o "$log" \
                --sensor lidar64 --seed 1 ;;
    *) echo "no log named $1" >&2; exit 2 ;;
  esac
}

for name in "${names[@]}"; do
  log=$work/$name.lcm
  [ -f "$log" ] || make_log "$name"
  case $name in office | hall) config=indoor ;; *) config=semantickitti ;; esac
  quietly "$build/hggmap" replay "$log" --config "$repo/firmware_cfg/$config/hggmap.toml" --out "$work/$name"
  loops=$(python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["loops_accepted"])' "$work/$name/stats.json")
  echo "$name map $(sha256sum < "$work/$name/map.hgg" | cut -c1-16)" \
       "trajectory $(sha256sum < "$work/$name/trajectory.tum" | cut -c1-16) loops $loops"
done
