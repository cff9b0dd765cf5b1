// SPDX-License-Identifier: MIT
//
// What a scene does to a body, in textures. What it has nothing of is empty.
#pragma once

#include <optional>

#include "fragment_joints.h"
#include "fragment_loads.h"
#include "fragment_open_step.h"
#include "fragment_tools.h"
#include "fragment_volumes.h"

namespace phymul::gl {

struct FragmentScene {
  /// Room for the values of as many instants. The scene and `tables` must outlive it. `on_host`: tools, contacts and
  /// kept volumes act there.
  FragmentScene(const Scene& scene, int instants, const FragmentTables& tables, const FloatTools& float_tools,
                bool on_host, const Texture& measured)
      : loads(scene, instants, tables) {
    if (FloatJoints own(scene, float_tools.middle()); !own.empty()) joints.emplace(std::move(own));
    if (on_host) {
      open.emplace(static_cast<Index>(scene.model().rest.size()), measured);
      if (joints && joints->any_tool()) tools.emplace(float_tools, false);
      return;
    }
    if (!float_tools.empty()) tools.emplace(float_tools, true);
    if (const FloatVolumes own = pack_volumes(scene); !own.empty()) volumes.emplace(own);
  }

  /// On the device.
  bool tools_act() const { return tools && !open; }

  FragmentLoads loads;
  std::optional<FragmentTools> tools;
  std::optional<FragmentVolumes> volumes;
  std::optional<FragmentJoints> joints;
  std::optional<FragmentOpenStep> open;
};

}  // namespace phymul::gl
