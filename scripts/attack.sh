#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/attack.sh [KIND ...] [--tries N] [--seed S] [--patience S] [--out FILE.csv]
#
# Attacks runs of the server set at random moments, on both DDS vendors and their mixes, and prints a table. A try fails
# if the run hangs, ends without naming the cause, leaves a process behind, or loses steps that count as logged.
#
#   kill       a server dies (SIGKILL)
#   stop       a server is stopped (SIGSTOP) for up to half a second; the log must have the same bits as without
#   launcher   the launcher dies; its servers must end, too
#   together   three runs at the same time; each must have the same bits as alone
#   junk       another program writes changed and random bytes to topics of the run
#   disk       the log cannot grow beyond a random size
#   slow       each write into the log takes up to 60 ms longer; same bits, complete log
#   reads      from a random read on, scenario and robot cannot be read
#   read_only  the log's file system is read-only
#   clock      wall clocks jump, or differ by an hour between processes; same bits
#   memory     one allocation of a server fails, or all from one on
#   memory_here  the same for a run in one process
#
#   --tries N     tries of each kind, default 25
#   --seed S      of the random moments, default 1
#   --patience S  seconds after which a run counts as hanging, default 90; use more on a busy machine
#   --out FILE    CSV file with one row for each try
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
[ -x "$BUILD/bin/hrp-simulate" ] || "$ROOT/scripts/build.sh" >&2
exec python3 "$ROOT/scripts/robustness/attack.py" "$BUILD/bin" "$ROOT/models/scenarios/hrp2p_stand.yaml" "$@"
