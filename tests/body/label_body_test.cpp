// SPDX-License-Identifier: MIT
//
// Bodies of several regions from labelled images: volumes, places, the boundaries between regions, materials.
#include <phymul/phymul.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "body_shapes.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

/// Particles of both groups.
std::vector<Index> between(const Model& model, const std::string& a, const std::string& b) {
  const std::vector<Index> of_a = model.group(a), of_b = model.group(b);
  std::vector<Index> both;
  std::ranges::set_intersection(of_a, of_b, std::back_inserter(both));
  return both;
}

/// Every cell is in one region.
void expect_partition(const Model& model, const BodyReport& report) {
  Index cells = 0;
  double volume = 0.0;
  for (const RegionReport& region : report.regions) {
    cells += region.cells;
    volume += region.volume;
    if (region.cells > 0) {
      EXPECT_EQ(static_cast<Index>(model.group(region.name).size()), region.particles);
    }
  }
  EXPECT_EQ(cells, report.cells);
  EXPECT_NEAR(volume, report.volume, 1e-12 * report.volume);
}

SoundBody sound_regions(const LabelImage& image, const LabelBodyOptions& options) {
  SoundBody made = sound_body(image, options);
  expect_partition(made.model, made.report);
  return made;
}

TEST(LabelBody, ABallInABall) {
  const double spacing = 0.0075, radius = 0.03;
  const auto [model, report] =
      sound_regions(ball_in_ball(80, radius), {.spacing = spacing, .regions = {{1, "fat"}, {2, "gland"}}});
  EXPECT_GT(report.particles, 2300);
  EXPECT_LT(report.particles, 2700);
  EXPECT_NEAR(report.volume / ball_volume(0.05), 1.0, 0.005);
  ASSERT_EQ(report.regions.size(), 2u);
  EXPECT_EQ(report.regions[1].name, "gland");
  EXPECT_NEAR(report.regions[1].wanted_volume / ball_volume(radius), 1.0, 0.005);
  EXPECT_NEAR(report.regions[1].volume / ball_volume(radius), 1.0, 0.03);
  EXPECT_NEAR(report.regions[0].volume / (ball_volume(0.05) - ball_volume(radius)), 1.0, 0.01);
  const std::vector<Index> boundary = between(model, "fat", "gland");
  EXPECT_GT(boundary.size(), 200u);
  for (const Index i : boundary) EXPECT_NEAR(model.rest[i].norm(), radius, 0.06 * spacing);
}

/// A plane oblique to voxels and lattice, out to the body's surface.
TEST(LabelBody, AnObliquePlaneBetweenTwoRegions) {
  const double spacing = 0.0075;
  const Vec3 normal = Vec3(1, 0.3, 0.1).normalized();
  for (const double offset : {0.0, 0.001, 0.002, 0.003}) {
    SCOPED_TRACE(offset);
    const LabelImage image = painted(80, [&](const Vec3& x) {
      return x.norm() > 0.05 ? 0 : normal.dot(x) < offset ? 7 : 9;
    });
    const auto [model, report] = sound_regions(image, {.spacing = spacing});
    for (const RegionReport& region : report.regions) {
      EXPECT_NEAR(region.volume / region.wanted_volume, 1.0, 0.002) << region.name;
    }
    double squares = 0.0;
    const std::vector<Index> boundary = between(model, "label 7", "label 9");
    for (const Index i : boundary) squares += std::pow((normal.dot(model.rest[i]) - offset) / spacing, 2);
    EXPECT_LT(std::sqrt(squares / static_cast<double>(boundary.size())), 0.1);
  }
}

TEST(LabelBody, TwoBallsThatTouch) {
  const auto ball = [](const Vec3& x, double at) { return (x - Vec3(at, 0, 0)).norm() < 0.025; };
  const LabelImage image = painted(80, [&](const Vec3& x) { return ball(x, -0.025) ? 1 : ball(x, 0.025) ? 2 : 0; });
  const auto [model, report] = sound_regions(image, {.spacing = 0.005, .regions = {{1, "left"}, {2, "right"}}});
  for (const RegionReport& region : report.regions) EXPECT_NEAR(region.volume / ball_volume(0.025), 1.0, 0.01);
  for (const Index i : model.group("left")) EXPECT_LT(model.rest[i].x(), 0.5 * 0.005);
}

/// Thinner than the spacing, and wider than a voxel: it appears where centres of cells are in it.
TEST(LabelBody, AThinShell) {
  const auto image = painted(120, [](const Vec3& x) {
    const double r = x.norm();
    return r > 0.05 ? 0 : r > 0.03 && r < 0.033 ? 2 : 1;
  });
  const auto [model, report] = sound_regions(image, {.spacing = 0.0075});
  EXPECT_NEAR(report.regions[1].volume / report.regions[1].wanted_volume, 1.0, 0.15);
  for (const Index i : model.group("label 2")) EXPECT_NEAR(model.rest[i].norm(), 0.0315, 0.0075);
}

TEST(LabelBody, ARegionWithoutCellsIsNamed) {
  LabelImage image = ball_in_ball(60, 0.02);
  image.label[(30 * 60 + 30) * 60 + 45] = 3;  // one voxel in the outer ball
  image.notes.emplace_back("from a test");
  BodyReport report;
  const Model model = make_body(image, {.spacing = 0.01}, &report);
  ASSERT_EQ(report.regions.size(), 3u);
  EXPECT_EQ(report.regions[2].cells, 0);
  EXPECT_NEAR(report.regions[2].wanted_volume, 8e-9, 1e-15);
  EXPECT_FALSE(model.has_group("label 3"));
  ASSERT_EQ(model.notes.size(), 2u);
  EXPECT_EQ(model.notes[0], "from a test");
  EXPECT_TRUE(says(model.notes[1], "region \"label 3\" of 0.008 ml has no cell and no group")) << model.notes[1];
}

/// A box of voxels in frames that are turned, anisotropic, left-handed and far from the origin.
TEST(LabelBody, FramesPutItInItsPlace) {
  const std::array<Index, 3> count{40, 30, 16}, first{5, 4, 3}, last{34, 25, 12};
  const Eigen::AngleAxisd turn(0.7, Vec3(1, 2, 3).normalized());
  for (const double hand : {1.0, -1.0}) {
    LabelImage image;
    image.size = count;
    image.origin = {0.3, -0.2, 1.5};
    image.step = {turn * Vec3(1e-3, 0, 0), turn * Vec3(0, 1.5e-3, 0), turn * Vec3(0, 0, hand * 2.5e-3)};
    for (Index k = 0; k < count[2]; ++k) {
      for (Index j = 0; j < count[1]; ++j) {
        for (Index i = 0; i < count[0]; ++i) {
          const bool in =
              i >= first[0] && i <= last[0] && j >= first[1] && j <= last[1] && k >= first[2] && k <= last[2];
          image.label.push_back(in ? i < 20 ? 1 : 2 : 0);
        }
      }
    }
    const auto [model, report] = sound_regions(image, {.spacing = 0.0025});
    EXPECT_NEAR(report.wanted_volume, 0.03 * 0.033 * 0.025, 1e-12);
    EXPECT_NEAR(report.volume / report.wanted_volume, 1.0, 0.005);
    EXPECT_NEAR(report.regions[0].volume / (0.015 * 0.033 * 0.025), 1.0, 0.01);
    Vec3 low = Vec3::Constant(1e9), high = -low;
    for (const Vec3& x : model.rest) {
      const Vec3 at = turn.inverse() * (x - image.origin);
      const Vec3 own(at.x(), at.y(), hand * at.z());
      low = low.cwiseMin(own);
      high = high.cwiseMax(own);
    }
    EXPECT_LT((low - Vec3(4.5e-3, 3.5 * 1.5e-3, 2.5 * 2.5e-3)).cwiseAbs().maxCoeff(), 0.0003) << low.transpose();
    EXPECT_LT((high - Vec3(34.5e-3, 25.5 * 1.5e-3, 12.5 * 2.5e-3)).cwiseAbs().maxCoeff(), 0.0003) << high.transpose();
    for (const Index i : between(model, "label 1", "label 2")) {
      EXPECT_NEAR((turn.inverse() * (model.rest[i] - image.origin)).x(), 19.5e-3, 0.4 * 0.0025);
    }
  }
}

void expect_good(std::uint32_t seed, double spacing) {
  SCOPED_TRACE(seed);
  const auto [model, report] = sound_regions(random_labels(seed), {.spacing = spacing});
  EXPECT_NEAR(report.volume, report.wanted_volume, 1e-3 * report.wanted_volume);
}

TEST(LabelBody, RandomImagesHaveGoodCells) {
  for (std::uint32_t seed = 0; seed < 30; ++seed) expect_good(seed, 0.011);
}

TEST(LabelBodyOfManyImages, NoCellIsInverted) {
  for (std::uint32_t seed = 100; seed < 500; ++seed) expect_good(seed, 0.007 + 0.0004 * (seed % 10));
}

/// Fine around the inner ball: its boundary is met as closely as the fine spacing allows.
TEST(LabelBody, WithASpacingThatVaries) {
  const double coarse = 0.014, fine = coarse / 4, radius = 0.015;
  const LabelBodyOptions options{.spacing = coarse,
                                 .regions = {{1, "fat"}, {2, "gland"}},
                                 .spacing_at = fine_near(Vec3::Zero(), radius + fine, fine, coarse)};
  const auto [model, report] = sound_regions(ball_in_ball(80, radius), options);
  EXPECT_NEAR(report.smallest_spacing, fine, 1e-12);
  EXPECT_NEAR(report.largest_spacing, coarse, 1e-12);
  EXPECT_NEAR(report.volume / ball_volume(0.05), 1.0, 0.005);
  EXPECT_NEAR(report.regions[1].volume / ball_volume(radius), 1.0, 0.03);
  for (const Index i : between(model, "fat", "gland")) EXPECT_NEAR(model.rest[i].norm(), radius, 0.15 * fine);

  LabelBodyOptions uniform{.spacing = coarse};
  const Model even = make_body(ball_in_ball(80, radius), uniform);
  uniform.spacing_at = [=](const Vec3&) { return 2.0 * coarse; };
  EXPECT_EQ(make_body(ball_in_ball(80, radius), uniform), even);
}

TEST(LabelBody, RandomImagesHaveGoodCellsWhereTheSpacingVaries) {
  for (std::uint32_t seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 bits(seed);
    const Vec3 place = 0.04 * random_vector(bits, 3);
    const auto [model, report] =
        sound_regions(random_labels(seed), {.spacing = 0.014, .spacing_at = fine_near(place, 0.01, 0.0035, 0.014)});
    EXPECT_LT(report.smallest_spacing, 0.004);
    EXPECT_NEAR(report.volume, report.wanted_volume, 1e-3 * report.wanted_volume);
  }
}

/// Against the same body as one region, of one material.
TEST(LabelBody, RegionsDoNotShortenTheStep) {
  const auto step_of = [](const LabelImage& image, const LabelBodyOptions& options) {
    Model model = with_material(make_body(image, options), soft_tissue(0.45));
    const Scene scene(model);
    return make_solver("reference", model, scene)->stable_step();
  };
  for (std::uint32_t seed = 0; seed < 6; ++seed) {
    const LabelImage image = random_labels(seed);
    LabelBodyOptions whole{.spacing = 0.01};
    const auto labels = static_cast<std::uint16_t>(2 + seed % 5);
    for (std::uint16_t label = 1; label <= labels; ++label) {
      if (std::ranges::count(image.label, label) > 0) whole.regions.push_back({label, "whole"});
    }
    const double ratio = step_of(image, {.spacing = 0.01}) / step_of(image, whole);
    std::printf("%u regions: step %.2f of that of one region\n", 2 + seed % 5, ratio);
    EXPECT_GT(ratio, 0.95);
    EXPECT_LT(ratio, 1.05);
  }
}

/// A ball cut by the plane x = 0 into a soft region and a stiff one, of nu = 0.
struct SoftAndStiff {
  SoftAndStiff() {
    const LabelImage image = painted(60, [](const Vec3& x) { return x.norm() > 0.05 ? 0 : x.x() < 0.0 ? 1 : 2; });
    model = make_body(image, {.spacing = 0.0075, .regions = {{1, "soft"}, {2, "stiff"}}}, &report);
    model.most_mass_moved = 0.0;  // which would be a note, too
    set_material(model, {10e3, 0.0, 1000.0}, "soft");
    EXPECT_EQ(model.notes.size(), 1u);  // the other half has none yet
    set_material(model, {40e3, 0.0, 1200.0}, "stiff");
    EXPECT_TRUE(model.notes.empty());
  }
  /// J, where each particle moves along x by `way` of its x.
  template <class Way>
  double energy(const Way& way) const {
    const TopologyTextures tables = build_topology(model);
    VecList x = tables.rest;
    for (Vec3& p : x) p.x() += way(p.x());
    return elastic_energy(tables, x);
  }
  BodyReport report;
  Model model;
};

/// Uniform strain: each region has the energy of its own material and volume, and each particle its mass, to rounding.
TEST(LabelBody, MaterialsBelongToTheCellsOfTheirRegion) {
  const SoftAndStiff body;
  const double mass = total_mass(body.model);
  const double soft = body.report.regions[0].volume, stiff = body.report.regions[1].volume, e = 1e-5;
  EXPECT_NEAR(mass, 1000.0 * soft + 1200.0 * stiff, 1e-9 * mass);
  const double wanted = 0.5 * e * e * (10e3 * soft + 40e3 * stiff);
  EXPECT_NEAR(body.energy([=](double x) { return e * x; }), wanted, 1e-4 * wanted);
}

/// In series: each region takes the strain that its stiffness gives it. Cells that cross the plane are off.
TEST(LabelBody, MaterialsOfRegionsInSeries) {
  const SoftAndStiff body;
  const double e = 1e-5, stress = 10e3 * e;
  const double wanted =
      0.5 * stress * stress * (body.report.regions[0].volume / 10e3 + body.report.regions[1].volume / 40e3);
  EXPECT_NEAR(body.energy([=](double x) { return (x < 0.0 ? e : 0.25 * e) * x; }), wanted, 0.006 * wanted);
}

/// Nothing is around it: the body ends with the outermost voxels.
TEST(LabelBody, AnImageFilledToItsBorder) {
  const LabelImage image = painted(24, [](const Vec3&) { return 65535; });
  const auto [model, report] = sound_regions(image, {.spacing = 0.012});
  EXPECT_NEAR(report.volume, 0.12 * 0.12 * 0.12, 0.005 * 0.12 * 0.12 * 0.12);
  for (const Vec3& x : model.rest) EXPECT_LT(x.cwiseAbs().maxCoeff(), 0.0605);
}

TEST(LabelBody, RegionsByNameAndByDefault) {
  LabelImage image = ball_in_ball(40, 0.03);
  image.names = {{2, "gland"}, {5, "not there"}};
  BodyReport report;
  const BodyReport one = (make_body(image, {.spacing = 0.012, .regions = {{2, "gland"}}}, &report), report);
  ASSERT_EQ(one.regions.size(), 1u);
  EXPECT_NEAR(one.volume / ball_volume(0.03), 1.0, 0.02);
  make_body(image, {.spacing = 0.012}, &report);
  ASSERT_EQ(report.regions.size(), 2u);
  EXPECT_EQ(report.regions[0].name, "label 1");
  EXPECT_EQ(report.regions[1].name, "gland");
  // Two labels with one name; in the order of the options.
  const Model joined = make_body(image, {.spacing = 0.012, .regions = {{2, "all"}, {1, "all"}}}, &report);
  ASSERT_EQ(report.regions.size(), 1u);
  EXPECT_EQ(report.regions[0].cells, report.cells);
  EXPECT_EQ(joined.group("all").size(), joined.rest.size());
}

TEST(LabelBody, RefusesWhatMakesNoBody) {
  const LabelImage image = ball_in_ball(20, 0.03);
  const auto filling = [](const LabelImage& from, const LabelBodyOptions& options) {
    return message_of([&] { make_body(from, options); });
  };
  const auto changed = [&](auto change) {
    LabelImage other = image;
    change(other);
    return filling(other, {.spacing = 0.02});
  };
  EXPECT_EQ(filling(image, {.spacing = 0.02}), "(no error)");
  EXPECT_TRUE(says(filling(image, {}), "expected a spacing above 0 m, got 0"));
  EXPECT_TRUE(says(filling(image, {.spacing = 1e-5}), "take a larger spacing, or check the unit of length"));
  EXPECT_TRUE(says(filling(image, {.spacing = 0.5}), "no point of a lattice"));
  EXPECT_TRUE(says(filling(image, {.spacing = 0.02, .regions = {{4, "x"}}}), "label 4 (\"x\") in the image, but no"));
  EXPECT_TRUE(says(filling(image, {.spacing = 0.02, .regions = {{1, "x"}, {1, "y"}}}),
                   "expected each label once, got label 1 for \"x\" and for \"y\""));
  EXPECT_TRUE(says(filling(image, {.spacing = 0.02, .regions = {{0, "air"}}}), "expected labels above 0"));
  EXPECT_TRUE(says(filling(image, {.spacing = 0.02, .regions = {{1, ""}}}), "a name for the region of label 1"));
  EXPECT_TRUE(says(filling(image, {.spacing = 0.02, .regions = {{1, "surface"}}}), "another name than \"surface\""));
  EXPECT_TRUE(says(filling(image, {.spacing = 0.02, .regions = {{1, "Elements"}}, .most_volume_error = 0.5}),
                   "another name than \"Elements\""));
  EXPECT_TRUE(says(changed([](LabelImage& i) { i.label.pop_back(); }), "expected 8000 labels for an image of 20 x 20"));
  EXPECT_TRUE(says(changed([](LabelImage& i) { i.size = {0, 20, 20}; }), "at least 1 x 1 x 1 voxels"));
  EXPECT_TRUE(says(changed([](LabelImage& i) { i.size = {1 << 21, 1 << 21, 1 << 20}; }), "each side below 2^21"));
  EXPECT_TRUE(says(changed([](LabelImage& i) { i.step[2] = i.step[0] + i.step[1]; }), "which lie in one plane"));
  EXPECT_TRUE(says(changed([](LabelImage& i) { i.origin.x() = std::nan(""); }), "expected a finite frame"));
  EXPECT_TRUE(says(changed([](LabelImage& i) { i.label.assign(i.label.size(), 0); }), "one with label 0 alone"));
  // A sheet of two voxels beside the ball, thinner than the spacing.
  const LabelImage sheet = painted(60, [](const Vec3& x) {
    return std::abs(x.x() + 0.055) < 0.0021 ? 1 : (x - Vec3(0.02, 0, 0)).norm() < 0.035 ? 2 : 0;
  });
  EXPECT_TRUE(says(filling(sheet, {.spacing = 0.02}), "thinner than the spacing"));
}

}  // namespace
}  // namespace phymul::test
