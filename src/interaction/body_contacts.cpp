// SPDX-License-Identifier: MIT
#include "body_contacts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "model/closed_surface.h"

namespace phymul {
namespace {

/// Of what is free of a particle along a direction: 1/kg.
double inverse_mass(const TouchedParticles::Touched& particle, const Vec3& along) {
  if (particle.held) return 0.0;
  double share = 0.0;
  for (int a = 0; a < 3; ++a) {
    if ((particle.fixed >> a & 1) == 0) share += along[a] * along[a];
  }
  return particle.inverse_mass * share;
}

void shift(TouchedParticles::Touched& particle, Vec3 by) {
  if (particle.held) return;
  for (int axis = 0; axis < 3; ++axis) {
    if ((particle.fixed >> axis & 1) != 0) by[axis] = 0.0;
  }
  particle.shift += by;
}

/// Whether what lies inside is too far from a side to have got in there. Edges are local: a coarser body's elsewhere
/// say nothing of this one.
bool is_deep(double distance, const ContactSurface::Triangle& triangle, const ContactSurface::Particle& own) {
  return distance > ContactSurface::depth_factor * std::max(triangle.edge, own.edge);
}

}  // namespace

void BodyContacts::follow(const Scene& scene, FollowedSurface& surface) {
  contacts_.clear();
  forget();
  if (!scene.contacts()) {
    surface_.reset();
    return;
  }
  options_ = *scene.contacts();
  const std::shared_ptr<const ContactSurface> now = surface.of(scene);
  if (surface_ == now) {
    candidates_.change(options_);
    return;
  }
  const auto before = std::exchange(surface_, nullptr);  // of no use half made
  candidates_.follow(*now, options_, before.get());
  find_rows(*now);
  place_.resize(now->particles.size());
  velocity_.resize(now->particles.size());
  surface_ = now;
}

void BodyContacts::find_rows(const ContactSurface& surface) {
  rows_.clear();
  means_.clear();
  for (const ContactSurface::Particle& particle : surface.particles) rows_.push_back(particle.row);
  if (std::ranges::find(rows_, -1) == rows_.end()) return;
  rows_.clear();
  std::vector<Index> known(surface.body_of.size(), -1);
  for (const ContactSurface::Particle& particle : surface.particles) {
    auto& of = means_.emplace_back(particle.at.particles);
    for (Index& row : of) {
      if (row < 0) continue;
      if (known[row] < 0) {
        known[row] = static_cast<Index>(rows_.size());
        rows_.push_back(row);
      }
      row = known[row];
    }
  }
  row_place_.resize(rows_.size());
  row_velocity_.resize(rows_.size());
}

/// place_ and velocity_.
void BodyContacts::fetch(const TouchedParticles& touched) {
  if (means_.empty()) {
    touched.fetch(rows_, place_, velocity_);
    return;
  }
  touched.fetch(rows_, row_place_, row_velocity_);
  for (std::size_t k = 0; k < means_.size(); ++k) {
    place_[k].setZero();
    velocity_[k].setZero();
    for (std::size_t v = 0; v < 4 && means_[k][v] >= 0; ++v) {
      const double weight = surface_->particles[k].at.weights[v];
      place_[k] += weight * row_place_[means_[k][v]];
      velocity_[k] += weight * row_velocity_[means_[k][v]];
    }
  }
}

/// Two places approach by at most twice `going`, and the margin of find(), 2 dt |v - mean|, is at most four times it.
bool BodyContacts::none_near(double going, double gone) const {
  return candidates_.none_within(4.0 * going, gone, gone_);
}

/// Particles whose gap to a triangle is less than twice what the fastest one moves against the mean.
void BodyContacts::find(TouchedParticles& touched) {
  const double dt = touched.dt();
  if (std::isnan(gone_)) candidates_.jump();
  gone_ = touched.step().gone();
  fetch(touched);
  Vec3 mean = Vec3::Zero();
  for (const Vec3& velocity : velocity_) mean += velocity;
  mean /= static_cast<double>(place_.size());
  double fastest = 0.0;
  for (const Vec3& velocity : velocity_) fastest = std::max(fastest, (velocity - mean).squaredNorm());
  // Beyond a few edges a step is a failure, which the solver reports: the search must not outgrow the body.
  const double margin = std::min(2.0 * dt * std::sqrt(fastest), 4.0 * surface_->longest_edge);
  contacts_.clear();
  candidates_.each(place_, margin, gone_, [&](const ContactCandidates::List& list) {
    const auto found = nearest(list);
    if (found) keep(*found, margin);
    return apart(list, found, margin);
  });
  // Not in the lists' order, which depends on when they were made.
  std::ranges::sort(contacts_, {}, [&](const Contact& contact) {
    return std::pair(contact.particle, surface_->triangles[contact.triangle].body);
  });
  shares_.clear();
  for (Contact& contact : contacts_) share_out(contact, touched);
}

void BodyContacts::share_out(Contact& contact, TouchedParticles& touched) {
  contact.first = shares_.size();
  const auto add = [&](std::size_t k, double factor) {
    const ContactSurface::Particle& own = surface_->particles[k];
    for (std::size_t v = 0; v < 4 && own.at.particles[v] >= 0; ++v) {
      const std::size_t slot = touched.slot(own.at.particles[v]);
      const auto known = std::find_if(shares_.begin() + static_cast<std::ptrdiff_t>(contact.first), shares_.end(),
                                      [&](const Share& share) { return share.slot == slot; });
      if (known == shares_.end()) {
        shares_.push_back({slot, factor * own.shares[v]});
      } else {
        known->weight += factor * own.shares[v];
      }
    }
  };
  add(contact.particle, 1.0);
  const auto& corner = surface_->triangles[contact.triangle].corner;
  for (int c = 0; c < 3; ++c) add(static_cast<std::size_t>(corner[c]), -contact.share[c]);
  contact.end = shares_.size();
  double unbound = 0.0;
  for (const auto& [slot, weight] : shares(contact)) {
    contact.mobility += weight * weight * inverse_mass(touched[slot], contact.normal);
    unbound += weight * weight * touched[slot].inverse_mass;
  }
  if (contact.mobility < ContactSurface::least_mobility * unbound) contact.mobility = 0.0;
}

/// The triangle of a body that ranks first: by distance, and on an edge that two share, by how much it faces the
/// particle, as that says on which side the particle is. A number of each triangle's own, so that the order they come
/// in does not matter.
std::optional<BodyContacts::Nearest> BodyContacts::nearest(const ContactCandidates::List& list) const {
  const double facing = 1.01 * ContactSurface::facing_share * surface_->longest_edge;  // and what rounds
  std::optional<Nearest> best;
  for (const auto& [t, least] : list.triangles) {
    if (best && least - list.nearer > best->rank + facing) break;
    const auto found = look(list.particle, static_cast<std::size_t>(t));
    if (!found) continue;
    if (!best || found->rank < best->rank || (found->rank == best->rank && found->triangle < best->triangle)) {
      best = found;
    }
  }
  if (best && best->inside && is_before_corner(list, *best)) {
    best->inside = false;
    best->way = -best->way;
  }
  return best;
}

/// m: by no less a particle and a body must come nearer to each other before keep() keeps a contact of them. Whichever
/// triangle ranks first by then: a gap is open, and the particle is in front of it, or too far away to have got in
/// there.
double BodyContacts::apart(const ContactCandidates::List& list, const std::optional<Nearest>& found,
                           double margin) const {
  if (found && found->inside) return 0.0;
  const ContactSurface::Particle& own = surface_->particles[list.particle];
  const auto edge_with = [&](const ContactCandidates::Near& near) {
    return std::max(own.edge, surface_->triangles[near.triangle].edge);
  };
  double edge = own.edge;
  for (const auto& near : list.triangles) edge = std::max(edge, edge_with(near));
  const bool of_another = found && own.body != surface_->triangles[found->triangle].body;
  const double skins = options_.margin > 0.0 ? 2.0 * options_.margin : 2.0 * ContactSurface::usual_skin * edge;
  double gap = (of_another ? (1.0 - 1e-9) * found->rank : list.triangles.front().least - list.nearer) - skins;
  for (const auto& near : list.triangles) {
    if (gap <= margin) break;
    if (!surface_->triangles[near.triangle].has_inside) continue;
    const double beyond = near.least - list.nearer - ContactSurface::depth_factor * edge_with(near);
    if (beyond < gap) gap = std::min(gap, std::max(beyond, in_front(list.particle, near.triangle)));
  }
  return gap;
}

/// m: by no less a particle that is before a triangle and its corners must come nearer to each other before it is
/// behind it. The volume f = N (x - a), N twice the area along the normal, of corners and a particle that go by d each
/// changes by up to 2 d |N| + 2 d (e + f + 2 d) (|x - a| + 2 d), with sides e and f.
double BodyContacts::in_front(std::size_t particle, std::size_t triangle) const {
  const auto& corner = surface_->triangles[triangle].corner;
  const Vec3& a = place_[corner[0]];
  const Vec3 e = place_[corner[1]] - a, f = place_[corner[2]] - a, to = place_[particle] - a, twice = e.cross(f);
  const double volume = (1.0 - 1e-9) * twice.dot(to), most = 0.25 * surface_->longest_edge;  // m, of d
  const double rate = 2.0 * (twice.norm() + (e.norm() + f.norm() + 2.0 * most) * (to.norm() + 2.0 * most));
  return volume > 0.0 ? 2.0 * std::min(most, volume / rate) : 0.0;
}

/// Whether a particle that is behind a triangle, and nearest to a corner or an edge of it, is outside all the same, as
/// by the tip of a sharp piece: by the normals of all triangles there, weighted by their angles (see ClosestTriangle).
bool BodyContacts::is_before_corner(const ContactCandidates::List& list, const Nearest& found) const {
  std::array<Index, 3> at{};
  std::size_t count = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (found.share[static_cast<Eigen::Index>(k)] > 0.0) at[count++] = surface_->triangles[found.triangle].corner[k];
  }
  if (count == 3) return false;
  Vec3 normal = Vec3::Zero();
  for (const auto& near : list.triangles) {
    const auto& corner = surface_->triangles[static_cast<std::size_t>(near.triangle)].corner;
    const auto own = std::ranges::find(corner, at[0]);
    if (own == corner.end() || (count == 2 && std::ranges::find(corner, at[1]) == corner.end())) continue;
    const auto first = static_cast<std::size_t>(own - corner.begin());
    const Vec3& tip = place_[corner[first]];
    const Vec3 e = place_[corner[(first + 1) % 3]] - tip, f = place_[corner[(first + 2) % 3]] - tip, area = e.cross(f);
    const double twice = area.norm();
    if (twice > 0.0) normal += (count == 2 ? 1.0 : std::atan2(twice, e.dot(f))) / twice * area;
  }
  return normal.dot(found.way) < 0.0;
}

/// Nothing where the triangle leads nowhere.
std::optional<BodyContacts::Nearest> BodyContacts::look(std::size_t particle, std::size_t t) const {
  const ContactSurface::Particle& own = surface_->particles[particle];
  const ContactSurface::Triangle& triangle = surface_->triangles[t];
  const Vec3 &a = place_[triangle.corner[0]], &b = place_[triangle.corner[1]], &c = place_[triangle.corner[2]];
  Nearest found;
  found.particle = particle;
  found.triangle = t;
  found.share = closest_point(place_[particle], a, b, c);
  found.way = place_[particle] - (found.share[0] * a + found.share[1] * b + found.share[2] * c);
  found.distance = found.way.norm();
  if (!std::isfinite(found.distance)) return {};
  const Vec3 area = (b - a).cross(c - a);
  const double across =
      area.norm() > 0.0 && found.distance > 0.0 ? area.dot(found.way) / (area.norm() * found.distance) : 0.0;
  found.rank = found.distance - ContactSurface::facing_share * surface_->longest_edge * std::abs(across);
  // What cuts have parted lies in the planes of triangles, beside them: there rounding has the sign.
  const double beside = surface_->are_cut(own, triangle) ? 1e-6 : 0.0;
  found.inside = triangle.has_inside && across < -beside;
  // Far inside its own body a particle has not got in anywhere: the triangle is of its other side.
  if (own.body == triangle.body && found.inside && is_deep(found.distance, triangle, own)) return {};
  if (found.distance > 0.0) {
    found.way *= (found.inside ? -1.0 : 1.0) / found.distance;
  } else if (area.norm() > 0.0) {
    found.way = area / area.norm();
  } else {
    return {};
  }
  return found;
}

void BodyContacts::keep(const Nearest& found, double margin) {
  const ContactSurface::Particle& own = surface_->particles[found.particle];
  const ContactSurface::Triangle& triangle = surface_->triangles[found.triangle];
  if (found.inside && is_deep(found.distance, triangle, own)) return;
  const double gap = (found.inside ? -found.distance : found.distance) -
                     surface_->skins(own, found.particle, triangle, options_.margin);
  if (gap > margin) return;
  Contact contact;
  contact.particle = found.particle;
  contact.triangle = found.triangle;
  contact.share = found.share;
  contact.normal = found.way;
  contact.gap = gap;
  contact.edge = std::max(triangle.edge, own.edge);
  contacts_.push_back(contact);
}

void BodyContacts::press(Contact& contact, TouchedParticles& touched) const {
  const auto mobility = [&](const Vec3& along) {
    double sum = 0.0;
    for (const auto& [slot, weight] : shares(contact)) sum += weight * weight * inverse_mass(touched[slot], along);
    return sum;
  };
  const auto relative = [&] {
    Vec3 v = Vec3::Zero();
    for (const auto& [slot, weight] : shares(contact)) v += weight * touched[slot].velocity;
    return v;
  };
  const auto give = [&](const Vec3& impulse) {
    for (const auto& [slot, weight] : shares(contact)) TouchedParticles::pull(touched[slot], weight * impulse);
  };

  if (contact.mobility == 0.0) return;
  const double lacking = -std::max(contact.gap, 0.0) / touched.dt() - contact.normal.dot(relative());
  const double pressed = std::max(contact.pressed + lacking / contact.mobility, 0.0);
  if (pressed != contact.pressed) give((pressed - contact.pressed) * contact.normal);
  contact.pressed = pressed;
  if (options_.friction == 0.0 || (pressed == 0.0 && contact.rubbed == Vec3::Zero())) return;

  const Vec3 after = relative(), sliding = after - contact.normal.dot(after) * contact.normal;
  const double speed = sliding.norm();
  Vec3 rubbed = contact.rubbed;
  if (speed > 0.0) {
    const double ease = mobility(sliding / speed);
    if (ease > 0.0) rubbed -= sliding / ease;
  }
  const double most = options_.friction * pressed, size = rubbed.norm();
  if (size > most) rubbed *= most / size;
  give(rubbed - contact.rubbed);
  contact.rubbed = rubbed;
}

void BodyContacts::part(const Contact& contact, TouchedParticles& touched) const {
  if (contact.gap >= 0.0 || contact.mobility == 0.0) return;
  const double way =
      std::min(-ContactSurface::parted_share * contact.gap, ContactSurface::largest_parting * contact.edge) /
      contact.mobility;
  for (const auto& [slot, weight] : shares(contact)) {
    shift(touched[slot], way * weight * touched[slot].inverse_mass * contact.normal);
  }
}

void BodyContacts::act(TouchedParticles& touched) {
  if (none_near(touched.going(), touched.step().gone())) return;
  find(touched);
  for (int round = 0; round < options_.rounds; ++round) {
    for (Contact& contact : contacts_) press(contact, touched);
  }
  for (const Contact& contact : contacts_) part(contact, touched);
}

}  // namespace phymul
