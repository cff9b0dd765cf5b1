// SPDX-License-Identifier: MIT
//
// plan(): finds the coarsest body and the cheapest solver that meet a largest error and a rate on this machine.
#pragma once

#include <phymul/body.h>
#include <phymul/simulation.h>

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace phymul {

/// The parameters that plan() varies. It does not vary the strain energy, which the builder sets.
struct PlanCandidate {
  double spacing = 0.0;         ///< m, for BodyOptions::spacing or the cells of a block
  std::string backend = "cpu";  ///< SimulationOptions::backend
  int threads = 1;              ///< SolverOptions::threads, >= 1
  double step = 0.5;            ///< SimulationOptions::step

  SimulationOptions options(SimulationOptions others = {}) const;  ///< `others` with this backend, threads and step
};

/// Makes the body at PlanCandidate::spacing, with PlanCandidate::options(), and fills its scene. The same candidate
/// must make the same simulation. It may be called at any time by the thread that calls plan() or Plan::make().
using SceneBuilder = std::function<Simulation(const PlanCandidate&)>;

/// Requirements. Set max_error, and rate or rest_in or both. plan() throws Error for a value out of its range.
struct PlanOptions {
  /// In (0, 1), largest error: distance of the body's points from their places in an infinitely fine body with the same
  /// strain energy, divided by their displacement; both are root mean squares (as PositionError::global_ratio).
  double max_error = 0.0;
  double rate =
      0.0;  ///< Hz, at least 1: a tick, advance(1 / rate), may take head_room / rate of wall time; 0: no requirement
  double rest_in = 0.0;    ///< s: finding the rest shape may take head_room * rest_in of wall time; 0: no requirement
  double head_room = 0.8;  ///< in (0, 1], share of the time that may be used
  /// s of simulated time, from the builder's state on, after which displacements are compared (and at seven times
  /// before); not with rest_in. 0: they are compared at rest, by solve_static(), or else by run_to_rest().
  double probe_time = 0.0;
  /// Called before each tick of probe_time (Error without it), for example to move tools. Every candidate calls it, so
  /// what it does must depend on Simulation::time() alone.
  std::function<void(Simulation&)> before_tick{};
  double coarsest = 0.0, finest = 0.0;  ///< m, limits of the spacing; 0: none
  double budget = 20.0;                 ///< s, > 0, wall time for planning; finer bodies that exceed it are omitted
  std::vector<std::string> backends{"cpu"};  ///< not "auto"; those that this machine cannot run are omitted
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
  double error = unknown;      ///< estimate of the error, to compare with max_error; plan() says of what
  double tick = unknown;       ///< s of wall time, median of ticks of 1 / rate (without a rate: of 1 ms)
  double real_time = unknown;  ///< simulated time of a tick over its wall time
  double rest = unknown;       ///< s of wall time to the rest shape
  bool rest_by_steps = false;  ///< by run_to_rest(), because solve_static() does not support the scene or failed
  /// It meets max_error, and no cell of the finest body is flat or inside out at rest; it meets rate and rest_in.
  bool keeps_error = false, keeps_time = false;
  std::string note{};  ///< why figures are missing, and what else to know; may be empty
};

struct Plan {
  PlanOptions options{};
  SceneBuilder builder{};
  bool kept = false;   ///< a candidate meets all requirements; else most_accurate and cheapest are the alternatives
  PlanTrial chosen{};  ///< if kept
  std::optional<PlanTrial> most_accurate{};  ///< if not kept: the most accurate one found that meets the time
  std::optional<PlanTrial> cheapest{};       ///< if not kept: the fastest one of the coarsest body that meets max_error
  std::vector<PlanTrial> trials{};           ///< all that were tried, from coarse to fine
  double order = PlanTrial::unknown;         ///< p of the fit error = C spacing^p
  double seconds = 0.0;                      ///< s of wall time that planning took
  std::string reason{};                      ///< one sentence: why this one, or why none
  std::vector<std::string> notes{};          ///< what was omitted, and why

  /// Calls the builder for `chosen`, or for a given trial. With the backend "cpu" two such simulations have bitwise the
  /// same motion. Without a trial it throws Error, which names the alternatives, if not `kept`. Passes on what the
  /// builder throws.
  Simulation make() const;
  Simulation make(const PlanTrial& trial) const;

  std::string report() const;  ///< for people: a table of the trials, the choice and the reason
};

/// Finds the coarsest spacing whose error is at most PlanOptions::max_error, and there the backend, step and number of
/// threads with the least processor time that meet the rate. If no candidate meets both, Plan::kept is false.
///
/// Error: bodies whose spacings have the ratio sqrt(2), from about 180 particles on, are compared at the same material
/// points (near the particles of the first one and in the centres of its cells). Three of them fit u(h) = u0 + C h^p
/// with p in [1, 2.5] (L. F. Richardson 1911). The error is |u(h) - u0|. If h is about 2 hf or more, with hf the finest
/// spacing, it is at least |u(h) - u(hf)| h^p / (h^p - hf^p). Half of |u(hf) - u0| is added, because the limit u0 is
/// extrapolated. It is never less than the error of a finer body. It is an estimate, not a bound. It does not include
/// errors that all bodies have in common, such as those of the strain energy or of a surface that is too coarse. Time:
/// medians of measured ticks, so other work on the machine changes it.
///
/// Throws Error for options out of their range, and for a builder that always throws, does not use the candidate or
/// makes a body without volume cells. Throws Error for a scene in which nothing moves. Without probe_time it also
/// throws for SolverOptions::sleep_tolerance, a body that nothing holds, and loads that change with time.
Plan plan(SceneBuilder builder, PlanOptions options);

/// The same for a body that make_body() fills: `simulation` has its material, and `fill` fills its scene. Use
/// Model::particles_in() to choose particles for any spacing. The surface or solid is copied.
Plan plan(const Surface& surface, SimulationOptions simulation, std::function<void(Simulation&)> fill,
          PlanOptions options);
Plan plan(const Solid& solid, SimulationOptions simulation, std::function<void(Simulation&)> fill, PlanOptions options);

}  // namespace phymul
