#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Runs clang-tidy over the library, tests, benches and examples; fails if it has something to say. Many files go
# in one unit, so that their headers are read once.
#   sh cmake/tidy.sh     results in build/tidy/said.txt
set -eu
cd "$(dirname "$0")/.."
sh cmake/install-packages.sh tests bench examples charts gl gl-tests surfaces labels clang tidy
. cmake/generator.sh
cmake --preset clang -B build/tidy -DPHYMUL_UNITY=ON -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON
status=0
# Such a unit includes .cpp files.
run-clang-tidy-16 -quiet -j "$(nproc)" -p build/tidy -checks=-bugprone-suspicious-include \
  "^$PWD/(src|tests|bench|examples|bindings)/.*\.cpp\$" 'Unity/.*\.cxx$' \
  >build/tidy/said.txt 2>build/tidy/errors.txt || status=$?
# What is said of other libraries' headers is theirs.
if grep -E "^$PWD/(include|src|tests|bench|examples|bindings)/.*: (warning|error):" build/tidy/said.txt | sort -u; then
  exit 1
fi
[ "$status" -eq 0 ] || tail -n 20 build/tidy/errors.txt >&2
exit "$status"
