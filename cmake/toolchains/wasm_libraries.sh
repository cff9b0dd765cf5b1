#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Compiles for WebAssembly, into build/wasm-libraries, what the preset wasm needs: the C++ standard library of Clang 16
# (that of Emscripten 3.1.6 is of Clang 13, without ranges), pugixml, zlib and GoogleTest, all from Debian's sources (140
# MB); and copies Eigen. Does nothing where they are there. Called by cmake/browser.sh.
set -eu
cd "$(dirname "$0")/../.."
prefix=$PWD/build/wasm-libraries
toolchain=$PWD/cmake/toolchains/wasm.cmake

# Eigen, without instructions of x86 that it writes where a compiler may be GCC before 6.3, and without the header of MMX,
# of which it uses nothing.
if [ ! -e "$prefix/share/eigen3" ]; then
  mkdir -p "$prefix/include" "$prefix/share"
  rm -rf "$prefix/include/eigen3"
  cp -r /usr/include/eigen3 "$prefix/include/"
  sed -i 's/^#if EIGEN_COMP_GNUC && EIGEN_COMP_GNUC < 63$/#if 0/' \
    "$prefix/include/eigen3/Eigen/src/Core/arch/SSE/PacketMath.h"
  echo '// Empty: WebAssembly has no MMX.' >"$prefix/include/eigen3/mmintrin.h"
  cp -r /usr/share/eigen3 "$prefix/share/"
fi

if [ -e "$prefix/complete" ]; then exit 0; fi
mkdir -p "$prefix/source/lists/partial" "$prefix/include/c++"
cd "$prefix/source"

# Lists of their own, because a machine's own seldom name sources.
. /etc/os-release
echo "deb-src http://deb.debian.org/debian $VERSION_CODENAME main" >sources.list
apt() {
  apt-get -qq -o Dir::Etc::SourceList="$PWD/sources.list" -o Dir::Etc::SourceParts=/dev/null \
    -o Dir::State::Lists="$PWD/lists" -o APT::Sandbox::User="$(id -un)" "$@"
}
apt update
apt source --download-only llvm-toolchain-16 pugixml zlib
unpack() {  # folder, archive, tar's options
  rm -rf "$1"
  mkdir "$1"
  folder=$1 archive=$2
  shift 2
  tar -xf "$archive" -C "$folder" --strip-components=1 "$@"
}
unpack llvm llvm-toolchain-16_*.orig.tar.* --wildcards '*/libcxx/include' '*/libcxx/src'
unpack pugixml pugixml_*.orig.tar.*
unpack zlib zlib_*.orig.tar.*

build() {  # source folder, options of CMake
  source=$1
  shift
  cmake -S "$source" -B "build-$(basename "$source")" -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX="$prefix" \
    -DCMAKE_TOOLCHAIN_FILE="$toolchain" "$@"
  cmake --build "build-$(basename "$source")" --target install --parallel "$(nproc)"
}

# Headers first, as everything else includes them. Names of its own (__16), beside which Emscripten's may be linked;
# exceptions and new come from Emscripten's libc++abi.
rm -rf "$prefix/include/c++/v1"
cp -r llvm/libcxx/include "$prefix/include/c++/v1"
cp /usr/share/emscripten/system/lib/libcxxabi/include/*.h "$prefix/include/c++/v1/"
cat >"$prefix/include/c++/v1/__config_site" <<'END'
#pragma once
#define _LIBCPP_ABI_VERSION 1
#define _LIBCPP_ABI_NAMESPACE __16
#define _LIBCPP_HAS_MUSL_LIBC
#define _LIBCPP_HAS_THREAD_API_PTHREAD
#define _LIBCPP_HAS_NO_VENDOR_AVAILABILITY_ANNOTATIONS
#define _LIBCPP_ENABLE_ASSERTIONS_DEFAULT 0
#define _LIBCPP_DISABLE_VISIBILITY_ANNOTATIONS
END
mkdir -p libcxx
cat >libcxx/CMakeLists.txt <<'END'
cmake_minimum_required(VERSION 3.25)
project(libcxx LANGUAGES CXX)
file(GLOB_RECURSE sources ${SOURCE}/src/*.cpp)
list(FILTER sources EXCLUDE REGEX "/(support/|experimental/|legacy_|strstream)")
add_library(c++16 STATIC ${sources})
target_compile_features(c++16 PRIVATE cxx_std_20)
target_include_directories(c++16 PRIVATE ${SOURCE}/src)
target_compile_definitions(c++16 PRIVATE LIBCXX_BUILDING_LIBCXXABI _LIBCPP_BUILDING_LIBRARY)
target_compile_options(c++16 PRIVATE -Os -w)
install(TARGETS c++16)
END
# The compiler is tried on a library alone: programs need this one.
build libcxx -DSOURCE="$PWD/llvm/libcxx" -DCMAKE_TRY_COMPILE_TARGET_TYPE=STATIC_LIBRARY

mkdir -p z
cat >z/CMakeLists.txt <<'END'
cmake_minimum_required(VERSION 3.25)
project(z LANGUAGES C)
file(GLOB sources ${SOURCE}/*.c)
add_library(z STATIC ${sources})
target_compile_definitions(z PRIVATE HAVE_UNISTD_H)
target_compile_options(z PRIVATE -w)
install(TARGETS z)
install(FILES ${SOURCE}/zlib.h ${SOURCE}/zconf.h TYPE INCLUDE)
END
build z -DSOURCE="$PWD/zlib"
build "$PWD/pugixml"
build /usr/src/googletest -DBUILD_GMOCK=OFF
touch "$prefix/complete"
