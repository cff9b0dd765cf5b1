// SPDX-License-Identifier: MIT
//
// Components with a bodyType, as in scenes of SOFA's reader of PML: what they are made of, and what joins them.
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <chrono>
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
  EXPECT_TRUE(has_note(model.notes, "a density of 800.0000000000002 kg/m^3 follows from the masses and volumes"));
  for (const Index i : model.group("tissue")) EXPECT_EQ(model.mass[i], 1e-4);
  for (const Index i : model.group("net")) EXPECT_EQ(model.mass[i], 2e-4);
  for (const Index i : model.group("net")) EXPECT_EQ(model.stiffness[i], 0.0);
  const Model again = reread(model);
  EXPECT_EQ(again, model);
  EXPECT_FALSE(has_note(again.notes, "density"));
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
  EXPECT_TRUE(has_note(model.notes, "t.pml:10: expected a density, or masses and cells that fill space"));
  EXPECT_EQ(attribute(model.components[1], "young"), "1000");
  EXPECT_EQ(reread(model), model);
}

TEST(PmlBodies, AMassThatIsAssumedGivesNoDensity) {
  const Model model = read_pml_text(replaced(text_of(hanging), " mass=\"1e-4\"", ""), "t.pml");
  EXPECT_TRUE(model.materials.empty());
  EXPECT_TRUE(has_note(model.notes, "expected a density, or masses and cells that fill space"));
  EXPECT_TRUE(has_note(model.notes, "have no mass: 1 kg each is assumed"));
  // Writing gives each particle its mass. The body is not weighed by that.
  EXPECT_EQ(reread(model), model);
  Model cleared = read_pml(hanging);
  cleared.materials.clear();
  for (Cell& cell : cleared.cells) cell.material = -1;
  EXPECT_EQ(reread(cleared), cleared);
}

TEST(PmlBodies, ADensityGivesMasses) {
  const std::string text = replaced(text_of(hanging), "mass=\"1e-4\"", "density=\"1200\"");
  const Model model = read_pml_text(text, "t.pml");
  ASSERT_EQ(model.materials.size(), 1u);
  EXPECT_EQ(model.materials[0].density, 1200.0);
  for (const Index i : model.group("tissue")) EXPECT_NEAR(model.mass[i], 1200e-6 / 8, 1e-15);
  EXPECT_EQ(reread(model), model);
}

/// A part of a cut wall weighs its share.
TEST(PmlBodies, ADensityGivesMassesOfPartsOfWalls) {
  std::string text = pml_text(
      tetrahedron_atoms, {cell_text("TRIANGLE", {0, 1, 2}, "phymul=\"share=0.25\""), cell_text("TRIANGLE", {0, 1, 3})});
  text = replaced(text, "name=\"Elements\"",
                  "name=\"wall\" bodyType=\"FEM\" young=\"1e3\" poisson=\"0.3\" density=\"1200\" thickness=\"1e-3\"");
  const Model model = read_pml_text(text, "t.pml");
  const double third = 1200.0 * 1e-3 * 0.5e-6 / 3.0;
  EXPECT_NEAR(model.mass[2], 0.25 * third, 1e-9 * third);
  EXPECT_NEAR(model.mass[3], third, 1e-9 * third);
}

TEST(PmlBodies, OnlySolidsHaveAMaterial) {
  const std::string text =
      replaced(text_of(hanging), "bodyType=\"stiffSpring\"", "bodyType=\"stiffSpring\" young=\"5\" poisson=\"0.3\"");
  const Model model = read_pml_text(text, "t.pml");
  EXPECT_EQ(model.materials.size(), 1u);
  Scene scene(model);
  add_body_types(scene);
  EXPECT_EQ(scene.joints().size(), 3u);
}

/// Atom, neighbourhood cell, its component, then the body.
TEST(PmlBodies, NeighbourhoodsComeBeforeBodies) {
  const std::string text = replaced(text_of(hanging), "</multiComponent>",
                                    "<structuralComponent name=\"Neighborhoods\" mass=\"7\" stiffness=\"9\">" +
                                        cell_text("POLY_VERTEX", {13, 14, 15}, "name=\"Atom #12\"") +
                                        "</structuralComponent></multiComponent>");
  const Model model = read_pml_text(text, "t.pml");
  EXPECT_EQ(model.mass[12], 7.0);
  EXPECT_EQ(model.stiffness[12], 9.0);
}

TEST(PmlBodies, OfUnknownTypesAreSaidAndDoNothing) {
  const std::string text =
      replaced(text_of(hanging), "bodyType=\"rigid\" mass=\"1\"", "bodyType=\"mapped\" mass=\"all\"");
  const Model model = read_pml_text(text, "t.pml");
  Scene scene(model);
  EXPECT_TRUE(has_note(add_body_types(scene), "component \"plate\" (bodyType \"mapped\"): nothing is added"));
  EXPECT_NO_THROW(build_topology(model));
}

TEST(PmlBodies, MayReferToTheirCells) {
  std::string text = text_of(hanging);
  const std::string cell = "<cellProperties type=\"QUAD\"/>";
  text = replaced(text, cell, "<cellProperties index=\"77\" type=\"QUAD\"/>");
  const std::size_t from = text.find("<cell><cellProperties index=\"77\""), to = text.find("</cell>", from) + 7;
  const std::string whole = text.substr(from, to - from);
  text.replace(from, to - from, "<cellRef index=\"77\"/>");
  text = replaced(text, "<informativeComponents/>",
                  "<informativeComponents><multiComponent name=\"i\"><structuralComponent name=\"shapes\">" + whole +
                      "</structuralComponent></multiComponent></informativeComponents>");
  const Model model = read_pml_text(text, "t.pml");
  Scene scene(model);
  EXPECT_TRUE(has_note(add_body_types(scene), "component \"plate\" (bodyType \"rigid\"): its 4 particle(s) are held"));
  EXPECT_NO_THROW(build_topology(model));
  EXPECT_EQ(reread(model), model);
}

/// Springs make one body of two as little as joints do.
TEST(PmlBodies, OfAnInteractionTouchEachOther) {
  std::string text = replaced(text_of(hanging), "mass=\"1\"", "mass=\"1\" collision=\"true\"");
  text = replaced(text, "stiffness=\"8\"", "stiffness=\"0.001\"");
  text = replaced(text, "stiffness=\"5\"", "stiffness=\"0.001\"");
  Simulation sim(read_pml_text(text, "t.pml"), {.backend = "cpu", .damping = {.rate = 20}});
  EXPECT_EQ(connected_bodies(sim.model()).size(), 3u);
  add_body_types(sim.scene());
  sim.scene().gravity({0, 0, 9.81});
  ASSERT_TRUE(sim.advance(0.3).ok());
  for (const Index i : sim.model().group("tissue")) EXPECT_LT(sim.state().position[i].z(), 0.0);
}

TEST(PmlBodies, OfAMergedModelFindEachOther) {
  const Model one = read_pml(hanging), other = moved(one, {0.1, 0, 0});
  const Model both = merge_models(std::vector<NamedBody>{{"a", &one}, {"b", &other}});
  Scene scene(both);
  add_body_types(scene);
  EXPECT_EQ(scene.joints().size(), 6u);
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
  EXPECT_TRUE(has_note(add_body_types(scene), "its cells have no material, which takes young, poisson, and masses"));
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
  EXPECT_EQ(with("body1=\"plate\"", "body1=\"ceiling\""),
            "component \"upper\": expected the name of a component in body1, got \"ceiling\"");
  const std::string no_line =
      "component \"upper\": expected lines between particles of body1 and body2, but that from 0 to 8 is none; both "
      "attributes may be left out";
  EXPECT_EQ(with("body1=\"plate\"", "body1=\"net\""), no_line);
  EXPECT_EQ(with("body1=\"plate\"", "body1=\"lower\" "), no_line);
  EXPECT_EQ(with("stiffness=\"8\"", "stiffness=\"-8\""),
            "component \"upper\": expected a stiffness of 0 N/m or more, got \"-8\"");
  EXPECT_EQ(with("damping=\"0.001\"", "damping=\"some\""),
            "component \"lower\": expected a damping of 0 N s/m or more, got \"some\"");
  EXPECT_EQ(with("<atomRef index=\"0\"/><atomRef index=\"8\"/></cell>",
                 "<atomRef index=\"0\"/><atomRef index=\"0\"/></cell>"),
            "component \"upper\": expected lines between two particles, got one from 0 to itself");
  EXPECT_NE(with("young=\"3000\"", "young=\"soft\"").find("bad.pml:"), std::string::npos);

  const Model model = read_pml(hanging);
  Scene twice(model);
  add_body_types(twice);
  EXPECT_NE(message_of([&] { add_body_types(twice); }).find("net"), std::string::npos);
  EXPECT_EQ(twice.loads().size(), 1u);
}

/// Components of one name have joints of names of their own, found without a search through all.
TEST(PmlBodies, ManyOfOneName) {
  Model model = make_tetrahedron(0.01);
  constexpr int count = 1500;
  for (int k = 0; k < count; ++k) {
    model.components.push_back({.name = k == 2 ? "net 3" : "net",
                                .exclusive = false,
                                .cell_refs = {static_cast<Index>(model.cells.size())},
                                .attributes = {{"bodyType", "interaction"}, {"stiffness", "1"}}});
    model.cells.push_back({.type = CellType::line, .particles = {0, 1}});
  }
  Scene scene(model);
  const auto start = std::chrono::steady_clock::now();
  add_body_types(scene);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(1));
  ASSERT_EQ(scene.joints().size(), std::size_t{count});
  EXPECT_EQ(scene.joints()[0].name, "net");
  EXPECT_EQ(scene.joints()[1].name, "net 2");
  EXPECT_EQ(scene.joints()[2].name, "net 3");
  EXPECT_EQ(scene.joints()[3].name, "net 4");
  EXPECT_EQ(scene.joints().back().name, "net " + std::to_string(count));
}

TEST(PmlBodies, OtherProgramsFilesAreTakenAsTheyAre) {
  const auto after = [&](const std::string& from, const std::string& to, std::vector<std::string>* names = nullptr) {
    const Model model = read_pml_text(replaced(text_of(hanging), from, to), "t.pml");
    Scene scene(model);
    const std::vector<std::string> done = add_body_types(scene);
    if (names) {
      for (const SceneJoint& joint : scene.joints()) names->push_back(joint.name);
    }
    return done;
  };
  EXPECT_TRUE(
      has_note(after("stiffness=\"8\" ", ""), "\"upper\" (bodyType \"interaction\"): no springs, because it has no"));
  std::vector<std::string> names;
  after("name=\"lower\"", "name=\"upper\"", &names);
  EXPECT_EQ(names, (std::vector<std::string>{"net", "upper", "upper 2"}));
  const std::string reversed = "body1=\"tissue\" body2=\"plate\"";
  EXPECT_TRUE(has_note(after("body1=\"plate\" body2=\"tissue\"", reversed),
                       "\"upper\" (bodyType \"interaction\"): 4 spring(s)"));
}

TEST(PmlBodies, AMassThatIsNoNumberIsSaid) {
  const Model model = read_pml_text(replaced(text_of(hanging), "mass=\"2e-4\"", "mass=\"1 2 3\""), "t.pml");
  EXPECT_TRUE(
      has_note(model.notes, "expected one mass of 0 kg or more for each particle of the component, got \"1 2 3\""));
}

}  // namespace
}  // namespace phymul
