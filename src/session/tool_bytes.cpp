// SPDX-License-Identifier: MIT
#include "scene_bytes.h"

#include <phymul/distance_grid.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <type_traits>

#include "wire_codes.h"

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
    auto& [length, radius, puncture, cutting, at_rest, sliding, spread, bending, arc, leaving] = shape;
    for (auto* m : {&length, &radius, &puncture, &cutting, &at_rest, &sliding, &spread, &bending}) visit(*m);
  } else if constexpr (std::is_same_v<Plain, Blade>) {
    visit(shape.width);
    visit(shape.toughness);
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

template <class Shape>
ToolShape take_members(ByteReader& in) {
  Shape shape;
  each_member(shape, [&](double& member) { member = in.real("a size of a tool"); });
  return shape;
}

/// What files of straight needles do not have.
template <class Bytes, class Any>
void arc_fields(Bytes& bytes, Any& needle) {
  bytes.field(needle.arc_radius, "radius of an arc");
  bytes.field(needle.leaving, "force to come out");
}

/// What files of straight blades without sides do not have.
template <class Bytes, class Any>
void curve_fields(Bytes& bytes, Any& blade) {
  bytes.field(blade.belly, "belly of a blade");
  bytes.field(blade.bow, "bow of a blade");
  bytes.field(blade.height, "height of a blade");
  bytes.field(blade.friction, "friction of a blade");
}

ToolShape take_shape(ByteReader& in, ShapeKind kind) {
  if (kind == arc_needle) {
    ToolShape shape = take_members<Needle>(in);
    arc_fields(in, std::get<Needle>(shape));
    return shape;
  }
  if (kind == curved_blade) {
    ToolShape shape = take_members<Blade>(in);
    curve_fields(in, std::get<Blade>(shape));
    return shape;
  }
  switch (kind) {
    case ShapeKind::sphere:
      return take_members<Sphere>(in);
    case ShapeKind::capsule:
      return take_members<Capsule>(in);
    case ShapeKind::half_space:
      return take_members<HalfSpace>(in);
    case ShapeKind::box:
      return take_members<Box>(in);
    case ShapeKind::grid:
      return take_grid(in);
    case ShapeKind::needle:
      return take_members<Needle>(in);
    case ShapeKind::blade:
      break;
  }
  return take_members<Blade>(in);
}

// From here on: what a thing is made of, for a ByteWriter and a thing that is const, or a ByteReader and one that is
// not.

template <class Bytes, class Any>
void law_fields(Bytes& bytes, Any& tool) {
  pose_fields(bytes, tool.pose);
  bytes.field(tool.friction, "a coefficient of friction");
  bytes.field(tool.compliance, "a compliance");
  bytes.field(tool.margin, "a margin");
}

/// What files of tools without suction do not have.
template <class Bytes, class Any>
void suction_fields(Bytes& bytes, Any& tool) {
  bytes.field(tool.suction, "a suction");
  bytes.field(tool.suction_reach, "a suction reach");
}

template <class Bytes, class Node>
void node_fields(Bytes& bytes, Node& node) {
  bytes.field(node.particles, "particles");
  bytes.list(node.weights, 8, "a number of weights", [&](auto& weight) { bytes.field(weight, "a weight"); });
  bytes.field(node.slides, "whether it slides");
}

template <class Bytes, class State>
void state_fields(Bytes& bytes, State& state) {
  bytes.field(state.name, "a tool's name");
  pose_fields(bytes, state.pose);
  bytes.field(state.placed, "whether it was placed");
  bytes.field(state.held, "held particles");
  bytes.list(state.held_at, 24, "a number of held places", [&](auto& at) { bytes.field(at, "a held place"); });
  bytes.list(state.needle.hole, 17, "a number of points of a hole", [&](auto& node) { node_fields(bytes, node); });
  bytes.field(state.needle.punctured, "whether it has punctured");
  bytes.field(state.needle.through, "whether it came out again");
  bytes.field(state.needle.slip, "a slip");
  bytes.list(state.needle.shaft, 24, "a number of forces on a shaft", [&](auto& load) {
    for (auto* value : {&load.along, &load.x, &load.y}) bytes.field(*value, "a force on a shaft");
  });
}

bool is_finite(const ToolState& state) {
  const auto finite = [](const auto&... values) { return (std::isfinite(values) && ...); };
  const auto& [position, orientation, velocity, spin] = state.pose;
  return position.allFinite() && orientation.coeffs().allFinite() && velocity.allFinite() && spin.allFinite() &&
         finite(state.needle.slip) &&
         std::ranges::all_of(state.held_at, [](const Vec3& at) { return at.allFinite(); }) &&
         std::ranges::all_of(state.needle.shaft, [&](const ShaftLoad& f) { return finite(f.along, f.x, f.y); }) &&
         std::ranges::all_of(state.needle.hole,
                             [&](const NeedleNode& node) { return std::ranges::all_of(node.weights, finite); });
}

void require_one_each(const ByteReader& in, std::size_t items, std::size_t particles, const char* what) {
  if (items == particles) return;
  in.fail(std::string("expected a ") + what + " for each of " + std::to_string(particles) + " particles, got " +
          std::to_string(items) + ", before this byte");
}

}  // namespace

void tool_fields(ByteWriter& out, const Tool& tool) {
  const auto* const needle = std::get_if<Needle>(&tool.shape);
  const bool is_arc = needle && (needle->arc_radius != 0.0 || needle->leaving != 0.0);
  const auto* const blade = std::get_if<Blade>(&tool.shape);
  const bool is_curved =
      blade && (blade->belly != 0.0 || blade->bow != 0.0 || blade->height != 0.0 || blade->friction != 0.0);
  code(out, is_arc ? arc_needle : is_curved ? curved_blade : kind_of(tool.shape), "");
  std::visit(
      [&](const auto& shape) {
        if constexpr (std::is_same_v<std::decay_t<decltype(shape)>, std::shared_ptr<const DistanceGrid>>) {
          put_grid(out, *shape);
        } else {
          each_member(shape, [&](const double& member) { out.real(member); });
        }
      },
      tool.shape);
  if (is_arc) arc_fields(out, *needle);
  if (is_curved) curve_fields(out, *blade);
  law_fields(out, tool);
  const bool draws = tool.suction > 0.0;
  code(out, static_cast<ToolContact>(static_cast<int>(tool.contact) + (draws ? with_suction : 0)), "");
  if (draws) suction_fields(out, tool);
}

void tool_fields(ByteReader& in, Tool& tool) {
  ShapeKind kind{};
  code(in, kind, "a tool's shape");
  tool.shape = take_shape(in, kind);
  law_fields(in, tool);
  code(in, tool.contact, "a tool's contact");
  if (static_cast<int>(tool.contact) < with_suction) return;
  tool.contact = static_cast<ToolContact>(static_cast<int>(tool.contact) - with_suction);
  suction_fields(in, tool);
}

void put_tool_state(ByteWriter& out, const ToolState& state) {
  state_fields(out, state);
}

ToolState take_tool_state(ByteReader& in) {
  ToolState state;
  state_fields(in, state);
  require_one_each(in, state.held_at.size(), state.held.size(), "place");
  for (const NeedleNode& node : state.needle.hole) {
    require_one_each(in, node.weights.size(), node.particles.size(), "weight");
  }
  if (!is_finite(state)) in.fail("expected finite numbers in a tool's state before this byte; the file is damaged");
  return state;
}

}  // namespace phymul
