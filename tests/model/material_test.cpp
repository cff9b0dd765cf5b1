// SPDX-License-Identifier: MIT
//
// Young's modulus and Poisson's ratio in, Young's modulus and Poisson's ratio out; and beams that bend as beams do.
#include <gtest/gtest.h>

#include <cstdio>

#include "support/bodies.h"
#include "support/mechanics.h"

namespace phymul::test {
namespace {

TEST(Material, UniformStretchIsExactOnEveryMesh) {
  const std::vector<std::pair<const char*, Model>> meshes = {
      {"lattice", make_block({0.04, 0.02, 0.03}, 4, 2, 3)},
      {"tetrahedra", make_tetrahedral_block({0.05, 0.04, 0.04}, 5, 4, 4, 0.2, 1)},
      {"tetrahedra, another mesh", make_tetrahedral_block({0.04, 0.03, 0.03}, 4, 3, 3, 0.2, 2)}};
  for (const auto& [name, shape] : meshes) {
    for (const double poisson : {0.0, 0.3, 0.45}) {
      Model model = shape;
      const Material tissue = soft_tissue(poisson);
      set_material(model, tissue);
      const Moduli found = stretch_block(model, build_topology(model), 1e-4);
      std::printf("%-26s nu %.2f: E / asked %.5f, nu found %.5f\n", name, poisson, found.young / tissue.young,
                  found.poisson);
      // Of a strain of 1e-4, and of how far the body was let come to rest.
      EXPECT_NEAR(found.young, tissue.young, 1e-3 * tissue.young) << name;
      EXPECT_NEAR(found.poisson, poisson, 1e-3) << name;
    }
  }
}

TEST(Material, CantileverAgreesWithTimoshenko) {
  for (double poisson : {0.0, 0.3, 0.45}) {
    const Material tissue = soft_tissue(poisson);
    const Model beam = cantilever(4, tissue);
    const double ratio = cantilever_ratio(beam, build_topology(beam), tissue, Root::beam);
    std::printf("cantilever of four cells across, nu %.2f: %.4f\n", poisson, ratio);
    EXPECT_NEAR(ratio, 1.0, 0.03) << "nu " << poisson;
  }
}

TEST(Material, AveragedEnergyDoesNotConverge) {
  const Material tissue = soft_tissue();
  double ratio[2];
  for (int k = 0; k < 2; ++k) {
    const Model beam = cantilever(2 << k, tissue);
    ratio[k] = cantilever_ratio(beam, averaged_tables(beam), tissue, Root::beam);
    std::printf("cantilever n = %d, averaged energy: %.3f\n", 2 << k, ratio[k]);
  }
  EXPECT_GT(ratio[1], 2.0 * ratio[0]);  // softer and softer: the deflection runs away from 1
  EXPECT_GT(ratio[1], 2.0);
}

}  // namespace
}  // namespace phymul::test
