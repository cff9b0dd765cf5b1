// SPDX-License-Identifier: MIT
//
// That what is calibrated on a body depends on nothing but the body.
#include <gtest/gtest.h>

#include "support/bodies.h"
#include "topology/body_frames.h"

namespace phymul::test {
namespace {

/// However a body is turned, and beside whatever other.
TEST(BodyFrames, TheStabiliserIsTheBodysOwn) {
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  for (const Model& shape : {make_block({0.03, 0.02, 0.02}, 3, 2, 2), make_block({0.04, 0.04, 0.04}, 4, 4, 4),
                             make_tetrahedral_block({0.08, 0.02, 0.02}, 12, 3, 3, 0.2, 3),
                             make_cylinder(0.01, 0.04, 3, 8, 11), make_strip(0.04, 0.02, 4, 2)}) {
    const Model model = with_material(shape);
    const double alone = *build_topology(model).options.stabiliser;
    Model turned = model;
    for (Vec3& p : turned.rest) {
      p = shape.dimension == 2 ? Vec3(0.6 * p.x() - 0.8 * p.y(), 0.8 * p.x() + 0.6 * p.y(), 0.0) : Vec3(turn * p);
    }
    EXPECT_NEAR(*build_topology(turned).options.stabiliser, alone, 2e-6);
    Model other = with_material(make_block({0.03, 0.01, 0.02}, 9, 2, 5));
    if (shape.dimension == 2) continue;
    const std::vector<NamedBody> both{{"one", &model}, {"other", &other}};
    const TopologyTextures tables = build_topology(merge_models(both));
    const TopologyTextures own = build_topology(model);
    for (std::size_t d = 0; d < own.domains.size(); ++d) {
      ASSERT_NEAR(tables.domains[d].spread_stiffness, own.domains[d].spread_stiffness,
                  1e-9 * own.domains[d].spread_stiffness);
    }
  }
}

/// A bar that lies slanted, and a cube's lattice, whose moments tell nothing.
TEST(BodyFrames, AxesLieAsTheBodyDoes) {
  const Mat3 turn = Eigen::AngleAxisd(0.6, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  for (Model model : {make_block({0.05, 0.02, 0.01}, 5, 4, 3), make_block({0.04, 0.04, 0.04}, 4, 4, 4, 26)}) {
    for (Vec3& p : model.rest) p = turn * p;
    const auto pairs = [&](const auto& visit) {
      for (Index i = 0; i < model.particle_count(); ++i) {
        for (const Index* j = model.neighbours.begin(i); j != model.neighbours.end(i); ++j) visit(i, *j);
      }
    };
    const BodyFrames frames(model, std::vector<double>(model.rest.size(), 1e-6), pairs);
    ASSERT_EQ(frames.parts(), 1);
    const Mat3 along = turn.transpose() * frames.of_part(0).axes;
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(along.col(axis).cwiseAbs().maxCoeff(), 1.0, 1e-9);
  }
}

}  // namespace
}  // namespace phymul::test
