// SPDX-License-Identifier: MIT
//
// The passes of a step. Two by default, besides those for what only some bodies hold:
//   attractor  F_i of every particle                        reactions full, shared, barycentric, averaged
//   bases      forces of a base on a, b, c and its owner    averaged, conservative
//   volumes    forces of a volume on its vertices           bodies with a volume energy
//   walls      forces of a triangle on its patch            bodies with walls
//   domains    stress of a neighbourhood                    the particle-averaged law
//   strains    those that the next step starts from         materials that dissipate
//   joint      force of a spring                            scenes with joints
//   step       net force and Verlet
// With tools the last is two (reaction, Verlet), as what they feel is a pass between them. Where the host acts, the
// step opens with a pass of its own, free; rows that the host asks for are gathered, and the step's end adds what it
// pushes. Where the scene keeps volumes on the device, the end is drawn aside, and passes follow it: which way their
// particles go, sums over facets, how far, and the end of the step.
#pragma once

#include <deque>

#include "fragment_scene.h"
#include "fragment_state.h"
#include "gl/solver/device.h"

namespace phymul::gl {

class FragmentPasses {
 public:
  /// `strains`: null unless the body dissipates.
  FragmentPasses(const FragmentTables& tables, const FragmentStrains* strains, const ShaderLibrary& library);

  /// Compiles what this scene needs, where it is not there yet. Where it throws, steps go on with the one before.
  void set_scene(FragmentScene& scene);

  /// Before steps of a call.
  void set_constants(const StepConstants& constants);

  /// One step from the current state to state.next(), as number `batch_step` (1, 2, ...) of a batch whose loads were
  /// evaluated at instants batch_step - 1 and batch_step. Does not advance the state.
  void step(const FragmentState& state, int batch_step, bool measuring) {
    open(state, batch_step);
    close(state, batch_step, measuring);
  }
  // Its halves, between which the host may act; gather() too, where it does.
  void open(const FragmentState& state, int batch_step);
  void gather(const FragmentState& state);
  void close(const FragmentState& state, int batch_step, bool measuring);

 private:
  struct Drawing {
    Pass pass;
    Framebuffer target;
    int rows = 0;
  };
  struct StepKind {
    LoadKind loads;
    bool tools = false, grids = false, volumes = false, on_host = false;
    bool joints_on_tools = false;
    bool operator==(const StepKind&) const = default;
  };
  struct Stepping {
    StepKind kind;
    Pass step;
    Pass reaction, tools;                  // only with tools
    Pass along, facets, sums, roots, end;  // only where volumes are kept
    Pass free, gather;                     // where the host acts
    Pass domains;                          // where stiffness is scaled: in place of the last of before_
    Pass joints;                           // where there are some
  };
  void add(ShaderRequest request, const std::vector<Attachment>& targets, int rows);
  Pass term_pass(ShaderRequest request, const Texture& target, int rows) const;
  void add_attractors();
  void add_bases();
  void add_volumes();
  void add_walls();
  void add_domains();
  ShaderRequest domains_request() const;
  void draw_terms(const FragmentState& state, int batch_step);
  void bind_terms(Pass& pass) const;
  ShaderRequest gathering(const LoadKind& loads) const;
  Stepping compiled(const StepKind& kind) const;
  Pass compiled(const StepKind& kind, const ShaderFiles& passes) const;
  void compile_keeping(Stepping& stepping) const;
  void make_passes(const StepKind& kind);
  void bind_scene();
  void bind_volumes();
  void bind_joints();
  void bind_open();
  void pull(const FragmentState& state, int batch_step);
  void tell(const FragmentState& state, int batch_step);
  /// The pass that gathers the net force.
  Pass& gathering_pass() { return now_->kind.tools ? now_->reaction : now_->kind.on_host ? now_->free : now_->step; }
  void keep(const FragmentState& state, int batch_step, bool measuring);
  void prepare(Pass& pass, const FragmentState& state, int batch_step) const;

  const FragmentTables* tables_;
  const FragmentStrains* strains_;
  const ShaderLibrary* library_;
  Texture force_, net_, base_terms_, volume_terms_, wall_terms_, domain_terms_;
  std::vector<Drawing> before_;      // drawn in order before the step
  Pass strains_pass_;                // where the body dissipates
  double dt_ = 0.0, last_dt_ = 0.0;  // s; StepConstants
  Framebuffer net_target_;
  std::deque<Stepping> stepping_;  // whose addresses stay
  Stepping* now_ = nullptr;
  FragmentScene* scene_ = nullptr;
};

}  // namespace phymul::gl
