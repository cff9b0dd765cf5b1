#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Builds phymul and runs all its tests on a machine that has only a compiler and CMake.
#   sh cmake/test.sh [preset [ctest's options]]     presets: ci (default), dev, release, asan-ubsan, tsan, no-gl
set -eu
cd "$(dirname "$0")/.."
preset=${1:-ci}
if [ $# -gt 0 ]; then
  shift
fi

if [ "$preset" = no-gl ]; then
  sh cmake/install-packages.sh tests bench examples charts
else
  sh cmake/install-packages.sh tests bench examples charts gl gl-tests
fi
. cmake/generator.sh

cmake --preset "$preset"
cmake --build --preset "$preset" --parallel "$(nproc)"
ctest --preset "$preset" --output-on-failure --parallel 2 "$@"
