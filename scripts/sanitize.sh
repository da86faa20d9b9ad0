#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/sanitize.sh [address|undefined|thread|address,undefined|assertions|guarded ...] [--tests REGEX]
#
# Builds with sanitizers and runs tests:
#   address, undefined   tests of one process (label unit)
#   thread               tests of code with threads (bus, logger, scheduler, viewer, parallel loops)
#   assertions           no sanitizer: the own checks of the standard library and of Eigen, such as those of indices; unit tests
#   guarded              the usual build, whose blocks of memory end at a page that nobody may touch; unit tests. The library
#                        for it, guarded_memory.so of the build, can be preloaded into every program
# Without names: address and undefined in one build, then thread. Each build but that of guarded has its own folder, such as
# build-address-undefined or build-thread.
#
#   --tests REGEX   only tests whose names fit; with thread, also tests with the label conformance
#
# A finding ends its test with the place in the source. docs/robustness.md has the counts.
# scripts/robustness/thread_sanitizer.supp lists what is suppressed in the vendors' libraries, and why.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

# What has threads of its own, or is called from a vendor's.
THREADED='^(parallel_for|mcap|log_writer|logger_node|node_end|step_protocol|faulty_messages|bus_conformance|viewer)_test$'
tests="" kinds=()
while [ $# -gt 0 ]; do
  case "$1" in
    --tests) [ $# -gt 1 ] || refuse "--tests needs a regular expression"; tests="$2"; shift ;;
    address | undefined | thread | address,undefined | assertions | guarded) kinds+=("$1") ;;
    *) refuse "unknown word $1 (--help)" ;;
  esac
  shift
done
[ ${#kinds[@]} -gt 0 ] || kinds=(address,undefined thread)
export UBSAN_OPTIONS="${UBSAN_OPTIONS:-print_stacktrace=1}"
export TSAN_OPTIONS="${TSAN_OPTIONS:-second_deadlock_stack=1:suppressions=$ROOT/scripts/robustness/thread_sanitizer.supp}"
usual="$BUILD" failed=0
for kind in "${kinds[@]}"; do
  export BUILD="$ROOT/build-${kind//,/-}"
  labels=unit fitting="${tests:-.}"
  if [ "$kind" = thread ]; then labels="unit|conformance" fitting="${tests:-$THREADED}"; fi
  # What sanitizers look for does not depend on the optimiser, and -O3 takes several times as long to build.
  options=(-DHRP_SANITIZE="$kind" "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG")
  case "$kind" in
    assertions) options=("-DCMAKE_CXX_FLAGS_RELEASE=-O1 -g1 -D_GLIBCXX_ASSERTIONS") ;;
    guarded) BUILD="$usual" options=() ;;
  esac
  configure -DBUILD_TESTING=ON -DHRP_RUN_ONLY=OFF "${options[@]}"
  # Names of the tests that fit; those that are no programs of ours (Python) are built by nobody.
  mapfile -t names < <(ctest --test-dir "$BUILD" -N -L "$labels" -R "$fitting" | sed -n 's/^ *Test *#[0-9]*: //p')
  [ ${#names[@]} -gt 0 ] || refuse "no test fits $fitting"
  known="$(ninja -C "$BUILD" -t targets all | sed -n 's/: phony$//p')"
  wanted=()
  for name in "${names[@]}"; do if grep -qx -- "$name" <<< "$known"; then wanted+=("$name"); fi; done
  ninja -C "$BUILD" -j "${HRP_JOBS:-$(nproc)}" "${wanted[@]}"
  pattern="$(IFS='|'; echo "${wanted[*]}")" preloaded=()
  if [ "$kind" = guarded ]; then
    # -fno-builtin: else the compiler makes a call of calloc() from the body of calloc().
    cc -O2 -fPIC -fno-builtin -shared -o "$BUILD/guarded_memory.so" "$ROOT/scripts/robustness/guarded_memory.c"
    preloaded=(env LD_PRELOAD="$BUILD/guarded_memory.so")
  fi
  "${preloaded[@]}" ctest --test-dir "$BUILD" -R "^($pattern)\$" --output-on-failure --timeout 3600 || failed=1
done
exit $failed
