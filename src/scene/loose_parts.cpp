// SPDX-License-Identifier: MIT
#include "loose_parts.h"

#include <algorithm>

#include "load_types.h"

namespace phymul {
namespace {

/// Calls visit(spring) for those that hold.
template <class Visit>
void for_each_spring(const Scene& scene, std::span<const JointState> joints, const Visit& visit) {
  for (const SceneJoint& joint : scene.joints()) {
    if (!(joint.joint.stiffness > 0.0)) continue;
    const auto state = std::ranges::find(joints, joint.name, &JointState::name);
    const auto is_broken = [&](std::size_t row) {
      return state != joints.end() && std::ranges::binary_search(state->broken, static_cast<Index>(row));
    };
    for (std::size_t row = 0; row < joint.joint.springs.size(); ++row) {
      if (!is_broken(row)) visit(joint.joint.springs[row]);
    }
  }
}

bool holds(const Load& load) {
  return load.type == LoadType::rotation ||
         (load.type == LoadType::translation &&
          std::ranges::any_of(load.axes, [](Axis axis) { return axis != Axis::free; }));
}

/// Whether loads other than imposed positions act on the part.
bool is_pushed(const ConnectedBody& part, const Scene& scene) {
  if (scene.gravity() != Vec3::Zero()) return true;
  return std::ranges::any_of(scene.loads(), [&](const Load& load) {
    return !imposes(load.type) &&
           std::ranges::any_of(load.particles, [&](Index i) { return std::ranges::binary_search(part.particles, i); });
  });
}

}  // namespace

bool may_hold_any(const Scene& scene) {
  return scene.contacts() || !scene.tools().empty() || !scene.threads().empty();
}

std::vector<char> held_particles(const Scene& scene, std::span<const JointState> joints) {
  std::vector<char> is_held(scene.model().rest.size(), 0);
  for (const Load& load : scene.loads()) {
    if (!holds(load)) continue;
    for (const Index i : load.particles) is_held[i] = 1;
  }
  for_each_spring(scene, joints, [&](const JointSpring& spring) {
    if (!spring.a.particles.empty() && !spring.b.particles.empty()) return;
    for (const Anchor* end : {&spring.a, &spring.b}) {
      for (const Index i : end->particles) is_held[i] = 1;
    }
  });
  return is_held;
}

std::vector<ConnectedBody> loose_parts(const Scene& scene, const std::vector<char>& is_held,
                                       std::span<const JointState> joints) {
  std::vector<ConnectedBody> parts = connected_bodies(scene.model());
  // One more for particles that were removed.
  std::vector<std::size_t> part_of(is_held.size(), parts.size());
  std::vector<char> part_is_held(parts.size() + 1, 0);
  for (std::size_t row = 0; row < parts.size(); ++row) {
    for (const Index i : parts[row].particles) {
      part_of[i] = row;
      part_is_held[row] |= is_held[i];
    }
  }
  for (bool spreads = true; spreads;) {
    spreads = false;
    for_each_spring(scene, joints, [&](const JointSpring& spring) {
      if (spring.a.particles.empty() || spring.b.particles.empty()) return;
      const std::size_t of_a = part_of[spring.a.particles.front()], of_b = part_of[spring.b.particles.front()];
      char &a = part_is_held[of_a], &b = part_is_held[of_b];
      if (std::max(of_a, of_b) == parts.size() || a == b) return;
      spreads = true;
      a = b = 1;
    });
  }
  std::erase_if(parts, [&](const ConnectedBody& part) { return part_is_held[part_of[part.particles.front()]] != 0; });
  return parts;
}

Index first_loose(const Scene& scene, std::span<const JointState> joints) {
  if (may_hold_any(scene)) return -1;
  for (const ConnectedBody& part : loose_parts(scene, held_particles(scene, joints), joints)) {
    if (is_pushed(part, scene)) return part.particles.front();
  }
  return -1;
}

}  // namespace phymul
