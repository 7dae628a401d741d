#!/bin/bash
# Maps kitti_0001 through a rig: clouds without labels, and label images of four virtual cameras around the LiDAR whose masks bleed
# by two pixels. Holds the cars, and the time of a frame, against the same drive with labelled clouds; then plays the log over LCM.
# usage: tests/kitti_rig_test.sh [BUILD_DIR] [OUT_DIR]     Data: $HGG_DATA, else ../shared/data beside the repository.
# Exit: 0 passed, 77 skipped, 1 a number is out of bounds, 2 a command failed.
set -u
need=kitti_0001
. "$(dirname "$0")/real_data.sh"
replay() { run "$build/hggmap" replay "$out/$1.lcm" --config "$repo/firmware_cfg/$2/hggmap.toml" --out "$out/$1"; }

run python3 "$data/unpack.py" "$data/kitti_0001" "$out/kitti"
run "$build/hgg-convert" semantickitti "$out/kitti" -o "$out/labelled.lcm" --poses "$out/kitti/poses.txt"
run "$build/hgg-convert" semantickitti "$out/kitti" -o "$out/rig.lcm" --poses "$out/kitti/poses.txt" --label-images
run "$build/hgg-convert" kitti-truth "$out/kitti" -o "$out/truth" --boxes "$data/kitti_0001/boxes.csv"

failed=0
if ! diff <(grep -v '^#' "$out/rig.rig.toml") <(grep -v '^#' "$repo/firmware_cfg/kitti_hdl64_cam/rig.toml"); then
  echo "FAILED: firmware_cfg/kitti_hdl64_cam/rig.toml is not the rig of the converter"
  failed=1
fi

replay labelled semantickitti
replay rig kitti_hdl64_cam
for log in labelled rig; do
  run "$build/hgg-eval" --truth "$out/truth" --class car --radius 1.5 --map "$out/$log/map.hgg" --trajectory "$out/$log/trajectory.tum" \
    --times "$out/kitti/times.txt" --json > "$out/$log.json"
done
python3 - "$out" <<'PYTHON' || failed=1
import json, sys

out = sys.argv[1]
score = {log: json.load(open(f"{out}/{log}.json"))["overall"] for log in ("labelled", "rig")}
stats = {log: json.load(open(f"{out}/{log}/stats.json")) for log in ("labelled", "rig")}
failed = False


def check(name, value, bound, good):
    global failed
    failed |= not good
    print(f"{'ok' if good else 'FAILED'}: {name} {value:.3f} ({bound})")


for log in ("labelled", "rig"):
    s = score[log]
    print(f"{log}: recall {s['recall']:.3f}, precision {s['precision']:.3f}, position error {s['position_error']['mean']:.3f} m, "
          f"frame_ms p50 {stats[log]['frame_ms']['p50']}, mean {stats[log]['frame_ms']['mean']}")
points = stats["rig"]["rig"]
print("points:", ", ".join(f"{key} {value}" for key, value in points.items() if key != "troubles"), points["troubles"])
# Two may be missed: docs/measurements.md says which and why.
check("recall of the rig", score["rig"]["recall"], "at least 10 of 12", score["rig"]["recall"] >= 0.83)
error = score["rig"]["position_error"]["mean"]
check("position error of the rig, m", error, "at most 0.15", error <= 0.15)
ratio = stats["rig"]["frame_ms"]["p50"] / stats["labelled"]["frame_ms"]["p50"]
print(f"frame time against labelled clouds {ratio:.2f}")  # no bound: times depend on who else uses the machine
check("frames dropped", stats["rig"]["dropped"], "0", stats["rig"]["dropped"] == 0)
sys.exit(failed)
PYTHON

echo "== live, over LCM"
HGG_LIVE_CONFIG=$repo/firmware_cfg/kitti_hdl64_cam/hggmap.toml HGG_LIVE_CHANNEL=LIDAR \
  "$repo/tests/live_test.sh" "$out/rig.lcm" "$build" "$out/live" || failed=1
exit $failed
