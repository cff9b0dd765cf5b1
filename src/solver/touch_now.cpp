// SPDX-License-Identifier: MIT
#include "touch_now.h"

namespace phymul {
namespace {

class HostStep final : public PredictedStep {
 public:
  HostStep(const VecList& position, VecList& velocity, std::span<const double> mass, double dt)
      : position_(position), velocity_(velocity), mass_(mass), dt_(dt) {}
  Vec3 position(Index i) const override { return position_[i]; }
  Vec3 predicted_velocity(Index i) const override { return velocity_[i]; }
  Vec3 withheld(Index) const override { return Vec3::Zero(); }
  void find(const Region& region, std::vector<Index>& found) const override {
    for (Index i = 0; i < static_cast<Index>(position_.size()); ++i) {
      if (region.meets(position_[i], position_[i] + dt_ * velocity_[i])) found.push_back(i);
    }
  }
  void add_force(Index i, const Vec3& force) override { velocity_[i] += dt_ / mass_[i] * force; }
  void shift(Index, const Vec3&) override {}

 private:
  const VecList& position_;
  VecList& velocity_;
  std::span<const double> mass_;
  double dt_;
};

}  // namespace

TouchNow::TouchNow(const Scene& scene, const TopologyTextures& topology, const State& state, double dt)
    : scene_(scene),
      state_(state),
      dt_(dt),
      any_(!scene.tools().empty() || !scene.threads().empty() || scene.contacts() ||
           !scene.volume_constraints().empty()) {
  if (!any_) return;
  scene.prepare(loads_);
  scene.evaluate(state.time + dt, loads_);
  tools_.follow(scene);
  tools_.reset(scene, state);
  touching_.follow(scene, tools_.surface());
  touching_.reset(scene, state);
  touched_.prepare(topology.mass, loads_.fixed, topology.dimension == 2);
}

void TouchNow::act(VecList& velocity) {
  if (!any_) return;
  for (std::size_t i = 0; i < loads_.fixed.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      if (loads_.fixed[i] >> axis & 1) velocity[i][axis] = (loads_.target[i][axis] - state_.position[i][axis]) / dt_;
    }
  }
  HostStep step(state_.position, velocity, scene_.model().mass, dt_);
  touching_.forget();
  touched_.begin(step, dt_, dt_);
  tools_.act(touched_);
  touching_.act(touched_);
  touched_.end();
}

}  // namespace phymul
