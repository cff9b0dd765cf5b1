// SPDX-License-Identifier: MIT
//
// The passes of a step, dispatched: forces of attractors, terms of bases, volumes, walls and domains in one dispatch
// (bases of the averaged reaction, which read forces, in a second), net force and Verlet in another. Where bodies touch
// or the host acts, another one before it finds where each particle would go by itself and by tools; then the host does
// its part, or come the passes of ContactPasses, and the last one ends what those began. Where the device keeps
// volumes, sums over their facets and the end of the step are two dispatches more behind it, or three.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "compute_loads.h"
#include "compute_state.h"
#include "gl/solver/device.h"

namespace phymul::gl {

/// The passes of a step in which bodies touch, between free_kernel.glsl and the motion: the grid, who meets whom, the
/// order in which contacts are pressed, their sweeps, and what they come to. Made where a scene has contacts.
class ContactPasses {
 public:
  /// Compiles.
  ContactPasses(const ShaderLibrary& library, const ComputeTables& tables, const ComputeLimits& limits);

  void set_contacts(const ComputeLoads& loads);
  void set_step(double dt);

  /// Of the state in a pair, once the free pass has written its rows of the loads.
  void act(int pair);

 private:
  void order(const ComputeContacts::Lists& lists, std::int64_t most);
  int press_dispatches() const;

  const ComputeTables* tables_;
  int group_, most_turns_;
  Kernel grid_, order_, search_, queue_, press_, part_;
  const ComputeLoads* loads_ = nullptr;
};

class ComputePasses {
 public:
  ComputePasses(const ComputeTables& tables, const ShaderLibrary& library, const ComputeLimits& limits)
      : tables_(&tables), library_(&library), limits_(limits) {}

  const ComputeTables& tables() const { return *tables_; }

  /// Compiles what these loads need, where it is not there yet.
  void set_loads(ComputeLoads& loads, const ComputeState& state);
  /// Before steps of a call.
  void set_constants(const StepConstants& constants);

  /// Step `number` of a batch from the current state to the free pair; `measuring`: what a report tells of the last
  /// one. Does not advance the state.
  void step(const ComputeState& state, int number, bool measuring) {
    open(state, number, measuring);
    close(state, number, measuring);
  }
  // Its halves, between which the host may act; gather() too, where it does.
  void open(const ComputeState& state, int number, bool measuring);
  void gather(const ComputeState& state);
  void close(const ComputeState& state, int number, bool measuring);

  /// A kernel over the body's tables, that knows where everything is.
  Kernel compiled(ShaderRequest request, int group, const ComputeState& state) const;

 private:
  struct StepKind {
    LoadKind loads;
    bool tools = false, grids = false, contacts = false, volumes = false, on_host = false;
    bool joints_on_tools = false;
    bool pushes() const { return contacts || on_host; }
    bool operator==(const StepKind&) const = default;
  };
  struct Stepping {
    StepKind kind;
    Kernel step;
    Kernel free;                 // where something pushes: the step before its impulses; `step` then does the rest
    Kernel gather;               // where the host acts
    Kernel keep_sums, keep_end;  // where volumes are kept, behind it
    Kernel joints;               // where there are some: their forces
    /// Of those that there are.
    template <class Function>
    void for_each(Function&& function) {
      for (Kernel* const kernel : {&step, &free, &gather, &keep_sums, &keep_end, &joints}) {
        if (*kernel) function(*kernel);
      }
    }
  };
  struct Terms {
    Kernel kernel;
    int groups = 0;
  };
  struct TermRows {
    bool attractors = false, bases = false, volumes = false, walls = false, domains = false;
    bool scaled = false;  ///< the stiffness of domains is
    bool any() const { return attractors || bases || volumes || walls || domains; }
  };
  std::vector<Terms> compiled_terms(bool scaled, const ComputeState& state) const;
  Terms terms_of(const TermRows& rows, const ComputeState& state) const;
  ShaderRequest gathering(const StepKind& step) const;
  ShaderRequest pushing(const StepKind& step) const;
  void add_tools(const StepKind& step, ShaderRequest& request) const;
  Stepping compiled(const StepKind& kind, const ComputeState& state) const;
  Kernel stepping(const StepKind& step, const ComputeState& state) const;
  Kernel freeing(const StepKind& step, const ComputeState& state) const;
  Kernel gathering_rows(const ComputeState& state) const;
  Kernel pulling(const StepKind& step, const ComputeState& state) const;
  Kernel keep_summing(const ComputeState& state) const;
  Kernel keep_ending(const StepKind& step, const ComputeState& state) const;
  void dispatch_terms(const ComputeState& state, int number);
  void run(Kernel& kernel, const ComputeState& state, int number, bool measuring) const;
  void pull(const ComputeState& state, int number) const;
  void keep(const ComputeState& state, int number) const;

  const ComputeTables* tables_;
  const ShaderLibrary* library_;
  ComputeLimits limits_;
  std::vector<Terms> terms_, scaled_terms_;  // dispatched in order before a step; the latter where stiffness is scaled
  std::vector<Terms>* terms_now_ = nullptr;
  double dt_ = 0.0, last_dt_ = 0.0;  // s; StepConstants
  std::deque<Stepping> stepping_;    // whose addresses stay
  Stepping* now_ = nullptr;
  ComputeLoads* loads_ = nullptr;          // that now_ is for
  std::optional<ContactPasses> contacts_;  // once there were some
};

}  // namespace phymul::gl
