// SPDX-License-Identifier: MIT
//
// Young's modulus and Poisson's ratio in, Young's modulus and Poisson's ratio out; and beams that bend as beams do.
#include <gtest/gtest.h>

#include <cstdio>

#include "support/bodies.h"
#include "support/mechanics.h"

namespace phymul::test {
namespace {

TopologyOptions averaged_over_cells() {
  TopologyOptions options;
  options.cell_average = 0.9;
  return options;
}

void expect_moduli(const char* name, const Model& shape, const TopologyOptions& options, double tolerance,
                   std::initializer_list<double> ratios) {
  for (double poisson : ratios) {
    Model model = shape;
    const Material tissue = soft_tissue(poisson);
    set_material(model, tissue);
    const Moduli found = stretch_block(model, build_topology(model, options), 1e-4);
    std::printf("%-44s nu %.2f: E / asked %.4f, nu found %.4f\n", name, poisson, found.young / tissue.young,
                found.poisson);
    EXPECT_NEAR(found.young, tissue.young, tolerance * tissue.young) << name;
    EXPECT_NEAR(found.poisson, poisson, tolerance) << name;
  }
}

TEST(Material, UniformStretchOfALattice) {
  const Model block = make_block({0.04, 0.02, 0.03}, 4, 2, 3);
  expect_moduli("lattice, per base", block, {}, 0.02, {0.0, 0.3, 0.45});
  expect_moduli("lattice, cell-averaged", block, averaged_over_cells(), 0.02, {0.0, 0.3, 0.45});
  TopologyOptions exponent;
  exponent.poisson_route = PoissonRoute::area_exponent;
  expect_moduli("lattice, per base, area exponent", block, exponent, 0.02, {0.0, 0.3, 0.4});
}

TEST(Material, UniformStretchOfUnstructuredTetrahedra) {
  expect_moduli("tetrahedra", make_tetrahedral_block({0.05, 0.04, 0.04}, 5, 4, 4, 0.2, 1), {}, 0.05, {0.0, 0.3, 0.45});
  const Model mesh = make_tetrahedral_block({0.04, 0.03, 0.03}, 4, 3, 3, 0.2, 2);
  expect_moduli("tetrahedra, another mesh", mesh, {}, 0.05, {0.3});
  TopologyOptions fitted;
  fitted.bases = BaseSelection::fitted;
  expect_moduli("tetrahedra, fitted bases", mesh, fitted, 0.05, {0.0, 0.45});
  TopologyOptions exponent;
  exponent.poisson_route = PoissonRoute::area_exponent;
  expect_moduli("tetrahedra, area exponent", mesh, exponent, 0.05, {0.3});
}

/// Cell-averaged beams are right at four cells across; per base, refinement closes the gap towards second order.
TEST(Material, CantileverConvergesToTimoshenko) {
  for (double poisson : {0.0, 0.3, 0.45}) {
    const Material tissue = soft_tissue(poisson);
    const Model beam = cantilever(4, tissue);
    const double ratio = cantilever_ratio(beam, build_topology(beam, averaged_over_cells()), tissue, Root::beam);
    std::printf("cantilever n = 4, nu %.2f: cell-averaged %.4f\n", poisson, ratio);
    EXPECT_NEAR(ratio, 1.0, 0.05) << "nu " << poisson;
  }
  const Material tissue = soft_tissue();
  double gap[2] = {};
  for (int k = 0; k < 2; ++k) {
    const Model beam = cantilever(2 << k, tissue);
    gap[k] = 1.0 - cantilever_ratio(beam, build_topology(beam), tissue, Root::beam);
    std::printf("cantilever n = %d, nu 0.30: per base %.4f\n", 2 << k, 1.0 - gap[k]);
  }
  EXPECT_GT(gap[1], 0.0);
  EXPECT_LT(gap[1], 0.5 * gap[0]);
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
