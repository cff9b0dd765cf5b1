// SPDX-License-Identifier: MIT
int main() {
  int a = 1;
}
