// SPDX-License-Identifier: MIT
int phymul_absent() {
  return 1;
}
