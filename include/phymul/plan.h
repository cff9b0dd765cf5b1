// SPDX-License-Identifier: MIT
//
// plan(): from an error and a rate to the coarsest body and the cheapest solver that keep them on this machine.
#pragma once

#include <phymul/body.h>
#include <phymul/simulation.h>

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace phymul {

/// What plan() varies. The strain energy is not in it: it is part of what is simulated, and the builder sets it.
struct PlanCandidate {
  double spacing = 0.0;         ///< m, for BodyOptions::spacing or the cells of a block
  std::string backend = "cpu";  ///< SimulationOptions::backend
  int threads = 1;              ///< SolverOptions::threads, >= 1
  double step = 0.5;            ///< SimulationOptions::step

  SimulationOptions options(SimulationOptions others = {}) const;  ///< `others` with the last three of these
};

/// Makes the body at PlanCandidate::spacing, with PlanCandidate::options(), and fills its scene. The same candidate
/// must make the same simulation. It may be called at any time by the thread that calls plan() or Plan::make().
using SceneBuilder = std::function<Simulation(const PlanCandidate&)>;

/// What is wanted. max_error, and rate or rest_in, have no default. plan() throws Error for a value out of its range.
struct PlanOptions {
  /// In (0, 1): distance of the body's points from where they would be in an infinitely fine body with the same law, as
  /// a share of their displacement; both are root mean squares (as PositionError::global_ratio).
  double max_error = 0.0;
  double rate =
      0.0;  ///< Hz, at least 1: a call of advance(1 / rate) must take less than head_room / rate; 0: no such wish
  double rest_in = 0.0;    ///< s: the rest shape must be found in head_room * rest_in of wall time; 0: no such wish
  double head_room = 0.8;  ///< in (0, 1]
  /// s of simulated time, from the builder's state on, after which displacements are compared (and at seven times
  /// before). 0: at rest, by solve_static(), or by run_to_rest() where that does not support the scene.
  double probe_time = 0.0;
  /// Called before each tick of probe_time, for example to move tools. It is called for every candidate, so what it
  /// does must depend on Simulation::time() alone.
  std::function<void(Simulation&)> before_tick{};
  double coarsest = 0.0, finest = 0.0;       ///< m, limits of the spacing; 0: none
  double budget = 20.0;                      ///< s of wall time for planning, > 0; kept by omitting finer bodies
  std::vector<std::string> backends{"cpu"};  ///< those that this machine cannot run are omitted
  /// Multiples of the stable step, in (0, 1). Above 0.5 a strongly deformed body can become unstable.
  std::vector<double> steps{0.5};
  int most_threads = 0;  ///< 0: the number of processors
};

/// One candidate that was tried. Figures that are not known are NaN.
struct PlanTrial {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

  PlanCandidate candidate{};
  Index particles = 0;
  double mean_spacing = 0.0;   ///< m, of the body that was made
  double error = unknown;      ///< estimate of what PlanOptions::max_error limits, with the factor of safety
  double tick = unknown;       ///< s of wall time, median of ticks of 1 / rate (without a rate: of 1 ms)
  double real_time = unknown;  ///< simulated time of a tick over its wall time
  double rest = unknown;       ///< s of wall time to the rest shape
  bool rest_by_steps = false;  ///< by run_to_rest(), because solve_static() does not support the scene or failed
  bool keeps_error = false, keeps_time = false;
  std::string note{};  ///< why figures are missing, and what else to know; may be empty
};

struct Plan {
  PlanOptions options{};
  SceneBuilder builder{};
  bool kept = false;   ///< both wishes are kept; else most_accurate and cheapest say what can be had
  PlanTrial chosen{};  ///< if kept
  std::optional<PlanTrial> most_accurate{};  ///< if not kept: the most accurate one found that keeps the time
  std::optional<PlanTrial> cheapest{};       ///< if not kept: the fastest of the coarsest body that keeps the error
  std::vector<PlanTrial> trials{};           ///< all that were tried, from coarse to fine
  double order = PlanTrial::unknown;         ///< p of the fit error = C spacing^p
  double seconds = 0.0;                      ///< s of wall time that planning took
  std::string reason{};                      ///< one sentence: why this one, or why none
  std::vector<std::string> notes{};          ///< what was omitted, and why

  /// The simulation of `chosen`, or of an offer, by the builder. With the backend "cpu" two of them move alike to the
  /// last bit. Throws Error, which names the offers, if the wishes are not kept, and what the builder throws.
  Simulation make() const;
  Simulation make(const PlanTrial& trial) const;

  std::string report() const;  ///< for people: a table of the trials, the choice and the reason
};

/// Finds the coarsest spacing whose error is below PlanOptions::max_error, and there the backend, step and number of
/// threads with the least processor time that keep the rate. Nothing is chosen silently: if no candidate keeps both,
/// Plan::kept is false.
///
/// Error: bodies with spacings in ratio sqrt(2), from some 180 particles on, are compared at the same material points
/// (near the particles of the first one and amid its cells). Three of them fit u(h) = u0 + C h^p with p in [1, 2.5]
/// (L. F. Richardson 1911). The error is |u(h) - u0| or, if larger and h is about 2 hf or more, |u(h) - u(hf)| h^p /
/// (h^p - hf^p), with hf the finest spacing; but not less than that of a finer body; times 1.25, the factor of safety
/// of P. J. Roache (J. Fluids Eng. 116, 1994). It is an estimate, not a bound: what all bodies have in common, such as
/// the law and a surface that is too coarse, is not in it. Time: medians of measured ticks, so other work on the
/// machine changes it.
///
/// Throws Error for options out of their range, for a builder that always throws, does not use the candidate or makes
/// a body without volume cells, and for a scene in which nothing moves or, without probe_time, a body that nothing
/// holds or loads that change with time.
Plan plan(SceneBuilder builder, PlanOptions options);

/// The same for a body that make_body() fills: `simulation` has its material, `fill` adds its scene (for groups see
/// Model::particles_in()). The surface or solid is copied.
Plan plan(const Surface& surface, SimulationOptions simulation, std::function<void(Simulation&)> fill,
          PlanOptions options);
Plan plan(const Solid& solid, SimulationOptions simulation, std::function<void(Simulation&)> fill, PlanOptions options);

}  // namespace phymul
