// SPDX-License-Identifier: MIT
//
// A backend as another program may have one: it overrides nothing that it need not, and so takes only what the base
// class takes for it. It stands still.
#pragma once

#include <phymul/backend.h>

#include <utility>

namespace phymul::test {

class StandingBackend : public SolverBackend {
 protected:
  using SolverBackend::SolverBackend;  // call reset() then
  void do_reset(const State& state) override { state_ = state; }
  void do_scene_changed() override {}
  Motion do_step(const StepPlan& plan) override {
    state_.time += plan.steps * plan.dt;
    Motion motion;
    motion.steps = plan.steps;
    return motion;
  }
  void do_read(State& state) const override { state = state_; }
  Energy do_energy() const override { return {}; }
  double do_time() const override { return state_.time; }
  std::string do_device() const override { return "nothing"; }

 private:
  State state_;
};

class OutsideBackend final : public StandingBackend {
 public:
  OutsideBackend(std::shared_ptr<const TopologyTextures> topology, const Scene& scene)
      : StandingBackend("outside", std::move(topology), scene, SolverOptions{}) {
    reset();
  }
};

}  // namespace phymul::test
