#!/bin/bash
# Plays LOG in real time over LCM into `hggmap run` and checks that it maps what `hggmap replay` maps: every frame, none dropped,
# the same objects. Multicast goes over the loopback of a network namespace of its own (root, or user namespaces allowed).
# usage: live_test.sh [LOG] BUILD_DIR OUT
# $HGG_LIVE_CONFIG: a config; $HGG_LIVE_CHANNEL: the channel of its clouds.
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
config=()
[ -z "${HGG_LIVE_CONFIG:-}" ] || config=(--config "$HGG_LIVE_CONFIG")
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
is_answered() { grep -q "command 7 of 'live_test'" "$out/live.log"; }
is_idle() { grep -q " Hz," "$out/live.log" && tail -n 1 "$out/live.log" | grep -q "no frames"; }

"$hggmap" replay "$log" "${config[@]}" --out "$out/replay" >"$out/replay.log" || fail "replay: $(tail -n 1 "$out/replay.log")"

"$hggmap" run "${config[@]}" --lcm-url "$url" --out "$out/live" >"$out/run.log" 2>"$out/live.log" &
mapper=$!
lcm-logger --lcm-url="$url" --force --quiet --channel='MAP_TRAVERSABILITY|HGG_COMMAND.*' "$out/heard.lcm" >"$out/logger.log" 2>&1 &
logger=$!
trap 'kill "$mapper" "$logger" 2>/dev/null || true' EXIT
wait_for 20 is_listening || fail "hggmap run does not listen"
lcm-logplayer -s 1 --lcm-url="$url" "$log" >"$out/player.log" 2>&1 || fail "lcm-logplayer: $(tail -n 1 "$out/player.log")"
wait_for 30 is_idle || fail "hggmap run does not come to rest after the log"
python3 - "$out/command.lcm" <<'PYTHON'
import struct, sys

# hgg.command_t: PUBLISH_TRAVERSABILITY of 8 x 6 m at 0.2 m.
command = struct.pack(">QqI", 0x1EE47F3CBFE785B6, 1, 10) + b"live_test\0" + struct.pack(">qbb6d", 7, 6, 1, -4, -3, 4, 3, -1.5, 0.2)
channel = b"HGG_COMMAND"
with open(sys.argv[1], "wb") as log:
    for number in range(2):
        log.write(struct.pack(">IqqII", 0xEDA1DA01, number, 1000 * number, len(channel), len(command)) + channel + command)
PYTHON
lcm-logplayer -s 1 --lcm-url="$url" "$out/command.lcm" >>"$out/player.log" 2>&1 || fail "lcm-logplayer: $(tail -n 1 "$out/player.log")"
wait_for 30 is_answered || fail "no answer to a command"
kill -INT "$logger"
wait "$logger" || true
kill -INT "$mapper"
wait "$mapper" || fail "hggmap run exits with $?: $(tail -n 1 "$out/live.log")"
trap - EXIT

for run in live replay; do
  "$hggmap" export "$out/$run/map.hgg" --format json -o "$out/$run.json" || fail "export of the $run map"
done

python3 - "$log" "$out" <<'PYTHON' || exit 1
import json, math, os, pathlib, struct, sys

log, out = sys.argv[1], pathlib.Path(sys.argv[2])


def fail(text):
    sys.exit(f"live_test: FAILED: {text}")


clouds = 0
with open(log, "rb") as file:
    while header := file.read(28):
        _, _, _, channel, data = struct.unpack(">IqqII", header)
        clouds += file.read(channel) == os.environ.get("HGG_LIVE_CHANNEL", "LIDAR_SEMANTIC").encode()
        file.seek(data, 1)


def events(path):
    with open(path, "rb") as file:
        while header := file.read(28):
            _, _, _, channel, data = struct.unpack(">IqqII", header)
            yield file.read(channel).decode(), file.read(data)


class Reader:
    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, layout):
        values = struct.unpack_from(">" + layout, self.data, self.at)
        self.at += struct.calcsize(">" + layout)
        return values if len(values) > 1 else values[0]

    def string(self):
        size = self.take("i")
        return self.take(f"{size}s")[:-1].decode()


def traversability(data):
    """The head of an hgg.traversability_t, all of which must be there."""
    r = Reader(data)
    fingerprint, utime, _ = r.take("Qqq")
    x, y, resolution, _, width, height, levels, layers = r.take("4d4i")
    names = []
    for _ in range(layers):
        names.append(r.string())
        _, _, size = r.take("bbi")
        if r.take("4s") != b"\x28\xb5\x2f\xfd":
            fail(f"layer {names[-1]} is no zstd frame")
        r.at += size - 4
    if fingerprint != 0xF7A8A26172165BC6 or r.at != len(data) or not 1 <= levels <= 8:
        fail(f"a MAP_TRAVERSABILITY of {len(data)} bytes does not decode")
    if names != ["cost", "height", "slope", "step", "roughness", "clearance", "confidence"]:
        fail(f"layers of MAP_TRAVERSABILITY: {names}")
    return utime, x, y, resolution, width, height


heard = list(events(out / "heard.lcm"))
grids = [traversability(data) for channel, data in heard if channel == "MAP_TRAVERSABILITY"]
around = {g[0] for g in grids if abs(g[3] - 0.1) < 1e-9}
if len(around) < max(1, clouds // 20):  # one a second is sent, and clouds come at 10 Hz
    fail(f"only {len(around)} grids around the robot were heard")
asked = [g for g in grids if abs(g[3] - 0.2) < 1e-9]
if [g[1:] for g in asked] != [(-4.0, -3.0, 0.2, 40, 30)]:
    fail(f"asked twice under one id for a grid of 8 x 6 m, got {asked}")
replies = [data for channel, data in heard if channel == "HGG_COMMAND_REPLY"]
if not replies or b"live_test" not in replies[0] or b"sent 40 x 30 cells" not in replies[0]:
    fail(f"answers to the command: {replies}")

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
