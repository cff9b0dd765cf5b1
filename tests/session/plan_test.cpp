// SPDX-License-Identifier: MIT
//
// plan(): promises, offers, the same motion from the same plan, and what it refuses.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>
#include <utility>

#include "session/planner/planner.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

constexpr Material planned_tissue{.young = 10e3, .poisson = 0.3, .density = 1000};

int cells(double length, double spacing) {
  return std::max(1, static_cast<int>(std::lround(length / spacing)));
}

Model beam(double spacing) {
  return make_block({0.2, 0.05, 0.05}, cells(0.2, spacing), cells(0.05, spacing), cells(0.05, spacing));
}

Simulation sagging(const PlanCandidate& candidate) {
  Simulation sim(beam(candidate.spacing), candidate.options({.material = planned_tissue}));
  sim.scene().fix("x0").gravity({0, 0, -0.1});
  return sim;
}

PlanOptions wishes(double max_error, double rate) {
  return {.max_error = max_error, .rate = rate};
}

/// Root mean square of the distance from another body of the same beam, at the particles of a coarse one.
double distance_from(const Simulation& sim, const Simulation& reference) {
  const VecList points = beam(0.025).rest;
  const auto at = [&](const Simulation& body) {
    return Skin(body.model(), points).deform(body.solver().read().position);
  };
  const VecList a = at(sim), b = at(reference);
  double error = 0.0, scale = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    error += (a[i] - b[i]).squaredNorm();
    scale += (b[i] - points[i]).squaredNorm();
  }
  return std::sqrt(error / scale);
}

TEST(Plan, KeepsItsPromiseAgainstAMuchFinerBody) {
  const Plan made = plan(sagging, wishes(0.02, 20));
  ASSERT_TRUE(made.kept) << made.report();
  EXPECT_LE(made.chosen.error, 0.02);
  EXPECT_GT(made.chosen.error, 0.0);
  EXPECT_LE(made.chosen.tick, 0.8 / 20);
  Simulation sim = made.make();
  Simulation fine = sagging({.spacing = 0.05 / 12});
  ASSERT_TRUE(sim.solve_static().converged());
  ASSERT_TRUE(fine.solve_static().converged());
  const double found = distance_from(sim, fine);
  EXPECT_LE(found, made.chosen.error);
  EXPECT_GE(found, 0.02 / 20) << "far finer than asked for:\n" << made.report();
  EXPECT_TRUE(says(made.report(), "chosen"));
}

/// Particles that wait for cuts are neither compared, at the place of the first one, nor counted.
TEST(Plan, SpareParticlesChangeNoError) {
  PlanOptions options = wishes(0.02, 20);
  options.coarsest = 0.05, options.finest = 0.02;
  const auto planned = [&](Index spare) {
    const auto hanging = [spare](const PlanCandidate& candidate) {
      Simulation sim(with_spare_particles(beam(candidate.spacing), spare),
                     candidate.options({.material = planned_tissue}));
      sim.scene().fix("x1").gravity({0, 0, -0.1});
      return sim;
    };
    return plan(hanging, options);
  };
  const Plan one = planned(0), other = planned(2000);
  ASSERT_EQ(one.trials.size(), other.trials.size());
  for (std::size_t k = 0; k < one.trials.size(); ++k) {
    EXPECT_EQ(one.trials[k].particles, other.trials[k].particles);
    EXPECT_NEAR(one.trials[k].error, other.trials[k].error, 1e-6);
  }
}

/// While time is left, bodies are compared with a better one than the error asked for needs.
TEST(Plan, UsesTimeThatIsLeftForABetterReference) {
  const Plan made = plan(sagging, wishes(0.1, 20));
  EXPECT_LT(made.trials.back().error, 0.25 * made.options.max_error) << made.report();
}

TEST(Plan, PromisesNothingWhereCellsFold) {
  const auto folding = [](const PlanCandidate& candidate) {
    Simulation sim = sagging(candidate);
    sim.scene().gravity({0, 0, -9.81});
    return sim;
  };
  const Plan made = plan(folding, {.max_error = 0.5, .rate = 20, .finest = 0.009});
  EXPECT_FALSE(made.kept) << made.report();
  EXPECT_TRUE(made.most_accurate) << "an offer";
  EXPECT_TRUE(says(made.report(), "No error is certain, because cells of the finest body")) << made.report();
  EXPECT_TRUE(says(made.report(), "error not certain; cell ")) << made.report();
  EXPECT_FALSE(says(plan(sagging, wishes(0.1, 20)).report(), "inside out"));
}

TEST(Plan, AStrictWishTakesAFinerBody) {
  const Plan loose = plan(sagging, wishes(0.1, 20)), strict = plan(sagging, wishes(0.01, 20));
  ASSERT_TRUE(loose.kept) << loose.report();
  ASSERT_TRUE(strict.kept) << strict.report();
  EXPECT_LT(loose.chosen.particles, strict.chosen.particles);
}

TEST(Plan, ImpossibleWishesNameOffers) {
  const Plan made = plan(sagging, wishes(0.02, 1e7));
  EXPECT_FALSE(made.kept);
  ASSERT_TRUE(made.cheapest) << made.report();
  EXPECT_LE(made.cheapest->error, 0.02);
  EXPECT_TRUE(refuses([&] { made.make(); }, "Fastest of the coarsest body with the error: "));
  EXPECT_TRUE(says(made.report(), "Not kept. No candidate that keeps the error is fast enough."));
  char tick[32];
  std::snprintf(tick, sizeof tick, "a tick takes %.4g us", 1e6 * made.cheapest->tick);
  EXPECT_TRUE(says(made.report(), tick));
  EXPECT_TRUE(made.make(*made.cheapest).advance(1e-3).ok());

  const Plan exact = plan(sagging, {.max_error = 1e-6, .rate = 20, .finest = 0.009});
  EXPECT_FALSE(exact.kept);
  ASSERT_TRUE(exact.most_accurate) << exact.report();
  EXPECT_TRUE(exact.most_accurate->keeps_time);
  EXPECT_TRUE(refuses([&] { exact.make(); }, "Most accurate in time: "));
  EXPECT_TRUE(says(exact.reason, "No body that was tried keeps the error", "PlanOptions::finest is reached"));
}

TEST(Plan, MakesTheSameMotionToTheLastBit) {
  const Plan made = plan(sagging, wishes(0.05, 20));
  ASSERT_TRUE(made.kept) << made.report();
  Simulation a = made.make(), b = made.make();
  ASSERT_TRUE(a.advance(0.05).ok());
  ASSERT_TRUE(b.advance(0.05).ok());
  EXPECT_GT(a.max_displacement(), 0.0);
  EXPECT_EQ(a.solver().read(), b.solver().read());
}

/// Ticks are those of the rest shape, where nothing moves, and not of the way there.
TEST(Plan, MeasuresTicksAtRest) {
  double fastest = 0.0;
  int told = 0;
  const auto watched = [&](const PlanCandidate& candidate) {
    SimulationOptions options{.material = planned_tissue};
    options.solver.progress_seconds = 0.0;
    options.solver.progress = [&](const StepProgress& at) {
      ++told;
      fastest = std::max(fastest, at.max_speed);
      return true;
    };
    Simulation sim(beam(candidate.spacing), candidate.options(std::move(options)));
    sim.scene().fix("x0").gravity({0, 0, -0.1});
    return sim;
  };
  ASSERT_TRUE(plan(watched, {.max_error = 0.1, .rate = 20, .steps = {0.5, 0.4}}).kept);
  EXPECT_GT(told, 10);
  EXPECT_LT(fastest, 1e-4);  // m/s; 5e-3 on the way
}

TEST(Plan, KeepsItsBudget) {
  for (const double budget : {0.05, 0.5}) {
    const auto begin = std::chrono::steady_clock::now();
    const Plan made = plan(sagging, {.max_error = 1e-5, .rate = 100, .budget = budget});
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    // A trial that has begun is finished, and other programs may have the processor.
    EXPECT_LT(seconds, 3.0 * budget + 1.0);
    EXPECT_LE(made.seconds, seconds);
    EXPECT_FALSE(made.kept);
  }
}

TEST(Plan, FollowsMotionUnderLoadsAndTools) {
  int ticks = 0;
  const auto pressed = [](const PlanCandidate& candidate) {
    Simulation sim(beam(candidate.spacing), candidate.options({.material = planned_tissue}));
    sim.scene().fix("z0");
    sim.scene().add_tool("probe", {.shape = Sphere{.radius = 0.03}, .pose = {.position = {0.1, 0.025, 0.081}}});
    return sim;
  };
  const auto move = [&ticks](Simulation& sim) {
    ++ticks;
    sim.scene().tool("probe").move_to({.position = {0.1, 0.025, 0.081 - 0.5 * sim.time()}});
  };
  const Plan made = plan(pressed, {.max_error = 0.9, .rate = 500, .probe_time = 0.02, .before_tick = move});
  EXPECT_GE(ticks, 3 * 10);
  EXPECT_GE(made.trials.size(), 3u);
  for (const PlanTrial& trial : made.trials) EXPECT_TRUE(std::isnan(trial.rest));
  EXPECT_FALSE(std::isnan(made.trials.front().error)) << made.report();
}

TEST(Plan, SaysWhichMotionWasMeasuredInPart) {
  double step = 0.0;
  int ticks = 0;
  const auto moving = [&](const PlanCandidate& candidate) {
    step = candidate.step;
    ticks = 0;
    return sagging(candidate);
  };
  // For longer than the budget, which suffices for the first motion on any machine.
  const auto wait = [&](Simulation&) {
    if (step < 0.4 && ++ticks == 3) std::this_thread::sleep_for(std::chrono::milliseconds(1600));
  };
  PlanOptions options{.max_error = 0.9, .rate = 500, .probe_time = 0.02, .before_tick = wait};
  options.coarsest = 0.05, options.finest = 0.02, options.budget = 1.5, options.steps = {0.5, 0.25};
  options.most_threads = 1;
  const Plan made = plan(moving, options);
  EXPECT_TRUE(says(made.report(), "the budget ended at ", " of 10 ticks")) << made.report();
}

TEST(Plan, NamesTheFinestBodyWithAnError) {
  const auto limited = [](const PlanCandidate& candidate) {
    if (candidate.spacing < 0.02) throw Error("no finer organ");
    return sagging(candidate);
  };
  PlanOptions options = wishes(1e-6, 20);
  options.coarsest = 0.05;
  const Plan made = plan(limited, options);
  EXPECT_TRUE(says(made.reason, "the finest, 25 mm, has ", "finer bodies fail: no finer organ")) << made.reason;
}

TEST(Plan, FillsASolidAndKeepsTheTimeToRest) {
  const auto fill = [](Simulation& sim) {
    sim.scene().fix(sim.model().particles_in([](const Vec3& at) { return at.x() < -0.02; }));
    sim.scene().gravity({0, 0, -2.0});
  };
  const Plan made = plan(solid_ellipsoid({0, 0, 0}, {0.05, 0.03, 0.03}), {.material = planned_tissue}, fill,
                         {.max_error = 0.5, .rest_in = 10.0, .finest = 0.006});
  ASSERT_TRUE(made.kept) << made.report();
  EXPECT_TRUE(made.make().solve_static().converged());
  // A thousandth of the time is for rest, and no body rests in a microsecond.
  const Plan hasty = plan(solid_ellipsoid({0, 0, 0}, {0.05, 0.03, 0.03}), {.material = planned_tissue}, fill,
                          {.max_error = 0.5, .rest_in = 10.0, .head_room = 1e-7, .finest = 0.006});
  for (const PlanTrial& trial : hasty.trials) EXPECT_FALSE(trial.keeps_time) << trial.rest;
}

TEST(Plan, RefusesWhatMakesNoSense) {
  const auto asked = [](const PlanOptions& options) { return [options] { plan(sagging, options); }; };
  EXPECT_TRUE(refuses(asked({.max_error = 0.0, .rate = 100}), "PlanOptions::max_error must be above 0 and below 1"));
  EXPECT_TRUE(refuses(asked({.max_error = 3.0, .rate = 100}), "; got 3"));
  EXPECT_TRUE(refuses(asked({.max_error = 0.1}), "expected a rate (Hz) or rest_in (s) to be kept, got neither"));
  EXPECT_TRUE(refuses(asked({.max_error = 0.1, .rate = -1}), "PlanOptions::rate must be"));
  EXPECT_TRUE(refuses(asked({.max_error = 0.1, .rate = 100, .budget = 0}), "PlanOptions::budget must be"));
  EXPECT_TRUE(refuses(asked({.max_error = 0.1, .rate = 100, .steps = {1.5}}), "PlanOptions::steps must be"));
  EXPECT_TRUE(refuses(asked({.max_error = 0.1, .rate = 100, .backends = {}}), "got none"));
  EXPECT_TRUE(refuses(asked({.max_error = 0.1, .rest_in = 1, .probe_time = 1}), "got both"));
  EXPECT_TRUE(refuses([] { plan(SceneBuilder(), wishes(0.1, 100)); }, "got an empty function"));
  EXPECT_TRUE(refuses([] { Plan().make({}); }, "got an empty plan"));
}

TEST(Plan, SaysWhatIsWrongWithABuilder) {
  const auto built = [](const SceneBuilder& builder) { return [builder] { plan(builder, wishes(0.1, 100)); }; };
  const auto beam_with = [&](auto act, double spacing = 0.0) {
    return built([=](const PlanCandidate& it) {
      Simulation sim(beam(spacing > 0.0 ? spacing : it.spacing), it.options({.material = planned_tissue}));
      act(sim.scene());
      return sim;
    });
  };
  EXPECT_TRUE(refuses(built([](const PlanCandidate&) -> Simulation { throw Error("no such organ"); }),
                      "the builder made no body at any spacing", "no such organ"));
  EXPECT_TRUE(refuses(beam_with([](Scene& scene) { scene.fix("x0").gravity(Vec3(0, 0, -1)); }, 0.02),
                      "it must use PlanCandidate::spacing"));
  EXPECT_TRUE(refuses(built([](const PlanCandidate& it) {
                        return Simulation(beam(it.spacing), {.material = planned_tissue, .backend = "reference"});
                      }),
                      "expected a simulation with the backend \"cpu\", got \"reference\""));
  EXPECT_TRUE(
      refuses(beam_with([](Scene& scene) { scene.gravity(Vec3(0, 0, -1)); }), "and the loads drive it: it moves away"));
  EXPECT_TRUE(refuses(beam_with([](Scene& scene) { scene.fix("x0"); }), "nothing moves in this scene"));
  const Load ramp{.type = LoadType::force, .particles = {0}, .events = {{0, 0}, {2, 1}}, .direction = {0, 0, 1}};
  EXPECT_TRUE(refuses(beam_with([&](Scene& scene) { scene.fix("x0").gravity(Vec3(0, 0, -0.1)).add(ramp); }),
                      "changes until 2 s, so the rest shape says little; give PlanOptions::probe_time"));
}

// Orders, limits and errors from sequences whose limits are known.

/// u0 + C h^p at two points.
VecList field(double h, double order) {
  const double part = std::pow(h, order);
  return {Vec3(1.0, 0.5, -0.2) + part * Vec3(0.3, -0.1, 0.2), Vec3(0.2, 0.0, 0.1) + part * Vec3(-0.5, 0.4, 0.0)};
}

TEST(PlanConvergence, FindsOrderLimitAndErrorOfExactSequences) {
  for (const double order : {1.0, 1.5, 2.0, 2.5}) {
    for (const double ratio : {1.4142, 1.7, 2.0}) {
      const double h = 0.3;
      const VecList a = field(h, order), b = field(h / ratio, order), c = field(0.8 * h / ratio, order);
      const Convergence fit = fit_convergence({h, a}, {h / ratio, b}, {0.8 * h / ratio, c});
      EXPECT_NEAR(fit.order, order, 1e-6) << ratio;
      EXPECT_TRUE(fit.converges);
      const VecList limit = field(0.0, order);
      EXPECT_LT(mean_distance(fit.limit, limit), 1e-7);
      const VecList zero(2, Vec3::Zero());
      EXPECT_NEAR(fit.scale, mean_distance(limit, zero), 1e-7);
      const FieldAt finest{0.8 * h / ratio, c};
      EXPECT_NEAR(estimated_error(fit, {h, a}, finest), mean_distance(a, limit) / mean_distance(limit, zero), 1e-6);
      EXPECT_NEAR(estimated_error(fit, finest, finest), mean_distance(c, limit) / mean_distance(limit, zero), 1e-6);
    }
  }
}

TEST(Plan, GoesOnWithABackendThatTakesTheScene) {
  for (const double coarsest : {0.0, 0.025}) {
    PlanOptions options = wishes(0.5, 20);
    options.budget = 0.1;
    options.backends = {"reference", "cpu"};
    options.coarsest = coarsest;
    const Plan made = plan(
        [](const PlanCandidate& candidate) {
          if (candidate.backend == "reference") throw Error(ErrorCode::not_supported, "the scene has a tool");
          return sagging(candidate);
        },
        options);
    ASSERT_FALSE(made.trials.empty());
    EXPECT_EQ(made.trials.front().candidate.backend, "cpu");
    EXPECT_GT(made.trials.front().particles, 0);

    int built = 0;
    options.backends = {"reference", "reference"};
    const auto refuse = [&](const PlanCandidate&) -> Simulation {
      ++built;
      throw Error(ErrorCode::not_supported, "the scene has a tool");
    };
    EXPECT_TRUE(refuses([&] { plan(refuse, options); }, "the scene has a tool"));
    EXPECT_LT(built, 50);
  }
}

TEST(PlanConvergence, KeepsTheOrderInItsRange) {
  // Of order 4: a lower order leaves a larger error, which is the safe side.
  const VecList a = field(0.4, 4.0), b = field(0.2, 4.0), c = field(0.1, 4.0);
  const Convergence steep = fit_convergence({0.4, a}, {0.2, b}, {0.1, c});
  EXPECT_NEAR(steep.order, most_order, 1e-9);
  EXPECT_TRUE(steep.converges);
  // Differences that do not fall.
  const Convergence none =
      fit_convergence({0.4, VecList{{1.0, 0, 0}}}, {0.2, VecList{{1.1, 0, 0}}}, {0.1, VecList{{1.2, 0, 0}}});
  EXPECT_NEAR(none.order, least_order, 1e-9);
  EXPECT_FALSE(none.converges);
}

TEST(PlanConvergence, EqualFieldsHaveNoError) {
  const VecList a{{1.0, 2.0, 3.0}};
  const Convergence fit = fit_convergence({0.4, a}, {0.2, a}, {0.1, a});
  EXPECT_TRUE(fit.converges);
  EXPECT_EQ(estimated_error(fit, {0.4, a}, {0.1, a}), 0.0);
}

TEST(PlanConvergence, AFinestFieldThatTheFitDoesNotExplainRaisesTheError) {
  const VecList a = field(0.4, 2.0), b = field(0.2, 2.0), c = field(0.1, 2.0);
  const Convergence fit = fit_convergence({0.4, a}, {0.2, b}, {0.1, c});
  VecList other = c;
  for (Vec3& u : other) u *= 1.1;
  EXPECT_GT(estimated_error(fit, {0.4, a}, {0.1, other}), estimated_error(fit, {0.4, a}, {0.1, c}));
}

}  // namespace
}  // namespace phymul::test
