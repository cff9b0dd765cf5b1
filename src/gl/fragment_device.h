// SPDX-License-Identifier: MIT
//
// Everything of a fragment solver that lives in its context: made, used and deleted inside Context::run.
#pragma once

#include <memory>
#include <vector>

#include "gl/fragment_copies.h"
#include "gl/fragment_passes.h"
#include "gl/fragment_report.h"
#include "gl/fragment_sums.h"
#include "gl/pass_timer.h"

namespace phymul::gl {

class FragmentDevice {
 public:
  /// Most steps between two reads of a report, so that their numbers fit what step_pass.glsl packs.
  static constexpr int most_steps = 256;

  /// Compiles, uploads, and draws every pass of a step once: drivers compile at the first draw, not when they are told.
  FragmentDevice(const FloatTables& tables, const Scene& scene, const ShaderLibrary& library, bool four_passes);

  /// From now on; timer() is null before.
  void time_passes(const ContextInfo& info, Profile& profile) { timer_ = std::make_unique<PassTimer>(info, profile); }
  PassTimer* timer() { return timer_.get(); }

  void set_scene(const Scene& scene);
  void write(const VecList& rest, const State& state) { state_.write(rest, state); }
  FragmentState& state() { return state_; }
  FragmentCopies& copies() { return copies_; }

  /// The loads at the instants of a batch: instants[s] is the old time of its step s + 1.
  void begin_batch(const StepConstants& constants, const std::vector<double>& instants);
  /// Steps 1 ... count of the batch from the checkpoint; the last one measures.
  void run(int count);
  /// Step `number` from the present state, which stays as it is; only what it measures is kept.
  BatchReport try_step(int number);
  /// Of the steps since begin_batch(), or since the last run() did.
  BatchReport report();

  Energy energy(const Scene& scene, double time, double dt);
  Momentum momentum(const VecList& rest, const Vec3& about);
  const Texture& attractors();

 private:
  EmptyVertexArray vertices_;
  ShaderLibrary library_;
  FragmentTables tables_;
  FragmentState state_;
  std::unique_ptr<FragmentLoads> loads_;
  FragmentPasses passes_;
  FragmentReport report_;
  FragmentSums sums_;
  FragmentCopies copies_;
  std::unique_ptr<PassTimer> timer_;
};

}  // namespace phymul::gl
