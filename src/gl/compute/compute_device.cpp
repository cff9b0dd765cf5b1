// SPDX-License-Identifier: MIT
#include "compute_device.h"

#include <utility>

#include "device/slice_tables.h"

namespace phymul::gl {

std::unique_ptr<Device> make_compute_device(FloatTables tables, const TopologyTextures& topology, const Scene& scene,
                                            const FloatTools& tools, bool on_host, const ShaderLibrary& library,
                                            std::vector<Index>& domains) {
  SliceTables slices = pack_slices(std::move(tables), topology);
  auto device = std::make_unique<ComputeDevice>(slices, scene, tools, on_host, library);
  domains = std::move(slices.rows.domains.source);
  return device;
}

ComputeDevice::ComputeDevice(const SliceTables& slices, const Scene& scene, const FloatTools& tools, bool on_host,
                             const ShaderLibrary& library, const ComputeLimits& limits)
    : library_(library),
      limits_(limits),
      tables_(slices, limits_),
      passes_(tables_, library_, limits_),
      state_(tables_, limits_),
      report_(library_, passes_, state_, limits_) {
  set_scene(scene, tools, on_host);
  begin_batch({.dt = 1.0}, {0.0, 1.0}, tools);
  try_step(1);
}

void ComputeDevice::bind() const {
  tables_.bind();
  state_.bind();
  loads_->bind();
}

void ComputeDevice::set_scene(const Scene& scene, const FloatTools& tools, bool on_host) {
  auto loads = std::make_unique<ComputeLoads>(scene, most_steps + 1, tools, on_host, tables_, limits_);
  passes_.set_loads(*loads, state_);
  loads_ = std::move(loads);
}

void ComputeDevice::begin_batch(const StepConstants& constants, const std::vector<double>& instants,
                                const FloatTools& tools) {
  loads_->evaluate(instants);
  loads_->set_frames(tools);
  passes_.set_constants(constants);
  if (loads_->open()) loads_->open()->set_pushes({}, loads_->rows());
  state_.set_checkpoint();
}

void ComputeDevice::run(int count) {
  bind();
  state_.go_back();
  for (int step = 1; step <= count; ++step) {
    passes_.step(state_, step, step == count);
    state_.advance();
  }
}

BatchReport ComputeDevice::try_step(int number) {
  bind();
  passes_.step(state_, number, true);
  return report_.read(state_, state_.free_pair(), *loads_);
}

BatchReport ComputeDevice::report() {
  bind();
  return report_.read(state_, state_.current(), *loads_);
}

void ComputeDevice::open_step() {
  bind();
  passes_.open(state_, 1, true);
}

void ComputeDevice::gather(std::span<const Index> rows) {
  bind();
  loads_->open()->set_gathered(rows, loads_->rows());
  passes_.gather(state_);
}

void ComputeDevice::close_step(std::span<const Push> pushes) {
  bind();
  loads_->open()->set_pushes(pushes, loads_->rows());
  passes_.close(state_, 1, true);
  state_.advance();
}

/// Rows in the model's order, sent from a buffer to a texture without the host.
const Texture& ComputeDevice::displacements() {
  if (!show_) {
    show_ = passes_.compiled(
        {.files = {"dialect/dialect_compute.glsl", "step/tables.glsl", "display/show_kernel.glsl"}, .defines = {}},
        lanes, state_);
    shown_ = Texture::target(tables_.kind().particles, "displacement");
  }
  bind();
  show_.set("pair", state_.current());
  show_.set("shown_place", state_.spare_row());
  show_.dispatch(show_.groups_for(tables_.kind().particles));
  glMemoryBarrier(GL_PIXEL_BUFFER_BARRIER_BIT);
  shown_.upload_from(state_.rows().id(), state_.spare_row());
  return shown_;
}

}  // namespace phymul::gl
