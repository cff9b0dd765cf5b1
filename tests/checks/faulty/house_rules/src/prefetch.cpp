// SPDX-License-Identifier: MIT
void f(int* p) { __builtin_prefetch(p); }
