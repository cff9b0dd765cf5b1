// SPDX-License-Identifier: MIT
//
// Case files of bench/reference: expressions, and the bodies and loads they make.
#include <gtest/gtest.h>
#include <phymul/load_frame.h>
#include <phymul/phymul.h>

#include <filesystem>
#include <fstream>
#include <limits>

#include "arguments.h"
#include "expression.h"
#include "measures.h"
#include "methods.h"
#include "problem.h"
#include "reference_case.h"
#include "relaxation.h"
#include "support/sanitized.h"

namespace phymul::bench {
namespace {

TEST(Expression, PrecedenceFunctionsAndConditions) {
  const Variables v{{"x", 2.0}, {"n", 3.0}};
  EXPECT_DOUBLE_EQ(evaluate("1+2*x^2-6/n", v), 7.0);
  EXPECT_DOUBLE_EQ(evaluate("-x^2", v), -4.0);
  EXPECT_DOUBLE_EQ(evaluate("2^-1", v), 0.5);
  EXPECT_DOUBLE_EQ(evaluate("8-3-2", v), 3.0);
  EXPECT_DOUBLE_EQ(evaluate("sqrt(16)+max(1, x)+cos(pi)", v), 5.0);
  EXPECT_DOUBLE_EQ(evaluate("if(x<=2 && n!=2, 1e-3, 7)", v), 1e-3);
  EXPECT_DOUBLE_EQ(evaluate("!(x>1) || n==3", v), 1.0);
}

TEST(Expression, ErrorsQuoteTheText) {
  for (const char* wrong : {"", "1+", "2*(3", "y", "foo(1)", "1/0", "3 4", "sin(1,2)"}) {
    EXPECT_THROW(evaluate(wrong, {}), Error) << wrong;
  }
}

TEST(Arguments, RefuseAChoiceThatIsNotThere) {
  char program[] = "work_precision", name[] = "--methods", value[] = "averaged,neo_hookean";
  char* argv[] = {program, name, value};
  const Arguments given(3, argv, {{"methods", ""}});
  EXPECT_EQ(given.chosen("methods", {"averaged", "neo_hookean"}).size(), 2u);
  EXPECT_THROW(given.chosen("methods", method_names()), Error);
}

class CaseFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) / "phymul_case_file";
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& text) const {
    std::string path = (folder_ / name).string();
    std::ofstream(path) << text;
    return path;
  }

  std::filesystem::path folder_;
};

/// A body no case file of the project has: a mesh file, a group by a condition, an imposed shear that depends on place.
TEST_F(CaseFile, MeshFileSheared) {
  const Model body = make_tetrahedral_block({0.06, 0.02, 0.02}, 6, 2, 2, 0.1, 4);
  write_vtu(body, rest_state(body), (folder_ / "body_2.vtu").string());
  const std::string path =
      write("sheared.case",
            "body file body_{n}.vtu 2\nresolutions 2\nlevel a nu=0.4 d=0.01*n\nlet twice 2*d\n"
            "material 5e3 nu 900\ngroup low z < 1e-9\ngroup high z > 0.04-1e-9 && x > -1\nfix low\n"
            "move high twice*x/0.12 - 0\npoint 0.05 0.02 0.02\nexact z 0 0\nreaction high - - 1\n");
  const ReferenceCase it = read_case(path);
  const Problem problem = make_problem(it, "a", 2);
  EXPECT_DOUBLE_EQ(problem.model.materials.front().poisson, 0.4);
  EXPECT_NEAR(volume(problem.model, problem.model.rest), 0.12 * 0.04 * 0.04, 1e-12);
  const Scene scene = problem.scene(problem.model);
  LoadFrame frame;
  scene.prepare(frame);
  scene.evaluate(0.0, frame);
  for (const Index i : problem.model.group("high")) {
    const Vec3& rest = problem.model.rest[i];
    EXPECT_EQ(frame.fixed[i], 5);
    EXPECT_NEAR(frame.target[i].x(), rest.x() + 0.04 * rest.x() / 0.12, 1e-12);
    EXPECT_NEAR(frame.target[i].z(), rest.z(), 1e-15);
  }
  for (const Index i : problem.model.group("low")) EXPECT_EQ(frame.fixed[i], 7);
  EXPECT_NEAR(problem.reference[0].x(), 0.02, 1e-15);
}

/// Files that include each other in other folders: each path is relative to the file that has it.
TEST_F(CaseFile, PathsAreRelativeToTheFileThatHasThem) {
  const Model body = make_block({1, 1, 1}, 2, 2, 2);
  std::filesystem::create_directories(folder_ / "parts" / "data");
  write_vtu(body, rest_state(body), (folder_ / "parts" / "data" / "cube.vtu").string());
  write("parts/data/cube.csv", "only,0,0,1,0,0,0.25\n");
  write("parts/body.case", "body file data/cube.vtu\nsamples data/cube.csv\nresolutions 2\n");
  write("parts/loads.case", "include body.case\nfix z0\n");
  const Problem problem = make_problem(read_case(write("all.case", "include parts/loads.case\n")), "only", 2);
  EXPECT_EQ(problem.model.particle_count(), body.particle_count());
  EXPECT_EQ(problem.reference, VecList{Vec3(0, 0, 0.25)});
}

TEST_F(CaseFile, ErrorsNameFileAndLine) {
  const std::string path = write("wrong.case", "title it\nbody block 1 1 1\nmove x0 0 0\n");
  try {
    read_case(path);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("wrong.case:3:"), std::string::npos) << error.what();
  }
  EXPECT_THROW(read_case(write("short.case", "body block 1 1 1\ncells n n n\nresolutions 2\n")), Error);
}

/// A wrong file's message, without its folder; empty where it is accepted.
std::string refusal(const std::string& path) {
  try {
    const ReferenceCase it = read_case(path);
    make_problem(it, it.levels.front().name, it.resolutions.front());
  } catch (const Error& error) {
    const std::string text = error.what();
    return text.substr(std::min(text.size(), text.rfind('/') + 1));
  }
  return {};
}

TEST_F(CaseFile, WrongToolsAreRefusedWithWhatIsExpected) {
  const std::string body = "body block 1 1 1\ncells n n n\nresolutions 1\n";
  const auto refused = [&](const std::string& lines) { return refusal(write("tool.case", body + lines)); };
  EXPECT_EQ(refused("tool t cone 1 0 0 0 0 0 0\npush t - - 1\n"),
            "tool.case:4: tool shape \"cone\": expected sphere, capsule, half-space or box");
  EXPECT_EQ(refused("tool t sphere 0 0 0 0 0 0\npush t - - 1\n"),
            "tool.case:4: expected: tool NAME sphere radius x y z ux uy uz [ax ay az]");
  EXPECT_EQ(refused("tool t\npush t - - 1\n"),
            "tool.case:4: expected: tool NAME sphere|capsule|half-space|box sizes x y z ux uy uz [ax ay az]");
  EXPECT_EQ(refused("tool t half-space 0 0 0 0 0 0 0 0\n"),
            "tool.case:4: expected: tool NAME half-space x y z ux uy uz [ax ay az]");
  EXPECT_EQ(refused("tool t sphere 1 0 0 3 0 0 0\npush t - 1\n"), "tool.case:5: expected: push TOOL fx fy fz");
  EXPECT_EQ(refused("push other - - 1\n"), "tool.case: expected a line \"tool other\" for the line \"push\"");
  EXPECT_EQ(refused("tool t sphere 1 0 0 3 0 0 0\ntool t half-space 0 0 -1 0 0 0\npush t - - 1\n"),
            "tool.case: expected one tool \"t\", not several");
  EXPECT_EQ(refused("tool t sphere 1 0 0 3 0 0 0 0 0 0\npush t - - 1\n"), "tool t: expected an axis that is not zero");
  EXPECT_EQ(refused("field f\npush t - - 1\n"), "tool.case:4: expected: field NAME expression");
  EXPECT_EQ(refused("point 0 0 0\nreaction z0 1 - -\n"), "tool.case: expected \"point\" lines and \"exact\" together");
  EXPECT_EQ(refused("tool t sphere 1 0 0 3 0 0 0\n"),
            "tool.case: expected \"samples\", or \"point\" lines and \"exact\"; or, for forces alone, \"reaction\", "
            "\"torque\" or \"push\"");
}

/// Tools of all shapes are where the file has brought them, and look where it says.
TEST_F(CaseFile, ToolsOfEveryShape) {
  const ReferenceCase it = read_case(
      write("tools.case",
            "body block 1 1 1\ncells n n n\nresolutions 1\nlevel a d=0.25\ntool ball sphere 2*d 0 0 3 0 0 -d\n"
            "tool rod capsule d 4 5 0 0 d 0 0 1 0 0\ntool plate half-space 0 0 2 0 0 0 0 0 -1\n"
            "tool brick box 1 2 3 9 0 0 0 0 0\npush ball - d 1\n"));
  const Problem problem = make_problem(it, "a", 1);
  const Scene scene = problem.scene(problem.model);
  ASSERT_EQ(scene.tools().size(), 4u);
  EXPECT_EQ(std::get<Sphere>(scene.tools()[0].tool.shape).radius, 0.5);
  EXPECT_LT((scene.tools()[0].pose.position - Vec3(0, 0, 2.75)).norm(), 1e-15);
  EXPECT_EQ(std::get<Capsule>(scene.tools()[1].tool.shape).radius, 0.25);
  EXPECT_EQ(std::get<Capsule>(scene.tools()[1].tool.shape).length, 4.0);
  EXPECT_LT((scene.tools()[1].pose.orientation * Vec3(0, 0, 1) - Vec3(1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((scene.tools()[1].pose.position - Vec3(5.25, 0, 0)).norm(), 1e-15);
  EXPECT_TRUE(std::holds_alternative<HalfSpace>(scene.tools()[2].tool.shape));
  EXPECT_LT((scene.tools()[2].pose.orientation * Vec3(0, 0, 1) - Vec3(0, 0, -1)).norm(), 1e-12);
  EXPECT_LT((std::get<Box>(scene.tools()[3].tool.shape).half_size - Vec3(1, 2, 3)).norm(), 1e-15);
  ASSERT_EQ(problem.pushes.size(), 1u);
  EXPECT_FALSE(problem.pushes[0].value[0]);
  EXPECT_EQ(problem.pushes[0].value[1], 0.25);
}

TEST_F(CaseFile, NullModelBetweenPlatesIsTheRamp) {
  const std::string path = write("ramp.case",
                                 "body block 0.1 0.1 0.2\ncells n n 2*n\nresolutions 3\nfix z0\nmove z1 0.01 0 -0.02\n"
                                 "point 0.05 0.05 0.1\nexact 0.005 0 -0.01\n");
  const Problem problem = make_problem(read_case(path), "only", 3);
  for (Index i = 0; i < problem.model.particle_count(); ++i) {
    const double share = problem.model.rest[i].z() / 0.2;
    EXPECT_LT((problem.displacement[i] - share * Vec3(0.01, 0, -0.02)).norm(), 1e-12);
  }
  EXPECT_LT(null_error(problem)->global_ratio, 1e-10);
}

/// Relaxed by real stepping, a stretched block has the strains and the force of its E and nu; a wrong nu is seen.
TEST_F(CaseFile, RelaxedBodyMeetsTheClosedForm) {
  const std::string text =
      "let e 1e-3\nbody block 0.04 0.02 0.02\ncells 2*n n n\nresolutions 2\nmaterial 1e4 0.3 1000\nlevel right q=0.3\n"
      "level wrong q=0.25\nmove x0 0 - -\nmove x1 e*0.04 - -\nmove y0 - 0 -\nmove z0 - - 0\npoint 0.021 0.02 0.013\n"
      "exact e*x -q*e*y -q*e*z\nreaction x1 1e4*e*0.02^2 - -\n";
  const ReferenceCase it = read_case(write("stretch.case", text));
  for (const bool right : {true, false}) {
    const Problem problem = make_problem(it, right ? "right" : "wrong", 2);
    const auto topology = std::make_shared<const TopologyTextures>(build_topology(problem.model));
    const Scene scene = problem.scene(problem.model);
    VecList start = problem.model.rest;
    for (std::size_t i = 0; i < start.size(); ++i) start[i] += problem.displacement[i];
    RelaxationPlan plan;
    plan.backend = "reference";
    const Relaxation relaxation = relax(topology, scene, start, plan);
    ASSERT_EQ(relaxation.status, "ok") << relaxation.message;
    const Measures measures = measure(problem, *topology, scene, relaxation.state.position);
    if (right) {
      EXPECT_LT(measures.displacement->global_ratio, 1e-3);
    } else {
      EXPECT_GT(measures.displacement->global_ratio, 0.02);
    }
    EXPECT_LT(measures.force_error.value(), 3e-3);
  }
}

/// Pressed between its frictionless ground and a plate, a block has uniform strain: the plate feels E times it. Forces
/// are all that this case knows; a wrong one is seen.
TEST_F(CaseFile, AToolFeelsTheForceOfTheClosedForm) {
  const ReferenceCase it = read_case(
      write("plate.case",
            "let e 1e-3\nbody block 0.04 0.02 0.02\ncells 2*n n n\nresolutions 2\nlevel right q=1\nlevel wrong q=0.8\n"
            "material 1e4 0.3 1000\nmove x0 0 - -\nmove y0 - 0 -\nmove z0 - - 0\n"
            "tool plate half-space 0.04 0 0 -e*0.04 0 0 -1 0 0\npush plate q*1e4*e*0.02^2 0 0\n"));
  for (const char* backend : {"reference", "cpu"}) {
    for (const bool right : {true, false}) {
      const Problem problem = make_problem(it, right ? "right" : "wrong", 2);
      const auto topology = std::make_shared<const TopologyTextures>(build_topology(problem.model));
      const Scene scene = problem.scene(problem.model);
      RelaxationPlan plan;
      plan.backend = backend;
      plan.step_share = 0.5;
      const Relaxation relaxation = relax(topology, scene, problem.model.rest, plan);
      ASSERT_EQ(relaxation.status, "ok") << relaxation.message;
      const Measures measures = measure(problem, *topology, scene, relaxation.state.position, relaxation.tool_force);
      EXPECT_FALSE(measures.displacement);
      EXPECT_FALSE(null_error(problem));
      ASSERT_TRUE(measures.force_error);
      EXPECT_NEAR(*measures.force_error, right ? 0.0 : 0.25, 3e-3) << backend;
    }
  }
}

/// Every level has sample points, and says how exact they are.
TEST(ReferenceCases, EveryLevelMakesItsCoarsestProblem) {
  for (const ReferenceCase& it : read_cases(PHYMUL_REFERENCE_CASES)) {
    for (const ReferenceCase::Level& level : it.levels) {
      const Problem problem = make_problem(it, level.name, it.resolutions.front());
      EXPECT_GE(problem.sample_point.size(), 4u) << it.name << ' ' << level.name;
      EXPECT_GT(problem.floor, 0.0) << it.name << ' ' << level.name;
    }
  }
}

/// Errors of a method, by name, at rest; none where it does not come to rest.
Measures measures_at_rest(const std::string& file, const std::string& level, int n, const std::string& method_name) {
  const ReferenceCase it = read_case(std::string(PHYMUL_REFERENCE_CASES) + "/" + file);
  const Problem problem = make_problem(it, level, n);
  for (const Method& method : all_methods()) {
    if (method.name != method_name) continue;
    MethodBody body = body_for(method, problem);
    if (method.rule == StiffnessRule::lattice) {
      set_stiffness(body, spring_stiffness(body, problem.model.materials.front()));
    }
    const auto topology = std::make_shared<const TopologyTextures>(build_topology(body.model, body.options));
    const Scene scene = problem.scene(body.model);
    VecList start = problem.model.rest;
    for (std::size_t i = 0; i < start.size(); ++i) start[i] += problem.displacement[i];
    RelaxationPlan plan;
    plan.backend = "cpu";
    plan.step_share = 0.5;
    plan.wall_cap = 60.0;
    const Relaxation relaxation = relax(topology, scene, start, plan);
    if (relaxation.status != "ok") return {};
    return measure(problem, *topology, scene, relaxation.state.position, relaxation.tool_force);
  }
  throw Error("no method is called " + method_name);
}

/// Of the displacement; infinite where it does not come to rest.
double error_at_rest(const std::string& file, const std::string& level, int n, const std::string& method) {
  const auto displacement = measures_at_rest(file, level, n, method).displacement;
  return displacement ? displacement->global_ratio : std::numeric_limits<double>::infinity();
}

/// A sphere feels Hertz' force, and the displacement under it is Hertz'; with under 3 cells in the contact's radius.
TEST(ReferenceCases, ASpherePressedInMeetsHertz) {
  for (const char* level : {"nu0.30", "nu0.45"}) {
    const Measures found = measures_at_rest("hertz.case", level, test::sanitized ? 4 : 8, "particle_averaged");
    ASSERT_TRUE(found.force_error && found.displacement) << level;
    EXPECT_LT(*found.force_error, test::sanitized ? 0.14 : 0.07) << level;
    EXPECT_LT(found.displacement->global_ratio, test::sanitized ? 0.15 : 0.04) << level;
  }
}

/// Strongly bent, cells of springs collapse; the calibrated body holds the bound of 2 %.
TEST(ReferenceCases, SpringsFailInStrongBendingAndTheCalibratedBodyHolds) {
  const int n = test::sanitized ? 2 : 4;
  EXPECT_GT(error_at_rest("cantilever.case", "nu0.30_g0.30", n, "springs_18"), 0.10);
  EXPECT_LT(error_at_rest("cantilever.case", "nu0.30_g0.30", n, "particle_averaged"), n == 2 ? 0.04 : 0.02);
}

/// Pressed by 18 % between bonded plates, where cells might buckle: no jump from level to level.
TEST(ReferenceCases, APressedCubeDoesNotBuckle) {
  const int n = test::sanitized ? 4 : 8;
  double before = 0.0;
  for (const char* level : {"nu0.30_c0.0500", "nu0.30_c0.1250", "nu0.30_c0.1825"}) {
    const double error = error_at_rest("cube_bonded.case", level, n, "particle_averaged");
    EXPECT_LT(error, 0.04) << level;
    EXPECT_LT(error, before + 0.025) << level;
    before = error;
  }
}

}  // namespace
}  // namespace phymul::bench
