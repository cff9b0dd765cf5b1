#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Draws the pictures of docs/guide/pictures.md and the README anew.
#   sh cmake/pictures.sh
set -eu
cd "$(dirname "$0")/.."

sh cmake/install-packages.sh examples
. cmake/generator.sh

cmake -S . -B build/pictures -DCMAKE_BUILD_TYPE=Release -DPHYMUL_BUILD_TESTS=OFF -DPHYMUL_BUILD_BENCH=OFF -DPHYMUL_WITH_GL=OFF
cmake --build build/pictures --parallel "$(nproc)"
build/pictures/examples/phymul-pictures docs/pictures
out=$(mktemp -d)
trap 'rm -r "$out"' EXIT
# Exit code 3: it was told to end before the body rests.
build/pictures/examples/phymul-run examples/data/cylinder_275.pml examples/data/cylinder_275_pull.lml --out "$out" \
  --frame-interval 0 --max-time 1.01 || [ $? -eq 3 ]
cp "$out/pulled.png" docs/pulled_cylinder.png
