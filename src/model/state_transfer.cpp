// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/state.h>
#include <phymul/state_transfer.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace phymul {

StateTransfer::StateTransfer(const Model& from, const Model& to, double most_outside)
    : skin_(from, to, most_outside), from_(from.rest), to_(to.rest) {}

State StateTransfer::operator()(const State& state) const {
  const std::size_t count = from_.size();
  if (state.position.size() != count || state.velocity.size() != count) {
    throw Error("StateTransfer: expected positions and velocities of " + std::to_string(count) + " particles, got " +
                std::to_string(state.position.size()) + " and " + std::to_string(state.velocity.size()));
  }
  const auto refuse = [](const std::string& what) {
    throw Error(ErrorCode::not_supported, "StateTransfer: " + what + ", which names particles of the old body");
  };
  State result;
  result.time = state.time;
  result.tools = state.tools;
  for (ToolState& tool : result.tools) {
    if (!tool.held.empty()) refuse("the tool \"" + tool.name + "\" holds particles");
    if (!tool.needle.hole.empty()) refuse("the needle \"" + tool.name + "\" is in the body");
    if (!tool.blade.empty()) refuse("the blade \"" + tool.name + "\" is in the body");
    tool.placed = true;
  }
  for (const ThreadState& thread : state.threads) {
    if (!thread.sewn.empty()) refuse("a needle has sewn the thread \"" + thread.name + '"');
  }
  result.threads = state.threads;
  result.fluids = state.fluids;
  for (const JointState& joint : state.joints) {
    if (!joint.broken.empty()) refuse("the joint \"" + joint.name + "\" has broken springs");
  }
  VecList displacement(count);
  for (std::size_t i = 0; i < count; ++i) displacement[i] = state.position[i] - from_[i];
  result.position = skin_.deform(displacement);
  for (std::size_t i = 0; i < result.position.size(); ++i) result.position[i] += to_[i];
  result.velocity = skin_.deform(state.velocity);
  return result;
}

State rest_state(const Model& model) {
  return {0.0, model.rest, VecList(model.rest.size(), Vec3::Zero())};
}

bool is_finite(const State& state) {
  const auto finite = [](const Vec3& v) { return v.allFinite(); };
  return std::isfinite(state.time) && std::all_of(state.position.begin(), state.position.end(), finite) &&
         std::all_of(state.velocity.begin(), state.velocity.end(), finite);
}

}  // namespace phymul
