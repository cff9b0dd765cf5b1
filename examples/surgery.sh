#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Makes every picture and force curve of docs/measurements/surgery.md: builds, runs the examples with tools, draws the curves.
#   sh examples/surgery.sh [--out DIR] [--docs]
# Default DIR: out/surgery. --docs copies pictures and curves to docs/pictures besides.
set -eu
cd "$(dirname "$0")/.."

out=out/surgery docs=""
while [ $# -gt 0 ]; do
  case $1 in
    --out)
      if [ $# -lt 2 ]; then
        echo "surgery.sh: --out needs a folder" >&2
        exit 2
      fi
      out=$2
      shift
      ;;
    --docs) docs=yes ;;
    --help | -h)
      sed -n "4,6s/^# *//p" examples/surgery.sh
      exit 0
      ;;
    *)
      echo "surgery.sh: unknown argument \"$1\"; see its first lines" >&2
      exit 2
      ;;
  esac
  shift
done

sh cmake/install-packages.sh examples charts
. cmake/generator.sh
python=python3
"$python" -c "import matplotlib" 2>/dev/null || python=/usr/bin/python3  # Debian's, where another one comes first

mkdir -p "$out"
cmake -S . -B build/surgery -DCMAKE_BUILD_TYPE=Release -DPHYMUL_BUILD_TESTS=OFF -DPHYMUL_BUILD_BENCH=OFF \
  -DPHYMUL_WITH_GL=OFF >"$out/build.log"
examples="needle liver probe_on_prostate two_organs cloth_on_sphere resection gallbladder"
# $examples is a list of words.
cmake --build build/surgery --parallel "$(nproc)" --target $examples >>"$out/build.log"
for example in $examples; do
  build/surgery/examples/$example --out "$out"
done
"$python" bench/charts/draw_forces.py "$out"
if [ -n "$docs" ]; then
  cp "$out"/*.png docs/pictures/
fi
echo "pictures, curves and CSV files are in $out"
