// SPDX-License-Identifier: MIT
//
// The device of the backend "gl-compute": every pass a compute shader, tables in storage buffers.
#pragma once

#include <memory>
#include <optional>

#include "compute_passes.h"
#include "compute_report.h"
#include "compute_sums.h"

namespace phymul::gl {

class ComputeDevice final : public Device {
 public:
  /// Compiles, uploads, and dispatches every pass of a step once, as drivers compile at first use.
  ComputeDevice(const SliceTables& slices, const Scene& scene, const FloatTools& tools, const ShaderLibrary& library,
                ComputeForm form, const ComputeLimits& limits = ComputeLimits::of_context());

  void set_scene(const Scene& scene, const FloatTools& tools) override;
  void set_held(const FloatTools& tools) override { loads_->set_held(tools); }
  void write_needles(const FloatTools& tools) override;
  void read_needles(FloatTools& tools) override;
  void write(const VecList& rest, const State& state) override { state_.write(rest, state); }
  void read(const VecList& rest, State& state) override { state_.read(rest, state); }
  void begin_batch(const StepConstants& constants, const std::vector<double>& instants,
                   const FloatTools& tools) override;
  void run(int count) override;
  BatchReport try_step(int number) override;
  void request_report() override;
  BatchReport take_report() override { return report_.take(); }
  std::span<const ToolSums> tool_sums() const override { return report_.tool_sums(); }
  Energy energy(const Scene& scene, double time, double dt) override;
  Momentum momentum(const VecList& rest, const Vec3& about) override;
  void request_copy(const State& header) override { state_.request_copy(copies_, header); }
  bool collect_copy(const VecList& rest, State& state) override {
    return copies_.collect(rest, state_.place_of(), state);
  }
  void drop_copies() override { copies_.clear(); }
  const Texture& displacements() override;
  const Texture& attractors() override;

  const ComputeState& state() const { return state_; }

 private:
  struct Shown {  // by particles of the model
    Kernel kernel;
    Texture texture;
  };
  void bind() const;
  const Texture& show(Shown& shown);

  ShaderLibrary library_;
  ComputeLimits limits_;
  ComputeTables tables_;
  ComputePasses passes_;
  ComputeState state_;
  std::unique_ptr<ComputeLoads> loads_;
  bool batch_was_run_ = false;  // since begin_batch()
  ComputeReport report_;
  ComputeSums sums_;
  StateCopies copies_;
  std::optional<Shown> displacements_, attractors_;
};

}  // namespace phymul::gl
