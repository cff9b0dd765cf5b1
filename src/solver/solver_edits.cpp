// SPDX-License-Identifier: MIT
//
// What a solver does when its body was changed (topology/body_edit.h).
#include <phymul/backend.h>
#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <tuple>

#include "elastic/dissipation.h"
#include "elastic/material_spectra.h"

namespace phymul {
namespace {

/// Mass that went from copies to others of their family takes its momentum along. `mass`: kg, after it; m/s.
void carry_momentum(std::span<const TopologyTextures::Exchanged> exchanged, std::span<const double> mass,
                    VecList& velocity) {
  std::map<Index, std::map<Index, double>> families;  // kg before, by particle
  for (const auto& [particle, family, before] : exchanged) families[family].try_emplace(particle, before);
  for (const auto& [first, members] : families) {
    double given = 0.0, taken = 0.0;  // kg
    Vec3 momentum = Vec3::Zero();     // of what was given, N s
    bool moves_as_one = true;
    for (const auto& [i, before] : members) {
      (mass[i] < before ? given : taken) += std::abs(mass[i] - before);
      if (mass[i] < before) momentum += (before - mass[i]) * velocity[i];
      moves_as_one = moves_as_one && velocity[i] == velocity[members.begin()->first];
    }
    if (moves_as_one || given == 0.0 || taken == 0.0) continue;
    const Vec3 mean = momentum / given;
    const double share = std::min(given / taken, 1.0);  // of what was taken: the rest is tissue brought back
    for (const auto& [i, before] : members) {
      const double more = share * (mass[i] - before);
      if (more > 0.0) velocity[i] += more / mass[i] * (mean - velocity[i]);
    }
  }
}

}  // namespace

Snapshot SolverBackend::snapshot() const {
  Snapshot snapshot = snapshot_without_hash();
  snapshot.topology_hash = topology_hash();
  return snapshot;
}

/// Of the body as it is now: an edit forgets it.
std::uint64_t SolverBackend::topology_hash() const {
  if (!topology_hash_) topology_hash_ = fingerprint(*topology_);
  return *topology_hash_;
}

void SolverBackend::take_spectrum() {
  const StepBound bound = step_bound(*topology_, own_spectrum_);
  stiffness_ = bound.stiffness;
  viscosity_ = bound.damping;
}

void SolverBackend::body_changed() {
  require_idle("Solver::body_changed");
  if (edits_seen_ == topology_->edits) return;
  if (local_steps_) {
    throw Error(ErrorCode::not_supported,
                "the body of a solver with SolverOptions::max_substeps above 1 cannot be changed: its fine parts are "
                "chosen once; set it to 1");
  }
  const auto before = std::tuple(own_spectrum_, stiffness_, viscosity_);
  if (std::isnan(largest_before_edits_)) {
    own_spectrum_ = estimate_spectrum(*topology_, topology_->rest);
  } else {
    own_spectrum_.largest = largest_before_edits_ * topology_->stiffened;
  }
  take_spectrum();
  topology_hash_.reset();
  materials_.reset();
  loose_.reset();
  all_held_.reset();
  growth_of_state_ = 0.0;
  last_.report.at_rest = false;
  copies_.clear();
  scene_->prepare(frame_);
  follow_joints();
  const auto domains = std::span(topology_->edited).subspan(domains_seen_);
  std::map<std::uint64_t, ToolReport> told;
  for (std::size_t row = 0; row < scene_->tools().size(); ++row) told[scene_->tools()[row].id] = tool_report(row);
  try {
    do_body_changed(domains);
  } catch (...) {  // a backend that does not follow
    std::tie(own_spectrum_, stiffness_, viscosity_) = before;
    throw;
  }
  do_scene_changed();
  // What the last step told stays; what tools hold and where they are is that of now.
  for (std::size_t row = 0; row < scene_->tools().size(); ++row) {
    ToolReport now = do_tool_report(row);
    const ToolReport& was = told.at(scene_->tools()[row].id);
    now.last_pose = was.last_pose;
    now.force.force = was.force.force;
    now.force.torque = was.force.torque;
    now.force.mean_force = was.force.mean_force;
    now.force.mean_torque = was.force.mean_torque;
    now.force.particles = was.force.particles;
    tools_before_[scene_->tools()[row].id] = std::move(now);
  }
  continue_copies(domains);
  copies_seen_ = topology_->copied.size();
  exchanged_seen_ = topology_->exchanged.size();
  edits_seen_ = topology_->edits;
  domains_seen_ = topology_->edited.size();
  scene_version_ = scene_->version();
  values_version_ = scene_->values_version();
}

/// Copies that cuts made move as what they copy. The domains are those that changed.
void SolverBackend::continue_copies(std::span<const Index> domains) {
  const auto copied = std::span(topology_->copied).subspan(copies_seen_);
  const auto exchanged = std::span(topology_->exchanged).subspan(exchanged_seen_);
  if (copied.empty() && exchanged.empty() && topology_->dissipation.empty()) return;
  Snapshot now = snapshot_without_hash();
  for (const auto& [copy, of] : copied) {
    if (topology_->mass[copy] == 0.0) continue;  // the cut was undone
    now.state.position[copy] = now.state.position[of];
    now.state.velocity[copy] = now.state.velocity[of];
    if (!now.displacement.empty()) now.displacement[copy] = now.displacement[of];
  }
  continue_strains(*topology_, domains, copied, now);  // by the velocities that led here
  carry_momentum(exchanged, topology_->mass, now.state.velocity);
  const auto beyond = std::tuple(first_beyond_, beyond_since_);
  restore(now);
  std::tie(first_beyond_, beyond_since_) = beyond;
}

void SolverBackend::do_body_changed(std::span<const Index>) {
  throw Error(ErrorCode::not_supported, "the backend \"" + name_ + "\" does not follow changes of its body");
}

/// Particles without mass at rest at their places, held by no tool.
State SolverBackend::without_removed(State state) const {
  for (std::size_t i = 0; i < state.position.size(); ++i) {
    if (topology_->mass[i] > 0.0) continue;
    state.position[i] = topology_->rest[i];
    state.velocity[i].setZero();
  }
  for (ToolState& tool : state.tools) {
    for (std::size_t k = tool.held.size(); k-- > 0;) {
      if (topology_->mass[tool.held[k]] > 0.0) continue;
      tool.held.erase(tool.held.begin() + static_cast<std::ptrdiff_t>(k));
      tool.held_at.erase(tool.held_at.begin() + static_cast<std::ptrdiff_t>(k));
    }
  }
  return state;
}

}  // namespace phymul
