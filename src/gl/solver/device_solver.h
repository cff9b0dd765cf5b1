// SPDX-License-Identifier: MIT
//
// The backends "gl" and "gl-compute": state and constants on the device, one small read a batch of steps. What searches
// or goes in order acts on the host, in open steps: needles, tools that touch surfaces, on "gl" contacts too, what
// tools hold that contacts or kept volumes push, and with any of these all tools, contacts and kept volumes.
//
// DeviceStep: an open step of a device, as tools, contacts and kept volumes on the host see it. Particles that are
// asked for are gathered from the device, those of the step before in advance: so a step usually takes one gather, and
// only of what is within reach. Which particles may be is told from where each was when it was last seen, and from how
// far any can have gone since.
#pragma once

#include <phymul/backend.h>

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "device.h"
#include "device/float_domains.h"
#include "device/float_tables.h"
#include "gl/context/context.h"
#include "interaction/predicted_step.h"
#include "interaction/tool_set.h"
#include "interaction/touching.h"
#include "solver/step_order.h"

namespace phymul::gl {

class DeviceStep final : public PredictedStep {
 public:
  explicit DeviceStep(const Model& model);  ///< which must outlive it

  void follow_body(const Model& model);  ///< its cells were cut, removed or brought back
  /// Places are not those of the last step's end: all are read when they are next asked for.
  void forget() { read_at_ = -1.0; }
  /// Before a step or several: places are known well enough to say what is out of reach, or read.
  void look(Device& device);
  /// Whether a particle may come into the region before gone() has grown by `more`, m. After look().
  bool any_in(const Region& region, double more) const;
  /// m: no point of a surface's triangle is farther from all its corners until then. After look().
  double wide(double more) const;
  /// Opens the step of a batch begun on the device. `largest_displacement`: m, of the state.
  void begin(Device& device, double dt, double largest_displacement);
  void close();                     ///< with what has been added
  void drop() { pushes_.clear(); }  ///< instead: the step is not done
  /// So many steps count. `longest_way`: m, no particle has gone farther in them.
  void accept(double longest_way, int steps = 1) { gone_ += longest_way + steps * rounding_; }

  Vec3 position(Index i) const override;
  Vec3 predicted_velocity(Index i) const override;
  Vec3 withheld(Index i) const override;
  void fetch(std::span<const Index> rows, VecList& position, VecList& velocity) const override;
  double gone() const override { return gone_; }
  double going() const override { return going_; }
  void find(const Region& region, std::vector<Index>& found) const override;
  void add_force(Index i, const Vec3& force) override;
  void shift(Index i, const Vec3& by) override;

 private:
  struct Seen {
    Vec3 position{0, 0, 0};                     // m
    Vec3 velocity{0, 0, 0}, withheld{0, 0, 0};  // m/s and N, in the step `step`
    double gone = 0.0;                          // m, gone_ when it was there
    std::uint64_t step = 0, used = 0;           // the last in which it was gathered, and asked for
  };
  bool is_known(Index i) const { return seen_[static_cast<std::size_t>(i)].step == step_; }
  const Seen& see(Index i) const;
  void gather() const;    // asked_
  void take() const;      // what gather() brought
  void ask_more() const;  // both, where there are some
  void use(Seen& seen, Index i) const;

  const VecList& rest_;
  std::vector<std::array<Index, 3>> triangles_;  // of the surface
  std::vector<Index> surface_;                   // their particles
  double spacing_;                               // m
  Device* device_ = nullptr;
  double read_at_ = -1.0;  // m, gone_ when all places were read; below 0: they are not known
  double dt_ = 0.0, gone_ = 0.0, going_ = 0.0, rounding_ = 0.0;  // s, m
  std::uint64_t step_ = 0;
  mutable std::vector<Seen> seen_;  // [particles]
  mutable std::vector<Index> asked_, used_;
  mutable std::vector<OpenRow> rows_;
  std::vector<Push> pushes_;
};

/// When the context is lost, so is the state. step() then says device_lost, with the time of the newest state the host
/// has: that of the last reset(), read() or collect(). The solver opens another context, rebuilds itself there from the
/// topology and goes on from that state at the next call; where it cannot, every step says device_lost until a reset()
/// finds a device.
class DeviceSolver final : public SolverBackend {
 public:
  DeviceSolver(GlBackend backend, std::shared_ptr<const TopologyTextures> shared, const Scene& scene_in,
               const SolverOptions& options_in);
  ~DeviceSolver() override;

  const std::shared_ptr<Context>& context() const { return context_; }  ///< another one after a loss
  GlContext context_kind() const { return gl_.context; }
  bool enumerated() const { return layout_ == FloatLayout::enumerated; }

 private:
  friend StepOrder;

  void do_reset(const State& state) override;
  void do_scene_changed() override { progress_.steps_at_rest = 0; }
  void do_body_changed(std::span<const Index> domains) override;
  Motion do_step(const StepPlan& plan) override;
  void do_read(State& state) const override;
  Energy do_energy() const override;
  double do_time() const override { return progress_.time; }
  bool do_pass_time(double seconds) override { return (progress_.time += seconds, true); }
  void do_snapshot(Snapshot& snapshot) const override;
  void do_restore(const Snapshot& snapshot) override;
  void do_request_read() override;
  bool do_collect(State& state) override;
  ParticleBuffer do_position_buffer() const override;
  std::string do_device() const override { return context_->info().device(); }
  void do_profile() const override;
  const char* do_cannot() const override { return beyond_devices(); }
  bool do_takes_tools() const override { return true; }
  const ToolReport& do_tool_report(std::size_t row) const override {
    return host_ ? host_->tools.report(scene().tools()[row]) : tools_.report(scene().tools()[row]);
  }
  const ThreadState& do_thread_state(std::size_t row) const override {
    return (host_ ? host_->tools : no_tools_).thread(scene().threads()[row]);
  }

  void build();
  void drop() noexcept;
  void rebuild();
  void recover() noexcept;
  template <class Function>
  auto on_device(Function&& function) const;
  bool acts_on_host() const;
  bool holds_what_is_pushed() const;
  void follow_on_host();
  void follow();
  void read_tools(State& state) const { host_ ? host_->tools.read(scene(), state) : tools_.read(scene(), state); }
  StrainMemory strains() const;
  void begin_joints();
  static Motion lost_motion();
  void begin_tools(const StepPlan& plan);
  Motion run_batches(const StepPlan& plan);
  bool run_batch(const StepPlan& plan, int count, Motion& motion);
  struct BatchEnd {
    BatchReport first;                  // of all its steps
    int good = 0, failed_at = 0;        // steps that count; the first that failed, 0: none
    bool rests = false, loses = false;  // the body after the good ones; a volume, in the failed one
  };
  BatchEnd end_batch(const StepPlan& plan, int count, Motion& motion);
  Motion run_on_host(const StepPlan& plan);
  void begin_tools_on_host(int steps, double dt);
  int steps_out_of_reach(const StepPlan& plan, int remaining);
  bool pass_on_host(const StepPlan& plan, int steps, Motion& motion);

  // Stages of StepOrder, of a step that the host acts in.
  static bool has_joints() { return false; }
  static bool has_substeps() { return false; }
  static bool has_implicit_joints() { return false; }
  static bool touches() { return true; }
  void begin(const StepPlan& plan);
  static void pull_joints(const StepPlan& /*plan*/) {}
  static void find_forces(const StepPlan& /*plan*/, bool /*last*/) {}
  static void add_substeps(const StepPlan& /*plan*/) {}
  static void limit(const StepPlan& /*plan*/) {}
  static void solve_joints(const StepPlan& /*plan*/) {}
  void predict(const StepPlan& plan);
  int touch(const StepPlan& plan);
  Index move(const StepPlan& plan, Motion& motion);
  const char* settle();
  void accept(const StepPlan& plan, Motion& motion);
  void drop_step();
  RestThresholds rest_now(const StepPlan& plan, const Motion& motion) const;
  int& steps_at_rest() { return progress_.steps_at_rest; }

  void take_over(const StepPlan& plan, int steps, const BatchReport& report, Motion& motion);
  StepConstants constants_of(const StepPlan& plan) const;
  int batch_size(const StepPlan& plan, int remaining) const;

  GlBackend backend_;
  GlOptions gl_;
  FloatLayout layout_;
  std::shared_ptr<Context> context_;
  std::unique_ptr<Device> device_;
  std::uint64_t loads_version_ = 0;
  mutable FloatTools tools_{Device::most_steps};
  struct OnHost {
    explicit OnHost(const Model& model) : step(model) {}
    ToolSet tools;
    Touching touching;
    TouchedParticles touched;
    DeviceStep step;
    double longest_way = 0.0;  // m, of the step in question
    BatchReport report;        // of it
  };
  ToolSet no_tools_;
  std::unique_ptr<OnHost> host_;  // null where nothing acts there
  std::optional<FloatDissipation> dissipation_;
  double dissipation_dt_ = 0.0;             // s, that the device has the constants of; 0: none
  bool joints_told_ = false;                // the device knows which springs are broken
  bool holds_pushed_ = false;               // holds_what_is_pushed(), when it was last given the scene
  std::vector<JointSet::Pull> joint_sums_;  // [tools] of the last batch; kept, so that no step allocates
  mutable State kept_;                      // the newest state the host has
  struct Progress {
    double time = 0.0, last_dt = 0.0;
    int steps_at_rest = 0;
    double largest_displacement = 0.0;  // m, when the present batch began
    double fastest = -1.0;  // m/s, that a particle may well be in the next step, where the host acts; -1: unknown
  } progress_;
  std::vector<double> instants_;  // of a batch
  double seconds_a_step_ = 0.0;   // wall clock; 0: not known yet
};

std::unique_ptr<Solver> make_device_solver(GlBackend backend, std::shared_ptr<const TopologyTextures> topology,
                                           const Scene& scene, const SolverOptions& options);

}  // namespace phymul::gl
