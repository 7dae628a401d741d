#!/usr/bin/env bash
# Installs the Debian 12 packages hggmap is built from. Idempotent: installs only what is missing and says what it does.
set -euo pipefail

packages=(
  build-essential cmake ninja-build pkg-config
  liblcm-dev liblcm-bin libglib2.0-dev                        # the bus (lcm.pc needs glib's)
  libeigen3-dev libceres-dev libnanoflann-dev liboctomap-dev libzstd-dev libsqlite3-dev
  libcli11-dev libtomlplusplus-dev libspdlog-dev libfmt-dev nlohmann-json3-dev
  libbz2-dev liblz4-dev libsqlite3-dev                        # hgg-convert: ROS bags
  wordnet-base                                                # nouns for queries; without it hggmap knows fewer words
  libgtest-dev libbenchmark-dev
  python3-rosbag python3-sensor-msgs python3-nav-msgs python3-tf2-msgs  # tests only: bags by ROS's own writer
  python3 iproute2 util-linux                                 # test scripts: loopback-only network namespace
)
lint_packages=(clang-format clang-tidy)

if [[ "${1:-}" == "--help" ]]; then
  echo "usage: tools/install_deps.sh [--lint]   install build and test dependencies (--lint: and clang-format, clang-tidy)"
  exit 0
fi
[[ "${1:-}" == "--lint" ]] && packages+=("${lint_packages[@]}")

missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q '^install ok installed$' || missing+=("$package")
done
if ((${#missing[@]} == 0)); then
  echo "dependencies: all ${#packages[@]} packages are installed"
  exit 0
fi

as_root=()
if ((EUID != 0)); then
  command -v sudo >/dev/null || { echo "dependencies: not root and no sudo; as root, run: apt-get install ${missing[*]}" >&2; exit 2; }
  as_root=(sudo)
fi
echo "dependencies: installing ${missing[*]}"
"${as_root[@]}" apt-get update -q
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}"
