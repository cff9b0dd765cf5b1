#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Installs what is missing on a Debian machine to build phymul; does nothing, and needs no rights, where nothing is.
#   sh cmake/install-packages.sh [examples] [tests] [bench] [charts] [gl] [surfaces] [labels] [gl-tests] [mpi] [clang]
#                                 [fuzz] [tidy] [coverage] [aarch64] [windows] [site] [browser]
# The library's own needs are always among them. A compiler and CMake are taken as there.
set -eu

missing=""
foreign=""
need_pkg_config=""
need_package() {  # package, or package:architecture
  case $1 in
    *:*) of=${1#*:} ;;
    *) of=$(dpkg --print-architecture) ;;  # that of another one is no use
  esac
  dpkg-query -W -f='${Architecture} ${db:Status-Status}\n' "$1" 2>/dev/null | grep -qE "^(all|$of) installed\$" ||
    missing="$missing $1"
}
need_command() {  # command, package that has it
  command -v "$1" >/dev/null 2>&1 || missing="$missing $2"
}

if ! command -v dpkg-query >/dev/null 2>&1; then
  echo "phymul: this is no Debian machine, so nothing was installed; CMake will name what it misses" >&2
  exit 0
fi

command -v make >/dev/null 2>&1 || need_command ninja ninja-build
for package in libeigen3-dev libpugixml-dev zlib1g-dev; do
  need_package $package
done
for part in "$@"; do
  case $part in
    examples)
      need_package libcli11-dev
      need_package libcairo2-dev
      need_package libmuparser-dev
      need_pkg_config=yes
      ;;
    tests)
      need_package libgtest-dev
      need_command abidiff abigail-tools
      need_pkg_config=yes
      ;;
    bench)
      need_package libbenchmark-dev
      need_package libmuparser-dev
      ;;
    charts)  # drawing, and a peer to measure beside
      need_package python3-matplotlib
      need_package libbullet-dev
      need_pkg_config=yes
      ;;
    gl)  # headers, the viewer's window, and Mesa's drivers: a software renderer where there is no GPU
      need_package libglew-dev
      need_package libegl-dev
      need_package libopengl-dev
      need_package libglfw3-dev
      need_package libegl1
      need_package libegl-mesa0
      need_package libgl1-mesa-dri
      ;;
    surfaces) need_package libassimp-dev ;;
    labels)  # NIfTI and NRRD
      need_package libnifti-dev
      need_package libteem-dev
      ;;
    gl-tests)  # a host on an X server
      need_package libgl-dev
      need_package libx11-dev
      need_package xvfb
      ;;
    mpi)  # studies on several machines
      need_package libopenmpi-dev
      need_package openmpi-bin
      ;;
    clang) need_command clang++-16 clang-16 ;;
    tidy) need_command clang-tidy-16 clang-tidy-16 ;;
    fuzz)
      need_command clang++-16 clang-16
      need_package libclang-rt-16-dev
      ;;
    coverage) need_command gcovr gcovr ;;
    aarch64)  # a cross compiler, libraries of that architecture, and QEMU
      need_command aarch64-linux-gnu-g++ g++-aarch64-linux-gnu
      need_command qemu-aarch64-static qemu-user-static
      for package in libpugixml-dev zlib1g-dev libgtest-dev; do
        need_package $package:arm64
      done
      foreign=arm64
      ;;
    windows)  # a cross compiler, what it finds of libraries, the source of another, and Wine
      need_command x86_64-w64-mingw32-g++-posix g++-mingw-w64-x86-64-posix
      need_package libz-mingw-w64-dev
      need_package googletest
      need_package wine64
      ;;
    browser)  # a compiler for WebAssembly, whose own Clang is too old, the sources of its libraries, and a browser
      need_package emscripten
      need_package clang-16
      need_package lld-16
      need_package llvm-16
      need_package googletest
      need_command xz xz-utils
      need_command bzip2 bzip2
      need_command node nodejs
      need_package chromium
      ;;
    site)  # pages, and the interface
      need_package mkdocs
      need_package mkdocs-material
      need_package doxygen
      ;;
    *)
      echo "phymul: unknown part \"$part\"; there are: examples tests bench charts gl surfaces labels gl-tests mpi clang" \
        "fuzz tidy coverage aarch64 windows site browser" >&2
      exit 2
      ;;
  esac
done

[ -z "$need_pkg_config" ] || need_command pkg-config pkg-config

[ -n "$missing" ] || exit 0

as_root=""
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null 2>&1; then
    echo "phymul: packages are missing and this user may not install them; as root: apt-get install$missing" >&2
    exit 1
  fi
  as_root=sudo
fi

echo "phymul: installing$missing"
[ -z "$foreign" ] || $as_root dpkg --add-architecture "$foreign"
$as_root apt-get update -qq
# $missing is a list of words; env, because sudo drops variables; Use-Pty, because a container may have no terminals.
$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends -o Dpkg::Use-Pty=0 $missing
