// SPDX-License-Identifier: MIT
//
// Starts no tissue is in, method by method and backend by backend: which come back, which do not, and that a body that
// stays elsewhere is never passed off as one at rest. docs/measurements/stability.md has the list of cases.
#include <cmath>

#include "stability_fixture.h"
#include "support/failure_states.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

constexpr double cube_side = 0.03;

struct Outcome {
  RestResult rest;
  double distance = 0.0;  ///< from the rest shape, of its own radius
  bool finite = false;
};

class StabilityStarts : public OnBackend {
 protected:
  /// The vector backend has time for the body of recovery_table, sanitized too.
  static int cells() { return GetParam() == "cpu" ? 4 : is_slow() ? 2 : 3; }
  static double spacing() { return cube_side / cells(); }

  class Cube {
   public:
    explicit Cube(const Method& method) : model(tissue_cube(method, cube_side, cells())), scene(model) {
      solver = make(model, scene, method.options, {.damping = {.factor = 0.99}});
    }

    Outcome from(const VecList& position) {
      State state = rest_state(model);
      state.position = position;
      solver->reset(state);
      Outcome outcome{solver->run_to_rest(12000, 0.5 * solver->stable_step())};
      const State end = solver->read();
      outcome.finite = is_finite(end);
      outcome.distance = distance_from_rest_shape(model, end.position);
      return outcome;
    }

    Outcome from(const FailureState& failure) {
      std::mt19937 bits(5);
      VecList position = model.rest;
      failure.apply(position, cube_side, spacing(), bits);
      return from(position);
    }

    Model model;
    Scene scene;
    std::unique_ptr<Solver> solver;
  };

  /// Of the 14 states and the exact point those that run in the time there is.
  static std::vector<FailureState> states() {
    std::vector<FailureState> all = failure_states();
    if (!is_slow()) return all;
    std::erase_if(all, [](const FailureState& state) {
      const std::string name = state.name;
      return name != "flat" && name != "mirrored" && name != "random, 3x" && name != "pulled 10 sides";
    });
    return all;
  }
};

std::string told(const Outcome& outcome) {
  return "distance " + std::to_string(outcome.distance) + ", " + outcome.rest.message();
}

/// What every start must keep to: numbers stay numbers, and rest away from the rest shape is named or a failure.
void expect_no_silent_nonsense(const Outcome& outcome, const std::string& name) {
  EXPECT_TRUE(outcome.finite) << name;
  if (!outcome.rest.report.ok()) {
    EXPECT_GE(outcome.rest.report.particle, 0) << name;
    EXPECT_NE(std::string(outcome.rest.report.cause), "") << name;
    return;
  }
  const bool returned = outcome.distance < 0.01;
  const bool named = outcome.rest.collapsed >= 0 || outcome.rest.folded >= 0;
  EXPECT_TRUE(returned || !outcome.rest.converged() || named) << name << ": " << told(outcome);
}

TEST_P(StabilityStarts, BodiesOfAMaterialReturnFromEveryState) {
  for (const char* name : {"material, nu 0.3", "material, nu 0.45"}) {
    Cube cube(method_named(name));
    int returned = 0, tried = 0;
    for (const FailureState& failure : states()) {
      const Outcome outcome = cube.from(failure);
      const std::string what = std::string(name) + ", " + failure.name + ": " + told(outcome);
      expect_no_silent_nonsense(outcome, what);
      ++tried;
      if (outcome.distance >= 0.01) continue;
      ++returned;
      EXPECT_EQ(outcome.rest.folded, -1) << what;
      EXPECT_TRUE(outcome.rest.report.force_clamped || failure.name == std::string_view("twisted")) << what;
    }
    EXPECT_EQ(returned, tried) << name;
  }
}

/// Every force is 0 there. In floats the rounding of displacements may be noise enough to leave it.
TEST_P(StabilityStarts, ABodyInOnePointIsReportedOrReturns) {
  for (const Method& method : stability_methods()) {
    if (!is_conservative(method)) continue;
    Cube cube(method);
    const VecList point(cube.model.rest.size(), Vec3::Constant(cube_side / 2));
    const Outcome outcome = cube.from(point);
    if (!is_reference() || method.material) {  // whose means are noise enough
      // What the averaged energy may do instead is the subject of a test below.
      if (method.name != "averaged") expect_no_silent_nonsense(outcome, method.name);
      continue;
    }
    EXPECT_TRUE(outcome.rest.converged()) << method.name;
    EXPECT_EQ(outcome.rest.report.steps, SolverOptions{}.rest_steps) << method.name;
    EXPECT_EQ(outcome.rest.report.residual, 0.0) << method.name;
    EXPECT_EQ(outcome.rest.folded, 0) << method.name << told(outcome);
    if (!method.options.law) {
      EXPECT_EQ(outcome.rest.collapsed, 0) << method.name;
      EXPECT_TRUE(says(outcome.rest.message(), "particle 0 has collapsed"));
    }
    EXPECT_TRUE(says(outcome.rest.message(), "cell 0, at ("));
  }
}

/// What becomes of methods that do not return from every state: how many of the states each returns from, and what the
/// report of each of the others says.
TEST_P(StabilityStarts, OtherMethodsReturnFromSomeStatesAndNameTheRest) {
  struct Expected {
    const char* name;
    double least = 0.0, most = 1.0;  // shares of the states
  };
  const Expected all[] = {{.name = "springs 6", .most = 0.25},
                          {.name = "springs 18", .most = 0.25},
                          {.name = "springs 26", .most = 0.25},
                          {.name = "springs 18, volume", .least = 0.25},
                          {.name = "full", .most = 0.0},
                          {.name = "shared"},
                          {.name = "barycentric"}};
  for (const Expected& method : all) {
    Cube cube(method_named(method.name));
    int returned = 0;
    for (const FailureState& failure : states()) {
      SCOPED_TRACE(std::string(method.name) + ", " + failure.name);
      const Outcome outcome = cube.from(failure);
      expect_no_silent_nonsense(outcome, told(outcome));
      returned += outcome.rest.report.ok() && outcome.distance < 0.01;
      if (method.name == std::string("full")) {
        EXPECT_EQ(outcome.rest.report.status, StepStatus::not_finite);
        EXPECT_TRUE(says(outcome.rest.message(), "full reaction"));
      } else if (method.most == 0.25) {
        EXPECT_EQ(outcome.rest.collapsed, -1);
        if (failure.name != std::string("mirrored")) continue;
        // Springs know lengths alone: mirrored, they have no energy at all.
        EXPECT_TRUE(outcome.rest.converged());
        EXPECT_GT(outcome.distance, 0.5);
        EXPECT_LE(cube.solver->energy().elastic, 1e-9 * soft_tissue().young * cube_side * cube_side * cube_side);
      }
    }
    const auto tried = static_cast<double>(states().size());
    EXPECT_GE(returned, std::floor(method.least * tried)) << method.name;
    EXPECT_LE(returned, std::floor(method.most * tried)) << method.name;
  }
}

/// No bulk stiffness: it may rest in other shapes, all of which have next to no energy.
TEST_P(StabilityStarts, TheAveragedEnergyRestsWhereItIsNearlyZero) {
  Cube cube(method_named("averaged"));
  for (const FailureState& failure : states()) {
    const Outcome outcome = cube.from(failure);
    EXPECT_TRUE(outcome.finite && outcome.rest.report.ok()) << failure.name << ": " << told(outcome);
    if (!outcome.rest.converged() || outcome.rest.collapsed >= 0 || outcome.rest.folded >= 0) continue;
    // That of a strain of about 1 %, however far the shape is from the rest shape.
    EXPECT_LE(cube.solver->energy().elastic, 1e-4 * soft_tissue().young * cube_side * cube_side * cube_side)
        << failure.name;
  }
}

/// Twisted by two turns; one cell through its own face; a point's neighbourhood swapped with its opposite.
TEST_P(StabilityStarts, FurtherStatesReturnToo) {
  const std::vector<FailureState> further{
      {"twisted by two turns",
       [](VecList& x, double length, double, std::mt19937&) {
         map_unit_cube(x, length, [](const Vec3& p) {
           return Vec3(Eigen::AngleAxisd(12.566370614359172 * p.z(), Vec3::UnitZ()) * p);
         });
       }},
      {"one corner through its cell",
       [](VecList& x, double, double h, std::mt19937&) { x.front() += Vec3::Constant(1.5 * h); }},
      {"opposite corners swapped", [](VecList& x, double, double, std::mt19937&) { std::swap(x.front(), x.back()); }}};
  for (const char* name : {"material, nu 0.3", "material, nu 0.45"}) {
    Cube cube(method_named(name));
    for (const FailureState& failure : further) {
      const Outcome outcome = cube.from(failure);
      EXPECT_TRUE(outcome.rest.report.ok() && outcome.distance < 0.01)
          << name << ", " << failure.name << ": " << told(outcome);
    }
  }
}

/// Let go from ten times its length, no particle is faster than ten times the stretch's own wave.
TEST_P(StabilityStarts, AStretchedBodySnapsBackNoFasterThanItsWaves) {
  Cube cube(method_named("material, nu 0.3"));
  State state = rest_state(cube.model);
  map_unit_cube(state.position, cube_side, [](const Vec3& p) { return Vec3(p.x(), p.y(), 10 * p.z()); });
  cube.solver->reset(state);
  double fastest = 0.0;
  for (int k = 0; k < 400; ++k) {
    const StepReport report = cube.solver->step(5, 0.5 * cube.solver->stable_step());
    ASSERT_TRUE(report.ok());
    fastest = std::max(fastest, report.max_speed);
  }
  const double wave = std::sqrt(soft_tissue().young * 1.35 / soft_tissue().density);  // of pressure, nu 0.3
  EXPECT_LT(fastest, 10 * wave);
  EXPECT_GT(fastest, wave);
}

PHYMUL_ON_EVERY_BACKEND(StabilityStarts);

}  // namespace
}  // namespace phymul::test
