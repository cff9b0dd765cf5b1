// SPDX-License-Identifier: MIT
//
// What the items of a scene share: their names, and checks of values and of anchors.
#pragma once

#include <phymul/error.h>
#include <phymul/load.h>
#include <phymul/scene.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/decimal.h"
#include "model/group.h"

namespace phymul {

/// "<kind> <number>" with the first number from `number` on that no item of the scene has in its name.
template <class Named>
std::string default_name(const std::string& kind, std::uint64_t number, const std::vector<Named>& items) {
  while (true) {
    std::string name = kind + ' ' + std::to_string(number++);
    if (std::ranges::find(items, name, &Named::name) == items.end()) return name;
  }
}

/// The item of that name; throws Error, with the known names, if there is none.
template <class Items>
auto& item_named(Items& items, const std::string& kind, std::string_view name) {
  std::string names;
  for (auto& item : items) {
    if (item.name == name) return item;
    names += (names.empty() ? "" : ", ") + item.name;
  }
  throw Error(ErrorCode::unknown_name, "the scene has no " + kind + " \"" + std::string(name) +
                                           "\"; it has: " + (names.empty() ? "none" : names));
}

/// The item of a handle.
template <class Items>
auto& item_with(Items& items, const std::string& kind, std::uint64_t id) {
  const auto own = std::ranges::find(items, id, &Items::value_type::id);
  if (own != items.end()) return *own;
  throw Error(ErrorCode::unknown_name, "the scene no longer has the " + kind + " of this handle; Scene::" + kind +
                                           " gives handles of those it has");
}

/// `label`: what is refused, with a colon after it.
inline void require_not_negative(std::string_view label, const char* what, double value) {
  if (value >= 0.0 && std::isfinite(value)) return;
  throw Error(std::string(label) + "expected a finite " + what + ", 0 or more; got " + to_decimal(value));
}

/// What an anchor of a joint or a thread must be.
struct AnchorCheck {
  const std::string& label;  // of the joint and the spring
  const Model& model;
  const std::vector<SceneTool>& tools;

  void operator()(const Anchor& anchor) const {
    if (anchor.particles.empty()) {
      require_point(anchor);
      return;
    }
    if (!anchor.tool.empty()) throw Error(label + "expected an anchor at particles or at a tool, got both");
    if (anchor.weights.size() != anchor.particles.size()) {
      throw Error(label + "expected a weight for each of " + std::to_string(anchor.particles.size()) +
                  " particles, got " + std::to_string(anchor.weights.size()));
    }
    require_indices(anchor.particles, model.rest.size(), "particles", [&] { return label; });
    if (std::set(anchor.particles.begin(), anchor.particles.end()).size() != anchor.particles.size()) {
      throw Error(label + "expected each particle once in an anchor, got one twice");
    }
    double sum = 0.0;
    for (const double w : anchor.weights) sum += w;
    if (!(std::abs(sum - 1.0) <= 1e-9)) {
      throw Error(label + "expected weights of sum 1, got a sum of " + to_decimal(sum));
    }
  }

  void require_point(const Anchor& anchor) const {
    if (!anchor.weights.empty()) throw Error(label + "expected particles for an anchor's weights, got none");
    if (!anchor.point.allFinite()) throw Error(label + "expected a finite point of an anchor");
    if (model.dimension == 2 && anchor.point.z() != 0.0) {
      throw Error(label + "expected an anchor with z = 0 in a two-dimensional model, got " +
                  to_decimal(anchor.point.z()));
    }
    if (anchor.tool.empty()) return;
    if (std::ranges::find(tools, anchor.tool, &SceneTool::name) != tools.end()) return;
    throw Error(ErrorCode::unknown_name, label + "the scene has no tool \"" + anchor.tool + '"');
  }
};

/// Whether a load of this type imposes positions; others apply forces.
inline bool imposes(LoadType type) {
  return type == LoadType::translation || type == LoadType::rotation;
}

}  // namespace phymul
