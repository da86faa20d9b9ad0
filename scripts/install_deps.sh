#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/install_deps.sh [--run | --tests] [--viewer] [--list]
#
# Installs the Debian 12 packages that the project needs. If all are installed, it ends within a second.
# As root or with sudo, it installs them itself. Otherwise it prints the line to run, and ends with status 1.
#
#   --run     only what a run needs (scripts/simulate.sh), without viewer, diagnosis and the Python package
#   --tests   also what the tests need: GoogleTest, Google Benchmark, DART, Node with npm, Chromium, iproute2,
#             pandas, matplotlib, SciPy, h5py and Dask; clang-format; and lld and ccache, which make builds of the whole tree faster
#   --viewer  also what the page of the viewer is built with: Node with npm
#   --list    print the packages and do nothing
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

run_packages=(
  cmake ninja-build g++ pkg-config python3
  libeigen3-dev liburdfdom-dev liburdfdom-headers-dev libconsole-bridge-dev libtinyxml2-dev
  libmujoco-dev libsdformat-dev libembree-dev
  libfcl-dev libyaml-cpp-dev libassimp-dev libpng-dev
  cyclonedds-dev cyclonedds-tools libfastrtps-dev fastddsgen libfastcdr-dev libssl-dev
  libcli11-dev libzstd-dev liblz4-dev libdeflate-dev zlib1g-dev
)
build_packages=("${run_packages[@]}" nlohmann-json3-dev libboost-dev libsqlite3-dev libbz2-dev
  pybind11-dev python3-dev python3-numpy python3-yaml)
test_packages=(libgtest-dev libgmock-dev libbenchmark-dev libdart-dev chromium iproute2 python3-pandas python3-matplotlib python3-distributed
  python3-scipy python3-h5py
  clang-format
  lld ccache) # nothing needs them: builds of the whole tree are faster with them

# Any Node from 18 on will do, wherever it came from; Debian's npm would pull in Debian's Node beside it.
add_node() {
  command -v node > /dev/null || packages+=(nodejs)
  command -v npm > /dev/null || packages+=(npm)
}

packages=("${build_packages[@]}")
list_only=false
for argument in "$@"; do
  case "$argument" in
    --run) packages=("${run_packages[@]}") ;;
    --tests)
      packages+=("${test_packages[@]}")
      add_node
      ;;
    --viewer) add_node ;;
    --list) list_only=true ;;
    -h | --help) print_help; exit 0 ;;
    *) refuse "unknown argument '$argument'; --help lists the known ones" ;;
  esac
done

if $list_only; then
  printf '%s\n' "${packages[@]}"
  exit 0
fi
if ! command -v dpkg-query > /dev/null || ! command -v apt-get > /dev/null; then
  say "This is no Debian system; going on as if these (Debian 12 names) were there: ${packages[*]}"
  exit 0
fi

# dpkg-query fails when one package is unknown, and still prints the others.
installed="$(dpkg-query -W -f='${db:Status-Status} ${Package}\n' "${packages[@]}" 2> /dev/null || true)"
missing=()
for package in "${packages[@]}"; do
  grep -qxF "installed $package" <<< "$installed" || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

options=(--yes --no-install-recommends -o DPkg::Lock::Timeout=600)
if [ "$(id -u)" -eq 0 ]; then
  as_root=(env DEBIAN_FRONTEND=noninteractive)
elif command -v sudo > /dev/null && { sudo -n true 2> /dev/null || [ -t 0 ]; }; then
  as_root=(sudo env DEBIAN_FRONTEND=noninteractive)
else
  say "Some packages are missing, and this user may not install them. As root, run:"
  say "  apt-get update && apt-get install --yes --no-install-recommends ${missing[*]}"
  exit 1
fi
say "Installing: ${missing[*]}"
log="$(mktemp)"
trap 'rm -f "$log"' EXIT
# Package lists may be empty or old: refresh them, and go on with what there is when that fails.
"${as_root[@]}" apt-get update -q > "$log" 2>&1 || { tail -n 3 "$log" >&2; say "apt-get update failed, going on"; }
if ! "${as_root[@]}" apt-get install -q "${options[@]}" "${missing[@]}" > "$log" 2>&1; then
  tail -n 30 "$log" >&2
  fail "apt-get could not install: ${missing[*]}"
fi
say "Installed."
