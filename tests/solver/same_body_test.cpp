// SPDX-License-Identifier: MIT
//
// Tables that are not, or no longer, those of a model, and states of other bodies: refused, however alike they are. A
// solver stepped by two threads at once, or by what it calls itself, is refused the second step and loses nothing.
#include <gtest/gtest.h>
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <cmath>
#include <limits>
#include <thread>
#include <vector>

#include "support/bodies.h"
#include "support/every_backend.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

Model block_of(const Material& material) {
  return with_material(make_block({0.03, 0.02, 0.02}, 3, 2, 2), material);
}

Model plain_block() {
  Model model = make_block({0.03, 0.02, 0.02}, 3, 2, 2);
  model.materials.clear();
  model.stiffness.assign(model.rest.size(), 10.0);
  return model;
}

std::shared_ptr<const TopologyTextures> tables(const Model& model, const TopologyOptions& options = {}) {
  return std::make_shared<const TopologyTextures>(build_topology(model, options));
}

/// What making a solver over tables of `built` says of a model that `change` has made another one.
std::string after(const Model& built, const std::function<void(Model&)>& change) {
  const auto topology = tables(built);
  Model model = built;
  change(model);
  const Scene scene(model);
  return message_of([&] { make_solver("cpu", topology, scene); });
}

constexpr Material own_tissue{6e3, 0.3, 1000.0};

TEST(TopologyOfAChangedModel, IsRefusedWithWhatHasChanged) {
  const Model model = block_of(own_tissue), plain = plain_block();
  const auto material = [](double young, double poisson) {
    return [=](Model& m) { set_material(m, {young, poisson, own_tissue.density}); };
  };
  EXPECT_TRUE(says(after(model, material(6e4, 0.3)),
                   "another Young's modulus, Poisson's ratio, dissipation, stiffening or row"));
  EXPECT_TRUE(says(after(model, material(6e3, 0.45)),
                   "another Young's modulus, Poisson's ratio, dissipation, stiffening or row"));
  EXPECT_TRUE(says(after(model, material(6e3, 0.45)), "build them anew with build_topology"));
  EXPECT_TRUE(says(after(model,
                         [](Model& m) {
                           m.materials.push_back({6e4, 0.3, own_tissue.density});
                           m.cells.back().material = 1;
                         }),
                   "another Young's modulus"));
  EXPECT_TRUE(says(after(model,
                         [](Model& m) {
                           m.materials.insert(m.materials.begin(), {6e4, 0.3, own_tissue.density});
                           for (Cell& cell : m.cells) ++cell.material;
                         }),
                   "row of Model::materials"));
  EXPECT_TRUE(says(after(model, [](Model& m) { std::swap(m.cells[0].particles, m.cells[1].particles); }), "its cells"));
  EXPECT_TRUE(says(after(plain, [](Model& m) { m.stiffness[7] = std::nextafter(10.0, 11.0); }), "another stiffness"));
  EXPECT_TRUE(says(after(plain, [](Model& m) { std::swap(m.neighbours.entry[0], m.neighbours.entry[1]); }),
                   "other neighbours"));
  EXPECT_TRUE(says(after(plain, material(6e3, 0.3)), "particle 0 has another mass"));
}

TEST(TopologyOfAChangedModel, IsTakenForACopyAndWhereNothingThatMovesTheBodyIsOther) {
  for (const Model& model : {block_of(own_tissue), plain_block()}) {
    EXPECT_EQ(after(model, [](Model&) {}), "(no error)");
    EXPECT_EQ(after(model,
                    [](Model& m) {
                      m.name = "another";
                      m.add_group("one more", {0, 1});
                      m.notes.push_back("read");
                    }),
              "(no error)");
  }
  EXPECT_EQ(after(block_of(own_tissue), [](Model& m) { m.stiffness.assign(m.rest.size(), 3.0); }), "(no error)")
      << "a stiffness that materials stand in for";
}

class SnapshotOfAnotherBody : public OnEveryBackend {
 protected:
  struct Run {
    Run(const Model& of, const TopologyOptions& options = {}) : model(of), scene(model) {
      scene.fix("x0").gravity({0, 0, -9.81});
      solver = make_solver(GetParam(), model, scene, options);
      dt = 0.4 * solver->stable_step();
    }
    Model model;
    Scene scene;
    std::unique_ptr<Solver> solver;
    double dt = 0.0;
  };
  static constexpr const char* refusal = "expected a snapshot of this solver's body";
};

PHYMUL_ON_EVERY_BACKEND(SnapshotOfAnotherBody);

TEST_P(SnapshotOfAnotherBody, IsRefusedAndTheSolverIsAsItWas) {
  const Model wide = with_material(make_block({0.06, 0.02, 0.02}, 3, 2, 2), own_tissue);
  Run own(block_of(own_tissue)), stiffer(block_of({6e4, 0.3, own_tissue.density})), wider(wide);
  Run twin(block_of(own_tissue));
  for (Run* run : {&own, &stiffer, &wider, &twin}) ASSERT_TRUE(run->solver->step(5, run->dt).ok());
  const Snapshot before = own.solver->snapshot();
  own.solver->request_read();
  for (const Run* run : {&stiffer, &wider}) {
    const Snapshot other = run->solver->snapshot();
    EXPECT_NE(other.topology_hash, before.topology_hash);
    EXPECT_TRUE(refuses([&] { own.solver->restore(other); }, refusal));
    EXPECT_EQ(own.solver->snapshot(), before);
  }
  Snapshot broken = before;
  if (!broken.displacement.empty()) {
    broken.displacement[3].y() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(refuses([&] { own.solver->restore(broken); }, "a displacement that is not finite"));
    EXPECT_EQ(own.solver->snapshot(), before);
  }
  State copy;
  bool arrived = false;  // a dropped copy never does
  for (int k = 0; k < 100000 && !arrived; ++k) arrived = own.solver->collect(copy);
  EXPECT_EQ(copy, before.state) << "a copy on its way";

  EXPECT_EQ(before.topology_hash, own.solver->topology_hash());
  ASSERT_TRUE(twin.solver->step(3, twin.dt).ok());
  twin.solver->restore(before);  // over other tables of an equal model
  EXPECT_EQ(twin.solver->snapshot(), before);
  wider.solver->reset(before.state);  // as the message says
  EXPECT_EQ(wider.solver->read().position[0], before.state.position[0]);
}

TEST_P(SnapshotOfAnotherBody, IsNeitherKeptNorGoneBackToByAHistory) {
  Run own(block_of(own_tissue)), other(block_of({6e4, 0.3, own_tissue.density}));
  StateHistory history(1, 1 << 20);
  history.follow(*own.solver, own.solver->step(0, own.dt));
  history.follow(*own.solver, own.solver->step(2, own.dt));
  ASSERT_EQ(history.size(), 2u);
  const Snapshot before = other.solver->snapshot();
  EXPECT_TRUE(refuses([&] { history.rewind(*other.solver, 0.0); }, refusal));
  EXPECT_EQ(other.solver->snapshot(), before);
  EXPECT_TRUE(refuses([&] { history.follow(*other.solver, other.solver->step(0, other.dt)); },
                      "expected a solver of the body whose states are kept"));
  EXPECT_EQ(history.size(), 2u);
  EXPECT_TRUE(history.rewind(*own.solver, 0.0));
  history.clear();
  history.follow(*other.solver, other.solver->step(0, other.dt));
  EXPECT_EQ(history.size(), 1u);
}

TEST(TwoThreads, AStepWithinAStepIsRefused) {
  const Model model = make_block({0.04, 0.02, 0.02}, 4, 2, 2);
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -9.81});
  for (const char* backend : {"cpu", "reference"}) {
    Solver* inner = nullptr;
    std::vector<StepReport> refused;
    SolverOptions options;
    options.progress_seconds = 0.0;
    options.progress = [&](const StepProgress&) {
      const double dt = 0.5 * inner->stable_step();
      refused.push_back(inner->step(1, dt));
      std::thread([&] { refused.push_back(inner->run_to_rest(1, dt).report); }).join();
      return true;
    };
    const auto solver = make_solver(backend, model, scene, {}, options);
    const auto alone = make_solver(backend, model, scene);
    inner = solver.get();
    for (int call = 0; call < 2; ++call) {
      ASSERT_TRUE(solver->step(20, 0.5 * solver->stable_step()).ok());
      ASSERT_TRUE(alone->step(20, 0.5 * alone->stable_step()).ok());
    }
    ASSERT_FALSE(refused.empty());
    for (const StepReport& report : refused) {
      EXPECT_EQ(report.status, StepStatus::invalid_step);
      EXPECT_EQ(report.steps, 0);
      EXPECT_TRUE(says(report.message(), "has not returned yet"));
    }
    EXPECT_TRUE(solver->read() == alone->read()) << backend;
  }
}

/// What is refused is neither recorded nor taken for a step by the history.
TEST(TwoThreads, ARefusedStepLeavesNoTrace) {
  Simulation* inner = nullptr;
  int refused = 0;
  SolverOptions options;
  options.progress_seconds = 0.0;
  options.progress = [&](const StepProgress&) {
    refused += inner->advance(1e-3).ok() ? 0 : 1;
    EXPECT_THROW(inner->unrecorded_solver().reset(), Error);
    return true;
  };
  Simulation sim(make_block({0.04, 0.02, 0.02}, 4, 2, 2),
                 {.material = {.young = 10e3, .poisson = 0.3, .density = 1000}, .backend = "cpu", .solver = options});
  inner = &sim;
  sim.scene().fix("x0").gravity({0, 0, -9.81});
  sim.keep_history(1);
  sim.record();
  ASSERT_TRUE(sim.advance(0.01).ok());
  const double half_way = sim.time();
  ASSERT_TRUE(sim.advance(0.01).ok());
  EXPECT_GT(refused, 0);
  const State end = sim.solver().read();
  EXPECT_TRUE(sim.rewind(half_way));
  EXPECT_DOUBLE_EQ(sim.time(), half_way);
  Simulation again(make_block({0.04, 0.02, 0.02}, 4, 2, 2),
                   {.material = {.young = 10e3, .poisson = 0.3, .density = 1000}, .backend = "cpu"});
  ASSERT_TRUE((again.scene().fix("x0").gravity({0, 0, -9.81}), again.advance(0.01).ok() && again.advance(0.01).ok()));
  EXPECT_TRUE(again.solver().read() == end);
}

}  // namespace
}  // namespace phymul::test
