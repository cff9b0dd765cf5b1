// SPDX-License-Identifier: MIT
#include "contact_candidates.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "model/closed_surface.h"

namespace phymul {
namespace {

/// Of a triangle's area and longest edge, squared: above it a nearest point is good to `of_nearest` of its distance.
constexpr double thin = 1e-4, of_nearest = 1e-8;

/// Kept lists, in mean edges of the surface: the least slack and the most. Where nothing touches even the most finds
/// next to nothing, as neighbours within two edges are left out.
constexpr double least_slack = 0.25, most_slack = 0.5;

/// Steps that a search is to last, and those that it must last to be worth more slack than none.
constexpr double wanted_steps = 8.0, least_steps = 2.0;

/// Searches without slack after lists were longer than that: with it they would be made in vain, at twice the cost.
constexpr int tight_searches = 16;
/// Further out nothing can be told apart: squares of lengths are no numbers any more.
constexpr double furthest_place = 1e150;  // m

}  // namespace

/// m: what may touch of one body is no nearer. What is no skin is at rest further than `skin_factor` edges from each
/// corner; from the nearest point of the triangle, which is at a right angle to the way there, by Pythagoras.
double ContactCandidates::Motion::least_apart(const Motion& triangles) const {
  if (of_cut && triangles.of_cut) return 0.0;
  const double skin = ContactSurface::skin_factor * std::max(least_edge, triangles.least_edge);
  const double at_rest = skin * skin - triangles.cover * triangles.cover;
  if (!(at_rest > 0.0)) return 0.0;
  const Vec3 most = (shift.high - triangles.shift.low).cwiseMax(triangles.shift.high - shift.low);
  return (1.0 - of_length) * std::sqrt(at_rest) - (1.0 + of_length) * most.norm();
}

void ContactCandidates::change(const ContactOptions& options) {
  if (options == options_) return;
  options_ = options;
  drop_lists();
}

void ContactCandidates::drop_lists() {
  complete_ = false;
  to_search_.clear();
  tight_searches_ = 0;
}

/// Not where a place is not finite, now or then.
bool ContactCandidates::hold(std::span<const Vec3> place, double margin) {
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
  nearer_ = (1.0 + of_length) * (high - low).norm() + of_places * (low.norm() + high.norm());
  return nearer_ <= slack_ && margin + nearer_ <= margin_ + slack_;
}

/// Where places jumped each has gone as far as the one that jumped farthest.
void ContactCandidates::see(std::span<const Vec3> place, double gone) {
  if (jumped_) {
    double farthest = 0.0;
    for (std::size_t k = 0; k < place.size(); ++k) {
      const double way = (place[k] - seen_[k]).squaredNorm();
      farthest = way > farthest ? way : farthest;  // what is new has no place before
    }
    const double left = gone - seen_gone_ - (1.0 + of_length) * std::sqrt(farthest);
    for (Kept& kept : kept_) kept.until += left;
    jumped_ = false;
  }
  seen_.assign(place.begin(), place.end());
  seen_gone_ = gone;
}

void ContactCandidates::begin(std::span<const Vec3> place, double margin) {
  complete_ = jumped_ = false;
  if (!has_all_) build_whole_trees();
  ranked_edge_ = 2.0 * surface_->longest_edge;
  ++searches_;
  margin_ = margin;
  nearer_ = 0.0;
  slack_ = std::clamp(wanted_steps * margin, least_slack * usual_edge_, most_slack * usual_edge_);
  if (slack_ < least_steps * margin || tight_searches_ > 0) slack_ = 0.0;
  if (tight_searches_ > 0) --tight_searches_;
  then_.assign(place.begin(), place.end());
  kept_.clear();
  listed_.clear();
  keeps_ = measure(place);
}

/// How far to look, and boxes around clusters and triangles. Whether all places are numbers, and no triangle is lost.
bool ContactCandidates::measure(std::span<const Vec3> place) {
  for (std::size_t k = 0; k < item_edge_.size(); ++k) item_search_[k] = search_distance(item_edge_[k]);
  for (std::size_t k = 0; k < node_edge_.size(); ++k) node_search_[k] = search_distance(node_edge_[k]);
  find_shifts(place);
  for (Cluster& cluster : clusters_) {
    cluster.box = cluster.motion.shift = {};
    for (std::size_t k = cluster.first; k < cluster.end; ++k) {
      const Vec3 &x = place[particles_.items[k]], &shift = shift_[particles_.items[k]];
      cluster.box.add(x, x);
      cluster.motion.shift.add(shift, shift);
    }
  }
  double widest = 0.0;
  for (std::size_t item = 0; item < item_box_.size(); ++item) {
    const auto triangle = static_cast<std::size_t>(triangles_.items[item]);
    Box& box = item_box_[item] = box_at(triangle, place);
    Box& shift = item_motion_[item].shift = box_at(triangle, shift_);
    const double more = box.rounding();
    for (Box* const own : {&box, &shift}) own->widen(more);
    widest = std::max(widest, (box.high - box.low).maxCoeff());
  }
  lost_ = !(widest < furthest_place);  // a runaway particle, found out elsewhere
  for (std::size_t own = 0; own < node_box_.size(); ++own) node_box_[own] = node_motion_[own].shift = {};
  triangles_.each_part_from_below([&](Index own, Index part, bool is_item) {
    const Box& box = is_item ? item_box_[part] : node_box_[part];
    const Box& shift = is_item ? item_motion_[part].shift : node_motion_[part].shift;
    node_box_[own].add(box.low, box.high);
    node_motion_[own].shift.add(shift.low, shift.high);
  });
  return !lost_ && std::ranges::all_of(place, [](const Vec3& x) { return x.allFinite(); });
}

/// Any rotation is right; that of its body makes what a particle moves besides small.
void ContactCandidates::find_shifts(std::span<const Vec3> place) {
  turns_.assign(triangles_.groups.size() - 1, {});
  const VecList& rest = surface_->rest;
  const auto each = [&](auto visit) {
    for (std::size_t k = 0; k < place.size(); ++k) visit(k, turns_[surface_->particles[k].body]);
  };
  each([&](std::size_t k, Turn& turn) {
    turn.place += place[k];
    turn.rest += rest[k];
    turn.count += 1.0;
  });
  each([&](std::size_t k, Turn& turn) {
    turn.product += (place[k] - turn.place / turn.count) * (rest[k] - turn.rest / turn.count).transpose();
  });
  for (Turn& turn : turns_) {
    if (!turn.product.allFinite()) continue;
    const Eigen::JacobiSVD<Mat3> svd(turn.product, Eigen::ComputeFullU | Eigen::ComputeFullV);
    turn.rotation = svd.matrixU() * svd.matrixV().transpose();
  }
  shift_.resize(place.size());
  each([&](std::size_t k, const Turn& turn) { shift_[k] = place[k] - turn.rotation * rest[k]; });
}

ContactCandidates::Motion ContactCandidates::motion_of(std::size_t particle) const {
  const ContactSurface::Particle& own = surface_->particles[particle];
  return {.shift = {shift_[particle], shift_[particle]}, .least_edge = own.edge, .of_cut = own.of_cut};
}

/// Beyond this, m, what has these edges, on the longer side, touches nothing in any step for which the search holds.
double ContactCandidates::search_distance(double edge) const {
  const double skins = options_.margin > 0.0 ? 2.0 * options_.margin : 2.0 * ContactSurface::usual_skin * edge;
  return (1.0 + of_length) * (std::max(margin_ + skins, ContactSurface::depth_factor * edge) + slack_);
}

/// Calls visit(item) for the triangles of a body that may be within `distance_limit` of a box, or what their own edges
/// say. `own`: of the particles in the box where it is their body; null: another one.
template <class Visit>
void ContactCandidates::visit_items(const Box& box, const Motion* own, std::size_t body, double distance_limit,
                                    Visit visit) const {
  const auto near = [&](const Box& other, const Motion& motion, double by_edge) {
    const double far = std::max(distance_limit, by_edge);
    return !(box.squared_distance(other) > far * far) && (own == nullptr || !(own->least_apart(motion) > far));
  };
  const Index end = triangles_.groups[body + 1];
  for (Index at = triangles_.groups[body]; at < end;) {
    const BoxTree::Node& node = triangles_.nodes[at];
    if (!near(node_box_[at], node_motion_[at], node_search_[at])) {
      at = node.next;
      continue;
    }
    if (node.is_leaf) {
      for (Index item = node.first; item < node.end; ++item) {
        if (near(item_box_[item], item_motion_[item], item_search_[item])) visit(item);
      }
    }
    ++at;
  }
}

bool ContactCandidates::meet(const Cluster& cluster, std::size_t body) {
  met_.clear();
  const bool itself = cluster.body == static_cast<Index>(body);
  if (lost_ || (!options_.self && itself)) return false;
  visit_items(cluster.box, itself ? &cluster.motion : nullptr, body, search_distance(cluster.edge),
              [&](Index item) { met_.push_back(item); });
  return !met_.empty();
}

/// Infinite where it is not within `distance_limit`, m. The box of a triangle alone says so where that is so thin that
/// rounding may put the nearest point anywhere on it.
ContactCandidates::Distance ContactCandidates::distance_to(const Vec3& x, std::size_t triangle, const Box& box,
                                                           double distance_limit) const {
  const double of_box = box.squared_distance({x, x});
  if (of_box > distance_limit * distance_limit) return {};
  const auto& corner = surface_->triangles[triangle].corner;
  const Vec3 &a = then_[corner[0]], &b = then_[corner[1]], &c = then_[corner[2]];
  const double longest = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  if (!((b - a).cross(c - a).squaredNorm() > thin * longest * longest)) {
    return {(1.0 - of_nearest) * std::sqrt(of_box), HUGE_VAL};
  }
  const Vec3 share = closest_point(x, a, b, c);
  const double off = (x - (share[0] * a + share[1] * b + share[2] * c)).norm();
  if (off > (1.0 + of_nearest) * distance_limit) return {};
  return {(1.0 - of_nearest) * off, (1.0 + of_nearest) * off};
}

/// Nothing where all triangles are too far away by their own edges. Else those too that may rank before one that is
/// not: longer edges let that out further. What is further than the nearest, which is not deep, by more than both may
/// move, ranks behind that while the search holds.
bool ContactCandidates::gather(std::size_t particle, const Vec3& x, std::size_t body) {
  const ContactSurface::Particle& own = surface_->particles[particle];
  const Box here{x, x};
  const double usual = search_distance(own.edge);
  const auto triangle_of = [&](Index item) -> const ContactSurface::Triangle& {
    return surface_->triangles[triangles_.items[item]];
  };
  const double facing = (1.0 + of_length) * ContactSurface::facing_share * ranked_edge_;
  double furthest = 0.0, nearest = HUGE_VAL;
  for (const Index item : met_) {
    const double distance_limit = std::max(item_search_[item], usual), off = here.squared_distance(item_box_[item]);
    const bool may_reach = distance_limit > furthest, may_be_nearest = off < nearest * nearest;
    if (!(may_reach || may_be_nearest) || off > distance_limit * distance_limit) continue;
    const ContactSurface::Triangle& triangle = triangle_of(item);
    if (surface_->is_own_skin(own, particle, triangle)) continue;
    const Distance found = distance_to(x, triangles_.items[item], item_box_[item], distance_limit);
    if (found.least == HUGE_VAL) continue;
    furthest = std::max(furthest, distance_limit);
    const double shallow = ContactSurface::depth_factor * std::max(triangle.edge, own.edge);
    if (found.most + slack_ < shallow) nearest = std::min(nearest, found.most);
  }
  if (furthest == 0.0) return false;
  furthest = std::min(furthest, (1.0 + of_length) * (nearest + 2.0 * slack_)) + facing;
  near_.clear();
  const auto add = [&](Index item) {
    if (surface_->is_own_skin(own, particle, triangle_of(item))) return;
    const double least = distance_to(x, triangles_.items[item], item_box_[item], furthest).least;
    if (least != HUGE_VAL) near_.push_back({triangles_.items[item], least});
  };
  if (furthest <= usual) {  // all are met
    for (const Index item : met_) {
      if (!(here.squared_distance(item_box_[item]) > furthest * furthest)) add(item);
    }
  } else {
    const Motion motion = motion_of(particle);
    visit_items(here, own.body == static_cast<Index>(body) ? &motion : nullptr, body, furthest, add);
  }
  std::ranges::sort(near_, {}, &Near::least);
  return true;
}

std::span<const ContactCandidates::Near> ContactCandidates::keep(std::size_t particle) {
  if (!keeps_) return near_;
  if (listed_.size() + near_.size() > most_each * then_.size()) {
    keeps_ = false;
    if (slack_ > 0.0) tight_searches_ = tight_searches;
    return near_;
  }
  kept_.push_back({.particle = particle, .first = listed_.size(), .count = near_.size()});
  listed_.insert(listed_.end(), near_.begin(), near_.end());
  return near_;
}

}  // namespace phymul
