# SPDX-License-Identifier: MIT
#
# Sourced by demo.sh and test.sh: Ninja where it is installed. A build folder made before keeps its own generator.
if [ -z "${CMAKE_GENERATOR:-}" ] && command -v ninja >/dev/null 2>&1; then
  CMAKE_GENERATOR=Ninja
  export CMAKE_GENERATOR
fi
