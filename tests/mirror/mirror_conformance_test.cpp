// SPDX-License-Identifier: MIT
//
// The float mirror passes what every backend must. The tests themselves are in solver_conformance_test.cpp.
#include "conformance/solver_conformance_fixture.h"
#include "mirror.h"

namespace phymul::test {
namespace {

BackendUnderTest mirror() {
  return {"mirror",
          [](const Model& model, const Scene& scene, const TopologyOptions& topology, const SolverOptions& options) {
            return cpu::make_mirror_solver(std::make_shared<const TopologyTextures>(build_topology(model, topology)),
                                           scene, options);
          },
          0x1p-24};
}

INSTANTIATE_TEST_SUITE_P(Float, SolverConformance, testing::Values(mirror()),
                         [](const auto& backend) { return backend.param.name; });

}  // namespace
}  // namespace phymul::test
