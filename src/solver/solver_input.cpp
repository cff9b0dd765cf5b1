// SPDX-License-Identifier: MIT
#include "solver_input.h"

#include <phymul/error.h>

#include <cmath>
#include <string>
#include <type_traits>

#include "base/decimal.h"

namespace phymul {
namespace {

/// s. Below it dt squared leaves the normal numbers of single precision, and a body on such a backend stands still;
/// with subnormal ones, double precision too fails. No wave in any body is this short.
constexpr double smallest_step = 1e-18;

}  // namespace

void require_options(const SolverOptions& options) {
  const auto require = [](bool holds, const char* what, const auto& got) {
    if (holds) return;
    std::string text;
    if constexpr (std::is_same_v<decltype(got), const double&>) {
      text = to_decimal(got);
    } else {
      text = std::to_string(got);
    }
    throw Error(std::string("SolverOptions::") + what + "; got " + text);
  };
  const auto not_negative = [](double value) { return value >= 0.0 && std::isfinite(value); };
  const Damping& d = options.damping;
  require(not_negative(d.rate), "damping.rate must be a finite rate in 1/s, 0 or more", d.rate);
  require(d.factor >= 0.0 && d.factor <= 1.0,
          "damping.factor must be in [0, 1] (1 takes nothing, above 1 a body gains energy)", d.factor);
  require(options.rest_tolerance > 0.0, "rest_tolerance must be above 0", options.rest_tolerance);
  const double sleep = options.sleep_tolerance.value_or(0.0);
  require(not_negative(sleep),
          "sleep_tolerance must be finite and 0 (skip only what repeats itself) or more, or empty (no sleep)", sleep);
  require(options.max_displacement_per_step > 0.0,
          "max_displacement_per_step must be above 0 (infinite: no force is clamped)",
          options.max_displacement_per_step);
  require(options.max_substeps >= 1, "max_substeps must be 1 (one step for all materials) or more",
          options.max_substeps);
  if (options.max_substeps > 1 && options.sleep_tolerance) {
    throw Error(
        "SolverOptions::max_substeps and sleep_tolerance exclude each other: expected one of them; leave the other at "
        "its default");
  }
  require(options.rest_steps >= 1, "rest_steps must be 1 or more", options.rest_steps);
  require(not_negative(options.progress_seconds), "progress_seconds must be finite and 0 or more",
          options.progress_seconds);
  require(options.threads >= 0, "threads must be 0 (chosen by the solver) or more", options.threads);
  const int width = options.runner ? options.runner->width() : 1;
  require(width >= 1, "runner must have a width() of 1 (the calling thread alone) or more", width);
}

const char* why_no_steps(int n, double dt, bool to_rest, const Damping& damping) {
  if (n < 0) return "expected 0 steps or more, got a negative number";
  if (std::isinf(dt) && dt > 0.0) {
    return "expected a finite step; stable_step() is infinite for a body without stiffness, which sets no step of its "
           "own: give one in which its loads and tools move little, such as 1e-3 s";
  }
  if (!(dt > 0.0) || !std::isfinite(dt)) return "expected a finite step above 0 s";
  if (dt < smallest_step) return "expected a step of at least 1e-18 s; is a time in the wrong unit?";
  if (!(damping.rate >= 0.0) || !std::isfinite(damping.rate) || !(damping.factor >= 0.0 && damping.factor <= 1.0)) {
    return "expected a finite damping rate in 1/s, 0 or more, and a factor in [0, 1]";
  }
  if (to_rest && damping.rate == 0.0 && damping.factor == 1.0) {
    return "run_to_rest() expected damping, without which nothing comes to rest; set SolverOptions::damping.rate "
           "(1/s), or call step()";
  }
  return nullptr;
}

}  // namespace phymul
