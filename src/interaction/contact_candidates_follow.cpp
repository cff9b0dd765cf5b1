// SPDX-License-Identifier: MIT
//
// What candidates of contacts take over of a surface, and which lists they keep of the one before.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "contact_candidates.h"

namespace phymul {
namespace {

/// Beside a body of far longer edges slack goes by those of the finer one, or its particles would have lists of the
/// coarse one from afar.
constexpr double most_coarse = 2.0;

/// m: the mean edge of all particles, but no more than twice that of the finest body.
double edge_for_slack(const ContactSurface& surface) {
  std::vector<double> sum(surface.bodies, 0.0), count(surface.bodies, 0.0);
  double mean = 0.0;
  for (const ContactSurface::Particle& particle : surface.particles) {
    sum[particle.body] += particle.edge;
    count[particle.body] += 1.0;
    mean += particle.edge / static_cast<double>(surface.particles.size());
  }
  for (Index b = 0; b < surface.bodies; ++b) {
    if (count[b] > 0.0) mean = std::min(mean, most_coarse * sum[b] / count[b]);
  }
  return mean;
}

/// Pairs of a particle and a new triangle: where more were to be looked at, a whole search costs less.
constexpr std::size_t most_pairs = 1 << 19;

/// Finds rows by one of the indices in them.
class RowsByKey {
 public:
  template <class KeyOf>
  RowsByKey(std::size_t rows, std::size_t keys, const KeyOf& key_of) : last_(keys, -1), earlier_(rows) {
    for (std::size_t row = 0; row < rows; ++row) {
      Index& last = last_[key_of(row)];
      earlier_[row] = std::exchange(last, static_cast<Index>(row));
    }
  }
  /// -1: there is none.
  template <class Is>
  Index find(Index key, const Is& is) const {
    Index row = last_[key];
    while (row >= 0 && !is(static_cast<std::size_t>(row))) row = earlier_[row];
    return row;
  }

 private:
  std::vector<Index> last_, earlier_;
};

/// What lists depend on besides the places at rest.
bool same_constants(const ContactSurface::Particle& a, const ContactSurface::Particle& b) {
  return std::tie(a.body, a.edge, a.of_cut, a.normal) == std::tie(b.body, b.edge, b.of_cut, b.normal);
}

bool same_constants(const ContactSurface::Triangle& a, const ContactSurface::Triangle& b) {
  return std::tie(a.body, a.edge, a.has_inside, a.of_cut, a.normal) ==
         std::tie(b.body, b.edge, b.has_inside, b.of_cut, b.normal);
}

}  // namespace

void ContactCandidates::follow(const ContactSurface& surface, const ContactOptions& options,
                               const ContactSurface* before) {
  const bool stays = before != nullptr && before == surface_ && (complete_ || !to_search_.empty()) &&
                     options == options_ && surface.bodies == before->bodies && surface.is_cut == before->is_cut &&
                     surface.longest_edge <= ranked_edge_ && surface.body_of.size() == before->body_of.size();
  surface_ = &surface;
  has_all_ = false;
  if (stays) {
    complete_ = false;
    return keep_lists_of(*before);
  }
  options_ = options;
  drop_lists();
  searches_ = 0;
  build_whole_trees();
}

/// Lists of particles that are the same, and of which all triangles are.
void ContactCandidates::keep_lists_of(const ContactSurface& before) {
  const auto& now = *surface_;
  const RowsByKey particles(now.particles.size(), now.body_of.size(),
                            [&](std::size_t k) { return now.particles[k].at.particles[0]; });
  const std::vector<char> was_to_search = std::exchange(to_search_, std::vector<char>(now.particles.size(), 1));
  const std::vector<char> was_new = std::exchange(is_new_triangle_, std::vector<char>(now.triangles.size(), 1));
  const VecList nowhere(now.particles.size(), Vec3::Constant(NAN));
  const VecList places = std::exchange(then_, nowhere), seen = std::exchange(seen_, nowhere);
  std::vector<Index> particle_now(before.particles.size(), -1), triangle_now(before.triangles.size(), -1);
  for (std::size_t k = 0; k < before.particles.size(); ++k) {
    const ContactSurface::Particle& own = before.particles[k];
    const Index row = particle_now[k] = particles.find(own.at.particles[0], [&](std::size_t other) {
      const TissueVertex& at = now.particles[other].at;
      return at.particles == own.at.particles && at.weights == own.at.weights && now.rest[other] == before.rest[k];
    });
    if (row < 0) continue;
    then_[row] = places[k];
    seen_[row] = seen[k];
    to_search_[row] = !same_constants(own, now.particles[row]) || (!was_to_search.empty() && was_to_search[k] != 0);
  }
  const RowsByKey triangles(now.triangles.size(), now.particles.size(),
                            [&](std::size_t t) { return now.triangles[t].corner[0]; });
  for (std::size_t t = 0; t < before.triangles.size(); ++t) {
    const auto& [a, b, c] = before.triangles[t].corner;
    const std::array<Index, 3> corner{particle_now[a], particle_now[b], particle_now[c]};
    if (corner[0] < 0 || (!was_new.empty() && was_new[t] != 0)) continue;
    const Index row = triangle_now[t] = triangles.find(corner[0], [&](std::size_t other) {
      return now.triangles[other].corner == corner && same_constants(now.triangles[other], before.triangles[t]);
    });
    if (row >= 0) is_new_triangle_[row] = 0;
  }
  const std::vector<Near> listed = std::exchange(listed_, {});
  const std::vector<Kept> kept = std::exchange(kept_, {});
  for (const Kept& own : kept) {
    const Index row = particle_now[own.particle];
    if (row < 0 || to_search_[row] != 0) continue;
    const auto list = std::span(listed).subspan(own.first, own.count);
    if (std::ranges::any_of(list, [&](const Near& near) { return triangle_now[near.triangle] < 0; })) {
      to_search_[row] = 1;  // what the one that is gone was nearer than is not listed
      continue;
    }
    kept_.push_back({static_cast<std::size_t>(row), listed_.size(), own.count, own.until});
    for (const Near& near : list) listed_.push_back({triangle_now[near.triangle], near.least});
  }
}

void ContactCandidates::build_whole_trees() {
  const ContactSurface& surface = *surface_;
  usual_edge_ = edge_for_slack(surface);
  const auto rows = [](std::size_t count) {
    std::vector<Index> all(count);
    std::iota(all.begin(), all.end(), 0);
    return all;
  };
  build_trees(rows(surface.particles.size()), rows(surface.triangles.size()));
  has_all_ = true;
  met_.reserve(triangles_.items.size());
  near_.reserve(triangles_.items.size());
  then_.reserve(surface.particles.size());
  seen_.reserve(surface.particles.size());
  kept_.reserve(surface.particles.size());
}

/// Of some particles and triangles.
void ContactCandidates::build_trees(const std::vector<Index>& particles, const std::vector<Index>& triangles) {
  const ContactSurface& surface = *surface_;
  VecList places;
  std::vector<Index> body;
  for (const Index k : particles) {
    places.push_back(surface.rest[k]);
    body.push_back(surface.particles[k].body);
  }
  particles_ = BoxTree(places, body, surface.bodies);
  for (Index& item : particles_.items) item = particles[item];
  clusters_.clear();
  for (const BoxTree::Node& node : particles_.nodes) {
    if (!node.is_leaf) continue;
    Cluster cluster{static_cast<std::size_t>(node.first), static_cast<std::size_t>(node.end),
                    surface.particles[particles_.items[node.first]].body};
    for (std::size_t k = cluster.first; k < cluster.end; ++k) {
      const ContactSurface::Particle& own = surface.particles[particles_.items[k]];
      cluster.edge = std::max(cluster.edge, own.edge);
      cluster.motion.join({.least_edge = own.edge, .of_cut = own.of_cut});
    }
    clusters_.push_back(cluster);
  }

  places.clear();
  body.clear();
  for (const Index t : triangles) {
    const auto& [a, b, c] = surface.triangles[t].corner;
    places.push_back((surface.rest[a] + surface.rest[b] + surface.rest[c]) / 3.0);
    body.push_back(surface.triangles[t].body);
  }
  triangles_ = BoxTree(places, body, surface.bodies);
  for (Index& item : triangles_.items) item = triangles[item];
  item_edge_.clear();
  for (const Index t : triangles_.items) item_edge_.push_back(surface.triangles[t].edge);
  item_motion_.clear();
  for (const Index t : triangles_.items) {
    const ContactSurface::Triangle& triangle = surface.triangles[t];
    double side = 0.0;  // m2, the longest: its corners cover all within side / sqrt(3)
    for (int c = 0; c < 3; ++c) {
      side =
          std::max(side, (surface.rest[triangle.corner[c]] - surface.rest[triangle.corner[(c + 1) % 3]]).squaredNorm());
    }
    item_motion_.push_back({.least_edge = triangle.edge, .cover = std::sqrt(side / 3.0), .of_cut = triangle.of_cut});
  }
  node_edge_.assign(triangles_.nodes.size(), 0.0);
  node_motion_.assign(triangles_.nodes.size(), {});
  triangles_.each_part_from_below([&](Index own, Index part, bool is_item) {
    node_edge_[own] = std::max(node_edge_[own], is_item ? item_edge_[part] : node_edge_[part]);
    node_motion_[own].join(is_item ? item_motion_[part] : node_motion_[part]);
  });
  item_box_.resize(triangles_.items.size());
  node_box_.resize(triangles_.nodes.size());
  item_search_.resize(item_box_.size());
  node_search_.resize(node_box_.size());
}

/// As the last search would have found it, had it been of this surface. Nothing where its lists do not hold any more,
/// or where much is new.
void ContactCandidates::search_what_is_new(std::span<const Vec3> place, double margin) {
  Box way;
  for (std::size_t k = 0; k < place.size(); ++k) {
    const Vec3 since = place[k] - then_[k];
    way.add(since, since);
  }
  const Vec3 middle = 0.5 * (way.low + way.high);
  for (std::size_t k = 0; k < place.size(); ++k) {
    if (!then_[k].allFinite()) then_[k] = place[k] - middle;
  }
  complete_ = true;
  const bool holds = hold(place, margin);
  complete_ = false;
  if (holds && list_new_triangles()) {
    const auto [particles, triangles] = to_search();
    std::erase_if(kept_, [&](const Kept& own) { return to_search_[own.particle] != 0; });
    has_all_ = false;
    build_trees(particles, triangles);
    keeps_ = measure(then_);
    gather_all([&](std::size_t particle) { keep(particle); });
    complete_ = keeps_;
  }
  to_search_.clear();
  is_new_triangle_.clear();
}

/// m: what is farther apart by places in then_ is listed for nothing.
double ContactCandidates::reach() const {
  return search_distance(surface_->longest_edge) + 2.0 * ContactSurface::facing_share * ranked_edge_;
}

bool ContactCandidates::are_near(const Box& a, const Box& b) const {
  return !((a.low - b.high).maxCoeff() > reach() || (b.low - a.high).maxCoeff() > reach());
}

ContactCandidates::Box ContactCandidates::box_at(std::size_t triangle, std::span<const Vec3> place) const {
  Box box;
  for (const Index c : surface_->triangles[triangle].corner) box.add(place[c], place[c]);
  return box;
}

/// m: within it all that may rank first is listed. Infinite: the nearest one, which is not deep, leaves out the rest.
double ContactCandidates::reach_of(const Kept& list) const {
  double furthest = 0.0;
  const double own = surface_->particles[list.particle].edge;
  const auto all = std::span(listed_).subspan(list.first, list.count);
  const auto edge_with = [&](const Near& near) { return std::max(own, surface_->triangles[near.triangle].edge); };
  for (const Near& near : all) {
    const double by_edge = search_distance(edge_with(near));
    if (near.least <= by_edge) furthest = std::max(furthest, by_edge);
  }
  for (const Near& near : all) {
    if (near.least + 2.0 * slack_ > furthest) break;
    const auto triangle = static_cast<std::size_t>(near.triangle);
    const double most = distance_to(then_[list.particle], triangle, box_at(triangle, then_), HUGE_VAL).most;
    const bool is_shallow = most + slack_ < ContactSurface::depth_factor * edge_with(near);
    if (is_shallow && most + 2.0 * slack_ <= furthest) return HUGE_VAL;
  }
  return furthest;
}

/// Adds them to the lists that there are of their bodies. Particles without one are to be looked for anew, as those of
/// which a list ends before such a triangle: what is nearer may be of shorter edges, and too far away by these. Not
/// where there are too many to look at.
bool ContactCandidates::list_new_triangles() {
  Box around;
  std::vector<std::size_t> triangles;
  std::vector<Box> boxes;
  for (std::size_t t = 0; t < is_new_triangle_.size(); ++t) {
    if (is_new_triangle_[t] == 0) continue;
    triangles.push_back(t);
    Box& box = boxes.emplace_back(box_at(t, then_));
    box.widen(box.rounding());
    around.add(box.low, box.high);
  }
  std::vector<std::size_t> rows;
  for (std::size_t k = 0; k < then_.size(); ++k) {
    if (to_search_[k] == 0 && are_near({then_[k], then_[k]}, around)) rows.push_back(k);
  }
  if (rows.size() * boxes.size() > most_pairs) return false;
  const RowsByKey lists(kept_.size(), then_.size(), [&](std::size_t k) { return kept_[k].particle; });
  std::vector<std::pair<std::size_t, Near>> added;  // rows of kept_
  Index last_list = -1;
  double known = 0.0;  // m, reach_of() it
  for (const std::size_t k : rows) {
    const ContactSurface::Particle& own = surface_->particles[k];
    for (std::size_t n = 0; n < triangles.size() && to_search_[k] == 0; ++n) {
      const ContactSurface::Triangle& triangle = surface_->triangles[triangles[n]];
      if (triangle.body == own.body && !options_.self) continue;
      const double least = distance_to(then_[k], triangles[n], boxes[n], reach()).least;
      if (least == HUGE_VAL || surface_->is_own_skin(own, k, triangle)) continue;
      const double limit = search_distance(std::max(own.edge, triangle.edge));
      const Index list = lists.find(static_cast<Index>(k), [&](std::size_t row) {
        return kept_[row].count > 0 && surface_->triangles[listed_[kept_[row].first].triangle].body == triangle.body;
      });
      if (list >= 0 && list != last_list) known = reach_of(kept_[last_list = list]);
      if (list < 0 || (least <= limit && limit > known)) {
        to_search_[k] = least <= limit;
      } else if (least <= known) {
        added.emplace_back(list, Near{static_cast<Index>(triangles[n]), least});
      }
    }
  }
  if (2 * listed_.size() + added.size() > most_each * then_.size()) return false;
  merge(added);
  return true;
}

/// Each to a row of kept_.
void ContactCandidates::merge(std::vector<std::pair<std::size_t, Near>>& added) {
  std::ranges::sort(added, {}, [](const auto& one) { return std::pair(one.first, one.second.least); });
  for (auto from = added.begin(); from != added.end();) {
    Kept& own = kept_[from->first];
    const auto end = std::find_if(from, added.end(), [&](const auto& one) { return one.first != from->first; });
    const std::size_t first = listed_.size();
    for (std::size_t k = 0; k < own.count; ++k) listed_.push_back(listed_[own.first + k]);
    for (; from != end; ++from) listed_.push_back(from->second);
    own = {own.particle, first, listed_.size() - first};
    std::ranges::sort(std::span(listed_).subspan(first), {}, &Near::least);
  }
}

/// Rows of the particles of to_search_, and of the triangles that may be listed for these.
std::pair<std::vector<Index>, std::vector<Index>> ContactCandidates::to_search() const {
  std::pair<std::vector<Index>, std::vector<Index>> found;
  Box around;
  for (std::size_t k = 0; k < then_.size(); ++k) {
    if (to_search_[k] == 0) continue;
    found.first.push_back(static_cast<Index>(k));
    around.add(then_[k], then_[k]);
  }
  for (std::size_t t = 0; t < surface_->triangles.size(); ++t) {
    if (are_near(box_at(t, then_), around)) found.second.push_back(static_cast<Index>(t));
  }
  return found;
}

}  // namespace phymul
