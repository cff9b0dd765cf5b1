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

# The library's objects name their sources phymul/..., wherever they were built (CMakeLists.txt): the link leads there.
ln -sfn ../.. build/coverage/phymul
# Branches that exceptions take out of nearly every line are left out.
gcovr --root . --object-directory build/coverage --filter src/ --filter include/ --exclude-throw-branches \
  --csv build/coverage/files.csv
awk -F, '
  # Headers have two rows, of the library and of the tests: the one that reached more counts.
  NR > 1 {
    file = $1
    sub("^build/coverage/phymul/", "", file)
    if (!(file in row) || $3 * of_row[file] > reached[file] * $2) { row[file] = $0; of_row[file] = $2; reached[file] = $3 }
  }
  function share(of, whole) { return whole > 0 ? 100 * of / whole : 100 }
  END {
    for (file in row) {
      split(row[file], field, ",")
      split(file, part, "/")
      room = part[1] == "src" ? part[1] "/" part[2] : part[1]
      lines[room] += field[2]; taken[room] += field[3]; branches[room] += field[5]; gone[room] += field[6]
      lines["all"] += field[2]; taken["all"] += field[3]; branches["all"] += field[5]; gone["all"] += field[6]
    }
    print "room              lines  reached  branches  taken"
    for (room in lines)
      printf "%-16s %6d  %6.1f%%  %8d  %5.1f%%\n", room, lines[room], share(taken[room], lines[room]),
             branches[room], share(gone[room], branches[room]) | "sort"
  }' build/coverage/files.csv
exit "$status"
