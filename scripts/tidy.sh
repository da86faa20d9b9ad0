#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/tidy.sh [--jobs N] [FOLDER or FILE ...]
#
# Static analysis: clang-tidy with the checks of .clang-tidy over all C++ sources, or those below the names. Prints each
# finding, and how many files have any; status 1 when there is one. A file without a finding is not looked at again until it,
# or a header or a check, has changed: a night's first time takes an hour of one core, the next one minutes.
#
# It needs clang and clang-tidy (apt-get install clang clang-tidy). Its folder is build-tidy; only code that a build makes is
# built there.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

jobs="$(nproc)" names=()
while [ $# -gt 0 ]; do
  case "$1" in
    --jobs) [ $# -gt 1 ] || fail "--jobs needs a number"; jobs="$2"; shift ;;
    -*) fail "unknown option $1 (--help)" ;;
    *) names+=("$1") ;;
  esac
  shift
done
for tool in clang++ clang-tidy; do command -v "$tool" > /dev/null || fail "$tool is missing: apt-get install clang clang-tidy"; done

export BUILD="${HRP_TIDY_BUILD_DIR:-$ROOT/build-tidy}"
CC=clang CXX=clang++ configure -DBUILD_TESTING=ON -DHRP_RUN_ONLY=OFF -DHRP_PRECOMPILE=OFF -DHRP_FUZZ=ON -DCMAKE_EXPORT_COMPILE_COMMANDS=ON
# Generated headers first: every source of ours may include them.
if [ -z "${HRP_TIDY_NO_BUILD:-}" ]; then ninja -C "$BUILD" hrp_messages hrp_cyclone_descriptors >&2; fi
exec python3 "$ROOT/scripts/robustness/tidy.py" "$ROOT" "$BUILD" "$jobs" "${names[@]}"
