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

/// Two blocks of different size, kept apart.
struct TwoBlocks {
  TwoBlocks() {
    const Model small = make_block({0.01, 0.01, 0.01}, 2, 2, 2), large = make_block({0.04, 0.03, 0.02}, 8, 6, 4);
    const Model away = moved(large, {0.1, 0, 0});
    const NamedBody bodies[] = {{"small", &small}, {"large", &away}};
    model = merge_models(bodies);
  }
  Model model;
};

TEST(FloatVolumes, SumsTakeEveryFacetOnceAndEndInOneOfEachVolume) {
  const TwoBlocks two;
  Scene scene(two.model);
  scene.constrain_volume("large").constrain_volume("small");
  const FloatVolumes tables = pack_volumes(scene);
  ASSERT_EQ(tables.count(), 2);
  const std::size_t of_large = scene.volume_constraints()[0].triangles.size();
  ASSERT_EQ(tables.facets.size(), of_large + scene.volume_constraints()[1].triangles.size());
  ASSERT_EQ(tables.levels.size(), 3u);  // 416 facets: 26, 2, 1
  // Of each level, what the nodes of a volume add, added up: the facets of that volume.
  std::vector<std::vector<std::int32_t>> under(tables.nodes.size());
  for (std::size_t level = 0; level < tables.levels.size(); ++level) {
    for (auto row = tables.levels[level][0]; row < tables.levels[level][1]; ++row) {
      const auto node = static_cast<std::size_t>(row);
      EXPECT_LE(tables.nodes[node][1] - tables.nodes[node][0], FloatVolumes::terms_a_sum);
      for (auto source = tables.nodes[node][0]; source < tables.nodes[node][1]; ++source) {
        if (level == 0) {
          under[node].push_back(source);
          continue;
        }
        const auto& own = under[static_cast<std::size_t>(source)];
        under[node].insert(under[node].end(), own.begin(), own.end());
      }
    }
  }
  for (std::size_t volume = 0; volume < 2; ++volume) {
    const auto node = static_cast<std::size_t>(tables.levels.back()[0]) + volume;
    EXPECT_EQ(tables.nodes[node][2], static_cast<std::int32_t>(volume));
    const std::size_t first = volume == 0 ? 0 : of_large, end = volume == 0 ? of_large : tables.facets.size();
    ASSERT_EQ(under[node].size(), end - first);
    for (std::size_t k = 0; k < under[node].size(); ++k) {
      EXPECT_EQ(under[node][k], static_cast<std::int32_t>(first + k));
    }
  }
}

TEST(FloatVolumes, ParticlesGatherTheFacetsTheyAreCornersOf) {
  const TwoBlocks two;
  Scene scene(two.model);
  scene.constrain_volume("small");
  const FloatVolumes tables = pack_volumes(scene);
  std::size_t gathered = 0;
  for (std::size_t i = 0; i < tables.ranges.size(); ++i) {
    const auto [first, end, volume, unused] = tables.ranges[i];
    EXPECT_EQ(volume, first < end ? 0 : -1);
    for (auto row = static_cast<std::size_t>(first); row < static_cast<std::size_t>(end); ++row) {
      const auto [a, b, c, facet] = tables.around[row];
      const auto corner = static_cast<std::int32_t>(i);
      EXPECT_TRUE(a == corner || b == corner || c == corner);
      EXPECT_EQ(tables.facets[static_cast<std::size_t>(facet)], (Int4{a, b, c, tables.facets[0][3]}));
      ++gathered;
    }
  }
  EXPECT_EQ(gathered, 3 * tables.facets.size());
  Scene none(two.model);
  EXPECT_TRUE(pack_volumes(none).empty());
}

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
  Scene scene(model);
  scene.fix("x0").gravity({0, 0, -9.81}).constrain_volume();
  SolverOptions options;
  options.damping.rate = 30.0;
  options.rest_tolerance = 1e-5;
  const auto tables = std::make_shared<const TopologyTextures>(build_topology(model, {}));
  const auto mirror = cpu::make_mirror_solver(tables, scene, options);
  const auto reference = make_solver("reference", tables, scene, options);
  const double dt = 0.4 * reference->stable_step();
  const RestResult a = mirror->run_to_rest(100000, dt), b = reference->run_to_rest(100000, dt);
  EXPECT_TRUE(a.converged() && b.converged()) << a.message();
  EXPECT_NEAR(a.report.steps, b.report.steps, 0.02 * b.report.steps);
  const State x = mirror->read(), y = reference->read();
  double moved = 0.0, off = 0.0;
  for (std::size_t i = 0; i < model.rest.size(); ++i) {
    moved = std::max(moved, (y.position[i] - model.rest[i]).norm());
    off = std::max(off, (x.position[i] - y.position[i]).norm());
  }
  EXPECT_GT(moved, 1e-3);
  EXPECT_LT(off, 1e-4 * moved);
  const VolumeConstraint& kept = scene.volume_constraints()[0];
  EXPECT_NEAR(enclosed_volume(kept.triangles, x.position) / kept.volume, 1.0, 1e-6);
}

}  // namespace
}  // namespace phymul
