// SPDX-License-Identifier: MIT
//
// What a solver does when its body was changed (topology/body_edit.h).
#include <phymul/backend.h>
#include <phymul/error.h>

#include <span>

#include "elastic/dissipation.h"
#include "elastic/local_steps.h"
#include "elastic/material_spectra.h"
#include "elastic/scaled_tables.h"
#include "interaction/joint_set.h"
#include "interaction/stiff_joints.h"
#include "profile.h"

namespace phymul {

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
  own_spectrum_.largest = largest_before_edits_ * topology_->stiffened;
  take_spectrum();
  topology_hash_.reset();
  materials_.reset();
  loose_.reset();
  all_held_.reset();
  growth_of_state_ = 0.0;
  copies_.clear();
  scene_->prepare(frame_);
  follow_joints();
  const auto domains = std::span(topology_->edited).subspan(domains_seen_);
  do_body_changed(domains);
  do_scene_changed();
  continue_copies(domains);
  copies_seen_ = topology_->copied.size();
  edits_seen_ = topology_->edits;
  domains_seen_ = topology_->edited.size();
  scene_version_ = scene_->version();
  values_version_ = scene_->values_version();
}

/// Copies that cuts made move as what they copy. The domains are those that changed.
void SolverBackend::continue_copies(std::span<const Index> domains) {
  const auto copied = std::span(topology_->copied).subspan(copies_seen_);
  if (copied.empty() && topology_->dissipation.empty()) return;
  Snapshot now = snapshot_without_hash();
  for (const auto& [copy, of] : copied) {
    if (topology_->mass[copy] == 0.0) continue;  // the cut was undone
    now.state.position[copy] = now.state.position[of];
    now.state.velocity[copy] = now.state.velocity[of];
    if (!now.displacement.empty()) now.displacement[copy] = now.displacement[of];
  }
  continue_strains(*topology_, domains, copied, now);
  restore(now);
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
