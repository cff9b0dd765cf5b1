#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Makes the CSV file and charts of docs/measurements/speed.md: builds, measures, draws.
#   sh bench/sweep.sh [--quick] [--out DIR] [--draw-only] [--sizes a,b] [--variants a,b] [--backends a,b] [--cap SECONDS]
# Default DIR: out/sweep. --quick takes bodies of up to 512 particles and under a minute once it is built; --draw-only
# redraws what is in DIR. Measure on a quiet machine.
set -eu
cd "$(dirname "$0")/.."

out=out/sweep draw_only="" arguments=""
while [ $# -gt 0 ]; do
  case $1 in
    --quick) arguments="$arguments --quick 1" ;;
    --draw-only) draw_only=yes ;;
    --out) out=$2; shift ;;
    --sizes | --variants | --backends | --cap) arguments="$arguments $1 $2"; shift ;;
    --help | -h)
      sed -n "4,7s/^# *//p" bench/sweep.sh
      exit 0
      ;;
    *)
      echo "sweep.sh: unknown argument \"$1\"; see its first lines" >&2
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
  cmake --build build/charts --parallel "$(nproc)" --target sweep >>"$out/build.log"
  # $arguments is a list of words.
  build/charts/bench/sweep --out "$out/sweep.csv" $arguments
fi
"$python" bench/charts/draw_sweep.py "$out/sweep.csv" "$out"
echo "charts and sweep.csv are in $out"
