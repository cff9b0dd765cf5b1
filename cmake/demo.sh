#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Builds phymul and pulls a cylinder of 275 particles, on a machine that has only a compiler and CMake.
#   sh cmake/demo.sh     results in ./out
set -eu
cd "$(dirname "$0")/.."

sh cmake/install-packages.sh examples surfaces
. cmake/generator.sh

# Less optimised, but for the kernels of the steps, which always have -O3. Of these the portable ones and those for AVX2
# are enough for so small a body. Both save time to build.
cmake -S . -B build/demo -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS_RELEASE="-O1 -DNDEBUG" \
  -DPHYMUL_X86_KERNELS=avx2 -DPHYMUL_BUILD_TESTS=OFF -DPHYMUL_BUILD_BENCH=OFF -DPHYMUL_WITH_GL=OFF
cmake --build build/demo --parallel "$(nproc)" --target phymul-run
mkdir -p out
build/demo/examples/phymul-run examples/data/cylinder_275.pml examples/data/cylinder_275_pull.lml --out out
