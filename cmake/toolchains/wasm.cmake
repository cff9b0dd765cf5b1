# SPDX-License-Identifier: MIT
#
# WebAssembly with vectors of 128 bits, compiled by Debian's Emscripten and tried in node. Its standard library is too
# old for C++20: cmake/toolchains/wasm_libraries.sh makes a newer one, and the other libraries.
set(phymul_emscripten /usr/share/emscripten)
set(phymul_wasm_libraries ${CMAKE_CURRENT_LIST_DIR}/../../build/wasm-libraries)
cmake_path(NORMAL_PATH phymul_wasm_libraries)

include(${phymul_emscripten}/cmake/Modules/Platform/Emscripten.cmake)
set(CMAKE_AR /usr/lib/llvm-16/bin/llvm-ar)
set(CMAKE_RANLIB /usr/lib/llvm-16/bin/llvm-ranlib)
# Exceptions of the machine itself (every browser since 2021); Emscripten's own go through JavaScript at every call.
# -msse2: Emscripten writes those functions by WebAssembly's vectors. Eigen adds numbers in the order of its vectors, and
# has none for WebAssembly itself: without them `reference` would end at other bits than elsewhere.
set(phymul_wasm_flags "--em-config ${CMAKE_CURRENT_LIST_DIR}/wasm_config.py -fwasm-exceptions -sSUPPORT_LONGJMP=0 -msimd128 -msse2 -mbulk-memory -mnontrapping-fptoint -Wno-version-check")
set(CMAKE_C_FLAGS_INIT "${phymul_wasm_flags}")
set(CMAKE_CXX_FLAGS_INIT "${phymul_wasm_flags} -nostdinc++ -isystem ${phymul_wasm_libraries}/include/c++/v1")
set(CMAKE_EXE_LINKER_FLAGS_INIT "-L${phymul_wasm_libraries}/lib -lc++16 -sALLOW_MEMORY_GROWTH=1 -sINITIAL_MEMORY=64MB -sTOTAL_STACK=4MB")
# Emscripten 3.1.6 takes a node that has fetch() for a browser.
set(CMAKE_CROSSCOMPILING_EMULATOR node --no-experimental-fetch)
list(APPEND CMAKE_FIND_ROOT_PATH ${phymul_wasm_libraries})
set(Eigen3_DIR ${phymul_wasm_libraries}/share/eigen3/cmake)
