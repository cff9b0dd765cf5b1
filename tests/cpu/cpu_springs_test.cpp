// SPDX-License-Identifier: MIT
//
// Springs of the vector backend where one of a particle's is stretched far and the others are not: the rows of a slice
// go by the widest ratio among them.
#include <gtest/gtest.h>

#include "support/cpu_forces.h"

namespace phymul::test {
namespace {

TEST(CpuSprings, AreExactAtLargeDisplacementsOfOneParticle) {
  Model model = make_block({0.06, 0.06, 0.06}, 6, 6, 6, 26);
  TopologyOptions options;
  options.law = Law::springs;
  const auto tables = std::make_shared<const TopologyTextures>(build_topology(model, options));
  const Scene scene(model);
  const double h = mean_spacing(model);
  for (const double way : {0.4 * h, 4.0 * h, 1e4 * h}) {
    for (const Index moved : {0, 24, 171, 342}) {
      VecList u(model.rest.size(), Vec3::Zero());
      u[moved] = (way * Vec3(1.0, -0.5, 0.25)).cast<float>().cast<double>();
      const VecList x = sum_of(model.rest, u);
      VecList exact(x.size());
      elastic_forces(*tables, x, exact);
      const BoundedForces bounded(*tables, u);
      for (const cpu::simd::Kernels* kernels : cpu::simd::usable_kernels()) {
        const InstructionSet chosen(kernels->name);
        const VecList found = forces_of(*make_solver("cpu", tables, scene, any_step()), x);
        for (std::size_t i = 0; i < x.size(); ++i) {
          ASSERT_LE(share_of_bound(bounded.force(static_cast<Index>(i)), exact[i], found[i]), 1.0)
              << kernels->name << ", " << way << ", particle " << i << " beside " << moved;
        }
      }
    }
  }
}

}  // namespace
}  // namespace phymul::test
