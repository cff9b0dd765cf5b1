// SPDX-License-Identifier: MIT
#pragma once

namespace phymul {

/// Where a continuous function that is negative at 0 and positive at 1 is zero. Halves the way until its end is exact
/// to a millionth of it, faster where the function is smooth: the secant of the two ends, one of them weighed down
/// where the other moves twice in a row (the Illinois rule).
template <class Function>
double root_between(const Function& f) {
  double a = 0.0, b = 1.0, at_a = f(a), at_b = f(b);
  int moved = 0;
  for (int turn = 0; turn < 60 && b - a > 1e-6; ++turn) {
    double middle = turn % 4 == 3 ? 0.5 * (a + b) : (a * at_b - b * at_a) / (at_b - at_a);
    if (!(middle > a && middle < b)) middle = 0.5 * (a + b);
    const double value = f(middle);
    if (value == 0.0) return middle;
    if (value < 0.0) {
      a = middle;
      at_a = value;
      if (moved == -1) at_b *= 0.5;
      moved = -1;
    } else {
      b = middle;
      at_b = value;
      if (moved == 1) at_a *= 0.5;
      moved = 1;
    }
  }
  return 0.5 * (a + b);
}

}  // namespace phymul
