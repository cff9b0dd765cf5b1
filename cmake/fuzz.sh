#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Builds the fuzz targets (tests/fuzz) and runs each from its corpus and the samples of its format in tests/data; fails
# if one finds something. What made it fail is in build/fuzz/found: mend the library, and add the file to
# tests/fuzz/corpus/<target>.
#   sh cmake/fuzz.sh [seconds for each target, 60 [targets, all]]
set -eu
cd "$(dirname "$0")/.."
seconds=${1:-60}
[ $# -eq 0 ] || shift
sh cmake/install-packages.sh tests surfaces labels fuzz
. cmake/generator.sh
cmake --preset fuzz
cmake --build --preset fuzz --parallel "$(nproc)"
[ $# -gt 0 ] || set -- $(sed -n 's/^foreach(name \(.*\))$/\1/p' tests/fuzz/CMakeLists.txt)
mkdir -p build/fuzz/found

# teem leaks what it has read of a header that it refuses.
export LSAN_OPTIONS="suppressions=$PWD/cmake/leaks-elsewhere.supp:print_suppressions=0"
failed=""
for target in "$@"; do
  corpus="build/fuzz/corpus/$target"  # with what libFuzzer adds; kept for the next run
  mkdir -p "$corpus"
  case $target in gmsh) ending=msh ;; *) ending=$target ;; esac
  find tests/data -name "*.$ending" -exec cp {} "$corpus" \;
  [ ! -d "tests/fuzz/corpus/$target" ] || cp "tests/fuzz/corpus/$target"/* "$corpus"
  # Memory: a file of some kilobytes must not cost more than the process itself does.
  if ! "build/fuzz/tests/fuzz/fuzz_$target" -max_total_time="$seconds" -max_len=4096 -timeout=10 \
    -rss_limit_mb=512 -malloc_limit_mb=128 -print_final_stats=1 "-artifact_prefix=build/fuzz/found/$target-" \
    "$corpus" >"build/fuzz/$target.log" 2>&1; then
    failed="$failed $target"
    tail -n 40 "build/fuzz/$target.log"
  fi
  echo "$target: $(sed -n 's/stat::number_of_executed_units: *//p' "build/fuzz/$target.log") inputs"
done
[ -z "$failed" ] || { echo "FOUND:$failed; see build/fuzz/found" >&2; exit 1; }
