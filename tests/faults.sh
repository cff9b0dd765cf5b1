#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Puts one-line faults (tests/faults.awk) into the CPU code of src and include, one at a time, and says which of them
# phymul_test notices. Some that survive change nothing that can be seen: a person judges that.
#   sh tests/faults.sh [number, 30 [seed, 1 [revision]]]   at places at random; with a revision, of lines added since
#   sh tests/faults.sh FILE.patch ...                      these faults
# It works on a copy of the last commit, in a temporary folder that it removes. What survives is kept as patches in
# build/faults. The first build takes a quarter of an hour: PHYMUL_FAULTS_FOLDER=<folder> keeps copy and build there for
# the next run.
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
  run 3000 cmake --build "$tree/build" --parallel "$(nproc)" --target "$1"
}

# ctest's options. A loop without end and memory without end end too.
test_with() {
  rm -f "$tree/build/Testing/Temporary/CTestCostData.txt"  # by which long suites would be first
  run 3000 sh -c 'ulimit -v 16000000 && exec "$@"' - env GTEST_FAIL_FAST=1 ctest --test-dir "$tree/build" \
    --parallel 2 --stop-on-failure --timeout 240 --output-on-failure -LE full "$@"
}

suites_near() {  # file: suites of its room and of files named as it is, as a regular expression; or nothing
  room=$(echo "$1" | sed -n 's|^src/\([^/]*\)/.*|\1|p')
  stem=$(basename "${1%.*}")
  find "$tree/tests" -name '*_test.cpp' \( -path "$tree/tests/${room:-no room}/*" -o -name "*${stem}*" \) \
    -exec sed -n 's/^\(TYPED_\)\{0,1\}TEST\(_F\|_P\)\{0,1\}(\([A-Za-z0-9_]*\).*/\3/p' {} + | sort -u | paste -s -d '|' -
}

failed_test() {
  sed -n -e 's/^\[  FAILED  \] \([^ ,]*\).*/\1/p' \
    -e 's/.*Test *#[0-9]*: phymul_test\.\([A-Za-z0-9_]*\) .*\*\*\*\(Timeout\|Exception[: A-Za-z]*[A-Za-z]\).*/\1 (\2)/p' \
    "$work/log" | head -n 1
}

try() {  # file that the fault is in: sets `verdict`
  near=$(suites_near "$1")
  if ! build phymul; then
    verdict="does not compile"
  elif ! build phymul_test; then
    verdict="killed: phymul_test does not start"
    ! grep -q 'error:' "$work/log" || verdict="does not compile"
  elif [ -n "$near" ] && ! test_with -R "^phymul_test\\.($near)\$"; then
    verdict="killed: $(failed_test)"
  elif ! test_with -R '^phymul_test\.' -E "^phymul_test\\.(${near:-none})\$"; then
    verdict="killed: $(failed_test)"
  else
    verdict=survived
  fi
}

one() {  # file, place, what: tries the fault that is in the tree, and takes it out again
  began=$(date +%s)
  try "$1"
  case $verdict in
    survived) survived=$((survived + 1)) && git -C "$tree" diff >"$kept/$2.patch" ;;
    killed*) killed=$((killed + 1)) ;;
    *) void=$((void + 1)) ;;
  esac
  printf '%3d  %-48s  %-26s  %s (%d s)\n' $((killed + survived + void)) "$2" "$3" "$verdict" $(($(date +%s) - began))
  git -C "$tree" checkout -q -- .
}

lines_of() {  # revision or nothing: rows "file line"
  set -- "${1:-}" src include ':!src/gl' ':!src/solver/gl_*'
  if [ -z "$1" ]; then
    shift
    git ls-files -- "$@" | grep -E '\.(h|cpp)$' | while read -r file; do awk -v file="$file" '{ print file, NR }' "$file"; done
  else
    # Lines that were only moved are not new.
    git diff -U0 --no-color "$@" >"$work/diff"
    awk 'FNR == 1 { ++pass }
         /^(---|\+\+\+) / { file = substr($2, 3); next }
         /^@@/ { split(substr($3, 2), at, ","); line = at[1]; next }
         /^[-+]/ { text = substr($0, 2); gsub(/^ +/, "", text) }
         /^-/ && pass == 1 { gone[text] = 1 }
         /^\+/ && pass == 2 { if (!(text in gone)) print file, line; ++line }' "$work/diff" "$work/diff"
  fi
}

if [ -e "$tree/.git" ]; then
  git -C "$tree" checkout -q --force --detach "$(git rev-parse HEAD)"
else
  git worktree add -q --detach "$tree"
fi
mkdir -p "$kept"
case ${1:-} in
  *.patch) ;;
  *) (cd "$tree" && lines_of "${3:-}" | grep -E '\.(h|cpp) ' |
      awk -v wanted=$((3 * ${1:-30})) -v seed="${2:-1}" -f tests/faults.awk) >"$work/faults" ;;
esac

# File by file, without what the tests do not need.
run 3000 cmake -S "$tree" -B "$tree/build" -DCMAKE_BUILD_TYPE=Release -DPHYMUL_UNITY=OFF -DPHYMUL_WITH_GL=OFF \
  -DPHYMUL_BUILD_BENCH=OFF -DPHYMUL_BUILD_EXAMPLES=OFF -DPHYMUL_WITH_C=OFF -DPHYMUL_INSTALL=OFF &&
  run 7200 cmake --build "$tree/build" --parallel "$(nproc)" --target phymul_test &&
  test_with -R '^phymul_test\.' || { tail -n 30 "$work/log" >&2; echo "without a fault the tests do not pass" >&2; exit 1; }

killed=0 survived=0 void=0
case ${1:-} in
  *.patch)
    for patch in "$@"; do
      git -C "$tree" apply - <"$patch"
      one "$(git -C "$tree" diff --name-only)" "$(basename "$patch" .patch)" "patch"
    done ;;
  *)
    while IFS='	' read -r file line what text; do
      [ $((killed + survived)) -lt "${1:-30}" ] || break
      TEXT=$text awk -v at="$line" 'NR == at { $0 = ENVIRON["TEXT"] } { print }' "$tree/$file" >"$work/faulty"
      cat "$work/faulty" >"$tree/$file"
      one "$file" "$(echo "${file#src/}" | tr / .):$line" "$what"
    done <"$work/faults" ;;
esac
echo "killed $killed of $((killed + survived)); $void did not compile"
for patch in "$kept"/*.patch; do
  [ "$survived" -eq 0 ] || [ ! -e "$patch" ] || { echo "survived, $patch:"; grep '^[-+] ' "$patch"; }
done
