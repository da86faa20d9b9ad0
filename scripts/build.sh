#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/build.sh [--tests | --run] [TARGET ...]
#
# Builds all programs (Release) into build/bin, and rebuilds only what changed. HRP_BUILD_DIR sets another folder.
# Installs missing packages first.
#
#   --tests   also the tests and benchmarks
#   --run     only what a run needs: the servers and the tools that join a run; no viewer, MuJoCo server, diagnosis
#   TARGET    only these targets; with --run, these targets and the programs of --run
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

tests=false
run=false
targets=()
for argument in "$@"; do
  case "$argument" in
    --tests) tests=true ;;
    --run) run=true ;;
    -h | --help) print_help; exit 0 ;;
    -*) refuse "unknown argument '$argument'; --help lists the known ones" ;;
    *) targets+=("$argument") ;;
  esac
done

is_configured() { [ -f "$BUILD/build.ninja" ]; }
# Words of CMakeCache.txt: is_on BUILD_TESTING.
is_on() { grep -qs "^$1:BOOL=ON" "$BUILD/CMakeCache.txt"; }
know_targets() {
  local known target
  known="$(ninja -C "$BUILD" -t targets all | sed -n 's/: phony$//p; s/: CXX_EXECUTABLE_LINKER.*//p')"
  for target in "$@"; do grep -qxF "$target" <<< "$known" || return 1; done
}

# A folder that has once been configured with more (all programs, tests) stays so: switching back would gain nothing.
if $tests; then
  "$ROOT/scripts/install_deps.sh" --tests
  { is_configured && is_on BUILD_TESTING && ! is_on HRP_RUN_ONLY; } || configure -DBUILD_TESTING=ON -DHRP_RUN_ONLY=OFF
elif $run && [ ${#targets[@]} -eq 0 ] || { is_configured && is_on HRP_RUN_ONLY && [ ${#targets[@]} -gt 0 ] && know_targets "${targets[@]}"; }; then
  "$ROOT/scripts/install_deps.sh" --run
  is_configured || configure -DBUILD_TESTING=OFF -DHRP_RUN_ONLY=ON
else
  "$ROOT/scripts/install_deps.sh"
  { is_configured && ! is_on HRP_RUN_ONLY; } || configure -DHRP_RUN_ONLY=OFF
fi
$run && targets+=(hrp_run_programs)
if [ ${#targets[@]} -eq 0 ] && ! $tests; then
  targets=(hrp_programs)
fi
run_ninja "${targets[@]}"
