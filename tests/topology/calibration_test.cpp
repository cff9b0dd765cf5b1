// SPDX-License-Identifier: MIT
//
// From Young's modulus and Poisson's ratio to stiffness, and what may stand in the way.
#include <gtest/gtest.h>

#include "model/file_extras.h"
#include "support/bodies.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Unit strains xx, yy, zz, yz, xz, xy (engineering shear 1).
Mat3 unit_strain(int k) {
  Mat3 e = Mat3::Zero();
  if (k < 3) {
    e(k, k) = 1.0;
  } else {
    const int a = k == 3 ? 1 : 0, b = k == 5 ? 1 : 2;
    e(a, b) = e(b, a) = 0.5;
  }
  return e;
}

// Elasticity of a body under affine strain, Pa: second differences of its energy, which is 0 at rest.
Matrix6 affine_elasticity(const TopologyTextures& t, double volume) {
  const double step = 1e-4;
  const auto energy = [&](const Mat3& strain) {
    double sum = 0.0;
    for (double sign : {-1.0, 1.0}) {
      VecList x = t.rest;
      for (Vec3& p : x) p += sign * step * strain * p;
      sum += elastic_energy(t, x) / (step * step);  // the two signs together: C e e
    }
    return sum / volume;
  };
  Matrix6 c;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      const Mat3 a = unit_strain(i), b = unit_strain(j);
      c(i, j) = (energy(a + b) - energy(a - b)) / 4.0;
    }
  }
  return c;
}

Matrix6 isotropic_elasticity(const Material& m) {
  const double mu = m.young / (2 * (1 + m.poisson));
  const double lambda = 2 * mu * m.poisson / (1 - 2 * m.poisson);
  Matrix6 c = Matrix6::Zero();
  c.topLeftCorner<3, 3>().setConstant(lambda);
  c.diagonal() << lambda + 2 * mu, lambda + 2 * mu, lambda + 2 * mu, mu, mu, mu;
  return c;
}

double volume_of(const Model& model) {
  double sum = 0.0;
  for (const Cell& cell : model.cells) sum += cell_volume(model, cell);
  return sum;
}

TEST(Calibration, ConstantsOfAMaterial) {
  const Calibration c = calibrate({10e3, 0.25, 1000});  // mu = lambda = 4 kPa
  EXPECT_NEAR(c.c, 15.0 / 7.0 * 4e3, 1e-9);
  EXPECT_NEAR(c.kappa, 4e3 + 3.0 / 7.0 * 4e3, 1e-9);
  EXPECT_NEAR(calibrate({10e3, -0.375, 1000}).kappa, 0.0, 1e-9);
}

TEST(Calibration, ConstantsOutOfRangeAreRefused) {
  const auto refuse = [](double young, double nu) { return message_of([&] { calibrate({young, nu, 1000}); }); };
  EXPECT_TRUE(says(refuse(1e4, 0.5), "Poisson's ratio is 0.5; expected -0.375 to 0.5"));
  EXPECT_TRUE(says(refuse(1e4, -0.4), "Poisson's ratio is -0.4"));
  EXPECT_TRUE(says(refuse(0.0, 0.3), "Young's modulus is 0 Pa"));
  EXPECT_TRUE(says(refuse(NAN, 0.3), "Young's modulus is nan"));
  EXPECT_TRUE(says(refuse(1e4, NAN), "Poisson's ratio is nan"));
}

TEST(Calibration, EveryBodyIsExactlyIsotropicUnderUniformStrain) {
  for (const Body& body : bodies()) {
    if (body.model.dimension == 2) continue;
    for (double nu : {0.0, 0.3, 0.45}) {
      Model model = body.model;
      set_material(model, soft_tissue(nu));
      const Matrix6 c = affine_elasticity(build_topology(model), volume_of(model));
      const Matrix6 wanted = isotropic_elasticity(soft_tissue(nu));
      EXPECT_LT((c - wanted).norm(), 1e-6 * wanted.norm()) << body.name << " nu " << nu;
    }
  }
}

TEST(Calibration, StiffnessIsWhatTheMaterialSaysNotWhatTheModelHeld) {
  Model block = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  set_material(block, soft_tissue());
  const VecList stretched = random_positions(block, 0.1, 1);
  const double before = elastic_energy(build_topology(block), stretched);
  std::fill(block.stiffness.begin(), block.stiffness.end(), 1e9);
  EXPECT_EQ(elastic_energy(build_topology(block), stretched), before);
  set_material(block, {20e3, 0.3, 1000});
  EXPECT_NEAR(elastic_energy(build_topology(block), stretched), 2 * before, 1e-9 * before);
}

TEST(Calibration, TheLawFollowsFromTheModel) {
  Model block = make_block({0.02, 0.02, 0.02}, 2, 2, 2, 26);
  EXPECT_EQ(build_topology(block).options.law, Law::shape_memory);
  set_material(block, soft_tissue());
  EXPECT_EQ(build_topology(block).options.law, Law::particle_averaged);
}

TEST(Calibration, WhatCannotCarryAMaterialSaysSo) {
  Model block = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  set_material(block, soft_tissue());
  const auto refuse = [](const Model& model, auto&& set) {
    TopologyOptions options;
    set(options);
    return message_of([&] { build_topology(model, options); });
  };
  for (const Law law : {Law::springs, Law::shape_memory}) {
    EXPECT_TRUE(says(refuse(block, [&](TopologyOptions& o) { o.law = law; }), "take their stiffness in N/m"));
  }
  EXPECT_TRUE(
      says(refuse(block, [](TopologyOptions& o) { o.reaction = Reaction::shared; }), "needs Reaction::conservative"));
  EXPECT_TRUE(says(refuse(block, [](TopologyOptions& o) { o.volume_stiffness = 1; }),
                   "volume_stiffness is for models without"));
  Model holed = block;
  holed.cells[3].material = -1;
  change_extras(holed, [](FileExtras& extras) { extras.cell_index = {-1, -1, -1, 12}; });
  EXPECT_TRUE(says(refuse(holed, [](TopologyOptions&) {}), "cell 3 (HEXAHEDRON, file index 12) has no material"));
  Model two = block;
  two.materials.push_back(soft_tissue(0.1));
  two.cells[0].material = 1;
  EXPECT_EQ(refuse(two, [](TopologyOptions&) {}), "(no error)");
}

}  // namespace
}  // namespace phymul::test
