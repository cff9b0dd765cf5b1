// SPDX-License-Identifier: MIT
//
// Tools in the fast backend: the moving pass runs, and where it takes particles into a tool it runs once more with what
// the tool does among the loads. So the kernels know nothing of tools.
#pragma once

#include <array>
#include <span>
#include <utility>
#include <vector>

#include "base/thread_pool.h"
#include "interaction/tool_set.h"
#include "interaction/touching.h"
#include "packed_body.h"
#include "simd_profile.h"

namespace phymul::cpu {

class PackedTools {
 public:
  PackedTools(const PackedBody& body, const TopologyTextures& topology, int parts);

  void follow(const Scene& scene, std::span<const std::uint8_t> fixed);
  bool empty() const { return set_.empty() && touching_.empty(); }
  bool touches() const { return !touching_.empty(); }
  ToolSet& set() { return set_; }
  void reset(const Scene& scene, const State& state);
  /// What settled() does and says.
  const char* settle(JointSet& joints, const StiffJoints* stiff) { return settled(joints, stiff, set_, touching_); }
  /// The step counts. `moved`: of its last pass.
  void accept(const simd::MoveSummary& moved, double dt);
  const ToolSet& set() const { return set_; }

  /// Before a moving pass, where not empty().
  void ask(simd::Move& move);
  /// After a moving pass: what tools do about where it went. True where the pass is to be done again, with loads() in
  /// place of move.load. `last_dt`: s, of the step before; 0: none. `moved`: of that pass.
  bool act(const simd::Move& move, ThreadPool& pool, double dt, double last_dt, const simd::MoveSummary& moved,
           WorkLaps& laps);
  /// Quads of the particles that the last act() pushed, and of those that shift() will move with the way of each, m.
  std::span<const std::size_t> pushed() const { return pushed_; }
  std::span<const std::pair<std::size_t, std::array<float, 3>>> shifts() const { return shifts_; }
  const FluidState& fluid(const Scene& scene, std::size_t row) const { return touching_.fluid(scene, row); }
  void read(const Scene& scene, State& state) const {
    set_.read(scene, state);
    touching_.read(scene, state);
  }
  double flow() const { return touching_.flow(); }  ///< m/s, KeptVolumes::flow()
  int lost_volume() const { return lost_volume_; }  ///< by the last act(): a row; -1: none
  char* loads() { return reinterpret_cast<char*>(load_.data()); }
  /// After the last pass of a step.
  void shift(float* next_u);

 private:
  class Step;
  /// Around the rest places of particles that follow each other.
  struct Block {
    Vec3 low{0, 0, 0}, high{0, 0, 0};  // m
  };
  Block around(std::size_t block) const;
  std::size_t quad_of_particle(Index i) const;

  const PackedBody& body_;
  const TopologyTextures& topology_;
  ToolSet set_;
  Touching touching_;
  int lost_volume_ = -1;
  double farthest_ = 0.0;        // m: no displacement at the step's start is larger; may be infinite
  double farthest_shift_ = 0.0;  // m, of shifts_
  double gone_ = 0.0;            // m, PredictedStep::gone()
  TouchedParticles touched_;
  // Empty without tools.
  std::vector<std::size_t> place_of_;                                 // [particles]
  VecList rest_;                                                      // [particles] by place, m
  std::vector<Block> blocks_;                                         // of rest_, block_size places each
  Floats load_;                                                       // [places][4] by quad, N
  Floats withheld_;                                                   // [places][4] by quad, N
  std::vector<std::uint8_t> was_cut_;                                 // [slices] of withheld_
  std::vector<std::size_t> pushed_;                                   // quads of load_ that tools wrote to
  std::vector<std::pair<std::size_t, std::array<float, 3>>> shifts_;  // by quad, m
  mutable std::vector<std::vector<Index>> found_;                     // [parts]
};

}  // namespace phymul::cpu
