// SPDX-License-Identifier: MIT
//
// Components with a bodyType, as in scenes of SOFA's reader of PML: what they are made of, and what joins them.
#include <phymul/simulation.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "support/every_backend.h"
#include "support/pml_text.h"

namespace phymul {
namespace {

const std::string hanging = test_data + "/hanging_bodies.pml";
constexpr double g = 9.81;

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string attribute(const Component& component, const std::string& name) {
  const auto found = std::ranges::find(component.attributes, name, &Attribute::name);
  return found == component.attributes.end() ? "" : found->value;
}

class PmlBodiesOn : public test::OnEveryBackend {};
PHYMUL_ON_EVERY_BACKEND(PmlBodiesOn);

TEST(PmlBodies, TissueHasTheFilesMaterial) {
  const Model model = read_pml(hanging);
  ASSERT_EQ(model.materials.size(), 1u);
  EXPECT_EQ(model.materials[0].young, 3000.0);
  EXPECT_EQ(model.materials[0].poisson, 0.45);
  EXPECT_NEAR(model.materials[0].density, 800.0, 1e-9);  // 8 particles of 0.1 g in 1 cm^3
  EXPECT_TRUE(has_note(model.notes, "800.0000000000002 kg/m^3 follows from the masses"));
  for (const Index i : model.group("tissue")) EXPECT_EQ(model.mass[i], 1e-4);
  for (const Index i : model.group("net")) EXPECT_EQ(model.mass[i], 2e-4);
  for (const Index i : model.group("net")) EXPECT_EQ(model.stiffness[i], 0.0);
  EXPECT_EQ(reread(model), model);
}

/// Two bodies that share a face: the particles there give each its part of their mass.
TEST(PmlBodies, DensityOfBodiesThatShareParticles) {
  std::vector<std::string> atoms;
  for (int i = 0; i < 12; ++i) {
    const int ring = i % 4;
    const double mass = i / 4 == 1 ? 4.0 : i / 4 == 0 ? 1.0 : 3.0;
    atoms.push_back("<atom><atomProperties index=\"" + std::to_string(i) + "\" x=\"" +
                    std::to_string(ring == 1 || ring == 2 ? 1 : 0) + "\" y=\"" + std::to_string(ring / 2) + "\" z=\"" +
                    std::to_string(i / 4) + "\" mass=\"" + std::to_string(mass) + "\"/></atom>");
  }
  const std::string constants = " bodyType=\"FEM\" young=\"1000\" poisson=\"0.3\"";
  std::string text = pml_text(atoms, {cell_text("HEXAHEDRON", {0, 1, 2, 3, 4, 5, 6, 7})});
  text = replaced(text, "name=\"Elements\"", "name=\"lower\"" + constants);
  text = replaced(text, "</multiComponent>",
                  "<structuralComponent name=\"upper\"" + constants + ">" +
                      cell_text("HEXAHEDRON", {4, 5, 6, 7, 8, 9, 10, 11}) + "</structuralComponent></multiComponent>");
  const Model model = read_pml_text(text, "t.pml", {.length_unit = 1.0});
  ASSERT_EQ(model.materials.size(), 2u);
  EXPECT_NEAR(model.materials[0].density, 4 * 1.0 + 4 * 2.0, 1e-9);
  EXPECT_NEAR(model.materials[1].density, 4 * 3.0 + 4 * 2.0, 1e-9);
  EXPECT_EQ(reread(model, {.length_unit = 1.0}), model);

  // Equal densities make one material, as they do in the file that is written.
  const Model even = read_pml_text(replaced(text, "mass=\"3.000000\"", "mass=\"1.000000\""), "t.pml");
  EXPECT_EQ(even.materials.size(), 2u);
  std::string all = text;
  while (all.find("mass=\"3.000000\"") != std::string::npos) all = replaced(all, "mass=\"3.000000\"", "mass=\"1\"");
  EXPECT_EQ(read_pml_text(all, "t.pml").materials.size(), 1u);
}

TEST(PmlBodies, AMaterialWithoutVolumeIsNone) {
  std::string text = pml_text(tetrahedron_atoms, {cell_text("TRIANGLE", {0, 1, 2})});
  text = replaced(text, "name=\"Elements\"", "name=\"shell\" bodyType=\"FEM\" young=\"1000\" poisson=\"0.3\"");
  const Model model = read_pml_text(text, "t.pml");
  EXPECT_TRUE(model.materials.empty());
  EXPECT_EQ(model.cells[0].material, -1);
  EXPECT_TRUE(has_note(model.notes, "neither a density nor masses"));
  EXPECT_EQ(attribute(model.components[1], "young"), "1000");
  EXPECT_EQ(reread(model), model);
}

TEST(PmlBodies, AMassThatIsAssumedGivesNoDensity) {
  const Model model = read_pml_text(replaced(text_of(hanging), " mass=\"1e-4\"", ""), "t.pml");
  EXPECT_TRUE(model.materials.empty());
  EXPECT_TRUE(has_note(model.notes, "neither a density nor masses"));
  EXPECT_TRUE(has_note(model.notes, "have no mass: 1 kg each is assumed"));
}

TEST(PmlBodies, AreAddedAsWhatTheyAre) {
  const Model model = read_pml(hanging);
  Scene scene(model);
  EXPECT_EQ(add_body_types(scene),
            (std::vector<std::string>{"component \"plate\" (bodyType \"rigid\"): its 4 particle(s) are held",
                                      "component \"tissue\" (bodyType \"FEM\"): its cells have a material",
                                      "component \"net\" (bodyType \"stiffSpring\"): 16 spring(s) of 20 N/m",
                                      "component \"upper\" (bodyType \"interaction\"): 4 spring(s) of 8 N/m",
                                      "component \"lower\" (bodyType \"interaction\"): 4 spring(s) of 5 N/m"}));
  ASSERT_EQ(scene.joints().size(), 3u);
  EXPECT_EQ(scene.joints()[0].name, "net");
  EXPECT_EQ(scene.joints()[0].joint.damping, 0.005);
  EXPECT_EQ(scene.joints()[1].joint.damping, 0.0);
  for (const JointSpring& spring : scene.joints()[1].joint.springs) EXPECT_NEAR(spring.rest_length, 5e-3, 1e-15);
  EXPECT_EQ(scene.loads().size(), 1u);
  EXPECT_FALSE(scene.contacts());  // one component with collision="true" has nothing to touch
  for (Index i = 12; i < 20; ++i) EXPECT_EQ(model.neighbours.size(i), 3);  // a line between bodies joins no neighbours
}

/// What hangs there pulls with its weight.
TEST_P(PmlBodiesOn, HangByTheirWeight) {
  Simulation sim(read_pml(hanging), {.backend = GetParam()});
  add_body_types(sim.scene());
  sim.scene().gravity({0, 0, -g});
  const RestResult rest = sim.run_to_rest();
  ASSERT_TRUE(rest.converged()) << rest.message();
  const double net = 8 * 2e-4 * g, all = net + 8 * 1e-4 * g;
  EXPECT_NEAR(sim.solver().joint_report("upper").force.z(), -all, 1e-3 * all);
  EXPECT_NEAR(sim.solver().joint_report("lower").force.z(), -net, 1e-3 * net);
  const State state = sim.state();
  for (const Index i : sim.model().group("plate")) EXPECT_EQ(state.position[i], sim.model().rest[i]);
}

TEST(PmlBodies, OfMassZeroAreHeldAndThoseThatCollideTouch) {
  std::string text = text_of(hanging);
  text = replaced(text, "bodyType=\"stiffSpring\" mass=\"2e-4\"", "bodyType=\"FEM\" mass=\"0\" collision=\"true\"");
  const Model model = read_pml_text(text, "t.pml");
  Scene scene(model);
  const std::vector<std::string> done = add_body_types(scene);
  EXPECT_TRUE(has_note(done, "component \"net\" (bodyType \"FEM\"): its 8 particle(s) are held"));
  EXPECT_TRUE(has_note(done, "contacts, because 2 components have collision=\"true\""));
  EXPECT_TRUE(scene.contacts().has_value());
  EXPECT_NO_THROW(build_topology(model));
}

TEST(PmlBodies, TissueStillNeedsAMaterial) {
  std::string text = text_of(hanging);
  text = replaced(text, "bodyType=\"stiffSpring\"", "bodyType=\"FEM\"");
  const Model model = read_pml_text(text, "t.pml");
  EXPECT_NE(message_of([&] { build_topology(model); }).find("has no material although others have"), std::string::npos);
  Scene scene(model);
  EXPECT_TRUE(has_note(add_body_types(scene), "its cells have no material, because it has no young and poisson"));
}

/// A user who gives all cells a material, as phymul-run does, gets no springs besides.
TEST(PmlBodies, ANetWithAMaterialHasNoSprings) {
  Model model = read_pml(hanging);
  set_material(model, {3000, 0.3, 1000});
  Scene scene(model);
  EXPECT_TRUE(has_note(add_body_types(scene), "component \"net\" (bodyType \"stiffSpring\"): no springs, because"));
  EXPECT_EQ(scene.joints().size(), 2u);
}

TEST(PmlBodies, RefusesWhatIsWrong) {
  const std::string text = text_of(hanging);
  const auto with = [&](const std::string& from, const std::string& to) {
    return message_of([&] {
      const Model model = read_pml_text(replaced(text, from, to), "bad.pml");
      Scene scene(model);
      try {
        add_body_types(scene);
      } catch (...) {
        EXPECT_TRUE(scene.joints().empty() && scene.loads().empty()) << "half of it was added";
        throw;
      }
    });
  };
  EXPECT_EQ(with("stiffness=\"8\" ", ""), "component \"upper\": expected a stiffness in N/m for its springs, got none");
  EXPECT_EQ(with("body1=\"plate\"", "body1=\"ceiling\""),
            "component \"upper\": expected the name of a component in body1, got \"ceiling\"");
  EXPECT_EQ(with("body1=\"plate\"", "body1=\"net\""),
            "component \"upper\": expected each line to go from a particle of body1 to one of body2, but particle 0 is "
            "not in \"net\"");
  EXPECT_NE(with("stiffness=\"8\"", "stiffness=\"-8\"").find("bad.pml:"), std::string::npos);
  EXPECT_NE(with("damping=\"0.001\"", "damping=\"some\"").find("expected a finite number"), std::string::npos);
  EXPECT_NE(with("name=\"lower\"", "name=\"upper\"").find("upper"), std::string::npos);
}

}  // namespace
}  // namespace phymul
