// SPDX-License-Identifier: MIT
#include "tool_bytes.h"

#include <phymul/distance_grid.h>

#include <bit>
#include <limits>
#include <type_traits>

#include "interaction/shape_kind.h"

namespace phymul {
namespace {

/// What each shape is made of, in one order for writing and reading.
template <class Shape, class Visit>
void each_member(Shape& shape, Visit visit) {
  using Plain = std::remove_const_t<Shape>;
  if constexpr (std::is_same_v<Plain, Sphere>) {
    visit(shape.radius);
  } else if constexpr (std::is_same_v<Plain, Capsule>) {
    visit(shape.radius);
    visit(shape.length);
  } else if constexpr (std::is_same_v<Plain, Box>) {
    for (int a = 0; a < 3; ++a) visit(shape.half_size[a]);
  } else if constexpr (std::is_same_v<Plain, Needle>) {
    visit(shape.length);
    visit(shape.radius);
    visit(shape.puncture);
    visit(shape.cutting);
    visit(shape.static_friction);
    visit(shape.kinetic_friction);
    visit(shape.spread);
    visit(shape.bending_stiffness);
  } else {
    static_assert(std::is_same_v<Plain, HalfSpace>, "a shape that is not written yet");
  }
}

void put_grid(ByteWriter& out, const DistanceGrid& grid) {
  out.vector(grid.origin());
  out.real(grid.spacing());
  for (const int count : grid.count()) out.index(count);
  out.u64(grid.values().size());
  for (const float value : grid.values()) out.u32(std::bit_cast<std::uint32_t>(value));
}

std::shared_ptr<const DistanceGrid> take_grid(ByteReader& in) {
  const Vec3 origin = in.vector("a grid's origin");
  const double spacing = in.real("a grid's spacing");
  std::array<int, 3> count{};
  for (int& c : count) c = in.index("a grid's corners");
  std::vector<float> values(in.count(4, "a number of distances"));
  for (float& value : values) value = std::bit_cast<float>(in.u32("a distance"));
  return std::make_shared<const DistanceGrid>(origin, spacing, count, std::move(values));
}

/// What a file calls each shape: never another number, whatever ToolShape lists first.
std::uint8_t code_of(const ToolShape& shape) {
  switch (kind_of(shape)) {
    case ShapeKind::sphere:
      return 0;
    case ShapeKind::capsule:
      return 1;
    case ShapeKind::half_space:
      return 2;
    case ShapeKind::box:
      return 3;
    case ShapeKind::grid:
      return 4;
    case ShapeKind::needle:
      break;
  }
  return 5;
}

template <std::size_t row = 0>
ToolShape take_shape(ByteReader& in, std::uint8_t wanted) {
  if constexpr (row == std::variant_size_v<ToolShape>) {
    in.fail("expected a tool's shape below " + std::to_string(row) + ", got " + std::to_string(wanted) +
            "; the file is damaged, or of a newer version of phymul");
  } else {
    using Shape = std::variant_alternative_t<row, ToolShape>;
    if (code_of(Shape{}) != wanted) return take_shape<row + 1>(in, wanted);
    if constexpr (std::is_same_v<Shape, std::shared_ptr<const DistanceGrid>>) {
      return take_grid(in);
    } else {
      Shape shape;
      each_member(shape, [&](double& member) { member = in.real("a size of a tool"); });
      return shape;
    }
  }
}

void put_node(ByteWriter& out, const NeedleNode& node) {
  out.indices(node.particles);
  out.u64(node.weights.size());
  for (const double weight : node.weights) out.real(weight);
  out.u8(node.slides ? 1 : 0);
}

NeedleNode take_node(ByteReader& in) {
  NeedleNode node;
  node.particles = in.indices("particles");
  node.weights.resize(in.count(8, "a number of weights"));
  if (node.weights.size() != node.particles.size()) {
    in.fail("expected a weight for each of " + std::to_string(node.particles.size()) + " particles, got " +
            std::to_string(node.weights.size()));
  }
  for (double& weight : node.weights) weight = in.real("a weight");
  node.slides = in.u8("whether it slides") != 0;
  return node;
}

}  // namespace

void put_pose(ByteWriter& out, const ToolPose& pose) {
  out.vector(pose.position);
  for (int k = 0; k < 4; ++k) out.real(pose.orientation.coeffs()[k]);  // x, y, z, w
  out.vector(pose.velocity);
  out.vector(pose.spin);
}

ToolPose take_pose(ByteReader& in) {
  ToolPose pose;
  pose.position = in.vector("a tool's position");
  for (int k = 0; k < 4; ++k) pose.orientation.coeffs()[k] = in.real("a tool's orientation");
  pose.velocity = in.vector("a tool's velocity");
  pose.spin = in.vector("a tool's spin");
  return pose;
}

void put_tool(ByteWriter& out, const Tool& tool) {
  out.u8(code_of(tool.shape));
  std::visit(
      [&](const auto& shape) {
        if constexpr (std::is_same_v<std::decay_t<decltype(shape)>, std::shared_ptr<const DistanceGrid>>) {
          put_grid(out, *shape);
        } else {
          each_member(shape, [&](const double& member) { out.real(member); });
        }
      },
      tool.shape);
  put_pose(out, tool.pose);
  out.real(tool.friction);
  out.real(tool.compliance);
  out.real(tool.margin);
}

Tool take_tool(ByteReader& in) {
  Tool tool;
  tool.shape = take_shape(in, in.u8("a tool's shape"));
  tool.pose = take_pose(in);
  tool.friction = in.real("a coefficient of friction");
  tool.compliance = in.real("a compliance");
  tool.margin = in.real("a margin");
  return tool;
}

void put_tool_state(ByteWriter& out, const ToolState& state) {
  out.text(state.name);
  put_pose(out, state.pose);
  out.u8(state.placed ? 1 : 0);
  out.indices(state.held);
  out.u64(state.held_at.size());
  out.vectors(state.held_at);
  out.u64(state.needle.hole.size());
  for (const NeedleNode& node : state.needle.hole) put_node(out, node);
  out.u8(state.needle.punctured ? 1 : 0);
  out.u8(state.needle.through ? 1 : 0);
  out.real(state.needle.slip);
  out.u64(state.needle.shaft.size());
  for (const ShaftLoad& load : state.needle.shaft) {
    for (const double value : {load.along, load.x, load.y}) out.real(value);
  }
}

ToolState take_tool_state(ByteReader& in) {
  ToolState state;
  state.name = in.text("a tool's name");
  state.pose = take_pose(in);
  state.placed = in.u8("whether it was placed") != 0;
  state.held = in.indices("held particles");
  const std::size_t count = in.count(24, "a number of held places");
  if (count != state.held.size()) {
    in.fail("expected a place for each of " + std::to_string(state.held.size()) + " held particles, got " +
            std::to_string(count));
  }
  state.held_at = in.vectors(count, "held places");
  const std::size_t nodes = in.count(17, "a number of points of a hole");
  for (std::size_t k = 0; k < nodes; ++k) state.needle.hole.push_back(take_node(in));
  state.needle.punctured = in.u8("whether it has punctured") != 0;
  state.needle.through = in.u8("whether it came out again") != 0;
  state.needle.slip = in.real("a slip");
  state.needle.shaft.resize(in.count(24, "a number of forces on a shaft"));
  for (ShaftLoad& load : state.needle.shaft) {
    for (double* value : {&load.along, &load.x, &load.y}) *value = in.real("a force on a shaft");
  }
  return state;
}

}  // namespace phymul
