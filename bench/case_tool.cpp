// SPDX-License-Identifier: MIT
#include "case_tool.h"

#include <phymul/error.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "case_body.h"

namespace phymul::bench {
namespace {

struct Kind {
  std::string_view name, sizes;
  std::size_t size_count;
  ToolShape (*make)(const std::vector<double>& size);
};

const std::array<Kind, 4> kinds{{
    {"sphere", "radius", 1, [](const std::vector<double>& size) -> ToolShape { return Sphere{size[0]}; }},
    {"capsule", "radius length", 2,
     [](const std::vector<double>& size) -> ToolShape {
       return Capsule{size[0], size[1]};
     }},
    {"half-space", "", 0, [](const std::vector<double>&) -> ToolShape { return HalfSpace{}; }},
    {"box", "half_x half_y half_z", 3,
     [](const std::vector<double>& size) -> ToolShape {
       return Box{{size[0], size[1], size[2]}};
     }},
}};

const Kind& kind_of(const std::string& shape) {
  const auto known = std::ranges::find(kinds, shape, &Kind::name);
  if (known == kinds.end()) {
    throw Error("tool shape \"" + shape + "\": expected sphere, capsule, half-space or box");
  }
  return *known;
}

}  // namespace

ReferenceCase::PlacedTool read_tool(const std::vector<std::string>& words) {
  if (words.size() < 3)
    throw Error("expected: tool NAME sphere|capsule|half-space|box sizes x y z ux uy uz [ax ay az]");
  const Kind& kind = kind_of(words[2]);
  const std::size_t place = 3 + kind.size_count, without_axis = place + 6, with_axis = place + 9;
  if (words.size() != without_axis && words.size() != with_axis) {
    throw Error("expected: tool NAME " + words[2] + " " + std::string(kind.sizes) + (kind.sizes.empty() ? "" : " ") +
                "x y z ux uy uz [ax ay az]");
  }
  const auto triple = [&](std::size_t first) { return Triple{words[first], words[first + 1], words[first + 2]}; };
  ReferenceCase::PlacedTool tool;
  tool.name = words[1];
  tool.shape = words[2];
  tool.sizes.assign(words.begin() + 3, words.begin() + static_cast<std::ptrdiff_t>(place));
  tool.place = triple(place);
  tool.displacement = triple(place + 3);
  if (words.size() == with_axis) tool.axis = triple(without_axis);
  return tool;
}

Tool make_tool(const ReferenceCase::PlacedTool& it, const Variables& variables) {
  std::vector<double> sizes;
  for (const std::string& text : it.sizes) sizes.push_back(evaluate(text, variables));
  const Vec3 axis = vector_of(it.axis, variables);
  if (!(axis.norm() > 0.0)) throw Error("tool " + it.name + ": expected an axis that is not zero");
  Tool tool;
  tool.shape = kind_of(it.shape).make(sizes);
  tool.pose.position = vector_of(it.place, variables) + vector_of(it.displacement, variables);
  tool.pose.orientation =
      Quaternion(Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), Eigen::Vector3d(axis)));
  return tool;
}

}  // namespace phymul::bench
