// SPDX-License-Identifier: MIT
//
// What an anchor of a joint or a thread must be.
#pragma once

#include <phymul/error.h>
#include <phymul/scene.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "base/decimal.h"
#include "model/require_indices.h"

namespace phymul {

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

}  // namespace phymul
