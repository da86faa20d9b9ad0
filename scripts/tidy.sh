#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/tidy.sh [--all] [--jobs N] [FOLDER or FILE ...]
#
# Static analysis: clang-tidy with the checks of .clang-tidy. Prints each finding, and a table of the folders; status 1 when there
# is a finding. Without names: sources that differ from the branch main, or that include a header which does.
#
#   FOLDER, FILE  these sources, and those in these folders
#   --all         all sources: the first time half an hour of two cores
#   --jobs N      sources at the same time, default the number of cores
#
# The script skips a source without findings until it, a header that it includes or a check changes. It needs clang and clang-tidy
# (apt-get install clang clang-tidy) and works in build-tidy, beside the usual build. With clang's headers
# (libclang-14-dev), it takes half of the time: scripts/robustness/own_sources.cpp.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

jobs="$(nproc)" names=() all=""
while [ $# -gt 0 ]; do
  case "$1" in
    --all) all=1 ;;
    --jobs) [ $# -gt 1 ] || refuse "--jobs needs a number"; jobs="$2"; shift ;;
    -*) refuse "unknown option $1 (--help)" ;;
    *) [ -e "$1" ] || [ -e "$ROOT/$1" ] || refuse "there is no $1"; names+=("$1") ;;
  esac
  shift
done
for tool in clang++ clang-tidy; do command -v "$tool" > /dev/null || fail "$tool is missing: apt-get install clang clang-tidy"; done

export BUILD="${HRP_TIDY_BUILD_DIR:-$ROOT/build-tidy}"
# Precompiled headers of another compiler would be refused.
CC=clang CXX=clang++ configure -DBUILD_TESTING=ON -DHRP_RUN_ONLY=OFF -DHRP_PRECOMPILE=OFF -DHRP_FUZZ=ON -DCMAKE_EXPORT_COMPILE_COMMANDS=ON
# Generated headers first: every source of ours may include them. These targets make what objects wait for, and no object.
ninja -C "$BUILD" -j "$jobs" cmake_object_order_depends_target_{hrp_messages,hrp_cyclone_descriptors} > "$BUILD/generated.log" || { cat "$BUILD/generated.log" >&2; exit 1; }

# A plugin must be of clang-tidy's own version.
clang="$(dirname "$(dirname "$(readlink -f "$(command -v clang-tidy)")")")" options=()
if [ -e "$clang/include/clang/Frontend/FrontendPluginRegistry.h" ]; then
  c++ -std=c++17 -O1 -fno-rtti -fPIC -shared -isystem "$clang/include" -o "$BUILD/own_sources.so" "$ROOT/scripts/robustness/own_sources.cpp"
  options+=(--load="$BUILD/own_sources.so")
fi
# The same position-independent code everywhere: clang refuses precompiled headers of another kind.
same=(-fPIC -fno-semantic-interposition -fvisibility=default)
clang++ -x c++-header -std=c++17 -O1 -DNDEBUG -ffp-contract=off -fsanitize=fuzzer-no-link "${same[@]}" -isystem /usr/include/eigen3 \
  -o "$BUILD/headers.pch" "$ROOT/scripts/robustness/tidy_headers.h"
for word in "${same[@]}" -include-pch "$BUILD/headers.pch"; do options+=(--extra-arg="$word"); done
exec python3 "$ROOT/scripts/robustness/tidy.py" --jobs "$jobs" ${all:+--all} "${options[@]/#/--option=}" "$BUILD" "${names[@]}"
