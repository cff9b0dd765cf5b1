// SPDX-License-Identifier: MIT
//
// The passes of a step, dispatched. By form:
//   store      forces of attractors, terms of bases, volumes and domains in one dispatch (bases of the averaged
//              reaction, which read forces, in a second); net force and Verlet in another
//   workgroup  as store, many steps in one dispatch by one group; where bodies touch or needles are, as store
// There another dispatch before the last one finds where each particle would go by itself, then come the passes of
// needle_passes.h, of other tools where there are needles, and of contact_passes.h, and the last one ends what those
// began. Where the scene keeps volumes, sums over their facets and the end of the step are two dispatches more behind
// it, or three; the workgroup waits for itself.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "compute_loads.h"
#include "compute_state.h"
#include "contact_passes.h"
#include "gl/solver/device.h"
#include "needle_passes.h"

namespace phymul::gl {

enum class ComputeForm { store, workgroup };

/// What `wish` means for a body; `software`: on a processor that plays GPU, where launches cost nothing.
ComputeForm choose_form(GlCompute wish, const SliceTables& slices, bool software);

class ComputePasses {
 public:
  ComputePasses(const ComputeTables& tables, const ShaderLibrary& library, ComputeForm form,
                const ComputeLimits& limits);

  const ComputeTables& tables() const { return *tables_; }
  ComputeForm form() const { return form_; }

  /// Compiles what these loads need, where it is not there yet.
  void set_loads(const ComputeLoads& loads, const ComputeState& state);
  /// Before steps of a call.
  void set_constants(const StepConstants& constants);

  /// Steps first ... first + count - 1 of a batch from the current state, each to the next free pair; the last one
  /// measures. Advances the state.
  void steps(ComputeState& state, int first, int count);
  /// Step `number` from the current state to the free pair; measures, and does not advance.
  void try_step(const ComputeState& state, int number);

  /// What other kernels read: forces and terms of the current state.
  void evaluate(const ComputeState& state);
  /// Files up to and with net_force.glsl, and what they need defined; `with_passes`: those before the step too.
  ShaderRequest gathering(const LoadKind& loads, bool with_passes = false) const;
  struct TermRows {
    bool attractors = false, bases = false, volumes = false, domains = false;
    bool any() const { return attractors || bases || volumes || domains; }
  };
  /// The kernels and passes of some rows alone.
  ShaderRequest evaluating(const TermRows& rows) const;
  /// A kernel that knows where everything is.
  Kernel placed(ShaderRequest request, int group, const ComputeState& state) const;

 private:
  struct StepKind {
    LoadKind loads;
    bool tools = false, grids = false, contacts = false, volumes = false;
    bool needles = false, presses = false;  // presses: there are other tools beside needles
    bool pushes() const { return contacts || needles; }
    bool operator==(const StepKind&) const = default;
  };
  struct Stepping {
    StepKind kind;
    Kernel kernel;
    Kernel free;             // where there are contacts or needles: up to what pushes, which `kernel` goes on from
    Kernel press;            // where there are needles and other tools: what these push
    KeepingKernels keeping;  // where volumes are kept, behind it; not of one group
  };
  struct Terms {
    Kernel kernel;
    int attractor_groups = 0, base_groups = 0, volume_groups = 0, domain_groups = 0;
    int groups() const { return attractor_groups + base_groups + volume_groups + domain_groups; }
  };
  void compile_terms(const ComputeState& state);
  TermRows all_terms() const;
  void add_terms(const TermRows& rows, const ComputeState& state);
  void add_tools(const StepKind& step, ShaderRequest& request) const;
  Kernel stepping(const StepKind& step, const ComputeState& state) const;
  Kernel freeing(const StepKind& step, const ComputeState& state) const;
  Kernel pressing(const StepKind& step, const ComputeState& state) const;
  KeepingKernels keeping(const StepKind& step, const ComputeState& state) const;
  bool by_one_group(bool pushes) const { return form_ == ComputeForm::workgroup && !pushes; }
  void act_on_free(const ComputeState& state, int number, bool measuring);
  void run(Kernel& kernel, const ComputeState& state, int number, bool measuring);
  void step(const ComputeState& state, int number, bool measuring);
  void dispatch_workgroup(const ComputeState& state, int number, int steps);
  std::int64_t turns_a_step(std::int64_t tools, const ComputeVolumes* volumes) const;
  int steps_a_dispatch() const;
  int workgroup() const;

  const ComputeTables* tables_;
  const ShaderLibrary* library_;
  ComputeForm form_;
  ComputeLimits limits_;
  std::vector<Terms> terms_;  // dispatched in order before a step
  bool terms_compiled_ = false;
  std::deque<Stepping> stepping_;  // whose addresses stay
  Stepping* now_ = nullptr;
  std::int64_t turns_ = 0;                   // of loops, of a step of now_ by one group
  const StorageBuffer* touching_ = nullptr;  // the loads that now_ is for, where they have contacts
  std::optional<ContactPasses> contacts_;    // once there were some
  std::optional<NeedlePasses> needles_;      // likewise
};

}  // namespace phymul::gl
