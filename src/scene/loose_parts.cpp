// SPDX-License-Identifier: MIT
#include "loose_parts.h"

#include <algorithm>

namespace phymul {
namespace {

bool holds(const SceneJoint& joint) {
  return joint.joint.stiffness > 0.0;
}

/// Whether loads other than imposed positions act on the part.
bool is_pushed(const ConnectedBody& part, const Scene& scene) {
  if (scene.gravity() != Vec3::Zero()) return true;
  return std::ranges::any_of(scene.loads(), [&](const Load& load) {
    return load.type != LoadType::translation &&
           std::ranges::any_of(load.particles, [&](Index i) { return std::ranges::binary_search(part.particles, i); });
  });
}

}  // namespace

std::vector<char> held_particles(const Model& model, const Scene& scene) {
  std::vector<char> is_held(model.rest.size(), 0);
  for (const Load& load : scene.loads()) {
    if (load.type != LoadType::translation) continue;
    for (const Index i : load.particles) is_held[i] = 1;
  }
  for (const SceneJoint& joint : scene.joints()) {
    for (const JointSpring& spring : joint.joint.springs) {
      const bool to_world = spring.a.particles.empty() || spring.b.particles.empty();
      if (!to_world || !holds(joint)) continue;
      for (const Anchor* end : {&spring.a, &spring.b}) {
        for (const Index i : end->particles) is_held[i] = 1;
      }
    }
  }
  return is_held;
}

std::vector<ConnectedBody> loose_parts(const Model& model, const Scene& scene, const std::vector<char>& is_held) {
  std::vector<ConnectedBody> parts = connected_bodies(model);
  std::vector<std::size_t> part_of(model.rest.size(), 0);
  std::vector<char> part_is_held(parts.size(), 0);
  for (std::size_t row = 0; row < parts.size(); ++row) {
    for (const Index i : parts[row].particles) {
      part_of[i] = row;
      part_is_held[row] |= is_held[i];
    }
  }
  for (bool spreads = true; spreads;) {
    spreads = false;
    for (const SceneJoint& joint : scene.joints()) {
      for (const JointSpring& spring : joint.joint.springs) {
        if (!holds(joint) || spring.a.particles.empty() || spring.b.particles.empty()) continue;
        char& a = part_is_held[part_of[spring.a.particles.front()]];
        char& b = part_is_held[part_of[spring.b.particles.front()]];
        spreads = spreads || a != b;
        a = b = a | b;
      }
    }
  }
  std::erase_if(parts, [&](const ConnectedBody& part) { return part_is_held[part_of[part.particles.front()]] != 0; });
  return parts;
}

Index first_loose(const Scene& scene) {
  if (scene.contacts() || !scene.tools().empty()) return -1;
  const Model& model = scene.model();
  for (const ConnectedBody& part : loose_parts(model, scene, held_particles(model, scene))) {
    if (is_pushed(part, scene)) return part.particles.front();
  }
  return -1;
}

}  // namespace phymul
