#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/nightly.sh [--only STEP,...] [--minutes N] [--tries N] [--steps N] [--seed N] [--limit N] [--out DIR]
#                    [--resume]
#
# Does what is too long for the tests, one step after the other, and ends with a table of tries, failures and seconds.
# Status 1 when a step found something, could not run or did not end.
#
#   fuzz        every reader of bytes is fed with mutated ones           scripts/fuzz.sh
#   kills       servers and launchers die, stand still, hear junk        scripts/attack.sh kill stop launcher together junk
#   faults      disks, memory and clocks fail                            scripts/attack.sh with its other kinds
#   soak        a long run: memory, threads, files                       scripts/soak.sh
#   sanitize    unit tests with address and undefined                    scripts/sanitize.sh address,undefined
#   threads     tests of what has threads, with the thread sanitizer     scripts/sanitize.sh thread
#   tidy        static analysis                                          scripts/tidy.sh --all
#   mutations   broken equations must fail their tests                   scripts/mutate_equations.py
#
#   --only STEP,...  these steps only, in the order above
#   --minutes N      of fuzzing, all targets together; default 10
#   --tries N        of each attack, default 100
#   --steps N        of the soak, default 1000000
#   --seed N         of fuzz, kills and faults; default the date, so each night tries something else
#   --limit N        minutes that a step may take, default 240
#   --out DIR        for logs and results.json, default out/nightly
#   --resume         what went well in DIR is not done again
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
export HRP_BUILD_DIR="$BUILD"
exec python3 "$ROOT/scripts/robustness/nightly.py" "$@"
