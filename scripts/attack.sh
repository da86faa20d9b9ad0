#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/attack.sh [KIND ...] [--tries N] [--seed S] [--patience S] [--out FILE.csv]
#
# Attacks runs of the server set at random moments, on both DDS vendors and their mixes, and prints a table. A try fails
# when the run hangs, ends without its cause, leaves a process behind, or loses steps of the log that it should have.
#
#   kill       a server dies (SIGKILL)
#   stop       a server stands still for up to half a second; the run must end with the bits of an undisturbed one
#   launcher   the launcher dies; its servers must follow
#   together   three runs at the same time: each has the bits of an undisturbed one
#   junk       somebody writes changed and random bytes to topics of the run
#   disk       the log may not grow beyond a random size
#   slow       each write into the log takes up to 60 ms more: same bits, whole log
#   reads      from some read on, scenario and robot cannot be read any more
#   read_only  the log's file system is read-only
#   clock      wall clocks that jump, or that are an hour apart in the processes: same bits
#   memory     an allocation of one server fails, or all from one on
#   memory_here  the same of a run in one process
#
#   --tries N     of each kind, default 25
#   --seed S      default 1
#   --patience S  seconds that a run may take before it hangs, default 90: more on a machine that others use
#   --out FILE    a row for each try
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
[ -x "$BUILD/bin/hrp-simulate" ] || "$ROOT/scripts/build.sh" >&2
exec python3 "$ROOT/scripts/robustness/attack.py" "$BUILD/bin" "$ROOT/models/scenarios/hrp2p_stand.yaml" "$@"
