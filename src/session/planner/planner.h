// SPDX-License-Identifier: MIT
//
// Planner: one call of plan(). Refines, estimates errors, then chooses.
#pragma once

#include <phymul/plan.h>

#include <optional>
#include <string>
#include <vector>

#include "prober.h"

namespace phymul {

class Planner {
 public:
  /// `guess`: m, a spacing that is not finer than it need be; 0: none.
  Planner(SceneBuilder builder, PlanOptions options, double guess);

  Plan run();

 private:
  /// A spacing that was tried.
  struct Level {
    Probe probe;
    PlanTrial trial;        ///< of the first configuration
    bool in_ladder = true;  ///< its error fit may use it
    bool has_field() const { return !probe.u.empty(); }
  };

  double first_spacing();
  bool goes_to_next_backend(const std::exception& error);  ///< where the first one refuses the scene
  void refine();                                           ///< finer and finer bodies
  void coarsen();                                          ///< coarser and coarser bodies, while they keep the error
  void bisect();  ///< between the coarsest one that keeps the error and the next coarser one
  bool add_level(double spacing, bool in_ladder);
  void estimate_errors();
  double predicted_seconds(double spacing) const;
  std::optional<std::size_t> coarsest_kept() const;  ///< of levels_

  std::vector<PlanCandidate> configurations(double spacing, int threads) const;
  PlanTrial measured(Level& level, const PlanCandidate& candidate);
  bool keeps_time(const PlanTrial& trial) const;
  double most_seconds() const;
  double cost(const PlanTrial& trial) const;  ///< s of processor time
  /// Cheapest configuration that keeps the time; else none. `fastest` becomes the fastest that was measured.
  std::optional<PlanTrial> cheapest_in_time(Level& level, PlanTrial& fastest);
  void choose();

  Plan plan_;
  Prober prober_;
  double guess_ = 0.0;
  PlanCandidate first_;        // configuration of all levels
  std::vector<Level> levels_;  // from coarse to fine
  std::vector<PlanTrial> measured_;
  std::string ended_;  // why no finer body was tried
};

}  // namespace phymul
