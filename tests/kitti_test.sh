#!/bin/bash
# Maps the real drive kitti_0001 and holds the result against its annotated parked cars: recall, position error, and the same
# bytes from the same log. Once with the true poses (scored in the raw map frame), once with a real front-end's odometry
# (scored after laying the trajectories over each other).
# usage: tests/kitti_test.sh [BUILD_DIR] [OUT_DIR]     Data: $HGG_DATA, else ../shared/data beside the repository.
# Exit: 0 passed, 77 skipped, 1 a number is out of bounds, 2 a command failed.
set -u
need=kitti_0001
. "$(dirname "$0")/real_data.sh"
radius=1.5 min_recall=0.9 max_error=0.5
replay() { run "$build/hggmap" replay "$1" --config "$repo/firmware_cfg/semantickitti/hggmap.toml" --out "$2"; }
evaluate() { run "$build/hgg-eval" --truth "$out/truth" --class car --radius "$radius" "$@"; }

# check JSON: bounds on recall and mean position error.
check() {
  python3 - "$1" "$min_recall" "$max_error" <<'EOF'
import json, sys
score, min_recall, max_error = json.load(open(sys.argv[1]))["overall"], float(sys.argv[2]), float(sys.argv[3])
error = score["position_error"]["mean"]
good = score["recall"] >= min_recall and error is not None and error <= max_error
print(f"{'ok' if good else 'FAILED'}: recall {score['recall']} (at least {min_recall}), mean error {error} m (at most {max_error})")
sys.exit(0 if good else 1)
EOF
}

frame_times() {
  python3 - "$1" <<'EOF'
import json, sys
stats = json.load(open(sys.argv[1]))
print(f"frame_ms p50 {stats['frame_ms']['p50']} p99 {stats['frame_ms']['p99']}, {stats['frames']} frames, {stats['dropped']} dropped")
EOF
}

run python3 "$data/unpack.py" "$data/kitti_0001" "$out/kitti"
run "$build/hgg-convert" semantickitti "$out/kitti" -o "$out/true.lcm" --poses "$out/kitti/poses.txt"
run "$build/hgg-convert" semantickitti "$out/kitti" -o "$out/odometry.lcm"
run "$build/hgg-convert" kitti-truth "$out/kitti" -o "$out/truth" --boxes "$data/kitti_0001/boxes.csv"

failed=0
echo "== true poses, raw map frame"
replay "$out/true.lcm" "$out/true"
evaluate --map "$out/true/map.hgg"
evaluate --map "$out/true/map.hgg" --json > "$out/true.json"
check "$out/true.json" || failed=1
frame_times "$out/true/stats.json"

echo "== where one can walk"
python3 "$repo/tests/kitti_plans.py" "$build/hggmap" "$out/true/map.hgg" "$repo/firmware_cfg/semantickitti/hggmap.toml" \
  "$data/kitti_0001/boxes.csv" "$out/true/trajectory.tum" "$out" || failed=1

echo "== questions about the cars"
python3 "$repo/tests/kitti_questions.py" "$build/hggmap" "$out/true/map.hgg" "$data/kitti_0001/boxes.csv" || failed=1

echo "== the same log again"
replay "$out/true.lcm" "$out/again"
if cmp "$out/true/map.hgg" "$out/again/map.hgg"; then
  echo "ok: byte-identical map.hgg"
else
  echo "FAILED: two replays of one log gave different maps"
  failed=1
fi

echo "== odometry of a real front-end, laid over the true trajectory"
aligned=(--map "$out/odometry/map.hgg" --trajectory "$out/odometry/trajectory.tum" --times "$out/kitti/times.txt")
replay "$out/odometry.lcm" "$out/odometry"
evaluate "${aligned[@]}"
evaluate "${aligned[@]}" --json > "$out/odometry.json"
check "$out/odometry.json" || failed=1
frame_times "$out/odometry/stats.json"

# ate LOG TRAJECTORY_DIR WORST: the mapper's ATE, at most WORST times that of its odometry plus 0.10 m where that is nothing.
ate() {
  "$build/hgg-eval" --map "$2/map.hgg" --truth "$out/truth" --class car --radius "$radius" --trajectory "$2/trajectory.tum" \
    --times "$out/kitti/times.txt" --log "$1" --json > "$2/ate.json"
  python3 - "$2/ate.json" "$3" <<'EOF'
import json, sys
score, share = json.load(open(sys.argv[1])), float(sys.argv[2])
before, after = score["odometry"]["ate_rmse"], score["trajectory"]["ate_rmse"]
good = after <= (share * before if before > 0.01 else 0.10)
objects = score["overall"]
print(f"{'ok' if good else 'FAILED'}: ATE {before:.3f} m of odometry, {after:.3f} m of the map; laid over the truth, recall {objects['recall']:.2f}, "
      f"precision {objects['precision']:.2f}, mean error {objects['position_error']['mean']:.3f} m")
sys.exit(0 if good else 1)
EOF
}

echo "== true poses: alignment does no harm"
ate "$out/true.lcm" "$out/true" 1 || failed=1
for seed in 1 2 3; do
  echo "== odometry that drifts by 2 % and 0.5 degrees in 10 m, seed $seed"
  run "$build/hgg-convert" semantickitti "$out/kitti" -o "$out/drift.lcm" --poses "$out/kitti/poses.txt" --odometry poor --seed $seed
  replay "$out/drift.lcm" "$out/drift"
  ate "$out/drift.lcm" "$out/drift" 0.333 || failed=1
done
exit $failed
