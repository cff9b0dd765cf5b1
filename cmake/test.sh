#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Builds phymul and runs its tests on a machine that has only a compiler and CMake.
#   sh cmake/test.sh [preset [ctest's options]]   what every landing must pass; presets: ci (default), dev, release, clang,
#                                                 asan-ubsan, tsan, no-gl, aarch64, windows
#   sh cmake/test.sh full                         everything: long tests, the other dialects and renderers of GL, all
#                                                 that the sanitizers can run, and a browser; takes hours
set -eu
cd "$(dirname "$0")/.."

run() {  # preset, ctest's options
  preset=$1
  shift
  case $preset in
    asan-ubsan | tsan) parts="tests" ;;
    aarch64 | windows) parts="tests $preset" ;;
    no-gl) parts="tests bench examples charts" ;;
    clang) parts="tests bench examples charts gl gl-tests surfaces labels clang" ;;
    *) parts="tests bench examples charts gl gl-tests surfaces labels mpi" ;;
  esac
  # $parts is a list of words.
  sh cmake/install-packages.sh $parts
  . cmake/generator.sh
  [ "$preset" != windows ] || sh cmake/toolchains/windows_libraries.sh
  cmake --preset "$preset"
  cmake --build --preset "$preset" --parallel "$(nproc)"
  ctest --preset "$preset" --output-on-failure --parallel 2 "$@"
}

if [ "${1:-}" = full ]; then
  failed=""
  for preset in ci asan-ubsan tsan; do
    run "$preset" || failed="$failed $preset"
    require=0
    [ "$preset" != ci ] || require=1
    PHYMUL_REQUIRE_GL=$require LP_NUM_THREADS=0 ctest --test-dir "build/$preset" --output-on-failure --parallel 2 \
      -L '^full$' --no-tests=error || failed="$failed $preset-full"
  done
  # File by file: each includes what it uses.
  { cmake --preset dev && cmake --build --preset dev --parallel "$(nproc)"; } || failed="$failed dev"
  # The page and the trajectories in WebAssembly; what else this script installs does not bring a compiler for it.
  if command -v em++ >/dev/null 2>&1 || apt-cache show emscripten >/dev/null 2>&1; then
    sh cmake/browser.sh || failed="$failed browser"
  else
    echo "NOT TESTED: WebAssembly and WebGL 2 (sh cmake/browser.sh), because there is no em++ and no package emscripten" >&2
  fi
  [ -z "$failed" ] || { echo "FAILED:$failed" >&2; exit 1; }
elif [ $# -gt 0 ]; then
  run "$@"
else
  run ci
fi
