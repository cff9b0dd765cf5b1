// SPDX-License-Identifier: MIT
//
// Three numbers of type S, a float or a pack of floats, with every operation in a fixed order: the same as in
// glsl/dialect/kernel_language.glsl, so that a shader without contraction and this code give the same bits.
#pragma once

#include <cmath>

namespace phymul {

template <class S>
struct Vector3 {
  S x{}, y{}, z{};

  Vector3& operator+=(const Vector3& b) { return *this = *this + b; }
  Vector3& operator-=(const Vector3& b) { return *this = *this - b; }

  friend Vector3 operator+(const Vector3& a, const Vector3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vector3 operator-(const Vector3& a, const Vector3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vector3 operator-(const Vector3& a) { return {-a.x, -a.y, -a.z}; }
  friend Vector3 operator*(const S& s, const Vector3& a) { return {s * a.x, s * a.y, s * a.z}; }
  friend bool operator==(const Vector3&, const Vector3&) = default;
};

template <class S>
S inner_product(const Vector3<S>& a, const Vector3<S>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <class S>
Vector3<S> cross_product(const Vector3<S>& a, const Vector3<S>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// What packs of floats overload: a choice lane by lane, whether a < b in any lane, and the square root.
inline float select(bool mask, float a, float b) {
  return mask ? a : b;
}
inline double select(bool mask, double a, double b) {
  return mask ? a : b;
}
inline bool any_below(float a, float b) {
  return a < b;
}
inline float square_root(float x) {
  return std::sqrt(x);
}
inline double square_root(double x) {
  return std::sqrt(x);
}

template <class Mask, class S>
Vector3<S> select(const Mask& mask, const Vector3<S>& a, const Vector3<S>& b) {
  return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
}

}  // namespace phymul
