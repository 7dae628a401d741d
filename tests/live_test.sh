#!/bin/bash
# Plays LOG in real time over LCM into `hggmap run` and checks that it maps what `hggmap replay` maps: every frame, none dropped,
# the same objects. Multicast goes over the loopback of a network namespace of its own (root, or user namespaces allowed).
# usage: live_test.sh [LOG] BUILD_DIR OUT
# Without LOG: kitti_0001 from $HGG_DATA, else from ../shared/data beside the repository, else a simulated world.
set -euo pipefail

fail() {
  echo "live_test: FAILED: $*" >&2
  exit 1
}

# Writes a log of its own to $2/live.lcm with the tools in $1.
make_log() {
  local data=${HGG_DATA:-$(dirname "$0")/../../shared/data}
  if [ -d "$data/kitti_0001" ]; then
    python3 "$data/unpack.py" "$data/kitti_0001" "$2/kitti" >/dev/null &&
      "$1/hgg-convert" semantickitti "$2/kitti" -o "$2/live.lcm" && rm -r "$2/kitti"
  else
    echo "live_test: no kitti_0001 in $data, taking a simulated world"
    "$1/hgg-sim" yard --frames 100 -o "$2/live.lcm" --truth "$2/truth"
  fi
}

if [ "${1:-}" != --inside ]; then
  if [ $# -eq 2 ]; then
    mkdir -p "$2"
    make_log "$1" "$2" || fail "no log to play"
    set -- "$2/live.lcm" "$1" "$2"
  fi
  [ $# -eq 3 ] || { echo "usage: live_test.sh [LOG] BUILD_DIR OUT" >&2; exit 2; }
  map_root=()
  [ "$(id -u)" -eq 0 ] || map_root=(--map-root-user)
  exec unshare --net "${map_root[@]}" "$0" --inside "$@"
fi

log=$2 hggmap=$3/hggmap out=$4
url="udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304"
ip link set lo up
ip route add 224.0.0.0/4 dev lo
mkdir -p "$out"
rm -rf "$out/live" "$out/replay" "$out"/{live,replay}.json
: >"$out/live.log"

# Waits up to $1 seconds for a command to succeed.
wait_for() {
  local tries=$(($1 * 20))
  shift
  until "$@"; do
    kill -0 "$mapper" 2>/dev/null || fail "hggmap run ended early: $(tail -n 1 "$out/live.log")"
    [ $((tries--)) -gt 0 ] || return 1
    sleep 0.05
  done
}
is_listening() { grep -q "listening to" "$out/live.log"; }
is_idle() { grep -q " Hz," "$out/live.log" && tail -n 1 "$out/live.log" | grep -q "no frames"; }

"$hggmap" replay "$log" --out "$out/replay" >"$out/replay.log" || fail "replay: $(tail -n 1 "$out/replay.log")"

"$hggmap" run --lcm-url "$url" --out "$out/live" >"$out/run.log" 2>"$out/live.log" &
mapper=$!
trap 'kill "$mapper" 2>/dev/null || true' EXIT
wait_for 20 is_listening || fail "hggmap run does not listen"
lcm-logplayer -s 1 --lcm-url="$url" "$log" >"$out/player.log" 2>&1 || fail "lcm-logplayer: $(tail -n 1 "$out/player.log")"
wait_for 30 is_idle || fail "hggmap run does not come to rest after the log"
kill -INT "$mapper"
wait "$mapper" || fail "hggmap run exits with $?: $(tail -n 1 "$out/live.log")"
trap - EXIT

for run in live replay; do
  "$hggmap" export "$out/$run/map.hgg" --format json -o "$out/$run.json" || fail "export of the $run map"
done

python3 - "$log" "$out" <<'PYTHON' || exit 1
import json, math, pathlib, struct, sys

log, out = sys.argv[1], pathlib.Path(sys.argv[2])


def fail(text):
    sys.exit(f"live_test: FAILED: {text}")


clouds = 0
with open(log, "rb") as file:
    while header := file.read(28):
        _, _, _, channel, data = struct.unpack(">IqqII", header)
        clouds += file.read(channel) == b"LIDAR_SEMANTIC"
        file.seek(data, 1)
for run in ("live", "replay"):
    stats = json.loads((out / run / "stats.json").read_text())
    if stats["frames"] != clouds or stats["dropped"] != 0:
        fail(f"{run}: {stats['frames']} frames and {stats['dropped']} dropped of {clouds} clouds in the log")

live, replay = (json.loads((out / f"{run}.json").read_text())["objects"] for run in ("live", "replay"))
if len(live) != len(replay):
    fail(f"{len(live)} objects live, {len(replay)} in the replay")
left = list(replay)
for a in live:
    same = [b for b in left if b["label"] == a["label"]]
    b = min(same, key=lambda o: math.dist(o["mean"], a["mean"]), default=None)
    if b is None or math.dist(a["mean"], b["mean"]) > 0.01:
        fail(f"object {a['id']} ({a['name']}) at {a['mean']} has no counterpart within 1 cm in the replay")
    left.remove(b)
print(f"live_test: passed: {clouds} frames live, none dropped, {len(live)} objects as in the replay")
PYTHON
