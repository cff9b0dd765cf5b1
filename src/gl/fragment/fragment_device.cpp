// SPDX-License-Identifier: MIT
#include "fragment_device.h"

#include <optional>
#include <utility>

namespace phymul::gl {

FragmentDevice::FragmentDevice(const FloatTables& tables, const Scene& scene, const FloatTools& tools,
                               const ShaderLibrary& library)
    : library_(library),
      tables_(tables),
      state_(tables.particle_count),
      strains_(tables_.kind().dissipates() ? std::make_unique<FragmentStrains>(tables_.kind()) : nullptr),
      passes_(tables_, strains_.get(), library_),
      report_(library_, tables.particle_count) {
  set_scene(scene, tools);
  const VecList origin(static_cast<std::size_t>(tables.particle_count), Vec3::Zero());
  state_.write(origin, {.time = 0.0, .position = origin, .velocity = origin});
  begin_batch({.dt = 1.0}, {0.0, 1.0}, tools);
  try_step(1);
}

void FragmentDevice::set_scene(const Scene& scene, const FloatTools& tools) {
  std::optional<PlannedContacts> touching;  // first, as it may refuse
  if (scene.contacts()) touching.emplace(scene);
  auto new_loads = std::make_unique<FragmentLoads>(scene, most_steps + 1, tables_);
  auto new_tools = tools.empty() ? nullptr : std::make_unique<FragmentTools>(tools);
  const FloatSurfaces surfaces = pack_surfaces(scene);
  auto new_surfaces = surfaces.empty() ? nullptr : std::make_unique<FragmentSurfaces>(surfaces, tools);
  const FloatVolumes volumes = pack_volumes(scene);
  auto new_volumes = volumes.empty() ? nullptr : std::make_unique<FragmentVolumes>(volumes);
  auto new_contacts = touching && !touching->contacts.empty()
                          ? std::make_unique<FragmentContacts>(*touching, static_cast<Index>(scene.model().rest.size()))
                          : nullptr;
  FloatJoints joints(scene, tools.middle());
  auto new_joints = joints.empty() ? nullptr : std::make_unique<FragmentJoints>(std::move(joints));
  passes_.set_loads(*new_loads, new_tools.get(), new_surfaces.get(), new_volumes.get(), new_contacts.get(),
                    new_joints.get());
  loads_ = std::move(new_loads);
  tools_ = std::move(new_tools);
  surfaces_ = std::move(new_surfaces);
  volumes_ = std::move(new_volumes);
  contacts_ = std::move(new_contacts);
  joints_ = std::move(new_joints);
}

void FragmentDevice::set_held(const FloatTools& tools) {
  if (tools_) tools_->set_held(tools);
}

void FragmentDevice::write_strains(std::span<const Float4> rows) {
  strains_->kept.write(rows, state_.current());
  state_.set_strains_fresh(false);
}

std::vector<Float4> FragmentDevice::read_strains() {
  return state_.no_strains() ? std::vector<Float4>() : strains_->kept.read(state_.current());
}

void FragmentDevice::begin_batch(const StepConstants& constants, const std::vector<double>& instants,
                                 const FloatTools& tools) {
  loads_->evaluate(instants);
  if (tools_) tools_->set_frames(tools);
  if (surfaces_) surfaces_->set_frames(tools);
  if (joints_) joints_->follow();
  if (contacts_) contacts_->begin_batch();
  passes_.set_constants(constants);
  state_.set_checkpoint();
}

void FragmentDevice::give_more_passes() {
  if (contacts_) contacts_->give_more_phases();
}

void FragmentDevice::run(int count) {
  vertices_.bind();
  state_.go_back();
  for (int step = 1; step <= count; ++step) {
    passes_.step(state_, step, step == count);
    state_.advance();
  }
  steps_ = count;
}

BatchReport FragmentDevice::try_step(int number) {
  vertices_.bind();
  passes_.step(state_, number, true);
  return report(state_.next_displacement(), state_.next_velocity(), number);
}

BatchReport FragmentDevice::report(const Texture& displacement, const Texture& velocity, int last_step) {
  vertices_.bind();
  if (contacts_) passes_.sum_contacts(last_step);
  return report_.read(displacement, velocity, state_.measured(), tools_.get(), volumes_.get(), contacts_.get());
}

}  // namespace phymul::gl
