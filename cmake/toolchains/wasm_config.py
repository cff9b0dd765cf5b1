# SPDX-License-Identifier: MIT
#
# Configuration of Emscripten, given to it by --em-config: Debian's Emscripten 3.1.6, with Clang 16 in the place of its
# own Clang 14, which lacks parts of C++20.
import os

EMSCRIPTEN_ROOT = '/usr/share/emscripten'
LLVM_ROOT = '/usr/lib/llvm-16/bin'
BINARYEN_ROOT = '/usr'
NODE_JS = 'node'
# Where Debian has the module acorn, which a node of other origin does not find.
os.environ.setdefault('NODE_PATH', '/usr/share/nodejs')
JS_ENGINES = [NODE_JS]
CACHE = '/usr/share/emscripten/cache'
FROZEN_CACHE = True
