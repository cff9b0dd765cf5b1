// SPDX-License-Identifier: MIT
#include "thread_set.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "model/closed_surface.h"

namespace phymul {
namespace {

constexpr int most_rounds = 12;
/// Of the longest edge, that nodes and tissue may go before triangles are looked for anew.
constexpr double room_in_edges = 0.25;
/// Of the stiffness of a segment: what sticks creeps by so much less than a segment stretches, in each step.
constexpr double stiffest_in_segments = 1000.0;
/// Of an overlap at the step's start, that comes out in the step: all of it would fling the thread.
constexpr double parted_share = 0.1;
/// Of the force against sliding: a smaller change is none.
constexpr double settled_share = 1e-3;
/// A node that is deeper in tissue, and than what the tissue goes in a step, did not get in through this side.
constexpr double deepest_in_radii = 4.0;

}  // namespace

ThreadContacts::ThreadContacts(const Thread& thread, std::shared_ptr<const ContactSurface> surface,
                               std::size_t particles)
    : radius_(thread.radius),
      segment_(thread.segment),
      friction_(thread.friction),
      stiffest_(stiffest_in_segments * axial_stiffness(thread) / thread.segment),
      surface_(std::move(surface)),
      crowd_(particles, 0.0) {}

Vec3 ThreadContacts::corner_place(Index corner, const PredictedStep& step) const {
  const TissueVertex& at = surface_->particles[corner].at;
  Vec3 place = Vec3::Zero();
  for (std::size_t v = 0; v < 4 && at.particles[v] >= 0; ++v) place += at.weights[v] * step.position(at.particles[v]);
  return place;
}

template <class Visit>
void ThreadContacts::each_particle(const Touch& touch, Visit visit) const {
  for (std::size_t c = 0; c < 3; ++c) {
    if (touch.share[c] == 0.0) continue;
    const ContactSurface::Particle& corner = surface_->particles[touch.corner[c]];
    for (std::size_t v = 0; v < 4 && corner.at.particles[v] >= 0; ++v) {
      visit(corner.at.particles[v], touch.share[c] * corner.shares[v]);
    }
  }
}

/// Whether the triangles of the last find_near() are all that nodes may face within a reach, m.
bool ThreadContacts::knows_near(const ThreadRod& rod, double reach, const TouchedParticles& touched) {
  if (std::isnan(gone_)) return false;
  double moved = 0.0;
  for (Index i = 0; i <= rod.last(); ++i) moved = std::max(moved, (rod.place(i) - then_[i]).norm());
  used_ = moved + touched.step().gone() - gone_ + going_;
  return used_ + reach <= listed_;
}

void ThreadContacts::find_near(const ThreadRod& rod, double reach, const TouchedParticles& touched) {
  constexpr Index run = 8;  // nodes that share a box
  const PredictedStep& step = touched.step();
  const Index nodes = rod.last() + 1;
  listed_ = reach + room_in_edges * surface_->longest_edge;
  used_ = 0.0;
  gone_ = step.gone();
  going_ = touched.going();
  then_.clear();
  for (Index i = 0; i < nodes; ++i) then_.push_back(rod.place(i));
  VecList corners;
  for (Index k = 0; k < static_cast<Index>(surface_->particles.size()); ++k) corners.push_back(corner_place(k, step));
  clear_.assign(nodes, listed_);
  first_.assign(1, 0);
  near_.clear();
  std::vector<Index> in_box;
  for (Index i = 0; i < nodes; ++i) {
    if (i % run == 0) {
      Vec3 low = then_[i], high = low;
      for (Index k = i; k < std::min<Index>(i + run, nodes); ++k) {
        low = low.cwiseMin(then_[k]);
        high = high.cwiseMax(then_[k]);
      }
      in_box.clear();
      for (Index t = 0; t < static_cast<Index>(surface_->triangles.size()); ++t) {
        const auto& [a, b, c] = surface_->triangles[t].corner;
        const Vec3 least = corners[a].cwiseMin(corners[b]).cwiseMin(corners[c]);
        const Vec3 most = corners[a].cwiseMax(corners[b]).cwiseMax(corners[c]);
        const bool near = ((least - high).array() <= listed_).all() && ((low - most).array() <= listed_).all();
        if (near) in_box.push_back(t);
      }
    }
    for (const Index t : in_box) {
      const auto& [a, b, c] = surface_->triangles[t].corner;
      const Vec3 share = closest_point(then_[i], corners[a], corners[b], corners[c]);
      const double apart = (share[0] * corners[a] + share[1] * corners[b] + share[2] * corners[c] - then_[i]).norm();
      if (!(apart <= listed_)) continue;  // nor what is no number
      clear_[i] = std::min(clear_[i], apart);
      near_.push_back({t, apart});
    }
    std::sort(near_.begin() + static_cast<std::ptrdiff_t>(first_.back()), near_.end(),
              [](const Near& a, const Near& b) { return a.apart < b.apart; });
    first_.push_back(near_.size());
  }
}

/// The triangle that the node faces at the step's start, if one is within reach. Of those that are equally near,
/// because they share what is nearest, the one that faces the node most; of those that do alike the first of the
/// surface.
std::optional<ThreadContacts::Touch> ThreadContacts::facing(Index node, const Vec3& place, double reach,
                                                            const TouchedParticles& touched) {
  const double tie = ContactSurface::facing_share * surface_->longest_edge;
  double nearest = reach;
  faced_.clear();
  for (std::size_t k = first_[node]; k < first_[node + 1]; ++k) {
    if (near_[k].apart - used_ > nearest + tie) break;
    const ContactSurface::Triangle& triangle = surface_->triangles[near_[k].triangle];
    std::array<Vec3, 3> x;
    for (std::size_t v = 0; v < 3; ++v) x[v] = corner_place(triangle.corner[v], touched.step());
    const Vec3 share = closest_point(place, x[0], x[1], x[2]);
    const Vec3 off = place - (share[0] * x[0] + share[1] * x[1] + share[2] * x[2]);
    const double apart = off.norm();
    if (!(apart <= nearest + tie)) continue;
    nearest = std::min(nearest, apart);
    const Vec3 normal = (x[1] - x[0]).cross(x[2] - x[0]).normalized();
    const bool inside = triangle.has_inside && normal.dot(off) < 0.0;
    Faced& faced = faced_.emplace_back();
    faced = {.triangle = near_[k].triangle,
             .apart = apart,
             .facing = apart > 0.0 ? std::abs(normal.dot(off)) / apart : 1.0,
             .gap = (inside ? -apart : apart) - radius_,
             .share = share,
             .normal = inside || !(apart > 1e-9 * triangle.edge) ? normal : Vec3(off / apart)};
  }
  const Faced* best = nullptr;
  for (const Faced& faced : faced_) {
    if (faced.apart > nearest + tie || faced.apart > reach) continue;
    const auto rank = [](const Faced& own) { return std::pair(-own.facing, own.triangle); };
    if (best == nullptr || rank(faced) < rank(*best)) best = &faced;
  }
  if (best == nullptr || best->gap < -deepest_in_radii * radius_ - touched.going()) return {};
  Touch touch{
      .node = node, .corner = surface_->triangles[best->triangle].corner, .share = best->share, .normal = best->normal};
  each_particle(touch, [&](Index i, double share) { touch.slide += share * touched.dt() * touched.velocity(i); });
  touch.need = touch.normal.dot(touch.slide) + std::min(0.0, (1.0 - parted_share) * best->gap) - best->gap;
  return touch;
}

void ThreadContacts::find_facing(const ThreadRod& rod, Index first, Index last, const TouchedParticles& touched) {
  facing_.clear();
  if (surface_ == nullptr || surface_->triangles.empty()) return;
  // No node goes farther than this beyond its guess; if it does, the next step pushes it back.
  double reach = radius_ + touched.going() + segment_;
  for (Index i = first; i <= last; ++i) reach = std::max(reach, radius_ + touched.going() + 2.0 * rod.way(i).norm());
  if (!knows_near(rod, reach, touched)) find_near(rod, reach, touched);
  for (Index i = first; i <= last; ++i) {
    if (rod.is_given(i) || clear_[i] - used_ > reach) continue;
    if (const std::optional<Touch> touch = facing(i, rod.place(i), reach, touched)) facing_.push_back(*touch);
  }
}

/// The plane that the node may not pass, by where it would be. False: it is outside.
bool ThreadContacts::measure(Touch& touch, const ThreadSupport& tool, const ThreadRod& rod) const {
  const Vec3 &place = rod.place(touch.node), way = rod.way(touch.node);
  ShapeIn<double> shape = *tool.shape;
  shape.margin += radius_;
  const Vec3 from = tool.start.inside(place), to = tool.end.inside(place + way);
  const Depth<double> in = depth_after(shape, unpacked(from), unpacked(to), unpacked(to - from));
  const double left = (1.0 - parted_share) * std::max(0.0, -distance_to(shape, unpacked(from)).phi);
  touch.normal = tool.end.turn * packed(in.normal);
  touch.slide = tool.end.outside(from) - place;
  touch.need = touch.normal.dot(way) + in.depth - left;
  touch.stiffness = stiffest_;
  return in.depth > left;
}

/// What acts against sliding is a stiffness too, of Coulomb's force over the way that the node slid in the last
/// iteration: so it takes energy in every iteration, converged or not. False: as before it, but for little.
bool ThreadContacts::rub(Touch& touch, const ThreadRod& rod) const {
  const Vec3 off = touch.slide - rod.way(touch.node);
  const double apart = (off - off.dot(touch.normal) * touch.normal).norm(), most = friction_ * touch.press;
  const double wanted = apart * touch.stiffness <= most ? touch.stiffness : most / apart;
  const bool changes = std::abs(wanted - touch.rubbing) * apart > settled_share * most;
  touch.rubbing = wanted;
  return changes;
}

/// What touches after the last iteration, and how. False: as before it. What pressed a node in the step before is a
/// guess, unless it may have been another thread.
bool ThreadContacts::update(const Lying& own, const ThreadCrossings& crossings) {
  const ThreadRod& rod = *own.rod;
  const std::span<const ThreadSupport> tools = own.tools;
  const VecList& before = rod.state().touch;
  bool changes = false;
  before_.swap(touches_);
  touches_.clear();
  if (before_.empty() && facing_.empty() && tools.empty()) return false;
  auto known = before_.begin();
  auto tissue = facing_.begin();
  for (Index i = 0; i <= rod.last(); ++i) {
    for (int tool = -1; tool < static_cast<int>(tools.size()); ++tool) {
      const bool is_known = known != before_.end() && known->node == i && known->tool == tool;
      Touch touch = is_known ? *known++ : Touch{.node = i, .tool = tool};
      const double missing = is_known ? touch.need - touch.normal.dot(rod.way(i)) : 0.0;
      if (tool < 0) {
        if (tissue == facing_.end() || tissue->node != i) continue;
        if (!is_known) touch = *tissue;
        ++tissue;
      }
      if (rod.is_given(i)) continue;
      const bool inside = tool < 0 ? touch.need > touch.normal.dot(rod.way(i)) : measure(touch, tools[tool], rod);
      if (is_known) {
        touch.press = std::max(touch.stiffness * missing, 0.0);
        if (!(touch.press > 0.0) && !inside) {
          changes = true;
          continue;
        }
        changes = rub(touch, rod) || changes;
      } else {
        const bool is_known_press = !before.empty() && !crossings.presses(own.strand, i);
        touch.press = is_known_press ? std::max(before[i].dot(touch.normal), 0.0) : 0.0;
        const bool goes_on = touch.press > 0.0 && touch.need - touch.normal.dot(rod.way(i)) > -radius_;
        if (!inside && !goes_on) continue;
        touch.rubbing = touch.stiffness;
        if (touch.press > 0.0) static_cast<void>(rub(touch, rod));
        changes = true;
      }
      touches_.push_back(touch);
    }
  }
  return changes;
}

/// The particles of tissue are split among the nodes that share them, so that together they do not push too far.
void ThreadContacts::find_stiffness(std::span<const Lying> threads, TouchedParticles& touched) {
  std::vector<double>& crowd = threads.front().contacts->crowd_;
  const auto each_share = [&](auto visit) {
    for (const Lying& thread : threads) {
      for (Touch& touch : thread.contacts->touches_) {
        if (touch.tool >= 0) continue;
        thread.contacts->each_particle(touch, [&](Index i, double share) { visit(touch, i, share); });
      }
    }
  };
  each_share([&](Touch& touch, Index i, double share) {
    crowd[i] += std::abs(share);
    touch.stiffness = 0.0;
  });
  each_share([&](Touch& touch, Index i, double share) {
    const TouchedParticles::Touched& particle = touched[touched.slot(i)];
    if (particle.held) return;
    touch.stiffness +=
        crowd[i] * std::abs(share) * particle.inverse_mass * particle.free_part(touch.normal).squaredNorm();
  });
  each_share([&](Touch&, Index i, double) { crowd[i] = 0.0; });
  const double dt = touched.dt();
  for (const Lying& thread : threads) {
    for (Touch& touch : thread.contacts->touches_) {
      if (touch.tool < 0) touch.stiffness = 1.0 / (dt * dt * touch.stiffness + 1.0 / thread.contacts->stiffest_);
    }
  }
}

void ThreadContacts::find_pushes() {
  pushes_.clear();
  for (const Touch& touch : touches_) {
    const Vec3& n = touch.normal;
    const Mat3 across = n * n.transpose();
    const double rubbing = std::min(touch.rubbing, touch.stiffness);
    pushes_.push_back({.node = touch.node,
                       .stiffness = touch.stiffness * across + rubbing * (Mat3::Identity() - across),
                       .to = touch.need * n + (touch.slide - n.dot(touch.slide) * n)});
  }
}

void ThreadContacts::solve(std::span<const Lying> threads, ThreadCrossings& crossings, TouchedParticles& touched) {
  for (const auto& [rod, own, strand, tools, first, last] : threads) {
    rod->start_newton();
    own->find_facing(*rod, first, last, touched);
    own->touches_.clear();
  }
  const auto has_settled = [](const Lying& thread) { return thread.rod->has_settled(); };
  for (int round = 0; round < most_rounds; ++round) {
    bool changes = crossings.update();
    for (const Lying& thread : threads) changes = thread.contacts->update(thread, crossings) || changes;
    if (!changes && round > 0 && std::ranges::all_of(threads, has_settled)) break;
    find_stiffness(threads, touched);
    for (const Lying& thread : threads) {
      thread.contacts->find_pushes();
      thread.rod->iterate(thread.contacts->pushes_);
    }
    crossings.couple();
  }
  crossings.give_forces();
  for (const Lying& thread : threads) thread.contacts->give_forces(thread, touched);
}

void ThreadContacts::give_forces(const Lying& own, TouchedParticles& touched) const {
  ThreadRod& rod = *own.rod;
  for (std::size_t k = 0; k < touches_.size(); ++k) {
    const Touch& touch = touches_[k];
    const Vec3 force = pushes_[k].at(rod.way(touch.node));
    rod.touch(touch.node, force);
    if (touch.tool < 0) {
      each_particle(touch, [&](Index i, double share) {
        TouchedParticles::pull(touched[touched.slot(i)], -touched.dt() * share * force);
      });
      continue;
    }
    const ThreadSupport& tool = own.tools[touch.tool];
    tool.force->force -= force;
    tool.force->torque -= (rod.place(touch.node) - tool.end.position).cross(force);
  }
}

}  // namespace phymul
