// SPDX-License-Identifier: MIT
//
// Builds candidates of plan(), and measures them: displacements at the same material points, and wall times.
#pragma once

#include <phymul/error.h>
#include <phymul/plan.h>
#include <phymul/skin.h>

#include <chrono>

namespace phymul {

/// A mistake that every candidate would have. It ends plan(); any other error ends the trial of one candidate only.
class SceneError : public Error {
 public:
  explicit SceneError(const std::string& text) : Error("plan: " + text) {}
};

/// What a candidate was measured to do.
struct Probe {
  Index particles = 0;
  double h = 0.0;                    ///< m, mean spacing of the body
  VecList u;                         ///< [points] or [times * points] m; empty if it failed
  State rest;                        ///< the state in which ticks were measured; of a scene at rest
  double tick = PlanTrial::unknown;  ///< s, median
  double rest_seconds = PlanTrial::unknown;
  bool by_steps = false;  ///< rest by run_to_rest()
  bool folded = false;    ///< a cell is flat or inside out at rest
  double seconds = 0.0;   ///< s, of everything
  std::string failure;    ///< empty: none
  std::string note;
};

/// Without spare ones (phymul/body.h), which have no place of their own.
Index own_particles(const Model& model);

class Prober {
 public:
  Prober(const SceneBuilder& builder, const PlanOptions& options);

  double elapsed() const;  ///< s, since the constructor
  double left() const { return options_.budget - elapsed(); }
  bool probes_motion() const { return options_.probe_time > 0.0; }
  double tick_length() const;  ///< s of simulated time

  /// By the builder. Throws SceneError if it did not use the candidate.
  Simulation build(const PlanCandidate& candidate) const;

  /// Everything about a candidate. The first call chooses the points. `is_known` is asked once particles and spacing
  /// are there; if it says yes, nothing else is measured. A failure is Probe::failure or an Error.
  Probe probe(const PlanCandidate& candidate, const std::function<bool(const Probe&)>& is_known);

  /// Times alone, of a candidate with the body of `known`: from its state of rest, or of the whole motion.
  Probe measure(const PlanCandidate& candidate, const Probe& known);

 private:
  void choose_points(const Model& model);
  VecList displacements(Simulation& sim, const Skin& skin) const;
  void find_rest(Simulation& sim, Probe& probe) const;
  void rest_by_steps(Simulation& sim, Probe& probe) const;
  void follow_motion(Simulation& sim, const Skin* skin, Probe& probe) const;
  void measure_ticks(Simulation& sim, Probe& probe) const;
  double timed_tick(Simulation& sim, Probe& probe) const;

  const SceneBuilder& builder_;
  const PlanOptions& options_;
  std::chrono::steady_clock::time_point begin_;
  VecList points_;  ///< m
};

}  // namespace phymul
