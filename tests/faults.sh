#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Puts one-line faults (tests/faults.awk) into the CPU code of src and include, one at a time, and says which of them
# phymul_test notices. Some that survive change nothing that can be seen: a person judges that.
#   sh tests/faults.sh [number, 30 [seed, 1 [revision]]]   at places at random; with a revision, in lines added since
#   sh tests/faults.sh FILE.patch ...                      these faults
# It works on a copy of the last commit, in a temporary folder that it removes. What survives is kept as patches in
# build/faults. The first build takes half an hour: PHYMUL_FAULTS_FOLDER=<folder> keeps copy and build there for the
# next run.
set -eu
cd "$(dirname "$0")/.."
. cmake/generator.sh
kept=$PWD/build/faults
work=$(mktemp -d)
tree=${PHYMUL_FAULTS_FOLDER:-$work/tree}
job=""

end() {
  [ -z "$job" ] || { kill "$job" && wait "$job"; } 2>/dev/null || true
  [ -n "${PHYMUL_FAULTS_FOLDER:-}" ] || git worktree remove --force "$tree" 2>/dev/null || true
  rm -rf "$work"
}
trap end EXIT
trap 'exit 130' HUP INT TERM

run() {  # seconds, command: ends it, with its processes, after that time or where this script is ended
  timeout --kill-after=10 "$@" >"$work/log" 2>&1 &
  job=$!
  status=0
  wait "$job" || status=$?
  job=""
  return "$status"
}

build() {  # target
  run 7200 cmake --build "$tree/build" --parallel "$(nproc)" --target "$1"
}

test_with() {  # ctest's options. Loops without end and memory without end end too
  rm -f "$tree/build/Testing/Temporary/CTestCostData.txt"  # by which long suites would be first
  run 3000 sh -c 'ulimit -v 16000000 && exec "$@"' - env GTEST_FAIL_FAST=1 ctest --test-dir "$tree/build" \
    --parallel 2 --stop-on-failure --timeout 1200 --output-on-failure -LE full "$@"
}

suites_near() {  # file: suites of its room and of files named as it is, as a regular expression; or nothing
  room=$(echo "$1" | sed -n 's|^src/\([^/]*\)/.*|\1|p')
  find "$tree/tests" -name '*_test.cpp' \( -path "*/tests/${room:-no room}/*" -o -name "*$(basename "${1%.*}")*" \) \
    -exec sed -n 's/^\(TYPED_\)\{0,1\}TEST\(_F\|_P\)\{0,1\}(\([A-Za-z0-9_]*\).*/\3/p' {} + | sort -u | paste -s -d '|' -
}

failed_test() {
  sed -n -e 's/^\[  FAILED  \] \([^ ,]*\).*/\1/p' \
    -e 's/.*Test *#[0-9]*: phymul_test\.\([A-Za-z0-9_]*\) .*\*\*\*\(Timeout\|Exception[: A-Za-z]*[A-Za-z]\).*/\1 (\2)/p' \
    "$work/log" | head -n 1
}

try() {  # file, place, what: tries the fault that is in the tree, and takes it out again
  began=$(date +%s)
  near=$(suites_near "$1")
  if ! build phymul || { ! build phymul_test && grep -q 'error:' "$work/log"; }; then
    verdict="does not compile" void=$((void + 1))
  elif [ ! -x "$tree/build/tests/phymul_test" ] || { [ -n "$near" ] && ! test_with -R "^phymul_test\\.($near)\$"; } ||
    ! test_with -R '^phymul_test\.' -E "^phymul_test\\.(${near:-none})\$"; then
    verdict="killed: $(failed_test)" killed=$((killed + 1))
  else
    verdict=survived survived=$((survived + 1))
    git -C "$tree" diff >"$kept/$2.patch"
  fi
  printf '%3d  %-48s  %-26s  %s (%d s)\n' $((killed + survived + void)) "$2" "$3" "$verdict" $(($(date +%s) - began))
  git -C "$tree" checkout -q -- .
}

lines_of() {  # revision or nothing: rows "file line"; lines that were only moved since then are not new
  git -C "$tree" diff -U0 --no-color "${1:-$(git hash-object -t tree /dev/null)}" -- src include ':!src/gl' \
    ':!src/solver/gl_*' >"$work/diff"
  awk 'FNR == 1 { ++pass }
       /^(---|\+\+\+) / { file = substr($2, 3); next }
       /^@@/ { split(substr($3, 2), at, ","); line = at[1]; next }
       { text = substr($0, 2); gsub(/^ +/, "", text) }
       /^-/ && pass == 1 { gone[text] = 1 }
       /^\+/ && pass == 2 { if (!(text in gone) && file ~ /\.(h|cpp)$/) print file, line; ++line }' "$work/diff" "$work/diff"
}

if [ -e "$tree/.git" ]; then
  git -C "$tree" checkout -q --force --detach "$(git rev-parse HEAD)"
else
  git worktree add -q --detach "$tree"
fi
mkdir -p "$kept"
# File by file, without what the tests do not need.
run 3000 cmake -S "$tree" -B "$tree/build" -DCMAKE_BUILD_TYPE=Release -DPHYMUL_UNITY=OFF -DPHYMUL_WITH_GL=OFF \
  -DPHYMUL_BUILD_BENCH=OFF -DPHYMUL_BUILD_EXAMPLES=OFF -DPHYMUL_WITH_C=OFF -DPHYMUL_INSTALL=OFF &&
  build phymul_test && test_with -R '^phymul_test\.' ||
  { tail -n 30 "$work/log" >&2; echo "without a fault the tests do not pass" >&2; exit 1; }

killed=0 survived=0 void=0
case ${1:-} in
  *.patch)
    for patch in "$@"; do
      git -C "$tree" apply - <"$patch"
      try "$(git -C "$tree" diff --name-only)" "$(basename "$patch" .patch)" patch
    done ;;
  *)
    lines_of "${3:-}" >"$work/lines"
    (cd "$tree" && awk -v wanted=$((3 * ${1:-30})) -v seed="${2:-1}" -f tests/faults.awk "$work/lines") >"$work/faults"
    while IFS='	' read -r file line what text && [ $((killed + survived)) -lt "${1:-30}" ]; do
      TEXT=$text awk -v at="$line" 'NR == at { $0 = ENVIRON["TEXT"] } { print }' "$tree/$file" >"$work/faulty"
      cat "$work/faulty" >"$tree/$file"
      try "$file" "$(echo "${file#src/}" | tr / .):$line" "$what"
    done <"$work/faults" ;;
esac
echo "killed $killed of $((killed + survived)); $void did not compile; survivors are in build/faults"
