# Sourced by the tests on real data, with their own arguments: sets repo, build, data and out, and ends the test where the data are absent.
# usage: need=FOLDER; . "$(dirname "$0")/real_data.sh"     Data: $HGG_DATA, else ../shared/data beside the repository.
repo=$(cd "$(dirname "$0")/.." && pwd)
build=${1:-$repo/build}
data=${HGG_DATA:-$repo/../shared/data}

if [ ! -d "$data/$need" ]; then
  echo "skipped: no $need in $data (HGG_DATA names another folder)"
  exit 77
fi
if [ $# -ge 2 ]; then
  out=$2
else
  out=$(mktemp -d)
  trap 'rm -rf "$out"' EXIT
fi
mkdir -p "$out" || exit 2

run() { "$@" || { echo "failed: $*" >&2; exit 2; }; }
