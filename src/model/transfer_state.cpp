// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/skin.h>
#include <phymul/transfer.h>

#include <string>

namespace phymul {

State transfer_state(const Model& from, const State& state, const Model& to, double most_outside) {
  const std::size_t count = from.rest.size();
  if (state.position.size() != count || state.velocity.size() != count) {
    throw Error("transfer_state: expected positions and velocities of " + std::to_string(count) + " particles, got " +
                std::to_string(state.position.size()) + " and " + std::to_string(state.velocity.size()));
  }
  const auto refuse = [](const std::string& what) {
    throw Error(ErrorCode::not_supported, "transfer_state: " + what + ", which names particles of the old body");
  };
  State result;
  result.time = state.time;
  result.tools = state.tools;
  for (ToolState& tool : result.tools) {
    if (!tool.held.empty()) refuse("the tool \"" + tool.name + "\" holds particles");
    if (!tool.needle.hole.empty()) refuse("the needle \"" + tool.name + "\" is in the body");
    tool.placed = true;
  }
  for (const JointState& joint : state.joints) {
    if (!joint.broken.empty()) refuse("the joint \"" + joint.name + "\" has broken springs");
  }
  const Skin skin(from, to.rest, most_outside);
  VecList displacement(count);
  for (std::size_t i = 0; i < count; ++i) displacement[i] = state.position[i] - from.rest[i];
  result.position = skin.deform(displacement);
  for (std::size_t i = 0; i < result.position.size(); ++i) result.position[i] += to.rest[i];
  result.velocity = skin.deform(state.velocity);
  return result;
}

}  // namespace phymul
