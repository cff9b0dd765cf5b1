// SPDX-License-Identifier: MIT
//
// The vector backend where one particle is far away and all others are at rest: rows of a slice, and faces of a
// simplex, go by the widest ratio among them.
#include <gtest/gtest.h>

#include "support/cpu_forces.h"

namespace phymul::test {
namespace {

/// Forces of every instruction set within the rounding bound, with some particle or other moved by so many spacings.
void expect_exact(const Model& model, const TopologyOptions& options, std::initializer_list<double> spacings) {
  const auto tables = std::make_shared<const TopologyTextures>(build_topology(model, options));
  const Scene scene(model);
  const double h = mean_spacing(model);
  for (const double way : spacings) {
    for (const Index moved : {0, model.particle_count() / 3, model.particle_count() / 2, model.particle_count() - 1}) {
      VecList u(model.rest.size(), Vec3::Zero());
      u[moved] = (way * h * Vec3(1.0, -0.5, 0.25)).cast<float>().cast<double>();
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

TEST(CpuFarParticle, SpringsAreExact) {
  TopologyOptions options;
  options.law = Law::springs;
  expect_exact(make_block({0.06, 0.06, 0.06}, 6, 6, 6, 26), options, {0.4, 4.0, 1e4});
}

}  // namespace
}  // namespace phymul::test
