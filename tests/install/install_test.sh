#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# install_test.sh BUILD: installs into a folder, moves it, runs the default scenario from there, and builds the controller
# template and a program that links the other libraries against it, away from the tree.
set -euo pipefail
build="$1"
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
work="$(mktemp -d)"
mkdir -m 700 "$work/runtime"
export XDG_RUNTIME_DIR="$work/runtime"  # my-controller joins the only run there is: not one of another test
trap 'rm -rf "$work"' EXIT
say() { echo "ok: $*"; }
fail() { echo "FAILED: $*" >&2; exit 1; }
quietly() { "$@" > "$work/log" 2>&1 || { cat "$work/log" >&2; fail "$*"; }; }

quietly cmake --install "$build" --prefix "$work/first"
mv "$work/first" "$work/moved"
root="$work/moved"
cd "$work"
quietly "$root/bin/hrp-simulate" default --duration 0.5 --no-plot --log "$work/default.mcap"
grep -q "complete up to step 500" "$work/log" || fail "the default scenario did not run to its end"
say "the installed servers run the default scenario, found by its name, from a folder that was moved"

printf 'scenario: %s\nduration: 0.2\nseeds: 2\n' "$root/share/openhrp_dds/models/scenarios/default.yaml" > "$work/sweep.yaml"
quietly "$root/bin/hrp-sweep" "$work/sweep.yaml" --out "$work/swept"
[ "$(wc -l < "$work/swept/table.csv")" -eq 3 ] || fail "the installed hrp-sweep does not give two rows"
say "the installed hrp-sweep runs a sweep"

quietly "$root/bin/hrp-log" foxglove "$work/default.mcap" --out "$work/foxglove.mcap"
[ -f "$root/share/openhrp_dds/foxglove/robot.json" ] || fail "Foxglove's layout is not installed"
grep -q "$root/share/openhrp_dds/foxglove/robot.json" "$work/log" || fail "hrp-log does not say where the layout is"
say "a log becomes a file for Foxglove, and its layout is there"

cp -r "$root/share/openhrp_dds/controller_template" "$work/mine"
quietly cmake -S "$work/mine" -B "$work/mine/build" -DCMAKE_PREFIX_PATH="$root"
quietly cmake --build "$work/mine/build"
"$root/bin/hrp-simulate" squat --duration 0.5 --no-plot --log "$work/mine.mcap" --without controller > "$work/run.log" 2>&1 &
run=$!
timeout 60 "$work/mine/build/my-controller" > "$work/mine.log" 2>&1 || { cat "$work/mine.log" "$work/run.log" >&2; fail "my-controller"; }
wait "$run" || { cat "$work/run.log" >&2; fail "the run with my-controller"; }
say "the template is a project of its own: built against the installed package, it controls a run"

quietly cmake -S "$here/consumer" -B "$work/consumer" -DCMAKE_PREFIX_PATH="$root"
quietly cmake --build "$work/consumer"
quietly "$work/consumer/consumer" "$work/default.mcap"
grep -q "hinge 0.500 kg m^2, 3 positions, log begins with time" "$work/log" || { cat "$work/log" >&2; fail "the consumer's answer"; }
say "openhrp_dds::idl, ::multibody and ::log link and work"
