// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <iostream>
#include <random>

#include "elastic/dissipation.h"
#include "support/cpu_forces.h"

namespace phymul::test {
namespace {

StrainMemory random_strains(const TopologyTextures& topology) {
  std::mt19937 bits(17);
  StrainMemory strains(topology.domains.size() * kept_strains(topology).count());
  for (Strain& strain : strains) {
    for (double& e : strain) e = static_cast<float>(0.1 * uniform(bits));
  }
  return strains;
}

TEST(CpuDissipation, ForcesAreWithinTheRoundingBound) {
  std::vector<Body> all = bodies();
  all.push_back({"lattice", make_block({0.2, 0.06, 0.06}, 20, 6, 6)});
  double worst = 0.0;
  for (const Body& body : all) {
    for (const int kinds : {1, 2, 3}) {
      Model model = body.model;
      Material material = soft_tissue();
      if ((kinds & 1) != 0) material.retardation_time = 2e-3;
      if ((kinds & 2) != 0) material.relaxation_strength = 1.5;
      material.relaxation_time = 0.01;
      set_material(model, material);
      const auto tables =
          std::make_shared<const TopologyTextures>(build_topology(model, {.on_sparse = SparseParticle::free}));
      const Scene scene(model);
      const VecList u = random_displacements(model, 0.1, 5), x = sum_of(model.rest, u);
      const StrainMemory strains = random_strains(*tables);
      const double last_dt = 0x1p-12;

      VecList exact(x.size());
      elastic_forces(*tables, x, exact);
      Dissipation dissipation(*tables);
      dissipation.reset(strains);
      dissipation.add_forces(*tables, x, tiny_step, last_dt, exact);
      const BoundedForces bounded(*tables, u, BoundedForces::DissipatingStep{strains, tiny_step, last_dt});

      Snapshot start;
      start.state = rest_state(model);
      start.state.position = x;
      start.last_dt = last_dt;
      put_strains(strains, start);
      for (const cpu::simd::Kernels* kernels : cpu::simd::usable_kernels()) {
        const InstructionSet chosen(kernels->name);
        const auto solver = make_solver("cpu", tables, scene, any_step());
        solver->restore(start);
        ASSERT_TRUE(solver->step(1, tiny_step).ok());
        const VecList found = solver->read().velocity;
        for (std::size_t i = 0; i < x.size(); ++i) {
          const Vec3 force = tables->mass[i] / tiny_step * found[i];
          const double share = share_of_bound(bounded.force(static_cast<Index>(i)), exact[i], force);
          ASSERT_LE(share, 1.0) << body.name << ", " << kinds << ", " << kernels->name << ", particle " << i;
          worst = std::max(worst, share);
        }
      }
    }
  }
  std::cout << "worst error: " << worst << " of the bound\n";
  EXPECT_GT(worst, 0.01);
}

}  // namespace
}  // namespace phymul::test
