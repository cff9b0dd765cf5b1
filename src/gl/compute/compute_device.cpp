// SPDX-License-Identifier: MIT
#include "compute_device.h"

#include <utility>

namespace phymul::gl {
namespace {

constexpr int lanes = 64;

}  // namespace

ComputeDevice::ComputeDevice(const SliceTables& slices, const Scene& scene, const FloatTools& tools,
                             const ShaderLibrary& library, ComputeForm form, const ComputeLimits& limits)
    : library_(library),
      limits_(limits),
      tables_(slices, limits_),
      passes_(tables_, library_, form, limits_),
      state_(tables_, limits_),
      report_(library_, passes_, state_, limits_),
      sums_(passes_, limits_) {
  set_scene(scene, tools);
  begin_batch({.dt = 1.0}, {0.0, 1.0}, tools);
  try_step(1);
}

void ComputeDevice::bind() const {
  tables_.bind();
  state_.bind();
  loads_->bind();
}

void ComputeDevice::set_scene(const Scene& scene, const FloatTools& tools) {
  const FloatVolumes volumes = pack_volumes(scene);
  auto loads = std::make_unique<ComputeLoads>(scene, most_steps + 1, tables_, limits_, &tools, &volumes);
  passes_.set_loads(*loads, state_);
  loads_ = std::move(loads);
}

void ComputeDevice::begin_batch(const StepConstants& constants, const std::vector<double>& instants,
                                const FloatTools& tools) {
  loads_->evaluate(instants);
  loads_->set_frames(tools);
  passes_.set_constants(constants);
  state_.set_checkpoint();
  if (const ComputeNeedles* const needles = loads_->needles()) needles->set_checkpoint();
  batch_was_run_ = false;
}

void ComputeDevice::write_needles(const FloatTools& tools) {
  if (loads_->needles()) loads_->needles()->write(tools);
}

void ComputeDevice::read_needles(FloatTools& tools) {
  if (loads_->needles()) loads_->needles()->read(tools);
}

void ComputeDevice::run(int count) {
  bind();
  state_.go_back();
  if (ComputeNeedles* const needles = loads_->needles()) {
    needles->go_back();
    if (batch_was_run_) needles->uncouple();  // another hole may have been begun in what is taken back
  }
  batch_was_run_ = true;
  passes_.steps(state_, 1, count);
}

BatchReport ComputeDevice::try_step(int number) {
  bind();
  ComputeNeedles* const needles = loads_->needles();
  if (needles) needles->begin_trial();
  passes_.try_step(state_, number);
  report_.request(state_, state_.free_pair(), *loads_);
  if (needles) {
    needles->end_trial();
    needles->uncouple();
  }
  return report_.take();
}

void ComputeDevice::request_report() {
  bind();
  report_.request(state_, state_.current(), *loads_);
}

Energy ComputeDevice::energy(const Scene& scene, double time, double dt) {
  ComputeLoads loads(scene, 1, tables_, limits_);  // the scene may have changed since the last step
  loads.evaluate({time});
  bind();
  loads.bind();
  return sums_.energy(state_, loads, dt);
}

Momentum ComputeDevice::momentum(const VecList& rest, const Vec3& about) {
  bind();
  return sums_.momentum(state_, rest, about);
}

/// Rows in the model's order, sent from a buffer to a texture without the host.
const Texture& ComputeDevice::show(Shown& shown) {
  bind();
  shown.kernel.set("pair", state_.current());
  shown.kernel.set("shown_place", state_.spare_row());
  shown.kernel.dispatch(shown.kernel.groups_for(tables_.kind().particles));
  glMemoryBarrier(GL_PIXEL_BUFFER_BARRIER_BIT);
  shown.texture.upload_from(state_.rows().id(), state_.spare_row());
  return shown.texture;
}

const Texture& ComputeDevice::displacements() {
  if (!displacements_) {
    ShaderRequest request{.files = {"dialect/dialect_compute.glsl", "step/tables.glsl", "display/show_kernel.glsl"},
                          .defines = {}};
    tables_.define(request);
    displacements_ = Shown{passes_.placed(std::move(request), lanes, state_),
                           Texture::target(tables_.kind().particles, TexelFormat::rgba32f, "displacement")};
  }
  return show(*displacements_);
}

const Texture& ComputeDevice::attractors() {
  if (!attractors_) {
    ShaderRequest request = passes_.gathering({});
    request.files.insert(request.files.end(), {"display/shown_attractor_pass.glsl", "display/show_kernel.glsl"});
    request.defines.emplace_back("ATTRACTOR", 1);
    attractors_ = Shown{passes_.placed(std::move(request), lanes, state_),
                        Texture::target(tables_.kind().particles, TexelFormat::rgba32f, "attractors")};
  }
  bind();
  passes_.evaluate(state_);
  return show(*attractors_);
}

}  // namespace phymul::gl
