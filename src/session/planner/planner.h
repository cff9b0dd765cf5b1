// SPDX-License-Identifier: MIT
//
// Planner: one call of plan(). Refines, estimates errors, then chooses. The error of a spacing from solutions at
// several spacings: Richardson's extrapolation of displacements.
#pragma once

#include <phymul/error.h>
#include <phymul/plan.h>
#include <phymul/skin.h>
#include <phymul/types.h>

#include <chrono>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace phymul {

/// Displacements of the same material points in a body of spacing h, m.
struct FieldAt {
  double h = 0.0;
  std::span<const Vec3> u;
};

/// u(h) = limit + C h^order.
struct Convergence {
  double order = 0.0;
  bool converges = true;  ///< false: the differences do not fall as fast as they do for the least order
  VecList limit;          ///< m
  double scale = 0.0;     ///< m, root mean square of the limit
};

constexpr double least_order = 1.0, most_order = 2.5;

/// Root mean square of the distances between two fields of equal size, m.
double mean_distance(std::span<const Vec3> a, std::span<const Vec3> b);

/// Of three fields with falling h. The order follows from the distances between them and is kept in [least_order,
/// most_order].
Convergence fit_convergence(const FieldAt& coarse, const FieldAt& middle, const FieldAt& fine);

/// Error of a field as a share of the scale: its distance from the limit or, if larger, that from the finest field,
/// extrapolated. The latter only where that field is about twice as fine: between nearer ones, what differs by chance
/// between two meshes would be multiplied.
double estimated_error(const Convergence& fit, const FieldAt& field, const FieldAt& finest);

// Builds candidates of plan(), and measures them: displacements at the same material points, and wall times.

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

// What a plan says to people.

/// `coarser`: the next coarser body, which misses the error; null: there is none.
std::string reason_of_choice(const Plan& plan, const PlanTrial* coarser);

/// `ended`: why no finer body than `finest` was tried.
std::string reason_of_refusal(const Plan& plan, const PlanTrial& finest, const std::string& ended);

/// "9.1 mm, 425 particles, cpu with 2 threads, step 0.5".
std::string describe(const PlanTrial& trial);

/// What can be had instead, a sentence each; empty if nothing can.
std::string describe_offers(const Plan& plan);

}  // namespace phymul
