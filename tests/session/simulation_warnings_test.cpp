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
  EXPECT_EQ(warnings(block(), soft,
                     [](Scene& scene) {
                       scene.fix("x0").gravity({0, 0, -9810});
                     }),
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
      scene.add_tool("ball", tool);
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

TEST(SimulationWarnings, BodiesDeeperThanACellAreSaidToInterlock) {
  const Model one = make_block({0.04, 0.02, 0.02}, 16, 8, 8), other = moved(one, {0.03, 0.003, 0.002});
  const auto found = warnings(merge_models(std::vector<NamedBody>{{"a", &one}, {"b", &other}}), soft,
                              [](Scene& scene) { scene.fix("a/x0").contacts({}); });
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(says(found[0], "so that they interlock; move them apart")) << found[0];
}

TEST(SimulationWarnings, WhatNothingHolds) {
  EXPECT_EQ(warnings(block(), soft,
                     [](Scene& scene) {
                       scene.gravity({0, 0, -9.81});
                     }),
            std::vector<std::string>{"nothing holds the body: it moves away; Scene::fix() holds a group of particles"});
  const Model one = block(), other = moved(block(), {0.1, 0, 0}), third = moved(block(), {0.2, 0, 0});
  const Model two = merge_models(std::vector<NamedBody>{{"liver", &one}, {"gall bladder", &other}});
  const auto hold_liver = [](Scene& scene) { scene.fix("liver/x0").gravity({0, 0, -9.81}); };
  EXPECT_EQ(
      warnings(two, soft, hold_liver),
      std::vector<std::string>{"\"gall bladder\", 45 particles at (0.1, 0, 0) m is joined to nothing that is held; "
                               "hold it too, join the meshes, or use Scene::attach() or Scene::contacts()"});
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
