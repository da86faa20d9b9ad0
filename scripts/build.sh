#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/build.sh [--tests] [TARGET ...]
#
# Builds all programs (Release) into build/bin; only what changed is built again. HRP_BUILD_DIR names another folder.
#
#   --tests   the tests and benchmarks, too
#   TARGET    only these targets
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

tests=false
targets=()
for argument in "$@"; do
  case "$argument" in
    --tests) tests=true ;;
    -h | --help) print_help; exit 0 ;;
    -*) fail "unknown argument '$argument'; --help lists the known ones" ;;
    *) targets+=("$argument") ;;
  esac
done

# Once a folder is configured with tests it stays so: switching back and forth would rebuild things.
if $tests; then
  grep -qs '^BUILD_TESTING:BOOL=ON' "$BUILD/CMakeCache.txt" && [ -f "$BUILD/build.ninja" ] || configure -DBUILD_TESTING=ON
elif [ ! -f "$BUILD/build.ninja" ]; then
  configure -DBUILD_TESTING=OFF
fi
if [ ${#targets[@]} -eq 0 ] && ! $tests; then
  targets=(hrp_programs)
fi
run_ninja "${targets[@]}"
