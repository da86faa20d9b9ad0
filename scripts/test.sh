#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/test.sh [ctest options]
#
# Installs what is missing, builds everything and runs all tests. Examples of options:
#   -L unit          one kind only: unit, physics, conformance, process, npm, browser
#   -R mcap          tests whose name contains mcap
#   -C nightly       also those that take long (-L nightly: only those)
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
case "${1:-}" in -h | --help) print_help; exit 0 ;; esac

"$ROOT/scripts/install_deps.sh" --tests
# A warning of the compiler fails the tests as well.
grep -qs "^HRP_WARNINGS_ARE_ERRORS:BOOL=ON" "$BUILD/CMakeCache.txt" || configure -DBUILD_TESTING=ON -DHRP_RUN_ONLY=OFF -DHRP_WARNINGS_ARE_ERRORS=ON
# The packages of npm are fetched while the compilers run: most of that time is the network's. They are a group of processes
# of their own, which ends with a build that fails.
set -m
{ "$ROOT/tests/npm/install.sh" && "$ROOT/tests/browser/install.sh" && "$ROOT/scripts/build_page.sh"; } &
page=$!
set +m
trap 'kill -- "-$page" 2> /dev/null' EXIT
"$ROOT/scripts/build.sh" --tests
wait "$page"
trap - EXIT
cd "$BUILD"
# One more than there are cores: many tests wait for processes most of the time.
exec ctest --output-on-failure -j "$(($(nproc) + 1))" "$@"
