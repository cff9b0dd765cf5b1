#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Builds the library and phymul_test with GCC's counters, runs the small set of phymul_test, and says how many of the
# lines and branches of each room of src/ it reached. Files one by one: build/coverage/files.csv.
#   sh cmake/coverage.sh [ctest's options, for instance -R Joint]
set -eu
cd "$(dirname "$0")/.."
sh cmake/install-packages.sh tests surfaces labels coverage
. cmake/generator.sh
cmake --preset coverage
cmake --build --preset coverage --parallel "$(nproc)"
find build/coverage -name '*.gcda' -delete  # counts of the run before
status=0
ctest --preset coverage --output-on-failure --parallel 2 "$@" || status=$?

# Branches that exceptions take out of nearly every line are left out.
gcovr --root . --object-directory build/coverage --filter src/ --filter include/ --exclude-throw-branches \
  --csv build/coverage/files.csv
awk -F, '
  NR > 1 {
    split($1, part, "/")
    room = part[1] == "src" ? part[1] "/" part[2] : part[1]
    lines[room] += $2; taken[room] += $3; branches[room] += $5; gone[room] += $6
    lines["all"] += $2; taken["all"] += $3; branches["all"] += $5; gone["all"] += $6
  }
  function share(of, whole) { return whole > 0 ? 100 * of / whole : 100 }
  END {
    print "room              lines  reached  branches  taken"
    for (room in lines)
      printf "%-16s %6d  %6.1f%%  %8d  %5.1f%%\n", room, lines[room], share(taken[room], lines[room]),
             branches[room], share(gone[room], branches[room]) | "sort"
  }' build/coverage/files.csv
exit "$status"
