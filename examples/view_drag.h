// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/camera.h>
#include <phymul/simulation.h>

#include <optional>

/// A particle in a hand: three loads that impose a coordinate each, because a load has one direction only, and a hand's
/// way has many. It follows at a finite speed, as a jump would tear the body.
class ParticleDrag {
 public:
  explicit ParticleDrag(phymul::Simulation& sim) : sim_(sim) {}

  /// Takes the frontmost particle within reach of a place in the picture; false: there is none.
  bool take(const phymul::Camera& camera, double x, double y, int width, int height);
  void move(const phymul::Camera& camera, double x, double y, int width, int height);
  void release();

  bool holds() const { return particle_.has_value(); }
  phymul::Index particle() const { return *particle_; }

 private:
  phymul::Load along(int axis, double time, double from, double to) const;

  phymul::Simulation& sim_;
  std::optional<phymul::Index> particle_;
  std::size_t first_row_ = 0;
  double depth_ = 0.0;            // m, from the eye
  phymul::Vec3 offset_{0, 0, 0};  // from the place under the mouse to the particle, m
};
