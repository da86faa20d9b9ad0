#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/nightly.sh [--only STEP,...] [--minutes N] [--tries N] [--steps N] [--seed N] [--limit N] [--out DIR]
#                    [--resume]
#
# Runs the checks that take too long for the tests, and prints a table of tries, failures and seconds. Status 1 if a
# step found a fault, could not run or did not end.
#
#   fuzz        every reader gets mutated bytes                          scripts/fuzz.sh
#   kills       servers and launchers die, stop, or get junk             scripts/attack.sh kill stop launcher together junk
#   faults      disks, memory and clocks fail                            scripts/attack.sh with its other kinds
#   soak        a long run: memory, threads, files                       scripts/soak.sh
#   sanitize    unit tests, sanitizers address and undefined             scripts/sanitize.sh address,undefined
#   threads     tests of code with threads, thread sanitizer             scripts/sanitize.sh thread
#   tidy        static analysis                                          scripts/tidy.sh --all
#   long        tests that take long                                     scripts/test.sh -C nightly -L nightly
#   mutations   broken equations must fail their tests                   scripts/mutate_equations.py
#
#   --only STEP,...  only these steps, in the order above
#   --minutes N      of fuzzing, all targets together; default 10
#   --tries N        of each attack, default 100
#   --steps N        of the soak, default 1000000
#   --seed N         of fuzz, kills and faults; default the date, so each night has other inputs
#   --limit N        time limit of a step in minutes, default 240
#   --out DIR        folder for logs and results.json, default out/nightly
#   --resume         skips the steps that passed in DIR
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
export HRP_BUILD_DIR="$BUILD"
exec python3 "$ROOT/scripts/robustness/nightly.py" "$@"
