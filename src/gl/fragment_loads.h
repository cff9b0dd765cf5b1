// SPDX-License-Identifier: MIT
//
// What a scene does to a body on the device: vectors per particle, uploaded when the scene changes, and a small table
// of the numbers they are multiplied by, a row per instant of a batch of steps.
#pragma once

#include <phymul/scene.h>

#include <vector>

#include "gl/pass.h"

namespace phymul::gl {

/// Which shaders a scene needs: one that holds nothing pays nothing.
struct LoadKind {
  bool forces = false, fixed = false;
  bool any() const { return forces || fixed; }
  bool operator==(const LoadKind&) const = default;
};

class FragmentLoads {
 public:
  /// Room for the values of as many instants.
  FragmentLoads(const Scene& scene, int instants);

  const LoadKind& kind() const { return kind_; }

  /// Takes over the values at these instants.
  void evaluate(const std::vector<double>& instants);
  /// Of an instant given to evaluate(), m/s^2: gravity and uniform accelerations.
  const Float4& gravity(std::size_t instant) const { return gravity_[instant]; }

  void bind(Pass& pass) const;

 private:
  void upload_parts();

  const Scene* scene_;
  LoadModes modes_;
  LoadKind kind_;
  Texture index_, parts_, values_;  // null where nothing but gravity acts
  std::vector<double> row_;         // [modes] at one instant
  std::vector<float> table_;        // [instants][modes]
  std::vector<Float4> gravity_;     // [instants]
};

}  // namespace phymul::gl
