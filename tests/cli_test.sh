#!/bin/bash
# Exit codes and error texts of hggmap: 0 done, 2 bad input or usage with one clear line that names what was wrong.
# usage: tests/cli_test.sh BUILD_DIR
set -u
hggmap=$(realpath "${1:?usage: tests/cli_test.sh BUILD_DIR}")/hggmap
repo=$(cd "$(dirname "$0")/.." && pwd)
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch" || exit 1
failed=0

complain() {
  echo "FAILED: $*"
  failed=1
}

# expect CODE LINES PATTERN COMMAND...: exit code, number of lines on stderr, and what one of them says.
expect() {
  local code=$1 lines=$2 pattern=$3
  shift 3
  timeout 60 "$@" > stdout 2> stderr < /dev/null
  local got=$?
  [ "$got" -eq "$code" ] || complain "exit $got instead of $code: $*: $(head -c 300 stderr)"
  [ "$(wc -l < stderr)" -eq "$lines" ] || complain "$(wc -l < stderr) lines on stderr instead of $lines: $*: $(head -c 600 stderr)"
  grep -qE -- "$pattern" stderr || complain "no '$pattern' on stderr: $*: $(head -c 300 stderr)"
}

# says PATTERN COMMAND...: exit 0 and the pattern on stdout.
says() {
  local pattern=$1
  shift
  timeout 60 "$@" > stdout 2> stderr < /dev/null || complain "exit $?: $*: $(head -c 300 stderr)"
  grep -qE -- "$pattern" stdout || complain "no '$pattern' on stdout: $*"
}

# Usage.
expect 2 1 'subcommand' "$hggmap"
expect 2 1 'subcommand' "$hggmap" fly
says 'Subcommands' "$hggmap" --help
says '^hggmap [0-9]+\.[0-9]+' "$hggmap" --version
for command in run replay export info align; do
  says 'Example' "$hggmap" "$command" --help
done
expect 2 1 '--warp' "$hggmap" run --warp
expect 2 1 '--warp' "$hggmap" replay l.lcm --warp
expect 2 1 '--warp' "$hggmap" export m.hgg --format json -o x --warp
expect 2 1 '--warp' "$hggmap" info m.hgg --warp
expect 2 1 'LOG' "$hggmap" replay
expect 2 1 'MAP' "$hggmap" info
expect 2 1 'B' "$hggmap" align a.hgg
expect 2 1 'MAP' "$hggmap" export --format json -o x
expect 2 1 'format' "$hggmap" export m.hgg --format stl -o x
expect 2 1 'output' "$hggmap" export m.hgg --format json

# Logs.
echo 'not a log' > text.log
: > empty.log
mkdir folder.log
expect 2 1 'missing\.lcm' "$hggmap" replay missing.lcm --out out
expect 2 1 'text\.log' "$hggmap" replay text.log --out out
expect 2 1 'empty\.log' "$hggmap" replay empty.log --out out
expect 2 1 'folder\.log' "$hggmap" replay folder.log --out out

mkdir earlier && echo 'kept' > earlier/trajectory.tum
expect 2 1 'missing\.lcm' "$hggmap" replay missing.lcm --out earlier
[ "$(cat earlier/trajectory.tum)" = kept ] || complain "a missing log emptied the results of an earlier replay"

# Configs.
expect 2 1 'missing\.toml' "$hggmap" run --config missing.toml
expect 2 1 'missing\.toml' "$hggmap" replay text.log --config missing.toml
printf 'speed = 3\n[frame]\nrange_max = "far"\nrange_mim = 1\n[map]\nleaf_size = -1\n' > bad.toml
for command in 'run' 'replay text.log'; do
  # shellcheck disable=SC2086
  expect 2 4 'bad\.toml:1: .*speed' "$hggmap" $command --config bad.toml
  grep -q 'bad\.toml:3: .*range_max' stderr || complain "range_max is not listed: $(cat stderr)"
  grep -q 'bad\.toml:4: .*range_mim' stderr || complain "range_mim is not listed: $(cat stderr)"
  grep -q 'bad\.toml:6: .*leaf_size' stderr || complain "leaf_size is not listed: $(cat stderr)"
done
printf 'classes = "none.toml"\n' > classless.toml
expect 2 1 'none\.toml' "$hggmap" run --config classless.toml

# The printed config is a config.
says '^leaf_size = ' "$hggmap" run --print-config
cp stdout printed.toml
says '^leaf_size = ' "$hggmap" run --config printed.toml --print-config
cmp -s stdout printed.toml || complain "--print-config does not print what it reads"
says 'udpm://1\.2\.3\.4:5' "$hggmap" run --lcm-url 'udpm://1.2.3.4:5?ttl=0' --print-config
for robot in "$repo"/firmware_cfg/*/hggmap.toml; do
  says '^leaf_size = ' "$hggmap" run --config "$robot" --print-config
done

# Maps.
printf 'HGGMAP\r\n\001\000\000\000\050\265\057\375rubbish' > corrupt.hgg
printf 'HGGMAP\r\n\007\000\000\000' > newer.hgg
echo 'not a map' > text.hgg
for map in corrupt newer text missing; do
  expect 2 1 "$map\\.hgg" "$hggmap" info $map.hgg
  expect 2 1 "$map\\.hgg" "$hggmap" export $map.hgg --format json -o export.json
  expect 2 1 "$map\\.hgg" "$hggmap" run --map $map.hgg --out out
  expect 2 1 "$map\\.hgg" "$hggmap" align $map.hgg $map.hgg --json
  [ ! -e export.json ] || complain "export.json was written from $map.hgg"
done

# Two maps: exit status, keys and numbers of the answer.
if ! timeout 60 "${hggmap%/*}/hgg-sim" yard --sensor lidar16 --frames 15 --rate 5 -o yard.lcm --truth truth > sim.txt 2>&1 ||
  ! timeout 60 "$hggmap" replay yard.lcm --config "$repo/firmware_cfg/semantickitti/hggmap.toml" --out yard > replay.txt 2>&1; then
  complain "no map to align: $(tail -n 3 sim.txt replay.txt)"
fi
timeout 60 "$hggmap" align yard/map.hgg yard/map.hgg --json > answer.json 2> stderr < /dev/null
code=$?
[ ! -s stderr ] || complain "align says on stderr: $(head -c 300 stderr)"
python3 - $code answer.json <<'EOF' || complain "align of a map with itself, exit $code: $(head -c 600 answer.json)"
import json, math, sys
lines = open(sys.argv[2]).read().splitlines()
assert len(lines) == 1, "not one line"
answer = json.loads(lines[0])
assert list(answer) == ["accepted", "T_a_b", "score", "threshold", "pairs", "reason", "evidence", "ms"], list(answer)
assert answer["accepted"] is True and sys.argv[1] == "0", "refused"
T = answer["T_a_b"]
assert len(T) == 12 and all(math.isfinite(v) for v in T)
assert max(abs(v - w) for v, w in zip(T, [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0])) < 1e-2, T
assert answer["score"] > answer["threshold"] and len(answer["pairs"]) >= 4
assert all(a == b for a, b in answer["pairs"]) and answer["reason"]
assert set(answer["evidence"]) == {"things_matched", "things_missed", "thing_share", "thing_odds", "overlap", "surface_share",
                                   "chance_share", "surface_odds", "runner_up"}
EOF
says '^accepted: ' "$hggmap" align yard/map.hgg yard/map.hgg
timeout 60 "$hggmap" align yard/map.hgg yard/map.hgg > /dev/full 2> stderr
code=$?
[ "$code" -eq 2 ] || complain "align exits $code where stdout is full"
grep -q 'stdout' stderr || complain "align does not say that stdout is full: $(head -c 300 stderr)"
for map in corrupt missing; do
  expect 2 1 "$map\\.hgg" "$hggmap" align yard/map.hgg $map.hgg --json
  [ ! -s stdout ] || complain "align answers where it failed: $(head -c 300 stdout)"
done
printf 'similar = 3\n[[class]]\nid = 1\nname = "x"\nkind = "ignore"\n' > classes.toml
expect 2 1 'classes\.toml: .*similar' "$hggmap" align yard/map.hgg yard/map.hgg --classes classes.toml
expect 2 1 'none\.toml: cannot read the class table$' "$hggmap" align yard/map.hgg yard/map.hgg --classes none.toml
printf 'similar = []\n[[class]]\nid = 1\nname = "x"\nkind = "ignore"\n' > classes.toml
says '^accepted: ' "$hggmap" align yard/map.hgg yard/map.hgg --classes classes.toml

# Where one can walk: exports, plans and what they refuse.
for format in bt ot grid; do
  timeout 60 "$hggmap" export yard/map.hgg --format $format -o walk.$format --resolution 0.2 --region -5,-5,5,5 > stdout 2> stderr ||
    complain "export --format $format: $(head -c 300 stderr)"
  [ ! -s stderr ] || complain "export --format $format says on stderr: $(head -c 300 stderr)"
  for resolution in 0 1e-9 nan -1; do
    expect 2 1 'resolution' "$hggmap" export yard/map.hgg --format $format -o no --resolution $resolution
  done
  expect 2 1 'outside the map' "$hggmap" export yard/map.hgg --format $format -o no --region 9000,9000,9001,9001
done
# Stopped at any time, an export leaves all of its files or none.
for delay in 0.05 0.1 0.2 0.4 0.8; do
  timeout -s INT "$delay" "$hggmap" export yard/map.hgg --format grid -o stopped --resolution 0.05 > stdout 2> stderr < /dev/null
  there=$(find . -maxdepth 1 -name 'stopped.*' | wc -l)
  [ "$there" -eq 0 ] || [ "$there" -eq 10 ] || complain "stopped after $delay s, an export leaves $there files"
  rm -f stopped.*
done
expect 2 1 'cannot write' "$hggmap" export yard/map.hgg --format json -o nowhere/x.json
[ "$(timeout 60 "$hggmap" export yard/map.hgg --format json -o /dev/stdout < /dev/null | head -c 1)" = "{" ] ||
  complain "an export does not go to a pipe"
timeout 60 "$hggmap" export yard/map.hgg --format ot --semantic -o semantic.ot --resolution 0.2 > stdout 2> stderr ||
  complain "export --semantic: $(head -c 300 stderr)"
grep -aq '^id ColorOcTree$' semantic.ot || complain "export --semantic makes no ColorOcTree"
expect 2 1 'semantic' "$hggmap" export yard/map.hgg --format bt --semantic -o no
if command -v bt2vrml > stdout; then  # octomap's own tool
  timeout 60 bt2vrml walk.bt > stdout 2> stderr < /dev/null && grep -q 'Box' walk.bt.wrl ||
    complain "bt2vrml does not take the .bt: $(tail -n 1 stderr)"
fi
[ -s walk.grid.pgm ] && [ -s walk.grid.layers.json ] && [ -s walk.grid.cost.npy ] || complain "the grid's files are missing"
expect 2 1 'cells' "$hggmap" export yard/map.hgg --format grid -o no --region -9000,-9000,9000,9000
for command in 'plan yard/map.hgg' 'plan yard/map.hgg --from 0,0' 'plan missing.hgg --from 0,0 --to 1,1' \
  'plan yard/map.hgg --from 0 --to 1,1' 'plan yard/map.hgg --from 0,0 --to 1,1 --resolution 0' \
  'plan yard/map.hgg --batch missing.jsonl'; do
  # shellcheck disable=SC2086
  expect 2 1 '.' "$hggmap" $command
done
timeout 60 "$hggmap" plan yard/map.hgg --from 0,0 --to 9000,0 --json > answer.json 2> stderr
code=$?
[ "$code" -eq 1 ] && grep -q '"found":false.*outside' answer.json || complain "a goal outside: exit $code, $(head -c 300 answer.json)"

# Graphs from elsewhere, and what a sentence means in them.
cat > room.json << 'JSON'
{"objects":[{"id":0,"label":"table","center":[0,0,0.4],"size":[1,1,0.8]},{"id":4,"label":"lamp","center":[0,0,1],"size":[0.2,0.2,0.4]},
 {"id":9,"label":"lamp","center":[3,2,0.8],"size":[0.3,0.3,1.6],"rgb":[200,30,30]}]}
JSON
says '3 objects of 2 classes' "$hggmap" import room.json -o room.hgg
says ' 4  lamp ' "$hggmap" query room.hgg 'the lamp on the table'
says '"status":"ok".*"id":9.*"goal":null' "$hggmap" query room.hgg 'the red lamp' --json
printf '{"text":"the table"}\n{"text":"the lamp on the left","from":[1,-3,1.57]}\n' > questions.jsonl
[ "$("$hggmap" query room.hgg --batch questions.jsonl | grep -c '"answers":\[{"id"')" -eq 2 ] || complain "query --batch"
for text in 'the banana' '' '}{' "$(head -c 10000 /dev/zero | tr '\0' x)" "$(printf '\377\376')"; do
  timeout 20 "$hggmap" query room.hgg "$text" --json > answer.json 2> stderr
  code=$?
  [ "$code" -eq 1 ] || [ -z "$text" ] && [ "$code" -le 2 ] || complain "query '$(head -c 20 <<< "$text")': exit $code"
done
printf '{"text":3}\n{"text":"the table"}\n' > bad.jsonl
for command in 'import missing.json -o no.hgg' 'import text.log -o no.hgg' 'query missing.hgg chair' 'query room.hgg' \
  'query room.hgg --batch bad.jsonl' 'query room.hgg chair --from 1,2'; do
  # shellcheck disable=SC2086
  expect 2 1 '.' "$hggmap" $command
done

# Where the results go: each command to its own default, and nowhere at all on a bad URL's account.
expect 2 1 '.' "$hggmap" replay text.log
[ ! -e out/run ] || complain "replay wrote into out/run"
: > file
expect 2 1 'file/out' "$hggmap" replay text.log --out file/out

[ "$failed" -eq 0 ] && echo ok
exit "$failed"
