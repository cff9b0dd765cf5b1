#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Compiles for Windows what Debian has in source alone, pugixml and GoogleTest, into build/windows-libraries; does
# nothing where they are there. Called by cmake/test.sh windows.
set -eu
cd "$(dirname "$0")/../.."
prefix=$PWD/build/windows-libraries
if [ -e "$prefix/complete" ]; then exit 0; fi
mkdir -p "$prefix/source/lists/partial"
cd "$prefix/source"

# Lists of their own, because a machine's own seldom name sources.
. /etc/os-release
echo "deb-src http://deb.debian.org/debian $VERSION_CODENAME main" >sources.list
apt() {
  apt-get -qq -o Dir::Etc::SourceList="$PWD/sources.list" -o Dir::Etc::SourceParts=/dev/null \
    -o Dir::State::Lists="$PWD/lists" -o APT::Sandbox::User="$(id -un)" "$@"
}
apt update
apt source --download-only pugixml
rm -rf pugixml
mkdir pugixml
tar -xf pugixml_*.orig.tar.* -C pugixml --strip-components=1

for source in "$PWD/pugixml" /usr/src/googletest; do
  build=build-$(basename "$source")
  cmake -S "$source" -B "$build" -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX="$prefix" -DBUILD_GMOCK=OFF \
    -DCMAKE_TOOLCHAIN_FILE="$prefix/../../cmake/toolchains/windows.cmake"
  cmake --build "$build" --target install
done
touch "$prefix/complete"
