# SPDX-License-Identifier: MIT
#
# 64-bit ARM under Linux, compiled on another machine by Debian's cross compiler and tried in QEMU. Libraries are
# Debian's own of that architecture (cmake/install-packages.sh aarch64).
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static)
