// SPDX-License-Identifier: MIT
#include "kept_volumes.h"

#include <algorithm>
#include <cmath>

#include "model/enclosed_volume.h"

namespace phymul {
namespace {

/// What of a push a rough tool that presses the particle lets through: along its surface less, by what friction bears
/// of the push against it. Without that what sticks to a tool would creep, a little in each step: tools act before.
Vec3 past_friction(const Vec3& push, const Vec3& rubbed) {
  const double friction = rubbed.norm();
  if (!(friction > 0.0)) return push;
  const Vec3 normal = rubbed / friction, against = normal.dot(push) * normal, along = push - against;
  const double bears = friction * against.norm(), size = along.norm();
  return size > bears ? Vec3(against + (1.0 - bears / size) * along) : against;
}

}  // namespace

void KeptVolumes::follow(const Scene& scene) {
  surfaces_.clear();
  for (std::size_t row = 0; row < scene.volume_constraints().size(); ++row) {
    const VolumeConstraint& kept = scene.volume_constraints()[row];
    Surface surface;
    surface.open = scene.is_open(row);
    surface.volume = kept.volume;
    surface.triangles = kept.triangles;
    for (const auto& t : kept.triangles) surface.particles.insert(surface.particles.end(), t.begin(), t.end());
    std::sort(surface.particles.begin(), surface.particles.end());
    surface.particles.erase(std::unique(surface.particles.begin(), surface.particles.end()), surface.particles.end());
    for (auto& t : surface.triangles) {
      for (Index& i : t) {
        const auto at = std::lower_bound(surface.particles.begin(), surface.particles.end(), i);
        i = static_cast<Index>(at - surface.particles.begin());
      }
    }
    for (VecList* list : {&surface.start, &surface.end, &surface.gradient, &surface.along}) {
      list->resize(surface.particles.size());
    }
    surfaces_.push_back(std::move(surface));
  }
}

int KeptVolumes::act(TouchedParticles& touched) {
  for (std::size_t row = 0; row < surfaces_.size(); ++row) {
    if (!surfaces_[row].open && !restore(surfaces_[row], touched)) return static_cast<int>(row);
  }
  return -1;
}

bool KeptVolumes::restore(Surface& surface, TouchedParticles& touched) {
  for (std::size_t k = 0; k < surface.particles.size(); ++k) {
    const TouchedParticles::Touched& particle = touched[touched.slot(surface.particles[k])];
    surface.start[k] = particle.position;
    surface.end[k] = particle.end(touched.dt()) + particle.shift;
  }
  volume_gradient(surface.triangles, surface.start, surface.gradient);
  for (std::size_t k = 0; k < surface.particles.size(); ++k) {
    const TouchedParticles::Touched& particle = touched[touched.slot(surface.particles[k])];
    surface.gradient[k] = past_friction(surface.gradient[k], particle.rubbed);
    surface.along[k] = particle.inverse_mass * surface.gradient[k];
    for (int a = 0; a < 3; ++a) {
      if (particle.held || (particle.fixed >> a & 1) != 0) surface.along[k][a] = 0.0;
    }
  }
  const double missing = surface.volume - enclosed_volume(surface.triangles, surface.end);
  const auto s = root_of_cubic(volume_along(surface.triangles, surface.end, surface.along), missing);
  // Where nothing is free to make up for it, what a backend in single precision rounds is not a loss; nor is what is no
  // number, whose particle is found out elsewhere.
  if (!s) return !(std::abs(missing) > rounded_volume_share * surface.volume);
  for (std::size_t k = 0; k < surface.particles.size(); ++k) {
    TouchedParticles::Touched& particle = touched[touched.slot(surface.particles[k])];
    // s d is a way; over dt a velocity, times the mass an impulse.
    if (!particle.held) TouchedParticles::push(particle, *s / touched.dt() * surface.gradient[k]);
  }
  return true;
}

}  // namespace phymul
