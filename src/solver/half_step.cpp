// SPDX-License-Identifier: MIT
#include "half_step.h"

#include <phymul/elasticity.h>
#include <phymul/load_frame.h>

#include <algorithm>
#include <utility>

#include "interaction/joint_set.h"

namespace phymul {
namespace {

/// Rounds in which the velocities that joints damp, or tools and contacts bound, are found: each leaves at most
/// dt c / m / (1 + d) or d / (1 + d) of the error.
constexpr int rounds = 60;

/// N, of elastic forces and loads; m/s^2 of gravity; coordinates that are imposed.
struct Acting {
  Acting(const TopologyTextures& topology, const Scene& scene, const State& state, const VecList& further)
      : force(state.position.size()) {
    scene.prepare(loads);
    scene.evaluate(state.time, loads);
    elastic_forces(topology, state.position, force);
    for (std::size_t i = 0; i < loads.force.size(); ++i) force[i] += loads.force[i];
    for (std::size_t i = 0; i < further.size(); ++i) force[i] += further[i];
  }
  VecList force;
  LoadFrame loads;
};

/// Calls change(particle, axis, acceleration) for every free coordinate. Dampers of joints act on state.velocity.
template <class Change>
void for_free_coordinates(const TopologyTextures& topology, const Scene& scene, const Acting& acting,
                          const State& state, Change change) {
  VecList force = acting.force;
  add_joint_forces(scene, state, force);
  const std::vector<std::uint8_t>& fixed = acting.loads.fixed;
  for (std::size_t i = 0; i < force.size(); ++i) {
    if (topology.mass[i] == 0.0) continue;  // removed
    const Vec3 acceleration = acting.loads.gravity + force[i] / topology.mass[i];
    for (int axis = 0; axis < topology.dimension; ++axis) {
      if (fixed.empty() || (fixed[i] >> axis & 1) == 0) change(i, axis, acceleration[axis]);
    }
  }
}

class HostStep final : public PredictedStep {
 public:
  HostStep(const VecList& position, VecList& velocity, std::span<const double> mass, double dt)
      : position_(position), velocity_(velocity), mass_(mass), dt_(dt) {
    for (const Vec3& v : velocity) going_ = std::max(going_, dt * v.norm());
  }
  Vec3 position(Index i) const override { return position_[i]; }
  Vec3 predicted_velocity(Index i) const override { return velocity_[i]; }
  Vec3 withheld(Index) const override { return Vec3::Zero(); }
  void find(const Region& region, std::vector<Index>& found) const override {
    for (Index i = 0; i < static_cast<Index>(position_.size()); ++i) {
      if (region.meets(position_[i], position_[i] + dt_ * velocity_[i])) found.push_back(i);
    }
  }
  double gone() const override { return 0.0; }  // all steps are from the same places
  double going() const override { return going_; }
  void add_force(Index i, const Vec3& force) override { velocity_[i] += dt_ / mass_[i] * force; }
  void shift(Index, const Vec3&) override {}

 private:
  const VecList& position_;
  VecList& velocity_;
  std::span<const double> mass_;
  double dt_, going_ = 0.0;  // s; m
};

}  // namespace

VecList free_accelerations(const TopologyTextures& topology, const Scene& scene, const State& state,
                           const VecList& further) {
  const Acting acting(topology, scene, state, further);
  VecList acceleration(state.position.size(), Vec3::Zero());
  for_free_coordinates(topology, scene, acting, state,
                       [&](std::size_t i, int axis, double a) { acceleration[i][axis] = a; });
  return acceleration;
}

void to_own_time(const TopologyTextures& topology, const Scene& scene, const HalfStep& step, State& state,
                 const VecList& further) {
  const Acting acting(topology, scene, state, further);
  TouchNow touch(scene, topology, state, step.dt);
  VecList next = state.velocity;
  for_free_coordinates(topology, scene, acting, state, [&](std::size_t i, int axis, double a) {
    next[i][axis] = step.d * next[i][axis] + step.dt * a;
  });
  touch.act(next);
  VecList velocity = state.velocity;
  for_free_coordinates(topology, scene, acting, state, [&](std::size_t i, int axis, double) {
    velocity[i][axis] = (velocity[i][axis] + next[i][axis]) / 2.0;
  });
  state.velocity = std::move(velocity);
}

void to_half_step_before(const TopologyTextures& topology, const Scene& scene, const HalfStep& step, State& state,
                         const VecList& further) {
  const Acting acting(topology, scene, state, further);
  TouchNow touch(scene, topology, state, step.dt);
  const bool damped =
      std::ranges::any_of(scene.joints(), [](const SceneJoint& joint) { return joint.joint.damping > 0.0; });
  const VecList own = state.velocity;
  VecList velocity = own, given(own.size(), Vec3::Zero());  // m/s, of tools and contacts
  for (int k = 0; k < (damped || !touch.empty() ? rounds : 1); ++k) {
    VecList next = own;
    const VecList before = velocity;
    for_free_coordinates(topology, scene, acting, state, [&](std::size_t i, int axis, double a) {
      velocity[i][axis] = (2.0 * own[i][axis] - step.dt * a - given[i][axis]) / (1.0 + step.d);
      next[i][axis] = step.d * velocity[i][axis] + step.dt * a;
    });
    state.velocity = velocity;
    if (k > 0 && velocity == before) return;  // as the next round would leave them
    if (touch.empty()) continue;
    given = next;
    touch.act(given);
    for (std::size_t i = 0; i < given.size(); ++i) given[i] -= next[i];
  }
}

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
