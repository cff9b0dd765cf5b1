#!/bin/sh
# SPDX-License-Identifier: MIT
#
# kill_test.sh PROGRAM STUDY FOLDER [mpirun and its options...]: kills a study with SIGKILL in its middle,
# starts it again, and compares its tables with those of a study that nothing happened to. With mpirun, it does so twice:
# rank 1 dies first, then rank 0. The other is killed right after it, because mpirun ends it only a second later, by when
# it may have finished a study as small as this one.
set -eu
program=$1 study=$2 out=$3
shift 3
rm -rf "$out"
mkdir -p "$out"

fail() {
  echo "kill_test.sh: $*" >&2
  exit 1
}

lines() {
  if [ -e "$1" ]; then wc -l < "$1"; else echo 0; fi
}

# The process of this rank among the children of mpirun; without mpirun, the program itself.
process_of() {  # first process, rank
  if [ "$launched" = no ]; then
    echo "$1"
    return
  fi
  for child in $(cat "/proc/$1/task/$1/children"); do
    if tr '\0' '\n' < "/proc/$child/environ" | grep -q "^OMPI_COMM_WORLD_RANK=$2\$"; then echo "$child"; fi
  done
}

launched=no
[ $# -eq 0 ] || launched=yes
"$@" "$program" "$study" --threads 1 --out "$out/whole" --quiet > "$out/whole.txt"
all=$(($(lines "$out/whole/results.txt") - 1))
[ "$all" -ge 20 ] || fail "expected a study of at least 20 scenes, got $all"

ranks="1 0"
[ "$launched" = yes ] || ranks=0

# Runs and kills the study once for each rank. False: the study was over before the kill.
kill_ranks() {
  rm -rf "$out/killed"
  before=0
  for rank in $ranks; do
    "$@" "$program" "$study" --threads 1 --out "$out/killed" --quiet > "$out/killed.txt" 2>&1 &
    first=$!
    tries=0
    while [ "$(lines "$out/killed/results.txt")" -le $((before + 20)) ]; do
      tries=$((tries + 1))
      if [ -e "$out/killed/scenes.csv" ]; then  # fewer than 20 were left
        wait "$first"
        return 1
      fi
      [ "$tries" -lt 3000 ] || fail "no results within 60 s: $(cat "$out/killed.txt")"
      sleep 0.02
    done
    victims=$(for one in $rank $ranks; do process_of "$first" "$one" 2> /dev/null || true; done)
    for victim in $victims; do kill -9 "$victim" 2> /dev/null || true; done
    if wait "$first" || [ -e "$out/killed/scenes.csv" ]; then return 1; fi
    before=$(($(lines "$out/killed/results.txt") - 1))
    echo "killed, rank $rank first, after $before of $all scenes"
  done
}

attempts=1
until kill_ranks "$@"; do
  attempts=$((attempts + 1))
  [ "$attempts" -le 5 ] || fail "the study was over before it was killed, five times"
done

"$@" "$program" "$study" --threads 1 --out "$out/killed" > "$out/again.txt" 2>&1 || fail "$(cat "$out/again.txt")"
grep -q "^$before of $all scenes were done before" "$out/again.txt" || fail "done again: $(cat "$out/again.txt")"
for table in scenes.csv targets.csv; do
  cmp "$out/whole/$table" "$out/killed/$table" || fail "$table differs"
done
[ "$(lines "$out/killed/results.txt")" -eq $((all + 1)) ] || fail "a scene was solved twice"
echo "the same tables, bit for bit"
