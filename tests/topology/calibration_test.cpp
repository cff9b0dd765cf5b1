// SPDX-License-Identifier: MIT
//
// From Young's modulus and Poisson's ratio to stiffness, and what may stand in the way.
#include <gtest/gtest.h>

#include "model/file_extras.h"
#include "support/bodies.h"
#include "support/message_of.h"
#include "topology/cell_terms.h"

namespace phymul::test {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

bool says(const std::string& text, const char* part) {
  return text.find(part) != std::string::npos;
}

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

TEST(Calibration, ConstantsOfTheVolumeRoute) {
  const Calibration c = calibrate({10e3, 0.25, 1000}, PoissonRoute::volume_term);  // mu = lambda = 4 kPa
  EXPECT_NEAR(c.c, 15.0 / 7.0 * 4e3, 1e-9);
  EXPECT_NEAR(c.kappa, 4e3 + 3.0 / 7.0 * 4e3, 1e-9);
  EXPECT_EQ(c.exponent, 0.0);
  EXPECT_NEAR(calibrate({10e3, -0.375, 1000}, PoissonRoute::volume_term).kappa, 0.0, 1e-9);
}

TEST(Calibration, ConstantsOfTheAreaRoute) {
  const auto by_area = [](double nu) { return calibrate({1.0, nu, 1.0}, PoissonRoute::area_exponent); };
  EXPECT_NEAR(by_area(-0.375).exponent, 0.0, 1e-12);
  EXPECT_NEAR(1.0 / by_area(-0.375).c, 7.0 / 12.0, 1e-12);
  EXPECT_NEAR(by_area(11.0 / 34.0).exponent, 1.0, 1e-12);
  EXPECT_NEAR(1.0 / by_area(11.0 / 34.0).c, 18.0 / 17.0, 1e-12);
  EXPECT_NEAR(by_area(1.0 / 7.0).exponent, 0.5, 1e-12);
  for (double nu = -0.37; nu < 0.42; nu += 0.01) EXPECT_LT(by_area(nu).exponent, by_area(nu + 0.0004).exponent);
  EXPECT_EQ(by_area(0.3).kappa, 0.0);
}

TEST(Calibration, RatioOutOfTheRoutesRangeIsRefused) {
  const auto refuse = [](double young, double nu, PoissonRoute route) {
    return message_of([&] { calibrate({young, nu, 1000}, route); });
  };
  EXPECT_TRUE(
      says(refuse(1e4, 0.5, PoissonRoute::volume_term), "Poisson's ratio is 0.5; this route takes -0.375 to 0.5"));
  EXPECT_TRUE(says(refuse(1e4, -0.4, PoissonRoute::volume_term), "Poisson's ratio is -0.4"));
  EXPECT_TRUE(says(refuse(1e4, 0.45, PoissonRoute::area_exponent), "Use the volume term"));
  EXPECT_TRUE(says(refuse(0.0, 0.3, PoissonRoute::volume_term), "Young's modulus is 0 Pa"));
  EXPECT_TRUE(says(refuse(NAN, 0.3, PoissonRoute::volume_term), "Young's modulus is nan"));
  EXPECT_TRUE(says(refuse(1e4, NAN, PoissonRoute::area_exponent), "Poisson's ratio is nan"));
}

TEST(Calibration, CubeIsExactlyIsotropic) {
  for (double nu : {0.0, 0.3, 0.4, 0.45}) {
    for (double gamma : {0.0, 0.9}) {
      for (PoissonRoute route : {PoissonRoute::volume_term, PoissonRoute::area_exponent}) {
        if (route == PoissonRoute::area_exponent && (gamma > 0.0 || nu > 0.42)) continue;
        Model cube = make_block({0.01, 0.01, 0.01}, 1, 1, 1);
        set_material(cube, soft_tissue(nu));
        TopologyOptions options;
        options.cell_average = gamma;
        options.poisson_route = route;
        const TopologyTextures t = build_topology(cube, options);
        EXPECT_EQ(t.cells.empty(), gamma == 0.0);
        const Matrix6 c = affine_elasticity(t, 1e-6);
        const Matrix6 wanted = isotropic_elasticity(soft_tissue(nu));
        EXPECT_LT((c - wanted).norm(), 1e-6 * wanted.norm()) << "nu " << nu << " gamma " << gamma;
      }
    }
  }
}

TEST(Calibration, OtherCellsAreIsotropicWithinThreePerCent) {
  std::vector<Body> all{
      {"flat", make_block({0.02, 0.02, 0.01}, 2, 2, 2)}, {"cylinder", cylinder_275()}, {"jittered", jittered_block()}};
  all.push_back({"tetrahedra", make_tetrahedral_block({0.03, 0.02, 0.02}, 3, 2, 2, 0.2, 5)});
  all.push_back({"tetrahedron", make_tetrahedron(0.01)});
  for (const Body& body : all) {
    for (double nu : {0.0, 0.45}) {
      Model model = body.model;
      set_material(model, soft_tissue(nu));
      const Matrix6 c = affine_elasticity(build_topology(model), volume_of(model));
      const Matrix6 wanted = isotropic_elasticity(soft_tissue(nu));
      const double worst = (c - wanted).cwiseAbs().maxCoeff() / (2 * wanted(5, 5));
      EXPECT_LT(worst, body.name == "tetrahedron" ? 0.06 : 0.03) << body.name << " nu " << nu;
    }
  }
}

TEST(Calibration, FittedSetsAreIsotropicInsideABody) {
  Model block = make_block({0.06, 0.06, 0.06}, 6, 6, 6, 26);
  set_material(block, soft_tissue());
  TopologyOptions options;
  options.bases = BaseSelection::fitted;
  const Matrix6 c = affine_elasticity(build_topology(block, options), 0.06 * 0.06 * 0.06);
  const Matrix6 wanted = isotropic_elasticity(soft_tissue());
  EXPECT_LT((c - wanted).norm(), 0.05 * wanted.norm());
}

TEST(Calibration, StiffnessIsWhatTheMaterialSaysNotWhatTheModelHeld) {
  Model block = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  set_material(block, soft_tissue());
  const std::vector<double> before = build_topology(block).stiffness;
  std::fill(block.stiffness.begin(), block.stiffness.end(), 1e9);
  EXPECT_EQ(build_topology(block).stiffness, before);
  set_material(block, {20e3, 0.3, 1000});
  const std::vector<double> twice = build_topology(block).stiffness;
  for (std::size_t i = 0; i < twice.size(); ++i) EXPECT_NEAR(twice[i], 2 * before[i], 1e-9 * before[i]);
}

TEST(Calibration, SelectionOfAModelWithMaterial) {
  Model block = make_block({0.02, 0.02, 0.02}, 2, 2, 2, 26);
  set_material(block, soft_tissue());
  TopologyOptions options;
  for (BaseSelection asked : {BaseSelection::all, BaseSelection::thresholded, BaseSelection::fitted}) {
    options.bases = asked;
    const TopologyTextures t = build_topology(block, options);
    EXPECT_EQ(t.options.bases, asked == BaseSelection::fitted ? asked : BaseSelection::opposite_faces);
  }
  options.poisson_route = PoissonRoute::area_exponent;
  EXPECT_NEAR(build_topology(block, options).options.area_exponent,
              calibrate(soft_tissue(), options.poisson_route).exponent, 1e-15);
  EXPECT_TRUE(build_topology(block, options).volumes.empty());
}

TEST(Calibration, WhatCannotCarryAMaterialSaysSo) {
  Model block = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  set_material(block, soft_tissue());
  const auto refuse = [](const Model& model, auto&& set) {
    TopologyOptions options;
    set(options);
    return message_of([&] { build_topology(model, options); });
  };
  EXPECT_TRUE(
      says(refuse(block, [](TopologyOptions& o) { o.law = Law::springs; }), "springs take their stiffness in N/m"));
  EXPECT_TRUE(
      says(refuse(block, [](TopologyOptions& o) { o.reaction = Reaction::shared; }), "needs Reaction::conservative"));
  EXPECT_TRUE(says(refuse(block, [](TopologyOptions& o) { o.volume_stiffness = 1; }),
                   "volume_stiffness is for models without"));
  EXPECT_TRUE(
      says(refuse(block, [](TopologyOptions& o) { o.area_exponent = 1; }), "area_exponent follows from the material"));
  EXPECT_TRUE(says(refuse(block,
                          [](TopologyOptions& o) {
                            o.cell_average = 0.9;
                            o.poisson_route = PoissonRoute::area_exponent;
                          }),
                   "cell_average goes with PoissonRoute::volume_term"));
  Model holed = block;
  holed.cells[3].material = -1;
  change_extras(holed, [](FileExtras& extras) { extras.cell_index = {-1, -1, -1, 12}; });
  EXPECT_TRUE(says(refuse(holed, [](TopologyOptions&) {}), "cell 3 (HEXAHEDRON, file index 12) has no material"));
  Model two = block;
  two.materials.push_back(soft_tissue(0.1));
  two.cells[0].material = 1;
  EXPECT_EQ(refuse(two, [](TopologyOptions&) {}), "(no error)");
  EXPECT_TRUE(says(refuse(two, [](TopologyOptions& o) { o.poisson_route = PoissonRoute::area_exponent; }),
                   "one for the whole body"));
}

TEST(CellTerms, MeanGradientsReproduceLinearFields) {
  // Tetrahedra, wedges, hexahedra with bent faces, and a pyramid.
  std::vector<Model> all{jittered_block(), cylinder_275(), make_tetrahedral_block({3, 2, 2}, 3, 2, 2, 0.2, 5)};
  Model pyramid = make_block({1, 1, 1}, 1, 1, 1);
  pyramid.cells[0].type = CellType::pyramid;
  pyramid.cells[0].particles = {0, 1, 3, 2, 7};
  all.push_back(pyramid);
  for (const Model& model : all) {
    for (const Cell& cell : model.cells) {
      const std::array<Vec3, 8> gradient = mean_gradients(model, cell);
      Vec3 sum = Vec3::Zero();
      Mat3 f = Mat3::Zero();
      for (std::size_t v = 0; v < cell.particles.size(); ++v) {
        sum += gradient[v];
        f += model.rest[cell.particles[v]] * gradient[v].transpose();
      }
      EXPECT_LT(sum.norm() * body_size(model), 1e-10);
      EXPECT_LT((f - Mat3::Identity()).norm(), 1e-10);
      for (std::size_t v = cell.particles.size(); v < 8; ++v) EXPECT_EQ(gradient[v], Vec3(0, 0, 0));
    }
  }
}

}  // namespace
}  // namespace phymul::test
