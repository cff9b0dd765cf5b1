// SPDX-License-Identifier: MIT
//
// The device of the backend "gl": every pass a fragment shader, every table a texture.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "fragment_passes.h"
#include "fragment_scene.h"
#include "gl/solver/device.h"
#include "gl/solver/state_copies.h"

namespace phymul::gl {

/// What a batch of steps has to tell, brought down to one texel on the device: one small read instead of the state.
class FragmentReport {
 public:
  FragmentReport(const ShaderLibrary& library, Index particles);

  /// Of the state a batch has reached, and of what its steps told of tools and kept volumes. Waits for the device.
  BatchReport read(const Texture& displacement, const Texture& velocity, const Texture& measured, FragmentScene& scene);
  std::span<const ToolSums> tool_sums() const { return tool_sums_; }

 private:
  const ShaderLibrary* library_;
  Pass first_, further_;
  std::optional<Pass> tools_added_;
  Reduction reduction_;
  ReportCopy copy_;
  std::vector<ToolSums> tool_sums_;
};

class FragmentDevice final : public Device {
 public:
  /// Compiles, uploads, and draws every pass of a step once: drivers compile at the first draw, not when they are told.
  FragmentDevice(const FloatTables& tables, const Scene& scene, const FloatTools& tools, bool on_host,
                 const ShaderLibrary& library);

  void set_scene(const Scene& scene, const FloatTools& tools, bool on_host) override;
  void set_held(const FloatTools& tools) override;
  void set_dissipation(std::span<const Float4> constants) override { strains_->set_constants(constants); }
  void write_strains(std::span<const Float4> rows) override;
  std::vector<Float4> read_strains() override;
  void write_joints(std::span<const Float4> rows) override { scene_->joints->state.write(rows, state_.current()); }
  std::vector<Float4> read_joints() override { return scene_->joints->state.read(state_.current()); }
  void write(const VecList& rest, const State& state) override { state_.write(rest, state); }
  void read(const VecList& rest, State& state) override { state_.read(rest, state); }
  void begin_batch(const StepConstants& constants, const std::vector<double>& instants,
                   const FloatTools& tools) override;
  void run(int count) override;
  BatchReport try_step(int number) override;
  BatchReport report() override { return report(state_.displacement(), state_.velocity()); }
  void open_step() override;
  void gather(std::span<const Index> rows) override;
  void read_gathered(std::span<OpenRow> rows) override { scene_->open->read(rows); }
  void close_step(std::span<const Push> pushes) override;
  void go_back() override { state_.go_back(); }
  std::span<const ToolSums> tool_sums() const override { return report_.tool_sums(); }
  void request_copy(const State& header) override { state_.request_copy(copies_, header); }
  bool collect_copy(const VecList& rest, State& state) override { return copies_.collect(rest, {}, state); }
  void drop_copies() override { copies_.clear(); }
  const Texture& displacements() override { return state_.displacement(); }

 private:
  BatchReport report(const Texture& displacement, const Texture& velocity);

  EmptyVertexArray vertices_;
  ShaderLibrary library_;
  FragmentTables tables_;
  FragmentState state_;
  std::unique_ptr<FragmentStrains> strains_;  // null unless the body dissipates
  std::unique_ptr<FragmentScene> scene_;
  FragmentPasses passes_;
  FragmentReport report_;
  StateCopies copies_;
};

}  // namespace phymul::gl
