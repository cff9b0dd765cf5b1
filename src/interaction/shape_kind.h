// SPDX-License-Identifier: MIT
//
// A name for each shape a tool can have: what kernels, tables and shaders tell shapes apart by.
#pragma once

#include <phymul/tool.h>

namespace phymul {

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

}  // namespace phymul
