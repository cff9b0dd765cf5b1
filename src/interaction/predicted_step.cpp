// SPDX-License-Identifier: MIT
#include "predicted_step.h"

namespace phymul {

void PredictedStep::fetch(std::span<const Index> rows, VecList& at, VecList& velocity) const {
  for (std::size_t k = 0; k < rows.size(); ++k) {
    at[k] = position(rows[k]);
    velocity[k] = predicted_velocity(rows[k]);
  }
}

double longest_of_ways(const VecList& from, const VecList& to) {
  double longest = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) longest = std::max(longest, (to[i] - from[i]).norm());
  return longest;
}

void TouchedParticles::prepare(std::span<const double> mass, std::span<const std::uint8_t> fixed, bool plane) {
  mass_ = mass;
  fixed_ = fixed;
  plane_ = plane;
  slot_of_.assign(mass.size(), -1);
  touched_.clear();
  touched_.reserve(mass.size());
}

void TouchedParticles::begin(PredictedStep& step, double dt, double last_dt) {
  step_ = &step;
  dt_ = dt;
  last_dt_ = last_dt;
}

void TouchedParticles::end() {
  for (const Touched& touched : touched_) {
    slot_of_[touched.particle] = -1;
    if (touched.impulse != Vec3::Zero()) step_->add_force(touched.particle, touched.impulse / dt_);
    if (touched.shift != Vec3::Zero()) step_->shift(touched.particle, touched.shift);
  }
  touched_.clear();
}

std::size_t TouchedParticles::slot(Index particle) {
  Index& slot = slot_of_[particle];
  if (slot < 0) {
    slot = static_cast<Index>(touched_.size());
    Touched& touched = touched_.emplace_back();
    touched.particle = particle;
    touched.inverse_mass = inverse_mass(particle);
    touched.fixed = fixed(particle);
    touched.position = step_->position(particle);
    touched.velocity = step_->predicted_velocity(particle);
    touched.withheld = step_->withheld(particle);
  }
  return static_cast<std::size_t>(slot);
}

void TouchedParticles::fetch(std::span<const Index> rows, VecList& position, VecList& velocity) const {
  step_->fetch(rows, position, velocity);
  if (touched_.empty()) return;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (slot_of_[rows[k]] >= 0) velocity[k] = touched_[slot_of_[rows[k]]].velocity;
  }
}

double TouchedParticles::going() const {
  double longest = step_->going();
  for (const Touched& touched : touched_) {
    longest = std::max(longest, (dt_ * touched.velocity + touched.shift).norm());
  }
  return longest;
}

}  // namespace phymul
