#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# compile.sh TREE COMPILER ARGUMENT ...
#
# CMake calls the compiler with this script where ccache is installed. Paths below TREE are relative to it, so a clone in another
# folder finds what this one has compiled. ccache keeps nothing that was compiled with a precompiled header unless it is told to.
# Such a header has 100 MB, and ccache would read all of it for every source (half a second): it takes the sum beside it instead.
CCACHE_BASEDIR="$1" CCACHE_SLOPPINESS=pch_defines,time_macros CCACHE_PCH_EXTSUM=true
export CCACHE_BASEDIR CCACHE_SLOPPINESS CCACHE_PCH_EXTSUM
shift
ccache "$@" || exit
previous=
for argument in "$@"; do
  case "$previous $argument" in
    "-o "*.gch) sha256sum < "$argument" > "$argument.sum" ;;
  esac
  previous="$argument"
done
