// SPDX-License-Identifier: MIT
//
// Simulation::warnings(): what is probably not meant is said before the first step, and only that.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <functional>

#include "support/message_of.h"

namespace phymul {
namespace {

constexpr Material soft{.young = 10e3, .poisson = 0.3, .density = 1000};

using Change = std::function<void(Scene&)>;

void hold_and_pull(Scene& scene) {
  scene.fix("x0").gravity({0, 0, -9.81});
}

std::vector<std::string> warnings(const Model& model, const Material& material, const Change& change) {
  std::vector<std::string> logged;
  Simulation sim(model,
                 {.material = material, .backend = "cpu", .log = [&](const std::string& it) { logged.push_back(it); }});
  change(sim.scene());
  EXPECT_TRUE(logged.empty());
  sim.advance(0.0);
  EXPECT_EQ(sim.warnings(), logged);
  sim.advance(0.0);
  EXPECT_EQ(sim.warnings().size(), logged.size());  // once
  return logged;
}

Model block() {
  return make_block({0.04, 0.02, 0.02}, 4, 2, 2);
}

TEST(SimulationWarnings, NothingIsSaidOfWhatIsUsual) {
  EXPECT_TRUE(warnings(block(), soft, hold_and_pull).empty());
  EXPECT_TRUE(warnings(block(), soft, [](Scene&) {}).empty());  // floats, and nothing pushes it
  EXPECT_TRUE(warnings(block(), soft, [](Scene& scene) {
                scene.gravity({0, 0, -9.81});
                scene.add_tool(HalfSpace{});
              }).empty());
}

TEST(SimulationWarnings, ABodyWithoutMaterial) {
  const auto found = warnings(block(), {}, hold_and_pull);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].starts_with("the body has no material: Model::stiffness, N/m, pulls its particles")) << found[0];
}

TEST(SimulationWarnings, SleepThatNothingHas) {
  const auto told = [](const char* backend) {
    Simulation sim(block(), {.material = soft, .backend = backend, .solver = {.sleep_tolerance = 1e-5}});
    sim.scene().fix("x0");
    sim.advance(0.0);
    return sim.warnings();
  };
  EXPECT_TRUE(told("cpu").empty());
  const std::vector<std::string> on_reference = told("reference");
  ASSERT_EQ(on_reference.size(), 1u);
  EXPECT_TRUE(says(on_reference[0], "sleep_tolerance has no effect")) << on_reference[0];
}

TEST(SimulationWarnings, OtherUnits) {
  Model large = block();
  for (Vec3& p : large.rest) p *= 1000.0;
  EXPECT_EQ(warnings(large, soft, hold_and_pull),
            std::vector<std::string>{"the body is 40 m large: expected lengths in m; were they in mm?"});
  EXPECT_EQ(warnings(block(), {.young = 10, .poisson = 0.3, .density = 1}, hold_and_pull),
            (std::vector<std::string>{"Young's modulus is 10 Pa: expected Pa; was it in kPa or MPa?",
                                      "the density is 1 kg/m^3: expected kg/m^3; was it in g/cm^3 (water: 1)?"}));
  EXPECT_EQ(warnings(block(), soft, [](Scene& scene) { scene.fix("x0").gravity(Vec3(0, 0, -9810)); }),
            std::vector<std::string>{"gravity is 9810 m/s^2: expected m/s^2 (on Earth 9.81); was it in mm/s^2?"});
}

TEST(SimulationWarnings, ToolsThatPassBetweenParticles) {
  const auto with = [](const Tool& tool) {
    return warnings(block(), soft, [&](Scene& scene) {
      hold_and_pull(scene);
      scene.add_tool("probe", tool);
    });
  };
  // Faces are squares of 10 mm: a corner of their triangles is at most 7.1 mm away.
  const auto found = with({.shape = Sphere{0.007}});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].starts_with("the tool \"probe\" can pass between the particles of the surface")) << found[0];
  EXPECT_TRUE(says(found[0], "a margin of 0.00183")) << found[0];
  EXPECT_TRUE(with({.shape = Sphere{0.0072}}).empty());
  EXPECT_TRUE(with({.shape = Sphere{0.006}, .margin = 0.0012}).empty());
  EXPECT_TRUE(with({.shape = Sphere{0.001}, .contact = ToolContact::surface}).empty());
  EXPECT_TRUE(with({.shape = Needle{.length = 0.1, .radius = 1e-3}}).empty());
}

TEST(SimulationWarnings, ToolsInOtherUnitsAndInsideTheBody) {
  const auto with = [](Tool tool, const Vec3& place) {
    tool.pose.position = place;
    return warnings(block(), soft, [&](Scene& scene) {
      hold_and_pull(scene);
      scene.add_tool("ball", tool).move_to({.position = {0.02, 0.01, 0.015}});  // where it goes, not where it begins
    });
  };
  const Tool ball{.shape = Sphere{0.008}, .contact = ToolContact::surface};
  EXPECT_TRUE(with(ball, {0.02, 0.01, 0.0281}).empty());
  EXPECT_TRUE(with(ball, {0.02, 0.01, 0.0201}).empty()) << "its middle is outside";
  const auto inside = with(ball, {0.02, 0.01, 0.0199});
  ASSERT_EQ(inside.size(), 1u);
  EXPECT_TRUE(inside[0].starts_with("the middle of the tool \"ball\" begins inside the body, 0.0001 m deep"))
      << inside[0];
  // With the other contact, at the far end of a rod, and deeper.
  EXPECT_TRUE(with({.shape = Sphere{0.008}}, {0.02, 0.01, 0.0281}).empty());
  EXPECT_EQ(with({.shape = Sphere{0.008}}, {0.02, 0.01, 0.0199}), inside);
  const auto rod = with({.shape = Capsule{0.008, 0.05}}, {0.02, 0.01, -0.042});
  ASSERT_EQ(rod.size(), 1u);
  EXPECT_TRUE(says(rod[0], "0.008 m deep")) << rod[0];
  EXPECT_EQ(with({.shape = Sphere{8}, .contact = ToolContact::surface}, {0, 0, 9}),
            std::vector<std::string>{"the tool \"ball\" is 16 m thick, the body 0.04 m large: expected lengths in m; "
                                     "was it in mm?"});
  EXPECT_TRUE(with({.shape = Box{{1, 1, 0.05}}}, {0, 0, -0.06}).empty()) << "a floor";
  const Model fine = make_tetrahedral_block({0.06, 0.06, 0.04}, 6, 6, 4, 0.2, 1);
  const Tool on_top{.shape = Sphere{0.01}, .pose = {.position = {0.03, 0.03, 0.04}}};
  EXPECT_TRUE(warnings(fine, soft, [&](Scene& scene) { scene.fix("z0").add_tool(on_top); }).empty()) << "by rounding";
}

TEST(SimulationWarnings, NeedlesBladesAndThreadsInOtherUnits) {
  const Model body = with_spare_particles(make_tetrahedral_block({0.04, 0.02, 0.02}, 4, 2, 2, 0.2, 1), 50);
  const auto found = warnings(body, soft, [](Scene& scene) {
    hold_and_pull(scene);
    scene.add_tool("needle", {.shape = Needle{.length = 40, .radius = 0.5}, .pose = {.position = {0, 0, 0.03}}});
    scene.add_tool("scalpel", {.shape = Blade{.width = 20}, .pose = {.position = {0, 0, 0.03}}});
    scene.add_thread("suture", {.length = 300, .radius = 0.15, .segment = 3}, {0, 0, 1}, {1, 0, 0});
    scene.add_tool("fine needle", {.shape = Needle{}, .pose = {.position = {0, 0, 0.03}}});
    scene.add_thread("fine suture", {}, {0, 0, 1}, {1, 0, 0});
  });
  ASSERT_EQ(found.size(), 3u);
  EXPECT_TRUE(found[0].starts_with("the tool \"needle\" is 1 m thick, the body 0.04 m large")) << found[0];
  EXPECT_TRUE(found[1].starts_with("the tool \"scalpel\" is 20 m thick")) << found[1];
  EXPECT_TRUE(found[2].starts_with("the thread \"suture\" is 0.3 m thick")) << found[2];
}

TEST(SimulationWarnings, WhatHasNoParticlesForACut) {
  const Model body = make_tetrahedral_block({0.04, 0.02, 0.02}, 4, 2, 2, 0.2, 1);
  const auto with_blade = [](Scene& scene) {
    hold_and_pull(scene);
    scene.add_tool("scalpel", {.shape = Blade{.width = 0.01}, .pose = {.position = {0, 0, 0.03}}});
  };
  const auto tearing = [](Scene& scene) { scene.fix("x0").tear({.toughness = 3.0}); };
  ASSERT_EQ(warnings(body, soft, with_blade).size(), 1u);
  EXPECT_TRUE(
      warnings(body, soft, with_blade)[0].starts_with("the tool \"scalpel\" cannot cut: the body has no spare"));
  ASSERT_EQ(warnings(body, soft, tearing).size(), 1u);
  EXPECT_TRUE(warnings(body, soft, tearing)[0].starts_with("nothing can tear: the body has no spare particles"));
  EXPECT_TRUE(warnings(with_spare_particles(body, 50), soft, with_blade).empty());
  EXPECT_TRUE(warnings(with_spare_particles(body, 50), soft, tearing).empty());
}

/// It is in no tissue.
TEST(SimulationWarnings, AToolInALumenIsUsual) {
  const Model cube = make_block({0.02, 0.02, 0.02}, 1, 1, 1);
  Material of_wall = soft;
  of_wall.thickness = 1e-3;
  const Model bag = make_wall({cube.rest, surface_triangles(cube), {}}, {.spacing = 0.01, .material = of_wall});
  const auto found = warnings(bag, {}, [](Scene& scene) {
    scene.fix(std::vector<Index>{0});
    scene.add_tool({.shape = Sphere{2e-3}, .pose = {.position = {0.01, 0.01, 0.01}}, .contact = ToolContact::surface});
  });
  EXPECT_TRUE(found.empty()) << found.front();
}

TEST(SimulationWarnings, BodiesThatBeginInsideEachOther) {
  const Model one = block();
  const auto at = [&](double gap, bool touches = true) {
    const Model other = moved(block(), {0.04 + gap, 0.003, 0.002});
    return warnings(merge_models(std::vector<NamedBody>{{"liver", &one}, {"kidney", &other}}), soft, [&](Scene& scene) {
      scene.fix("liver/x0");
      if (touches) scene.contacts({});
      if (!touches) scene.fix("kidney/x0");
    });
  };
  EXPECT_TRUE(at(0.001).empty());
  EXPECT_TRUE(at(0.0).empty());
  EXPECT_TRUE(at(-0.002, false).empty());
  const auto shallow = at(-0.002);
  ASSERT_EQ(shallow.size(), 1u);
  EXPECT_TRUE(says(shallow[0], "\"kidney\" begins 0.002 m deep inside \"liver\", at (0.038, 0.003, 0.012) m"))
      << shallow[0];
  EXPECT_TRUE(says(shallow[0], "contacts part them little by little")) << shallow[0];
}

/// In each other at first: a block of soft tissue, and another, `moved` on it.
Simulation overlapping(const Model& other) {
  const Model one = make_block({0.04, 0.04, 0.04}, 4, 4, 4);
  return Simulation({{"a", one, soft}, {"b", other, soft}});
}

/// The edges are 10 mm long. The largest speed of 96 random pairs was 0.33 m/s (warnings.cpp).
TEST(SimulationWarnings, OverlapsUpToAQuarterOfAnEdgePartGently) {
  const double most = 0.25 * 0.01;
  for (const double turn : {0.0, 0.4}) {
    Model other = make_block({0.04, 0.04, 0.04}, 4, 4, 4);
    const Eigen::AngleAxisd about(turn, Vec3::UnitZ());
    for (Vec3& x : other.rest) x = about * x + Vec3(0.003, 0.002, 0.04 - 0.999 * most);
    Simulation sim = overlapping(other);
    sim.scene().contacts({});
    double fastest = 0.0;
    for (int k = 0; k < 50; ++k) {
      const StepReport report = sim.advance(0.01);
      ASSERT_TRUE(report.ok()) << report.message();
      fastest = std::max(fastest, report.max_speed);
    }
    ASSERT_EQ(sim.warnings().size(), 1u);
    EXPECT_TRUE(says(sim.warnings()[0], "contacts part them little by little")) << sim.warnings()[0];
    EXPECT_LT(fastest, 0.33) << turn;
    const State state = sim.state();
    const auto height = [&](const char* group, bool highest) {
      double found = highest ? -1.0 : 1.0;
      for (const Index i : sim.model().group(group)) {
        const double z = state.position[i].z();
        found = highest ? std::max(found, z) : std::min(found, z);
      }
      return found;
    };
    EXPECT_GT(height("b", false), height("a", true)) << turn;
  }
}

TEST(SimulationWarnings, BodiesThatWouldInterlockAreRefusedUntilTheyAreMovedOrDoNotTouch) {
  const Model block = make_block({0.04, 0.04, 0.04}, 4, 4, 4);
  Simulation sim = overlapping(moved(block, {0.004, 0.003, 0.04 - 0.0026}));
  sim.scene().contacts({});
  for (int tries = 0; tries < 2; ++tries) {
    const std::string refused = message_of([&] { sim.advance(0.01); });
    EXPECT_TRUE(says(refused,
                     "overlap by at most 0.0025 m, a quarter of the longest edge, got more: \"b\" begins "
                     "0.0026 m deep inside \"a\", at (0.004, 0.003, 0.0374) m"))
        << refused;
  }
  sim.scene().no_contacts();
  EXPECT_TRUE(sim.advance(0.01).ok());
}

/// As a tumour in an organ, which it is attached to: no side of one is near one of the other.
TEST(SimulationWarnings, ABodyFarInsideAnotherIsNotTouched) {
  const Model inner = moved(make_block({0.004, 0.004, 0.004}, 2, 2, 2), {0.018, 0.018, 0.018});
  Simulation sim = overlapping(inner);
  sim.scene().contacts({});
  EXPECT_TRUE(sim.advance(0.01).ok());
  ASSERT_EQ(sim.warnings().size(), 1u);
  EXPECT_TRUE(says(sim.warnings()[0], "deep inside \"a\", at ")) << sim.warnings()[0];
  EXPECT_TRUE(says(sim.warnings()[0], ": contacts do not act between them")) << sim.warnings()[0];
  EXPECT_LT(sim.max_displacement(), 1e-9);
}

TEST(SimulationWarnings, WhatNothingHolds) {
  EXPECT_EQ(warnings(block(), soft, [](Scene& scene) { scene.gravity(Vec3(0, 0, -9.81)); }),
            std::vector<std::string>{"nothing holds the body: it moves away; Scene::fix() holds a group of particles"});
  const Model one = block(), other = moved(block(), {0.1, 0, 0}), third = moved(block(), {0.2, 0, 0});
  const Model two = merge_models(std::vector<NamedBody>{{"liver", &one}, {"gall bladder", &other}});
  const auto hold_liver = [](Scene& scene) { scene.fix("liver/x0").gravity({0, 0, -9.81}); };
  EXPECT_EQ(
      warnings(two, soft, hold_liver),
      std::vector<std::string>{"\"gall bladder\", 45 particles at (0.1, 0, 0) m is joined to nothing that is held; "
                               "hold it too, join the meshes, or use Scene::attach() or Scene::contacts({})"});
  const Model three = merge_models(std::vector<NamedBody>{{"liver", &one}, {"a", &other}, {"b", &third}});
  ASSERT_EQ(warnings(three, soft, hold_liver).size(), 1u);
  EXPECT_TRUE(says(warnings(three, soft, hold_liver)[0], " and 1 more are joined to nothing"));
  // A chain of joints leads to a part that is held, in whatever order the joints stand.
  EXPECT_TRUE(warnings(three, soft, [&](Scene& scene) {
                hold_liver(scene);
                for (const auto& [one_end, other_end] :
                     {std::pair{"a/x1", "b/x0"}, std::pair{"liver/x1", "a/x0"}, std::pair{"liver/y1", "a/y1"}}) {
                  scene.add_joint({at_mean(three.group(one_end)), at_mean(three.group(other_end))}, 10.0);
                }
              }).empty());
  EXPECT_TRUE(warnings(two, soft, [&](Scene& scene) {
                hold_liver(scene);
                scene.contacts({});
              }).empty());
}

}  // namespace
}  // namespace phymul
