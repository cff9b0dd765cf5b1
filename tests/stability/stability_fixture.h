// SPDX-License-Identifier: MIT
//
// The fixture of stability tests that every backend of the build runs.
#pragma once

#include <limits>
#include <string>

#include "stability_methods.h"
#include "support/every_backend.h"
#include "support/sanitized.h"

namespace phymul::test {

class OnBackend : public OnEveryBackend {
 protected:
  static std::unique_ptr<Solver> make(const Model& model, const Scene& scene, const TopologyOptions& topology = {},
                                      const SolverOptions& options = {}) {
    return make_solver(GetParam(), model, scene, topology, options);
  }
  static bool is_reference() { return GetParam() == "reference"; }
  /// Where a software renderer may stand in for a GPU, and where sanitizers are: bodies and runs are cut down.
  static bool is_slow() { return GetParam().starts_with("gl") || sanitized; }
};

/// Takes nothing from growth, whatever the step.
inline SolverOptions any_step_uncut() {
  return {.on_unstable = UnstableStep::allow, .max_displacement_per_step = std::numeric_limits<double>::infinity()};
}

inline Method method_named(const std::string& name) {
  for (Method& method : stability_methods()) {
    if (method.name == name) return method;
  }
  throw Error("no method is called " + name);
}

}  // namespace phymul::test
