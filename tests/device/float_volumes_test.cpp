// SPDX-License-Identifier: MIT
//
// Kept volumes in single precision, as far as no device is needed: tables, the root, and the mirror against the
// reference.
#include <gtest/gtest.h>

#include <cmath>

#include "device/float_volumes.h"
#include "mirror/mirror.h"
#include "mirror/volume_root.h"
#include "model/enclosed_volume.h"
#include "support/mechanics.h"
#include "support/run_scenes.h"

namespace phymul {
namespace {

using namespace test;

/// Far from where a branch ends both find the same root or none.
TEST(FloatVolumes, RootsAreThoseInDoublePrecision) {
  std::mt19937 bits(12);
  int roots = 0, none = 0;
  for (int k = 0; k < 20000; ++k) {
    const float c1 = static_cast<float>(std::pow(10.0, 3.0 * uniform(bits))), c2 = static_cast<float>(uniform(bits)),
                c3 = static_cast<float>(uniform(bits));
    const float wanted = static_cast<float>(2.0 * uniform(bits));
    const auto exact = root_of_cubic({c1, c2, c3}, wanted);
    const auto near = root_of_cubic({c1, c2, c3}, 1.001 * wanted), nearer = root_of_cubic({c1, c2, c3}, 0.999 * wanted);
    const cpu::VolumeRoot root = cpu::root_of_cubic(c1, c2, c3, wanted);
    if (near.has_value() != nearer.has_value()) continue;
    ASSERT_EQ(root.found, exact.has_value()) << c1 << ' ' << c2 << ' ' << c3 << ' ' << wanted;
    if (!root.found) {
      ++none;
      continue;
    }
    ++roots;
    const double s = root.s, c_s = std::abs(c1 * s) + std::abs(c2 * s * s) + std::abs(c3 * s * s * s);
    EXPECT_NEAR(((c3 * s + c2) * s + c1) * s, wanted, 16.0 * 0x1p-24 * (c_s + std::abs(wanted)));
    EXPECT_NEAR(s, *exact, std::abs(*near - *nearer)) << c1 << ' ' << c2 << ' ' << c3 << ' ' << wanted;
  }
  EXPECT_GT(roots, 10000);
  EXPECT_GT(none, 100);
  EXPECT_FALSE(cpu::root_of_cubic(0.0f, 1.0f, 1.0f, 0.1f).found);
  EXPECT_FALSE(cpu::root_of_cubic(-1.0f, 0.0f, 1.0f, 0.1f).found);
  EXPECT_FALSE(cpu::root_of_cubic(1.0f, 0.0f, 0.0f, NAN).found);
  EXPECT_FALSE(cpu::root_of_cubic(INFINITY, 0.0f, 0.0f, 1.0f).found);
  EXPECT_EQ(cpu::root_of_cubic(1.0f, 1.0f, 1.0f, 0.0f).s, 0.0f);
}

/// Held, squeezed and let go again, the rest of it at rest: see KeptVolume.LeavesHeldParticlesAndComesToRest.
TEST(FloatVolumes, TheMirrorComesToRestWithItsVolume) {
  Model model = make_block({0.03, 0.02, 0.02}, 6, 4, 4);
  for (double& k : model.stiffness) k = 5.0;
  for (double& m : model.mass) m = 1e-4;
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -9.81}).constrain_volume();
  const SolverOptions options{.damping = {.rate = 30.0}, .rest_tolerance = 1e-5};
  const auto tables = std::make_shared<const TopologyTextures>(build_topology(model, {}));
  const auto mirror = cpu::make_mirror_solver(tables, scene, options);
  const auto reference = make_solver("reference", tables, scene, options);
  const double dt = 0.4 * reference->stable_step();
  const RestResult a = mirror->run_to_rest(100000, dt), b = reference->run_to_rest(100000, dt);
  EXPECT_TRUE(a.converged() && b.converged()) << a.message();
  EXPECT_NEAR(a.report.steps, b.report.steps, 0.02 * b.report.steps);
  const State x = mirror->read(), y = reference->read();
  const double moved = largest_distance(y.position, model.rest), off = largest_distance(x.position, y.position);
  EXPECT_GT(moved, 1e-3);
  EXPECT_LT(off, 1e-4 * moved);
  const VolumeConstraint& kept = scene.volume_constraints()[0];
  EXPECT_NEAR(enclosed_volume(kept.triangles, x.position) / kept.volume, 1.0, 1e-6);
}

}  // namespace
}  // namespace phymul
