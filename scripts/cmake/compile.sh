#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# compile.sh CCACHE TREE COMPILER ARGUMENT ...
#
# CMake calls the compiler with this script where ccache is installed. Paths below TREE are relative to it, so a clone in another
# folder finds what this one has compiled. ccache keeps nothing that was compiled with a precompiled header unless it is told to.
#
# Such a header has 100 MB, and no two runs of a compiler write the same bytes. Beside it lies a sum of what it was made from: ccache
# takes this instead. Without the sum it reads 100 MB for every source, and finds none again where a header was made anew.
ccache="$1" CCACHE_BASEDIR="$2" CCACHE_SLOPPINESS=pch_defines,time_macros CCACHE_PCH_EXTSUM=true
export CCACHE_BASEDIR CCACHE_SLOPPINESS CCACHE_PCH_EXTSUM
shift 2
header= depends= previous=
for argument in "$@"; do
  case "$previous $argument" in
    "-o "*.gch) header="$argument" ;;
    "-MF "*) depends="$argument" ;;
  esac
  previous="$argument"
done
[ -n "$header" ] || exec "$ccache" "$@"
rm -f "$header" "$header.sum"  # ccache would count the last one as an input
"$ccache" "$@" || exit
# A .d file: "target: file file \", over many lines.
{
  "$1" --version
  printf '%s\n' "$*" | sed "s#$CCACHE_BASEDIR##g"
  sed 's/^[^ :]*://; s/\\$//' "$depends" | tr ' ' '\n' | grep . | sort -u | xargs cat
} | sha256sum > "$header.sum"
