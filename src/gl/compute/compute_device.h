// SPDX-License-Identifier: MIT
//
// The device of the backend "gl-compute": every pass a compute shader, tables in storage buffers.
#pragma once

#include <memory>

#include "compute_passes.h"
#include "gl/solver/state_copies.h"

namespace phymul::gl {

/// What a batch of steps has to tell, brought down to two rows, to four for each tool and one for each kept volume: one
/// small read instead of the state.
class ComputeReport {
 public:
  ComputeReport(const ShaderLibrary& library, const ComputePasses& passes, const ComputeState& state,
                const ComputeLimits& limits);

  /// Of the state in a pair, which the last step wrote and measured, and of what steps told of the tools and volumes
  /// among `loads`. Waits for the device.
  BatchReport read(const ComputeState& state, int pair, const ComputeLoads& loads);
  std::span<const ToolSums> tool_sums() const { return tool_sums_; }

 private:
  void sum_tools(const ComputeTools& tools);

  const ShaderLibrary* library_;
  const ComputePasses* passes_;
  ComputeLimits limits_;
  Kernel kernel_, tool_kernel_;
  Index particles_;
  int groups_;
  ReportCopy copy_;
  std::vector<ToolSums> tool_sums_;
};

class ComputeDevice final : public Device {
 public:
  /// Compiles, uploads, and dispatches every pass of a step once, as drivers compile at first use.
  ComputeDevice(const SliceTables& slices, const Scene& scene, const FloatTools& tools, bool on_host,
                const ShaderLibrary& library, const ComputeLimits& limits = ComputeLimits::of_context());

  void set_scene(const Scene& scene, const FloatTools& tools, bool on_host) override;
  void set_held(const FloatTools& tools) override { loads_->set_held(tools); }
  void set_dissipation(std::span<const Float4> constants) override { state_.set_dissipation(constants); }
  void write_strains(std::span<const Float4> rows) override { state_.write_strains(rows); }
  std::vector<Float4> read_strains() override { return state_.read_strains(); }
  void write_joints(std::span<const Float4> rows) override { loads_->write_joints(rows, state_.current()); }
  std::vector<Float4> read_joints() override { return loads_->read_joints(state_.current()); }
  void write(const VecList& rest, const State& state) override { state_.write(rest, state); }
  void read(const VecList& rest, State& state) override { state_.read(rest, state); }
  void begin_batch(const StepConstants& constants, const std::vector<double>& instants,
                   const FloatTools& tools) override;
  void run(int count) override;
  BatchReport try_step(int number) override;
  BatchReport report() override;
  void open_step() override;
  void gather(std::span<const Index> rows) override;
  void read_gathered(std::span<OpenRow> rows) override { loads_->open()->read(rows, loads_->rows()); }
  void close_step(std::span<const Push> pushes) override;
  void go_back() override { state_.go_back(); }
  std::span<const ToolSums> tool_sums() const override { return report_.tool_sums(); }
  void request_copy(const State& header) override { state_.request_copy(copies_, header); }
  bool collect_copy(const VecList& rest, State& state) override {
    return copies_.collect(rest, state_.place_of(), state);
  }
  void drop_copies() override { copies_.clear(); }
  const Texture& displacements() override;

  const ComputeState& state() const { return state_; }

 private:
  void bind() const;

  ShaderLibrary library_;
  ComputeLimits limits_;
  ComputeTables tables_;
  ComputePasses passes_;
  ComputeState state_;
  std::unique_ptr<ComputeLoads> loads_;
  ComputeReport report_;
  StateCopies copies_;
  Kernel show_;
  Texture shown_;
};

}  // namespace phymul::gl
