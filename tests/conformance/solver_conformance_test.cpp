// SPDX-License-Identifier: MIT
#include "solver_conformance.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

std::vector<BackendUnderTest> built_backends() {
  std::vector<BackendUnderTest> all;
  for (const std::string& name : backend_names()) {
    all.push_back({name,
                   [name](const Model& model, const Scene& scene, const TopologyOptions& topology,
                          const SolverOptions& options) { return make_solver(name, model, scene, topology, options); },
                   name == "reference" ? 0x1p-53 : 0x1p-24, [name] { return why_not_here(name); }});
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(All, SolverConformance, testing::ValuesIn(built_backends()), [](const auto& backend) {
  std::string name = backend.param.name;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

TEST(Backends, ABuildWithoutGlIsNoneWhereGlIsRequired) {
  EXPECT_TRUE(!gl_is_required() || std::ranges::count(backend_names(), "gl") == 1)
      << "PHYMUL_REQUIRE_GL=1, and this build has no GL backend: " << backend_names().size() << " backends";
}

TEST(Backends, UnknownNameListsTheKnownOnes) {
  const Model model = make_tetrahedron(0.01);
  const Scene scene(model);
  try {
    make_solver("vulkan", model, scene);
    FAIL() << "accepted";
  } catch (const Error& error) {
    std::string known = "auto";
    for (const std::string& name : backend_names()) known += ", " + name;
    EXPECT_EQ(error.what(), "unknown backend \"vulkan\"; this build has: " + known);
  }
  EXPECT_EQ(make_solver("auto", model, scene)->name(), "cpu");
}

TEST(Backends, SceneOfAnotherModelIsRefused) {
  const Model model = make_tetrahedron(0.01), other = make_tetrahedron(0.02);
  const Scene scene(other);
  EXPECT_THROW(make_solver("reference", model, scene), Error);
}

TEST(Backends, TablesOfAnotherBodyAreRefused) {
  const Model model = make_tetrahedron(0.01), other = make_block({1, 1, 1}, 1, 1, 1);
  const Scene scene(model);
  EXPECT_TRUE(
      refuses([&] { make_solver("reference", std::make_shared<const TopologyTextures>(build_topology(other)), scene); },
              "built for 8 particles, the scene's model has 4"));
  EXPECT_TRUE(refuses([&] { make_solver("reference", std::shared_ptr<const TopologyTextures>(), scene); },
                      "the topology is null"));
}

TEST(Backends, TablesOfAChangedBodyAreRefused) {
  Model model = make_tetrahedron(0.01);
  const auto tables = std::make_shared<const TopologyTextures>(build_topology(model));
  const Model wider = make_tetrahedron(0.02);
  const Scene scene(model), scene_of_wider(wider);
  const auto message = [&](const Scene& of) { return message_of([&] { make_solver("reference", tables, of); }); };
  EXPECT_TRUE(says(message(scene_of_wider), "particle 1 has another rest place"));
  model.mass[2] = 3.0;
  EXPECT_TRUE(says(message(scene), "particle 2 has another mass"));
}

TEST(Backends, BodiesBeyondTheRangeOfNumbersAreRefused) {
  Model model = make_tetrahedron(0.01);
  model.mass[1] = 1e-300;
  const Scene scene(model);
  EXPECT_TRUE(refuses([&] { make_solver("reference", model, scene); }, "beyond the range of numbers"));
}

TEST(Backends, TablesAreShared) {
  const Model model = make_tetrahedron(0.01);
  const Scene scene(model);
  const auto tables = std::make_shared<const TopologyTextures>(build_topology(model));
  const auto a = make_solver("reference", tables, scene), b = make_solver("reference", tables, scene);
  EXPECT_EQ(&a->topology(), &b->topology());
}

}  // namespace
}  // namespace phymul::test
