#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Builds the page of examples/browser and the trajectories for WebAssembly, runs these in node and that in headless
# Chromium. The page is then in build/wasm/examples/browser/page, what the test saw in ../screenshots.
#   sh cmake/browser.sh [ctest's options]
set -eu
cd "$(dirname "$0")/.."
sh cmake/install-packages.sh browser
. cmake/generator.sh
sh cmake/toolchains/wasm_libraries.sh
cmake --preset wasm
cmake --build --preset wasm --parallel "$(nproc)"
ctest --preset wasm --output-on-failure "$@"
