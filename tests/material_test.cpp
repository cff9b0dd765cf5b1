// SPDX-License-Identifier: MIT
//
// Young's modulus and Poisson's ratio in, Young's modulus and Poisson's ratio out; and beams that bend as beams do.
#include <gtest/gtest.h>

#include <cstdio>

#include "bodies.h"
#include "mechanics.h"

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
  for (int valence : {6, 26}) {
    const Model block = make_block({0.06, 0.04, 0.04}, 6, 4, 4, valence);
    expect_moduli("lattice, per base", block, {}, 0.02, {0.0, 0.3, 0.45});
    expect_moduli("lattice, cell-averaged", block, averaged_over_cells(), 0.02, {0.0, 0.3, 0.45});
  }
  TopologyOptions exponent;
  exponent.poisson_route = PoissonRoute::area_exponent;
  expect_moduli("lattice, per base, area exponent", make_block({0.06, 0.04, 0.04}, 6, 4, 4), exponent, 0.02,
                {0.0, 0.3, 0.4});
}

TEST(Material, UniformStretchOfUnstructuredTetrahedra) {
  for (std::uint32_t seed : {1u, 2u}) {
    const Model mesh = make_tetrahedral_block({0.06, 0.04, 0.04}, 6, 4, 4, 0.2, seed);
    expect_moduli("tetrahedra", mesh, {}, 0.05, {0.0, 0.3, 0.45});
    TopologyOptions fitted;
    fitted.bases = BaseSelection::fitted;
    expect_moduli("tetrahedra, fitted bases", mesh, fitted, 0.05, {0.0, 0.3, 0.45});
    TopologyOptions exponent;
    exponent.poisson_route = PoissonRoute::area_exponent;
    expect_moduli("tetrahedra, area exponent", mesh, exponent, 0.05, {0.3, 0.4});
  }
}

TEST(Material, CantileverConvergesToTimoshenko) {
  for (double poisson : {0.0, 0.3, 0.45}) {
    const Material tissue = soft_tissue(poisson);
    double base[2] = {}, cell[2] = {};
    for (int k = 0; k < 2; ++k) {
      const Model beam = cantilever(2 << k, tissue);
      base[k] = cantilever_ratio(beam, build_topology(beam), tissue, Root::beam);
      cell[k] = cantilever_ratio(beam, build_topology(beam, averaged_over_cells()), tissue, Root::beam);
      std::printf("cantilever n = %d, nu %.2f: per base %.4f, cell-averaged %.4f\n", 2 << k, poisson, base[k], cell[k]);
    }
    EXPECT_NEAR(cell[1], 1.0, 0.05) << "cell-averaged, n = 4, nu " << poisson;
    // Refining halves the distance to 1 at least, towards second order.
    EXPECT_LT(1.0 - base[1], 0.6 * (1.0 - base[0])) << "per base, nu " << poisson;
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
