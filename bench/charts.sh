#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Makes every chart and table of docs/measurements/charts.md, peers.md and stability.md: builds, measures, draws.
#   sh bench/charts.sh [--quick] [--out DIR] [--draw-only] [--methods a,b,...] [--backends a,b,...] [--wall-cap SECONDS]
# Default DIR: out/charts. --quick takes coarse bodies only and under 3 minutes; --draw-only redraws what is in DIR.
# Measure on a quiet machine: times are wall times.
set -eu
cd "$(dirname "$0")/.."

out=out/charts quick="" draw_only="" methods="" backends="" wall_cap=""
while [ $# -gt 0 ]; do
  case $1 in
    --quick) quick=yes ;;
    --draw-only) draw_only=yes ;;
    --out) out=$2; shift ;;
    --methods) methods=$2; shift ;;
    --backends) backends=$2; shift ;;
    --wall-cap) wall_cap=$2; shift ;;
    --help | -h)
      sed -n "4,7s/^# *//p" bench/charts.sh
      exit 0
      ;;
    *)
      echo "charts.sh: unknown argument \"$1\"; see its first lines" >&2
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
  cmake --build build/charts --parallel "$(nproc)" --target work_precision peer_cube trajectory_error stability_atlas >>"$out/build.log"
  if [ -n "$quick" ]; then
    precision="--most-particles 450 --most-particles-in-reference 200 --most-resolutions 3 --steps 0.5 --wall-cap ${wall_cap:-4}"
    peer="--reference-steps 1000 --slow-steps 200 --steps 70,100,200,1000 --bullet-steps 10,50 --repeats 2"
    trajectory="--finest 16 --most-steps 1024"
    atlas="--cells 2 --steps 2000 --most-particles 40"
    peer_caps=4 peer_particles=450
  else
    precision="--most-particles 4096 --most-particles-in-reference 800 --steps 0.9,0.5 --wall-cap ${wall_cap:-10}"
    peer=""
    trajectory=""
    atlas=""
    peer_caps="20 4 4" peer_particles=40000  # rounds: the first comes to rest, the others only time the steps
  fi
  bin=build/charts/bench
  # $precision and the like are lists of words.
  $bin/work_precision $precision --methods "$methods" --backends "$backends" --out "$out/work_precision.csv" \
    --samples "$out/samples.csv"
  $bin/peer_cube $peer --backends "$backends" --out "$out/soft_cube.csv"
  $bin/trajectory_error $trajectory --backends "$backends" --order "$out/order_in_time.csv" \
    --equivalence "$out/equivalence.csv"
  peer_cases=bench/reference/peers round=0
  [ ! -e bench/reference/bean_10000.vtu ] || peer_cases=$peer_cases,bench/reference/fine/bean_fine.case
  rm -f "$out"/peers_*.csv
  for cap in $peer_caps; do
    round=$((round + 1))
    $bin/work_precision --cases $peer_cases --methods particle_averaged --backends cpu --threads 1 \
      --rest steps --most-particles $peer_particles --wall-cap "$cap" --out "$out/peers_$round.csv"
  done
  $bin/stability_atlas $atlas --limits "$out/stability_limits.csv" --recovery "$out/stability_recovery.csv" \
    --rates "$out/stability_rates.csv"
fi
"$python" bench/charts/draw.py "$out"
"$python" bench/charts/draw_stability.py "$out"
"$python" bench/charts/draw_peers.py "$out"
echo "charts, tables and CSV files are in $out"
