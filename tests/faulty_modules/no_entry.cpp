// SPDX-License-Identifier: MIT
//
// A shared library that is no GL module.
extern "C" int something_else() {
  return 1;
}
