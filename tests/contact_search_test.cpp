// SPDX-License-Identifier: MIT
//
// Which triangle of another body a particle meets, and on which side of it the particle is.
#include <gtest/gtest.h>

#include "run_scenes.h"

namespace phymul {
namespace {

using namespace test;

Vec3 middle_of(const State& state, const std::vector<Index>& particles) {
  Vec3 sum = Vec3::Zero();
  for (const Index i : particles) sum += state.position[i];
  return sum / static_cast<double>(particles.size());
}

/// A cube of one cell, inside another body: its low corner, and its edge, m.
Model small_cube(const Vec3& at, double edge) {
  return moved(make_block(Vec3::Constant(edge), 1, 1, 1), at);
}

/// What contacts do to two bodies in a step from rest.
struct Effect {
  Vec3 way{0, 0, 0};  // m, of the middle of the small one
  bool none = false;  // no bit of any particle
};

/// Beside them is a body with edges of 6 cm, which touches neither.
Effect effect_of_contacts(const Model& big, const Model& small, const char* backend) {
  const Model coarse = small_cube({0, 0, 0.5}, 0.06);
  const NamedBody bodies[] = {{"big", &big}, {"small", &small}, {"coarse", &coarse}};
  const Model model = merge_models(bodies);
  State end[2];
  for (const bool touching : {false, true}) {
    Scene scene(model);
    if (touching) scene.contacts({.skin = 1e-4});
    const auto solver = make_solver(backend, model, scene, {}, options_for({backend, 1}));
    EXPECT_TRUE(solver->step(1, 0.4 * solver->stable_step()).ok());
    end[touching] = solver->read();
  }
  const std::vector<Index> own = model.group("small");
  return {middle_of(end[1], own) - middle_of(end[0], own), end[0] == end[1]};
}

/// Inside is what has got no deeper than the longer edge of the two that meet, however coarse another body is.
TEST(ContactSearch, InsideIsAsDeepAsTheLongerEdgeOfTheTwo) {
  struct Case {
    int cells;           // of 3 cm along each axis
    double edge, depth;  // m; of the small cube, and of its top below the side
    bool inside;
  };
  const Case cases[] = {
      {6, 0.002, 0.0055, false}, {6, 0.002, 0.0045, true}, {5, 0.002, 0.0055, true}, {6, 0.006, 0.0055, true}};
  for (const char* backend : {"reference", "cpu"}) {
    for (const Case& c : cases) {
      const Model big = make_block({0.03, 0.03, 0.03}, c.cells, c.cells, c.cells);
      const double low = 0.015 - 0.5 * c.edge;
      const Effect effect = effect_of_contacts(big, small_cube({low, low, 0.03 - c.depth - c.edge}, c.edge), backend);
      SCOPED_TRACE(testing::Message() << backend << ", " << c.cells << " cells, " << c.edge << " m");
      EXPECT_EQ(effect.none, !c.inside);
      EXPECT_EQ(effect.way.z() > 1e-7, c.inside) << effect.way.transpose();
    }
  }
}

/// Two cells along x: sides across it have edges of 5 mm, the others of 20 mm.
TEST(ContactSearch, DeepBelowAFineSideNoCoarseOneLeadsOut) {
  const Model big = make_block({0.04, 0.02, 0.02}, 2, 4, 4);
  for (const char* backend : {"reference", "cpu"}) {
    const auto effect = [&](double below) {
      return effect_of_contacts(big, small_cube({0.039 - below, 0.011, 0.0095}, 0.001), backend);
    };
    EXPECT_GT(effect(0.003).way.x(), 1e-7) << backend;  // it came in there
    EXPECT_TRUE(effect(0.0065).none) << backend;        // 8 mm below a coarse side
    EXPECT_GT(effect(0.012).way.y(), 1e-7) << backend;  // the coarse side is the nearest
  }
}

/// A body all in one point, a particle of another one on it: no triangle has a normal, and the point gives no
/// direction.
TEST(ContactSearch, TrianglesWithoutAreaGiveNoDirection) {
  const double size = 0x1p-6;  // m; places are exact in floats too
  const Model low = small_cube({0, 0, 0}, size), high = small_cube({0, 0, 2 * size}, size);
  const NamedBody bodies[] = {{"low", &low}, {"high", &high}};
  const Model model = merge_models(bodies);
  for (const char* backend : {"reference", "cpu"}) {
    Scene scene(model);
    scene.contacts({});
    const auto solver = make_solver(backend, model, scene, {}, options_for({backend, 1}));
    State state = rest_state(model);
    for (const Index i : model.group("high")) state.position[i] = model.rest[model.group("low").front()];
    solver->reset(state);
    const StepReport report = solver->step(20, 0.4 * solver->stable_step());
    EXPECT_TRUE(report.ok()) << backend << ": " << report.message();
    for (const Vec3& x : solver->read().position) EXPECT_LT(x.norm(), 10 * size) << backend;
  }
}

}  // namespace
}  // namespace phymul
