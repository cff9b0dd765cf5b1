// SPDX-License-Identifier: MIT
//
// A backend of one's own with a force of one's own: steps in double precision, in water, whose drag grows with the
// square of the speed. CONTRIBUTING.md has the checklist for a backend that joins the library.
#include <phymul/backend.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <cstdio>

namespace {

using namespace phymul;

class InWater final : public SolverBackend {
 public:
  InWater(std::shared_ptr<const TopologyTextures> tables, const Scene& scene, const SolverOptions& options)
      : SolverBackend("in-water", std::move(tables), scene, options) {
    reset();
  }

 private:
  static constexpr double drag = 0.01;  // N s^2/m^2 per particle

  void do_reset(const State& state) override {
    state_ = state;
    do_scene_changed();
  }
  void do_scene_changed() override { steps_at_rest_ = 0; }

  Motion do_step(const StepPlan& plan) override {
    Motion motion;
    while (motion.steps < plan.steps) {
      const State before = state_;
      motion.max_speed = motion.max_acceleration = motion.max_force = 0.0;
      VecList force(state_.position.size());
      elastic_forces(topology(), state_.position, force);
      scene().evaluate(state_.time, frame());
      const VecList pushed = frame().force;
      state_.time += plan.dt;
      scene().evaluate(state_.time, frame());
      for (Index i = 0; i < topology().particle_count; ++i) move(i, force[i], pushed, plan, motion);
      if (motion.bad_particle >= 0) {
        state_ = before;
        break;
      }
      ++motion.steps;
      const bool quiet = motion.max_speed <= plan.speed_at_rest && motion.max_acceleration <= plan.acceleration_at_rest;
      steps_at_rest_ = quiet ? steps_at_rest_ + 1 : 0;
      if (plan.stop_at_rest && steps_at_rest_ >= plan.rest_steps) break;
    }
    motion.steps_at_rest = steps_at_rest_;
    return motion;
  }

  void move(Index i, Vec3 force, const VecList& pushed, const StepPlan& plan, Motion& motion) {
    Vec3 &x = state_.position[i], &v = state_.velocity[i];
    if (!pushed.empty()) force += pushed[i];
    force -= drag * v.norm() * v;
    Vec3 acceleration = force / topology().mass[i] + frame().gravity;
    Vec3 free = Vec3::Ones();  // 0: the coordinate is imposed
    for (int a = 0; a < 3; ++a) free[a] = frame().fixed.empty() || !(frame().fixed[i] >> a & 1) ? 1.0 : 0.0;
    acceleration = acceleration.cwiseProduct(free);
    const Vec3 from = x;
    x += plan.dt * (plan.damping_factor * v + plan.dt * acceleration);
    for (int a = 0; a < 3; ++a) {
      if (free[a] == 0.0) x[a] = frame().target[i][a];
    }
    v = (x - from) / plan.dt;
    if (!(v.norm() <= plan.runaway_speed)) motion.bad_particle = i;
    motion.max_speed = std::max(motion.max_speed, v.cwiseProduct(free).norm());
    motion.max_acceleration = std::max(motion.max_acceleration, acceleration.norm());
    motion.max_force = std::max(motion.max_force, topology().mass[i] * acceleration.norm());
  }

  void do_read(State& state) const override { state = state_; }
  double do_time() const override { return state_.time; }
  std::string do_device() const override { return "one processor core"; }
  Energy do_energy() const override {
    Energy energy;
    energy.elastic = elastic_energy(topology(), state_.position);
    energy.kinetic = kinetic_energy(model(), state_);
    for (std::size_t i = 0; i < state_.position.size(); ++i) {
      energy.gravity -= topology().mass[i] * scene().gravity().dot(state_.position[i] - topology().rest[i]);
    }
    return energy;
  }

  State state_;
  int steps_at_rest_ = 0;
};

std::unique_ptr<Solver> make_in_water(std::shared_ptr<const TopologyTextures> tables, const Scene& scene,
                                      const SolverOptions& options) {
  return std::make_unique<InWater>(std::move(tables), scene, options);
}

/// m: how far a beam that was let go still swings after a second.
double swing(const SimulationOptions& options) {
  Simulation sim(make_block({0.08, 0.02, 0.02}, 8, 2, 2), options);
  sim.scene().fix("x0").gravity({0, 0, -9.81});
  sim.run_to_rest();
  sim.scene().gravity({0, 0, 0});
  double farthest = 0.0;
  if (!sim.advance(1.0).ok()) return -1.0;
  for (int k = 0; k < 20 && sim.advance(0.01).ok(); ++k) farthest = std::max(farthest, sim.max_displacement());
  return farthest;
}

}  // namespace

int main() try {
  SimulationOptions options{.material = {.young = 100e3, .poisson = 0.3, .density = 1000}, .backend = "reference"};
  const double in_air = swing(options);
  options.make_solver = make_in_water;
  const double in_water = swing(options);
  std::printf("after a second it swings by %.2f mm in air, by %.2f mm in water\n", 1e3 * in_air, 1e3 * in_water);
  return in_water > 0.0 && in_water < 0.5 * in_air ? 0 : 1;
} catch (const Error& error) {
  std::puts(error.what());
  return 1;
}
