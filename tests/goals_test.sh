#!/bin/bash
# Plays a simulated drive in real time over LCM into `hggmap run` while the clients of examples/ ask for three things in words, two of
# them by what they are next to, and holds the replies against the truth: the right object, a goal within 1 m of its surface, on ground
# that is free, a way that does not lead over blocked ground, an answer in time.
# usage: goals_test.sh BUILD_DIR OUT [WORLD] [FRAMES]
set -euo pipefail

fail() {
  echo "goals_test: FAILED: $*" >&2
  exit 1
}

if [ "${1:-}" != --inside ]; then
  [ $# -ge 2 ] || { echo "usage: goals_test.sh BUILD_DIR OUT [WORLD] [FRAMES]" >&2; exit 2; }
  map_root=()
  [ "$(id -u)" -eq 0 ] || map_root=(--map-root-user)
  exec unshare --net "${map_root[@]}" "$0" --inside "$@"
fi

build=$2 out=$3 world=${4:-apartment} frames=${5:-300}
repo=$(cd "$(dirname "$0")/.." && pwd)
url="udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304"
ip link set lo up
ip route add 224.0.0.0/4 dev lo
rm -rf "$out"
mkdir -p "$out"

# The examples as their reader builds them: against what is installed.
cmake --install "$build" --component lcmtypes --prefix "$out/installed" >"$out/install.log" || fail "install"
{ cmake -S "$repo/examples/cpp" -B "$out/go_to" -DCMAKE_PREFIX_PATH="$(realpath "$out")/installed" && cmake --build "$out/go_to"; } \
  >"$out/example.log" 2>&1 || fail "examples/cpp: $(tail -n 3 "$out/example.log")"
lcm-gen -p --ppath="$out/types" "$out"/installed/share/hggmap/lcmtypes/*.lcm || fail "lcm-gen -p"

"$build/hgg-sim" "$world" --sensor lidar64 --frames "$frames" -o "$out/drive.lcm" --truth "$out/truth" >"$out/sim.log" 2>&1 || fail "hgg-sim"
python3 -B "$repo/tests/goals_check.py" choose "$out/truth" >"$out/asked.jsonl" || fail "no things to ask for"

waited_for() {  # up to $1 seconds for a command to succeed
  local tries=$(($1 * 20))
  shift
  until "$@"; do
    kill -0 "$mapper" 2>/dev/null || fail "hggmap run ended early: $(tail -n 1 "$out/run.log")"
    [ $((tries--)) -gt 0 ] || return 1
    sleep 0.05
  done
}
is_listening() { grep -q "listening to" "$out/run.log"; }
is_told() { grep -q "^goal" "$1"; }

"$build/hggmap" run --config "$repo/firmware_cfg/indoor/hggmap.toml" --lcm-url "$url" --out "$out/map" >/dev/null 2>"$out/run.log" &
mapper=$!
lcm-logger --lcm-url="$url" --force --quiet --channel='GOAL_.*|NAV_TARGET|POSE_MAP|HGG_STATUS' "$out/heard.lcm" >"$out/logger.log" 2>&1 &
logger=$!
trap 'kill "$mapper" "$logger" $(jobs -p) 2>/dev/null || true' EXIT
waited_for 20 is_listening || fail "hggmap run does not listen"
lcm-logplayer -s 1 --lcm-url="$url" "$out/drive.lcm" >"$out/player.log" 2>&1 &
player=$!

# While the drive goes on: in the last tenth of it, one after the other.
sleep "$((frames * 9 / 100))"
export PYTHONPATH="$out/types:$repo/tests/python"
number=0
while read -r line; do
  text=$(python3 -c 'import json, sys; print(json.loads(sys.argv[1])["text"])' "$line")
  number=$((number + 1))
  client=("$out/go_to/go_to")
  [ "$number" -ne 2 ] || client=(python3 -B "$repo/examples/python/go_to.py")
  "${client[@]}" "$text" "$url" >"$out/client_$number.log" 2>&1 &
  waited_for 20 is_told "$out/client_$number.log" || fail "\"$text\": $(tail -n 2 "$out/client_$number.log")"
done <"$out/asked.jsonl"
wait "$player" || fail "lcm-logplayer: $(tail -n 1 "$out/player.log")"
kill -INT "$logger"
wait "$logger" || true
kill -INT "$mapper"
wait "$mapper" || fail "hggmap run: $(tail -n 1 "$out/run.log")"
trap - EXIT
kill $(jobs -p) 2>/dev/null || true
python3 -B "$repo/tests/goals_check.py" check "$out/truth" "$out/asked.jsonl" "$out/heard.lcm" || exit 1
