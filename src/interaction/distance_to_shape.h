// SPDX-License-Identifier: MIT
//
// Signed distance of a point from a tool's surface, negative inside, and the direction in which it grows. In the
// tool's frame; pure functions of any scalar, every operation in a fixed order.
#pragma once

#include <phymul/tool.h>

#include "base/vector3.h"

namespace phymul {

/// What kernels, tables and shaders tell shapes apart by.
enum class ShapeKind { sphere, capsule, half_space, box, grid, needle, blade };

inline ShapeKind kind_of(const ToolShape& shape) {
  struct Kind {
    ShapeKind operator()(const Sphere&) const { return ShapeKind::sphere; }
    ShapeKind operator()(const Capsule&) const { return ShapeKind::capsule; }
    ShapeKind operator()(const HalfSpace&) const { return ShapeKind::half_space; }
    ShapeKind operator()(const Box&) const { return ShapeKind::box; }
    ShapeKind operator()(const std::shared_ptr<const DistanceGrid>&) const { return ShapeKind::grid; }
    ShapeKind operator()(const Needle&) const { return ShapeKind::needle; }
    ShapeKind operator()(const Blade&) const { return ShapeKind::blade; }
  };
  return std::visit(Kind{}, shape);
}

/// Distances at the corners of cubes, x fastest; linear in between.
template <class S>
struct GridValues {
  const float* value = nullptr;  // [n.z][n.y][n.x] m
  int nx = 0, ny = 0, nz = 0;
  Vector3<S> origin{};  // m
  S spacing{};          // m
};

template <class S>
struct ShapeIn {
  ShapeKind kind = ShapeKind::sphere;
  Vector3<S> size{};  // sphere: radius; capsule: radius, length; box: half sizes
  S margin{};         // m around it
  S thickness{};      // m: a way shorter than half of it cannot pass through
  GridValues<S> grid{};
};

template <class S>
struct Distance {
  S phi{};
  Vector3<S> normal{};
};

template <class S>
S at_least(const S& a, const S& b) {
  return a < b ? b : a;
}
template <class S>
S at_most(const S& a, const S& b) {
  return b < a ? b : a;
}

/// From a point, less a radius; the direction of a point that is right there is +z.
template <class S>
Distance<S> distance_from_point(const Vector3<S>& q, const S& radius) {
  const S length = square_root(inner_product(q, q));
  if (!(length > S(0.0f))) return {-radius, {S(0.0f), S(0.0f), S(1.0f)}};
  return {length - radius, (S(1.0f) / length) * q};
}

template <class S>
Distance<S> distance_from_box(const Vector3<S>& q, const Vector3<S>& half) {
  const Vector3<S> side{q.x < S(0.0f) ? S(-1.0f) : S(1.0f), q.y < S(0.0f) ? S(-1.0f) : S(1.0f),
                        q.z < S(0.0f) ? S(-1.0f) : S(1.0f)};
  const Vector3<S> d{side.x * q.x - half.x, side.y * q.y - half.y, side.z * q.z - half.z};
  const S zero(0.0f);
  if (d.x <= zero && d.y <= zero && d.z <= zero) {
    if (d.x >= d.y && d.x >= d.z) return {d.x, {side.x, zero, zero}};
    if (d.y >= d.z) return {d.y, {zero, side.y, zero}};
    return {d.z, {zero, zero, side.z}};
  }
  const Vector3<S> out{at_least(d.x, zero), at_least(d.y, zero), at_least(d.z, zero)};
  const S length = square_root(inner_product(out, out));
  const S scale = S(1.0f) / length;
  return {length, {scale * side.x * out.x, scale * side.y * out.y, scale * side.z * out.z}};
}

/// Outside of the grid: of its nearest point, plus the way there.
template <class S>
Distance<S> distance_in_grid(const Vector3<S>& q, const GridValues<S>& grid) {
  const S inverse = S(1.0f) / grid.spacing, zero(0.0f);
  const Vector3<S> local = inverse * (q - grid.origin);
  const Vector3<S> in{at_least(zero, at_most(local.x, S(static_cast<float>(grid.nx - 1)))),
                      at_least(zero, at_most(local.y, S(static_cast<float>(grid.ny - 1)))),
                      at_least(zero, at_most(local.z, S(static_cast<float>(grid.nz - 1))))};
  const auto cell = [](const S& s, int n) { return static_cast<int>(s) < n - 1 ? static_cast<int>(s) : n - 2; };
  const int i = cell(in.x, grid.nx), j = cell(in.y, grid.ny), k = cell(in.z, grid.nz);
  const S x = in.x - S(static_cast<float>(i)), y = in.y - S(static_cast<float>(j)), z = in.z - S(static_cast<float>(k));
  const auto at = [&](int a, int b, int c) {
    return S(grid.value[(static_cast<long>(k + c) * grid.ny + (j + b)) * grid.nx + (i + a)]);
  };
  const S v00 = at(0, 0, 0) + x * (at(1, 0, 0) - at(0, 0, 0)), v10 = at(0, 1, 0) + x * (at(1, 1, 0) - at(0, 1, 0));
  const S v01 = at(0, 0, 1) + x * (at(1, 0, 1) - at(0, 0, 1)), v11 = at(0, 1, 1) + x * (at(1, 1, 1) - at(0, 1, 1));
  const S w0 = v00 + y * (v10 - v00), w1 = v01 + y * (v11 - v01);
  const S dx0 = (at(1, 0, 0) - at(0, 0, 0)) + y * ((at(1, 1, 0) - at(0, 1, 0)) - (at(1, 0, 0) - at(0, 0, 0)));
  const S dx1 = (at(1, 0, 1) - at(0, 0, 1)) + y * ((at(1, 1, 1) - at(0, 1, 1)) - (at(1, 0, 1) - at(0, 0, 1)));
  Vector3<S> slope{dx0 + z * (dx1 - dx0), (v10 - v00) + z * ((v11 - v01) - (v10 - v00)), w1 - w0};
  Distance<S> distance{w0 + z * (w1 - w0), {}};
  const Vector3<S> way = grid.spacing * (local - in);
  const S beyond = square_root(inner_product(way, way));
  if (beyond > zero) {
    distance.phi += beyond;
    slope = way;
  }
  const S length = square_root(inner_product(slope, slope));
  distance.normal = length > zero ? (S(1.0f) / length) * slope : Vector3<S>{S(0.0f), S(0.0f), S(1.0f)};
  return distance;
}

template <class S>
Distance<S> distance_to(const ShapeIn<S>& shape, const Vector3<S>& q) {
  Distance<S> distance;
  switch (shape.kind) {
    case ShapeKind::sphere:
      distance = distance_from_point(q, shape.size.x);
      break;
    case ShapeKind::capsule:
      distance =
          distance_from_point(Vector3<S>{q.x, q.y, q.z - at_least(S(0.0f), at_most(q.z, shape.size.y))}, shape.size.x);
      break;
    case ShapeKind::half_space:
      distance = {q.z, {S(0.0f), S(0.0f), S(1.0f)}};
      break;
    case ShapeKind::box:
      distance = distance_from_box(q, shape.size);
      break;
    case ShapeKind::grid:
      distance = distance_in_grid(q, shape.grid);
      break;
    case ShapeKind::needle:  // has no inside: needle_path.h
    case ShapeKind::blade:   // likewise: blade_edge.h
      break;
  }
  distance.phi = distance.phi - shape.margin;
  return distance;
}

}  // namespace phymul
