#!/bin/bash
# Logs as they should not be: slow odometry, clocks that are set, stamps out of line or in another unit, channels that are
# silent. hggmap replay maps what can be mapped and says what was lost, or exits 2, says why, and leaves an earlier map alone.
# usage: tests/inputs_test.sh BUILD_DIR WORK_DIR
set -u
[ $# -eq 2 ] || { sed -n '2,4s/^# \{0,1\}//p' "$0" >&2; exit 2; }
build=$(realpath "$1")
tests=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$2" && cd "$2" || exit 2
config=$tests/../firmware_cfg/semantickitti/hggmap.toml
failed=0

complain() {
  echo "FAILED: $*"
  failed=1
}

relog() { python3 -B "$tests/relog.py" good.lcm "$1" case.lcm || complain "no log for $1"; }

# maps CASE FRAMES [PATTERN]: exit 0, so many frames, and what is said on stdout.
maps() {
  relog "$1"
  timeout 60 "$build/hggmap" replay case.lcm --config "$config" --out out > stdout 2> stderr
  local code=$?
  [ "$code" -eq 0 ] || { complain "$1: exit $code: $(head -c 600 stderr)"; return; }
  grep -q "^$2 frames" stdout || complain "$1: not $2 frames: $(head -c 600 stdout)"
  [ $# -lt 3 ] || grep -qE -- "$3" stdout || complain "$1: no '$3': $(head -c 900 stdout)"
}

# refuses CASE PATTERN: exit 2, one line on stderr that says why, and the earlier results are what they were.
refuses() {
  relog "$1"
  rm -rf earlier && mkdir earlier && for f in map.hgg trajectory.tum stats.json; do echo kept > earlier/$f; done
  timeout 60 "$build/hggmap" replay case.lcm --config "$config" --out earlier > stdout 2> stderr
  local code=$?
  [ "$code" -eq 2 ] || complain "$1: exit $code instead of 2: $(head -c 600 stdout)"
  [ "$(grep -c . stderr)" -eq 1 ] || complain "$1: not one line: $(head -c 900 stderr)"
  grep -qE -- "$2" stderr || complain "$1: no '$2': $(head -c 900 stderr)"
  [ "$(cat earlier/*)" = "$(printf 'kept\nkept\nkept')" ] || complain "$1: the earlier results are not what they were"
}

timeout 60 "$build/hgg-sim" yard --sensor lidar16 --frames 41 --rate 10 --seed 3 -o good.lcm --truth truth > sim.txt 2>&1 ||
  { tail -n 3 sim.txt; exit 1; }

maps good 41
for rate in 5 1 0.5; do
  maps odometry_${rate}hz 41
done
maps odometry_late 21 '20 clouds dropped: odometry: begins after the cloud'
maps odometry_ends 21 '20 clouds dropped: odometry: ends before the cloud'

for step in back_5s back_1h; do
  maps step_$step 41 'odometry began anew 1 times'
done
maps step_ahead_5s 41
maps step_ahead_10h 41 'odometry began anew 1 times'
maps joined_an_hour_apart 82 'odometry began anew 1 times'

for off in ahead_2s ahead_8s ahead_1h back_1h ahead_0.5s; do
  maps odometry_$off 41 '1 odometry samples rejected: 1 with stamps out of line'
  maps cloud_$off 41 '1 clouds dropped: cloud: stamp out of line'
done
maps twice 41 '41 clouds dropped: cloud: late or twice'
maps no_orientation_at_first 36 '5 messages unreadable: odometry: orientation'
maps nan_now_and_then 41 'messages unreadable: odometry: orientation'
maps event_times_zero 41
maps odd_events 41
! grep -q damaged stdout || complain "a healthy log is called damaged: $(cat stdout)"

refuses no_odometry 'nothing came on POSE_ODOM \(lcm\.odometry, .*LIDAR_SEMANTIC: 41'
refuses odometry_elsewhere 'nothing came on POSE_ODOM \(lcm\.odometry, .*POSE_BODY: 41 bot_core\.pose_t'
refuses clouds_elsewhere 'nothing came on LIDAR_SEMANTIC \(lcm\.lidar_semantic, .*VELODYNE: 41 bot_core\.pointcloud2_t'
refuses cloud_seconds 'stamps of LIDAR_SEMANTIC .* look like seconds'
refuses both_seconds 'stamps of LIDAR_SEMANTIC .* look like seconds.*stamps of POSE_ODOM .* look like seconds'
refuses cloud_milliseconds 'stamps of LIDAR_SEMANTIC .* look like milliseconds'
refuses cloud_nanoseconds 'stamps of LIDAR_SEMANTIC .* look like nanoseconds'
refuses both_nanoseconds 'stamps of POSE_ODOM .* look like nanoseconds'
refuses both_zero 'all 41 stamps of LIDAR_SEMANTIC are the same, 0'
refuses boot_clock 'LIDAR_SEMANTIC .* lie 41\.7 years before those of POSE_ODOM'
refuses tai 'LIDAR_SEMANTIC .* lie 33\.0 s after those of POSE_ODOM'
refuses no_orientation '41 messages unreadable \(odometry: orientation'

# A log that was cut: what there is is mapped, and what is missing is told.
relog good
head -c $(($(stat -c %s case.lcm) * 2 / 3)) case.lcm > cut.lcm
timeout 60 "$build/hggmap" replay cut.lcm --config "$config" --out out > stdout 2> stderr || complain "a cut log: exit $?"
grep -q '^2[5-9] frames' stdout && grep -q 'damaged' stdout || complain "a cut log: $(head -c 600 stdout)"

[ "$failed" -eq 0 ] && echo ok
exit "$failed"
