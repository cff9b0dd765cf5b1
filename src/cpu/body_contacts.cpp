// SPDX-License-Identifier: MIT
#include "body_contacts.h"

#include <phymul/bodies.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "../surface.h"

namespace phymul::cpu {
namespace {

constexpr double skin_factor = 2.0;  // of the sum of radii, at rest
/// Of an overlap, and of the sum of radii, in a step.
constexpr double parted_share = 0.2, largest_parting = 0.02;

/// Half of the mean length of the surface's edges around each particle; 0 for particles inside. A model without facets
/// is all surface, its neighbours stand for edges.
std::vector<double> surface_radii(const Model& model) {
  std::vector<double> sum(model.rest.size(), 0.0);
  std::vector<int> count(model.rest.size(), 0);
  const auto edge = [&](Index a, Index b) {
    const double length = (model.rest[a] - model.rest[b]).norm();
    for (const Index i : {a, b}) {
      sum[i] += length;
      ++count[i];
    }
  };
  const std::vector<Facet> facets = surface_facets(model, std::vector<char>(model.rest.size(), 1));
  for (const Facet& facet : facets) {
    const std::vector<Index>& ring = facet.particles;
    for (std::size_t k = 0; k < ring.size(); ++k) edge(ring[k], ring[(k + 1) % ring.size()]);
  }
  if (facets.empty()) {
    for (Index i = 0; i < model.neighbours.rows(); ++i) {
      for (const Index* j = model.neighbours.begin(i); j != model.neighbours.end(i); ++j) edge(i, *j);
    }
  }
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = count[i] > 0 ? 0.5 * sum[i] / count[i] : 0.0;
  return sum;
}

/// Of what is free of a particle along a direction: 1/kg.
double inverse_mass(const TouchedParticles::Touched& particle, const Vec3& along) {
  if (particle.held) return 0.0;
  double share = 0.0;
  for (int a = 0; a < 3; ++a) {
    if ((particle.fixed >> a & 1) == 0) share += along[a] * along[a];
  }
  return particle.inverse_mass * share;
}

void push_apart(TouchedParticles::Touched& a, TouchedParticles::Touched& b, const Vec3& impulse) {
  if (!a.held) TouchedParticles::push(a, impulse);
  if (!b.held) TouchedParticles::push(b, -impulse);
}

}  // namespace

void BodyContacts::follow(const Scene& scene) {
  balls_.clear();
  pairs_.clear();
  if (!scene.contacts()) return;
  options_ = *scene.contacts();
  const Model& model = scene.model();
  rest_ = &model.rest;
  std::vector<Index> body_of(model.rest.size(), -1);
  const std::vector<ConnectedBody> bodies = connected_bodies(model);
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    for (const Index i : bodies[b].particles) body_of[i] = static_cast<Index>(b);
  }
  const std::vector<double> radii = surface_radii(model);
  largest_radius_ = 0.0;
  for (Index i = 0; i < model.particle_count(); ++i) {
    if (radii[i] == 0.0) continue;
    balls_.push_back({i, body_of[i], options_.radius > 0.0 ? options_.radius : radii[i]});
    largest_radius_ = std::max(largest_radius_, balls_.back().radius);
  }
  place_.resize(balls_.size());
  velocity_.resize(balls_.size());
}

bool BodyContacts::skin(const Ball& a, const Ball& b) const {
  if (a.body != b.body) return false;
  if (!options_.self) return true;
  const double apart = ((*rest_)[a.particle] - (*rest_)[b.particle]).norm();
  return apart <= skin_factor * (a.radius + b.radius);
}

/// Pairs that may meet in this step: those whose gap is less than twice what the fastest ball moves against the mean.
void BodyContacts::find_pairs(TouchedParticles& touched) {
  const double dt = touched.dt();
  Vec3 mean = Vec3::Zero();
  for (std::size_t k = 0; k < balls_.size(); ++k) {
    place_[k] = touched.step().position(balls_[k].particle);
    velocity_[k] = touched.step().free_velocity(balls_[k].particle);
    mean += velocity_[k] / static_cast<double>(balls_.size());
  }
  double fastest = 0.0;
  for (const Vec3& v : velocity_) fastest = std::max(fastest, (v - mean).squaredNorm());
  // Beyond a few diameters a step is a failure, which the solver reports: the search must not outgrow the body.
  const double margin = std::min(2.0 * dt * std::sqrt(fastest), 4.0 * largest_radius_);
  grid_.build(place_, 2.0 * largest_radius_ + margin);
  pairs_.clear();
  grid_.each_pair([&](std::size_t a, std::size_t b) {
    const Vec3 between = place_[a] - place_[b];
    const double reach = balls_[a].radius + balls_[b].radius, near = reach + margin;
    const double squared = between.squaredNorm();
    if (squared > near * near || squared == 0.0 || skin(balls_[a], balls_[b])) return;
    const double distance = std::sqrt(squared);
    pairs_.push_back({touched.slot(balls_[a].particle), touched.slot(balls_[b].particle), between / distance,
                      distance - reach, reach, 0.0, Vec3::Zero()});
  });
}

void BodyContacts::press(Pair& pair, TouchedParticles& touched) const {
  TouchedParticles::Touched &a = touched[pair.a], &b = touched[pair.b];
  const double mobility = inverse_mass(a, pair.normal) + inverse_mass(b, pair.normal);
  if (mobility == 0.0) return;
  const Vec3 relative = a.velocity - b.velocity;
  const double lacking = -std::max(pair.gap, 0.0) / touched.dt() - pair.normal.dot(relative);
  const double pressed = std::max(pair.pressed + lacking / mobility, 0.0);
  push_apart(a, b, (pressed - pair.pressed) * pair.normal);
  pair.pressed = pressed;
  if (options_.friction == 0.0) return;

  const Vec3 after = a.velocity - b.velocity, sliding = after - pair.normal.dot(after) * pair.normal;
  const double speed = sliding.norm();
  if (speed == 0.0 && pair.rubbed == Vec3::Zero()) return;
  const Vec3 along = speed > 0.0 ? Vec3(sliding / speed) : Vec3(Vec3::Zero());
  const double ease = inverse_mass(a, along) + inverse_mass(b, along);
  Vec3 rubbed = pair.rubbed;
  if (ease > 0.0) rubbed -= speed / ease * along;
  const double most = options_.friction * pair.pressed, size = rubbed.norm();
  if (size > most) rubbed *= most / size;
  push_apart(a, b, rubbed - pair.rubbed);
  pair.rubbed = rubbed;
}

void BodyContacts::part(const Pair& pair, TouchedParticles& touched) const {
  if (pair.gap >= 0.0) return;
  TouchedParticles::Touched &a = touched[pair.a], &b = touched[pair.b];
  const double mobility = inverse_mass(a, pair.normal) + inverse_mass(b, pair.normal);
  if (mobility == 0.0) return;
  const double way = std::min(-parted_share * pair.gap, largest_parting * pair.reach) / mobility;
  for (const auto& [particle, sign] : {std::pair{&a, 1.0}, std::pair{&b, -1.0}}) {
    if (particle->held) continue;
    Vec3 by = sign * way * particle->inverse_mass * pair.normal;
    for (int axis = 0; axis < 3; ++axis) {
      if ((particle->fixed >> axis & 1) != 0) by[axis] = 0.0;
    }
    particle->shift += by;
  }
}

void BodyContacts::act(TouchedParticles& touched) {
  find_pairs(touched);
  for (int round = 0; round < options_.rounds; ++round) {
    for (Pair& pair : pairs_) press(pair, touched);
  }
  for (const Pair& pair : pairs_) part(pair, touched);
}

}  // namespace phymul::cpu
