// SPDX-License-Identifier: MIT
#include "contact_candidates.h"

#include <algorithm>
#include <cmath>

namespace phymul::cpu {
namespace {

/// Of a length: more than rounding makes of it, and of the coordinates between which it is measured.
constexpr double of_length = 1e-9, of_places = 1e-14;

/// Kept lists, in mean edges of the surface: the least slack and the most. Where nothing touches even the most finds
/// next to nothing, as neighbours within two edges are left out.
constexpr double least_slack = 0.25, most_slack = 0.75;

/// Steps that a search is to last, and those that it must last to be worth more slack than none.
constexpr double wanted_steps = 8.0, least_steps = 2.0;

/// Entries a particle of a list that is kept: a heap of bodies that lie in each other has as many as it has pairs.
constexpr std::size_t most_each = 64;

/// Further out nothing can be told apart: squares of lengths are no numbers any more.
constexpr double furthest_place = 1e150;  // m

double squared_distance(const Vec3& x, const Vec3& low, const Vec3& high) {
  double sum = 0.0;
  for (int a = 0; a < 3; ++a) {
    const double off = std::max(std::max(low[a] - x[a], x[a] - high[a]), 0.0);
    sum += off * off;
  }
  return sum;
}

}  // namespace

void ContactCandidates::follow(const ContactSurface& surface, const ContactOptions& options) {
  surface_ = &surface;
  options_ = options;
  Index bodies = 0;
  mean_edge_ = 0.0;
  for (const ContactSurface::Particle& particle : surface.particles) {
    bodies = std::max(bodies, particle.body + 1);
    mean_edge_ += particle.edge / static_cast<double>(surface.particles.size());
  }
  const std::size_t triangles = surface.triangles.size();
  around_.resize(static_cast<std::size_t>(bodies));
  furthest_.assign(static_cast<std::size_t>(bodies), 0.0);
  box_.resize(triangles);
  meant_.reserve(triangles);
  middle_.reserve(triangles);
  grid_.reserve(triangles);
  then_.reserve(surface.particles.size());
  kept_.reserve(surface.particles.size());
  most_ = most_each * surface.particles.size();
  complete_ = false;
  searches_ = 0;
}

/// Neither where a place is not finite, now or then.
bool ContactCandidates::hold(std::span<const Vec3> place, double margin) const {
  if (!complete_) return false;
  Vec3 low = Vec3::Constant(HUGE_VAL), high = Vec3::Constant(-HUGE_VAL), sum = Vec3::Zero();
  for (std::size_t k = 0; k < place.size(); ++k) {
    for (int a = 0; a < 3; ++a) {
      const double way = place[k][a] - then_[k][a];
      sum[a] += way;  // comparing leaves out what is no number
      low[a] = way < low[a] ? way : low[a];
      high[a] = way > high[a] ? way : high[a];
    }
  }
  if (!sum.allFinite()) return false;
  const double diagonal = (1.0 + of_length) * (high - low).norm() + of_places * (low.norm() + high.norm());
  return diagonal <= slack_ && margin + diagonal <= margin_ + slack_;
}

/// `margin` bounds how much two particles come nearer in a step.
void ContactCandidates::begin(std::span<const Vec3> place, double margin) {
  ++searches_;
  margin_ = margin;
  slack_ = std::clamp(wanted_steps * margin, least_slack * mean_edge_, most_slack * mean_edge_);
  if (slack_ < least_steps * margin) slack_ = 0.0;
  const double longest = surface_->longest_edge;
  const double skins = options_.skin > 0.0 ? 2.0 * options_.skin : 2.0 * ContactSurface::usual_skin * longest;
  reach_ = std::max(margin + skins, ContactSurface::depth_factor * longest) + ContactSurface::facing_share * longest;
  reach_ = (1.0 + of_length) * (reach_ + slack_);
  then_.assign(place.begin(), place.end());
  kept_.clear();
  listed_.clear();
  complete_ = true;
  measure(place);
}

/// Puts the triangles that something may touch into the grid.
void ContactCandidates::measure(std::span<const Vec3> place) {
  std::ranges::fill(around_, Box{Vec3::Constant(HUGE_VAL), Vec3::Constant(-HUGE_VAL)});
  for (std::size_t k = 0; k < place.size(); ++k) {
    Box& box = around_[surface_->particles[k].body];
    box.low = box.low.cwiseMin(place[k]);
    box.high = box.high.cwiseMax(place[k]);
    if (!place[k].allFinite()) complete_ = false;
  }
  double widest = 0.0;
  for (std::size_t t = 0; t < box_.size(); ++t) {
    const auto& corner = surface_->triangles[t].corner;
    const Vec3 &a = place[corner[0]], &b = place[corner[1]], &c = place[corner[2]];
    Box& box = box_[t];
    box.low = a.cwiseMin(b).cwiseMin(c);
    box.high = a.cwiseMax(b).cwiseMax(c);
    const double more = of_places * std::max(box.low.cwiseAbs().maxCoeff(), box.high.cwiseAbs().maxCoeff());
    box.low.array() -= more;
    box.high.array() += more;
    widest = std::max(widest, (box.high - box.low).maxCoeff());
  }
  meant_.clear();
  middle_.clear();
  if (!(widest < furthest_place)) {  // a runaway particle, found out elsewhere
    complete_ = false;
    return;
  }
  for (std::size_t t = 0; t < box_.size(); ++t) {
    if (!options_.self && !meets_another(surface_->triangles[t].body, box_[t])) continue;
    meant_.push_back(static_cast<Index>(t));
    middle_.push_back(0.5 * (box_[t].low + box_[t].high));
  }
  grid_.build(middle_, (1.0 + of_length) * (0.5 * widest + reach_));
}

/// Whether a box is within reach of what lies around another body.
bool ContactCandidates::meets_another(Index body, const Box& box) const {
  for (std::size_t other = 0; other < around_.size(); ++other) {
    if (static_cast<Index>(other) == body) continue;
    const Box& around = around_[other];
    if ((box.high.array() >= around.low.array() - reach_).all() &&
        (box.low.array() <= around.high.array() + reach_).all())
      return true;
  }
  return false;
}

/// Beyond this, m, a triangle is no contact of the particle, in any step for which the search holds.
double ContactCandidates::reach_of(const ContactSurface::Particle& own,
                                   const ContactSurface::Triangle& triangle) const {
  const double skins =
      options_.skin > 0.0 ? 2.0 * options_.skin : ContactSurface::usual_skin * (triangle.edge + own.edge);
  return std::max(margin_ + skins, ContactSurface::depth_factor * std::max(triangle.edge, own.edge)) + slack_;
}

/// A body whose triangles are all too far away by their own edges is left out. Of one that is not, those that may rank
/// before what the particle touches count too, which another edge may have let out.
void ContactCandidates::gather(std::size_t particle, const Vec3& x) {
  near_.clear();
  const ContactSurface::Particle& own = surface_->particles[particle];
  if (!options_.self && !meets_another(own.body, {x, x})) return;
  const auto is_listed = [&](Index t, double far) {
    if (squared_distance(x, box_[t].low, box_[t].high) > far * far) return false;
    const ContactSurface::Triangle& triangle = surface_->triangles[t];
    if (own.body == triangle.body && !options_.self) return false;
    return !surface_->is_own_skin(own, particle, triangle);
  };
  grid_.each_near(x, [&](std::size_t entry) {
    const Index t = meant_[entry];
    const ContactSurface::Triangle& triangle = surface_->triangles[t];
    const double far = (1.0 + of_length) * reach_of(own, triangle);
    if (far <= furthest_[triangle.body] || !is_listed(t, far)) return;
    if (furthest_[triangle.body] == 0.0) met_.push_back(triangle.body);
    furthest_[triangle.body] = far;
  });
  if (met_.empty()) return;
  const double ranks = (1.0 + of_length) * ContactSurface::facing_share * surface_->longest_edge;
  grid_.each_near(x, [&](std::size_t entry) {
    const Index t = meant_[entry];
    const double far = furthest_[surface_->triangles[t].body];
    if (far > 0.0 && is_listed(t, far + ranks)) near_.push_back(t);
  });
  for (const Index body : met_) furthest_[body] = 0.0;
  met_.clear();
}

void ContactCandidates::keep(std::size_t particle) {
  if (!complete_) return;
  if (listed_.size() + near_.size() > most_) {
    complete_ = false;
    return;
  }
  kept_.push_back({particle, listed_.size(), near_.size()});
  listed_.insert(listed_.end(), near_.begin(), near_.end());
}

}  // namespace phymul::cpu
