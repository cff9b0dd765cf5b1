// SPDX-License-Identifier: MIT
//
// Running error analysis (Higham, Accuracy and Stability of Numerical Algorithms, sec. 3.3): a number that carries a
// bound of how far single precision, on any GPU, may be from it. The kernels are templates: run on Bounded they yield,
// beside each force, a bound of its rounding error. Rules in DESIGN.md, "The rounding bound".
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/vector3.h"

namespace phymul::test {

/// Relative error of one + - *: the last place, because GLSL leaves the direction of rounding open.
inline constexpr double unit = 0x1p-23;
/// Of 1 / x and sqrt(x) on GPUs: GLSL allows 2.5 units for a division; sqrt inherits 1 / inversesqrt.
inline constexpr double slow_unit = 5.0 * unit;

struct Bounded {
  double value = 0.0;
  double error = 0.0;  ///< |what single precision has - exact value| is at most this

  Bounded() = default;
  Bounded(double v, double e) : value(v), error(e) {}
  /// A literal of a kernel: exact if it has few bits, else the rounding of some real number.
  explicit Bounded(float literal) : value(literal) {
    if (std::floor(literal * 0x1p10f) != literal * 0x1p10f) error = 0x1p-24 * std::abs(value);
  }
};

/// A constant of the tables: rounded once from double.
inline Bounded stored(double exact) {
  return {exact, 0x1p-24 * std::abs(exact)};
}

inline Bounded operator-(const Bounded& a) {
  return {-a.value, a.error};
}
inline Bounded rounded(double value, double inherited) {
  return {value, inherited + unit * (std::abs(value) + inherited)};
}
inline Bounded operator+(const Bounded& a, const Bounded& b) {
  return rounded(a.value + b.value, a.error + b.error);
}
inline Bounded operator-(const Bounded& a, const Bounded& b) {
  return rounded(a.value - b.value, a.error + b.error);
}
inline double product_error(const Bounded& a, const Bounded& b) {
  return std::abs(a.value) * b.error + std::abs(b.value) * a.error + a.error * b.error;
}
inline Bounded operator*(const Bounded& a, const Bounded& b) {
  return rounded(a.value * b.value, product_error(a, b));
}
inline Bounded operator/(const Bounded& a, const Bounded& b) {
  const double least = std::abs(b.value) - b.error;
  if (!(least > 0.0)) return {a.value / b.value, std::numeric_limits<double>::infinity()};
  const double value = a.value / b.value, inherited = (a.error + std::abs(value) * b.error) / least;
  return {value, inherited + slow_unit * (std::abs(value) + inherited)};
}
/// By the inverse, or divided.
inline Bounded quotient(const Bounded& a, const Bounded& b) {
  const Bounded divided = a / b;
  return rounded(divided.value, divided.error);
}
inline Bounded square_root(const Bounded& a) {
  const double value = std::sqrt(a.value), inherited = value - std::sqrt(std::max(a.value - a.error, 0.0));
  return {value, inherited + slow_unit * (value + inherited)};
}

/// Three products in any order, fused or not.
inline Bounded inner_product(const Vector3<Bounded>& a, const Vector3<Bounded>& b) {
  const double x = a.x.value * b.x.value, y = a.y.value * b.y.value, z = a.z.value * b.z.value;
  const double inherited = product_error(a.x, b.x) + product_error(a.y, b.y) + product_error(a.z, b.z);
  return {x + y + z, inherited + 3.01 * unit * (std::abs(x) + std::abs(y) + std::abs(z) + inherited)};
}

/// A comparison whose outcome rounding may have changed.
struct Outcome {
  bool holds = false;
  bool sure = true;
};
inline Outcome compared(bool holds, const Bounded& a, const Bounded& b) {
  return {holds, std::abs(a.value - b.value) > a.error + b.error};
}
inline Outcome operator<(const Bounded& a, const Bounded& b) {
  return compared(a.value < b.value, a, b);
}
inline Outcome operator<=(const Bounded& a, const Bounded& b) {
  return compared(a.value <= b.value, a, b);
}
inline Outcome operator>(const Bounded& a, const Bounded& b) {
  return compared(a.value > b.value, a, b);
}
inline Bounded select(const Outcome& outcome, const Bounded& a, const Bounded& b) {
  const Bounded &taken = outcome.holds ? a : b, &left = outcome.holds ? b : a;
  if (outcome.sure) return taken;
  return {taken.value, std::max(taken.error, left.error + std::abs(left.value - taken.value))};
}

/// Also where rounding may have changed it.
inline bool any_below(const Bounded& a, const Bounded& b) {
  const Outcome outcome = a < b;
  return outcome.holds || !outcome.sure;
}

/// Of 1 / sqrt(a) - 1 from y = a - 1. The vector kernels' has a few units of the result and of 1e-10 besides.
inline Bounded inverse_root_change(const Bounded& a, const Bounded& y) {
  const Bounded root = square_root(a);
  const Bounded change = -y * (Bounded(1.0f) / (root * (Bounded(1.0f) + root)));
  return {change.value, change.error + 4.0 * unit * std::abs(change.value) + 1e-10};
}

/// a^(-1/3); three steps of Newton's method leave two units.
inline Bounded inverse_cube_root(const Bounded& a) {
  const double value = 1.0 / std::cbrt(a.value), least = std::max(a.value - a.error, 0.0);
  const double inherited = least > 0.0 ? 1.0 / std::cbrt(least) - value : std::numeric_limits<double>::infinity();
  return {value, inherited + 4.0 * unit * (value + inherited)};
}

/// A sum of vectors in any order.
class BoundedSum {
 public:
  void add(const Vector3<Bounded>& term) {
    ++terms_;
    add(0, term.x);
    add(1, term.y);
    add(2, term.z);
  }
  Vector3<Bounded> total() const { return {of(0), of(1), of(2)}; }

 private:
  void add(int axis, const Bounded& term) {
    value_[axis] += term.value;
    magnitude_[axis] += std::abs(term.value) + term.error;
    error_[axis] += term.error;
  }
  Bounded of(int axis) const { return {value_[axis], error_[axis] + 1.01 * unit * terms_ * magnitude_[axis]}; }

  int terms_ = 0;
  double value_[3]{}, magnitude_[3]{}, error_[3]{};
};

}  // namespace phymul::test
