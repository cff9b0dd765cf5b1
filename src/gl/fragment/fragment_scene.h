// SPDX-License-Identifier: MIT
//
// What a scene does to a body, in textures. What it has nothing of is empty.
#pragma once

#include <optional>

#include "fragment_contacts.h"
#include "fragment_joints.h"
#include "fragment_loads.h"
#include "fragment_surfaces.h"
#include "fragment_tools.h"
#include "fragment_volumes.h"

namespace phymul::gl {

struct FragmentScene {
  /// Room for the values of as many instants. The scene and `tables` must outlive it. Throws Error where shaders cannot
  /// do what touches, before anything is made.
  FragmentScene(const Scene& scene, int instants, const FragmentTables& tables, const FloatTools& float_tools)
      : FragmentScene(scene, scene.contacts() ? std::optional<PlannedContacts>(scene) : std::nullopt, instants, tables,
                      float_tools) {}

  FragmentLoads loads;
  std::optional<FragmentTools> tools;
  std::optional<FragmentSurfaces> surfaces;
  std::optional<FragmentVolumes> volumes;
  std::optional<FragmentContacts> contacts;
  std::optional<FragmentJoints> joints;

 private:
  FragmentScene(const Scene& scene, const std::optional<PlannedContacts>& touching, int instants,
                const FragmentTables& tables, const FloatTools& float_tools)
      : loads(scene, instants, tables) {
    if (!float_tools.empty()) tools.emplace(float_tools);
    if (const FloatSurfaces own = pack_surfaces(scene); !own.empty()) surfaces.emplace(own, float_tools);
    if (const FloatVolumes own = pack_volumes(scene); !own.empty()) volumes.emplace(own);
    if (touching && !touching->contacts.empty()) {
      contacts.emplace(*touching, static_cast<Index>(scene.model().rest.size()));
    }
    if (FloatJoints own(scene, float_tools.middle()); !own.empty()) joints.emplace(std::move(own));
  }
};

}  // namespace phymul::gl
