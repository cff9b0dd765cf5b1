// SPDX-License-Identifier: MIT
//
// Device: what of a solver lives in its context, whatever the passes are: made, used and deleted inside Context::run.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "device/float_tables.h"
#include "device/float_tools.h"
#include "gl/objects/pass.h"
#include "gl/objects/program.h"
#include "gl/objects/texture.h"

namespace phymul::gl {

/// What all steps of a call have in common.
struct StepConstants {
  double dt = 0.0, damping_factor = 1.0;
  double last_dt = 0.0;        ///< s, of the step before the first; 0: there was none
  bool tools_at_once = false;  ///< tools are where they go in the first step, and joints feel no speed of theirs
  double largest_acceleration = 0.0, runaway_speed = 0.0, speed_at_rest = 0.0, acceleration_at_rest = 0.0;
};

/// What a batch of steps has to tell. Steps count from 1 within the batch; 0: never.
struct BatchReport {
  int runaway_step = 0;  ///< first in which a particle ran away
  Index particle = -1;   ///< the first of them by number
  bool cut = false;      ///< an elastic force was; false too where a particle ran away
  int first_unquiet = 0, last_unquiet = 0;
  int lost_step = 0;     ///< first in which a kept volume could not be restored
  int lost_volume = -1;  ///< the first of them by row
  /// Of the last step.
  double max_speed = 0.0, max_acceleration = 0.0, max_force = 0.0, max_displacement = 0.0;

  BatchReport() = default;
  /// From what report_events.glsl leaves of all rows. Throws Error where that is no report.
  BatchReport(const Int4& events, const Float4& largest);
  /// From what kept_root_pass.glsl leaves of every volume.
  void see_volumes(std::span<const Float4> roots);
};

/// Of a particle in an open step, as gather_pass.glsl has it.
struct OpenRow {
  Float4 displacement{};  ///< m, at the step's start
  Float4 velocity{};      ///< m/s: it would go to x + dt v
  Float4 withheld{};      ///< N
};

/// What the host adds to an open step, for host_pushes.glsl.
struct Push {
  Index particle = 0;
  Float4 force{};  ///< N, over this step
  Float4 shift{};  ///< m
};

class Device {
 public:
  /// Most steps between two reads of a report, so that their numbers fit what step_pass.glsl packs.
  static constexpr int most_steps = 256;

  Device() = default;
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  virtual ~Device() = default;

  /// From now on; timer() is null before.
  void time_passes(const ContextInfo& info, Profile& profile) { timer_ = std::make_unique<PassTimer>(info, profile); }
  PassTimer* timer() { return timer_.get(); }

  /// `tools` of the scene; they may be none. `on_host`: these, contacts and kept volumes act there, in open steps.
  virtual void set_scene(const Scene& scene, const FloatTools& tools, bool on_host) = 0;
  /// After a change of what they hold.
  virtual void set_held(const FloatTools& tools) = 0;
  // Of a body that dissipates, in rows of FloatDissipation. After write() each domain's strains are those of its state.
  virtual void set_dissipation(std::span<const Float4> constants) = 0;
  virtual void write_strains(std::span<const Float4> rows) = 0;
  /// Of the present state; empty: as after write(). Waits for the device.
  virtual std::vector<Float4> read_strains() = 0;
  // Of a scene with joints, in rows of FloatJoints, as the present state has them. After set_scene() and write() they
  // mean nothing.
  virtual void write_joints(std::span<const Float4> rows) = 0;
  virtual std::vector<Float4> read_joints() = 0;  ///< waits for the device
  virtual void write(const VecList& rest, const State& state) = 0;
  virtual void read(const VecList& rest, State& state) = 0;

  /// The loads at the instants of a batch: instants[s] is the old time of its step s + 1. The present state becomes the
  /// checkpoint. `tools` as far as they are ahead.
  virtual void begin_batch(const StepConstants& constants, const std::vector<double>& instants,
                           const FloatTools& tools) = 0;
  /// Steps 1 ... count of the batch from the checkpoint; the last one measures.
  virtual void run(int count) = 0;
  /// Step `number` from the present state, which stays as it is; only what it measures is kept.
  virtual BatchReport try_step(int number) = 0;
  /// Of the steps since begin_batch(), or since the last run() did. Waits for the device.
  virtual BatchReport report() = 0;

  // Of a scene that acts on the host, the one step of a batch in halves, in this order.
  virtual void open_step() = 0;  ///< up to where each particle would go by itself
  /// Starts to; may be called again after read_gathered(). Where no step is open only displacements mean something.
  virtual void gather(std::span<const Index> rows) = 0;
  virtual void read_gathered(std::span<OpenRow> rows) = 0;  ///< of the last gather(). Waits for the device
  /// No two of a particle. The step's end becomes the present state, which report() then tells of.
  virtual void close_step(std::span<const Push> pushes) = 0;
  virtual void go_back() = 0;  ///< the checkpoint becomes the present state
  /// What the steps of that report, of run(), did to each tool.
  virtual std::span<const ToolSums> tool_sums() const = 0;

  /// Starts a copy of the present state to the host; what `header` has besides places and velocities comes with it.
  virtual void request_copy(const State& header) = 0;
  /// True where the oldest copy has arrived, and is then in `state`.
  virtual bool collect_copy(const VecList& rest, State& state) = 0;
  virtual void drop_copies() = 0;

  /// Displacements of the particles in the model's order.
  virtual const Texture& displacements() = 0;

 private:
  std::unique_ptr<PassTimer> timer_;
};

/// The device of "gl-compute". `domains` gets the row of the topology's domain at each row of the device. Throws Error
/// also where this build has none.
std::unique_ptr<Device> make_compute_device(FloatTables tables, const TopologyTextures& topology, const Scene& scene,
                                            const FloatTools& tools, bool on_host, const ShaderLibrary& library,
                                            std::vector<Index>& domains);

}  // namespace phymul::gl
