#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# debian_package_test.sh BUILD: makes the Debian package, installs it in a bare Debian 12 made by mmdebstrap, runs the
# default scenario there, and builds and runs the controller template with nothing but what the package brings. Skipped,
# and said, without root, mmdebstrap or the Debian archive.
set -euo pipefail
build="$1"
skip() { echo "SKIPPED: $*" >&2; exit 77; }
fail() { echo "FAILED: $*" >&2; exit 1; }
say() { echo "ok: $*"; }
[ "$(id -u)" -eq 0 ] || skip "only root can make a clean root"
command -v mmdebstrap > /dev/null || skip "mmdebstrap is not installed"
command -v dpkg-shlibdeps > /dev/null || skip "dpkg-shlibdeps (package dpkg-dev) is not installed"

work="$(mktemp -d)"
clean() { umount -q "$work/root/proc" "$work/root/dev/shm" 2> /dev/null || true; rm -rf --one-file-system "$work"; }
trap clean EXIT
mmdebstrap --variant=minbase bookworm "$work/root" > "$work/log" 2>&1 || { tail -n 5 "$work/log" >&2; skip "the Debian archive cannot be reached"; }
(cd "$build" && cpack -G DEB -B "$work/package") > "$work/log" 2>&1 || { cat "$work/log" >&2; fail "cpack -G DEB"; }
cp "$work"/package/*.deb "$work/root/"
cp /etc/resolv.conf "$work/root/etc/"
mount -t proc proc "$work/root/proc"
mkdir -p "$work/root/dev/shm" && mount -t tmpfs tmpfs "$work/root/dev/shm"

inside() { chroot "$work/root" /bin/sh -c "$1" > "$work/log" 2>&1 || { tail -n 40 "$work/log" >&2; fail "$1"; }; }
inside "apt-get update -q -o Acquire::Check-Valid-Until=false && apt-get install -q --yes --no-install-recommends /*.deb"
inside "cd /var/tmp && hrp-simulate default --no-plot --log /var/tmp/default.mcap"
grep -q "complete up to step 12000" "$work/log" || fail "the default scenario did not run to its end"
say "the package installs on a bare Debian 12 and runs the default scenario there"
inside "apt-get install -q --yes --no-install-recommends \$(dpkg-query -W -f='\${Recommends}' openhrp-dds | tr -d ',')"
inside "cp -r /usr/share/openhrp_dds/controller_template /var/tmp/mine && cd /var/tmp/mine && cmake -S . -B build && cmake --build build"
inside "cd /var/tmp && (hrp-simulate squat --duration 1 --no-plot --log /var/tmp/mine.mcap --without controller > run.log 2>&1 &
  echo \$! > pid; timeout 60 mine/build/my-controller; tail -f --pid=\$(cat pid) /dev/null; cat run.log)"
grep -q "complete up to step 1000" "$work/log" || { cat "$work/log" >&2; fail "the run with my-controller"; }
say "the controller template builds with what the package recommends, and controls a run"
