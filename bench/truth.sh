#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Holds phymul against measurements and closed forms: builds, measures, writes docs/measurements/truth.md, credibility.md.
#   sh bench/truth.sh [--quick] [--out DIR] [--draw-only] [--cases a,b,...]
# Default DIR: out/truth. --quick takes the coarsest body of each case and writes no page; nor does --cases.
# --draw-only writes pages and pictures again from DIR. Times do not matter: the machine may be busy.
set -eu
cd "$(dirname "$0")/.."

out=out/truth draw_only="" quick=0 cases=""
while [ $# -gt 0 ]; do
  case $1 in
    --quick) quick=1 ;;
    --draw-only) draw_only=yes ;;
    --out) out=$2; shift ;;
    --cases) cases=$2; shift ;;
    --help | -h)
      sed -n "4,7s/^# *//p" bench/truth.sh
      exit 0
      ;;
    *)
      echo "truth.sh: unknown argument \"$1\"; see its first lines" >&2
      exit 2
      ;;
  esac
  shift
done

sh cmake/install-packages.sh bench charts
. cmake/generator.sh
python=python3
"$python" -c "import matplotlib" 2>/dev/null || python=/usr/bin/python3  # Debian's, where another one comes first

mkdir -p "$out"
if [ -z "$draw_only" ]; then
  cmake -S . -B build/charts -DCMAKE_BUILD_TYPE=Release -DPHYMUL_BUILD_TESTS=OFF -DPHYMUL_BUILD_EXAMPLES=OFF >"$out/build.log"
  cmake --build build/charts --parallel "$(nproc)" --target truth >>"$out/build.log"
  build/charts/bench/truth --quick "$quick" --cases "$cases" --out "$out"
fi
if [ "$quick" = 0 ] && [ -z "$cases" ]; then
  "$python" bench/charts/draw_truth.py "$out" docs/charts docs/measurements/truth.md
  "$python" bench/charts/write_credibility.py "$out" docs/measurements/claims.md docs/measurements/credibility.md
fi
echo "truth.csv and truth_curves.csv are in $out"
