// SPDX-License-Identifier: MIT
//
// The fixture of the tests that every backend runs; see solver_conformance.h.
#pragma once

#include <gtest/gtest.h>

#include <functional>

#include "support/bodies.h"
#include "support/every_backend.h"

namespace phymul::test {

struct BackendUnderTest {
  std::string name;
  std::function<std::unique_ptr<Solver>(const Model&, const Scene&, const TopologyOptions&, const SolverOptions&)> make;
  double roundoff = 0x1p-53;  ///< of one operation of its arithmetic
  /// A sentence where this machine cannot run it: its tests are skipped, or fail. Null: it always can.
  std::function<std::string()> why_not = {};
};

inline void PrintTo(const BackendUnderTest& backend, std::ostream* out) {
  *out << backend.name;
}

class SolverConformance : public testing::TestWithParam<BackendUnderTest> {
 protected:
  void SetUp() override { PHYMUL_SKIP_OR_FAIL(GetParam().why_not ? GetParam().why_not() : ""); }

  static std::unique_ptr<Solver> make(const Model& model, const Scene& scene, const SolverOptions& options = {},
                                      const TopologyOptions& topology = {}) {
    return GetParam().make(model, scene, topology, options);
  }
  static double roundoff() { return GetParam().roundoff; }

  const Model model_ = with_material(make_block({0.03, 0.02, 0.02}, 3, 2, 2));
};

}  // namespace phymul::test
