// SPDX-License-Identifier: MIT
//
// Tools in the fast backend: the moving pass runs, and where it takes particles into a tool it runs once more with what
// the tool does among the loads. So the kernels know nothing of tools.
#pragma once

#include <array>

#include "thread_pool.h"
#include "tool_set.h"
#include "touching.h"
#include "vector_body.h"

namespace phymul::cpu {

class VectorTools {
 public:
  VectorTools(const VectorBody& body, const TopologyTextures& topology, int parts);

  void follow(const Scene& scene, std::span<const std::uint8_t> fixed);
  bool empty() const { return set_.empty() && touching_.empty(); }
  ToolSet& set() { return set_; }
  const ToolSet& set() const { return set_; }

  /// After a moving pass: what tools do about where it went. True where the pass is to be done again, with loads() in
  /// place of move.load.
  bool act(const simd::Move& move, ThreadPool& pool, double dt);
  int lost_volume() const { return lost_volume_; }  ///< by the last act(): a row; -1: none
  const char* loads() const { return reinterpret_cast<const char*>(load_.data()); }
  /// After the last pass of a step.
  void shift(float* next_u) const;

 private:
  class Step;
  std::size_t velocity_at(std::size_t place, int axis) const;
  std::size_t quad_of_particle(Index i) const;

  const VectorBody& body_;
  const TopologyTextures& topology_;
  ToolSet set_;
  Touching touching_;
  int lost_volume_ = -1;
  TouchedParticles touched_;
  // Empty without tools.
  std::vector<Index> place_of_;                                       // [particles]
  VecList rest_;                                                      // [particles] by place, m
  Floats load_;                                                       // [places][4] by quad, N
  std::vector<std::size_t> pushed_;                                   // quads of load_ that tools wrote to
  std::vector<std::pair<std::size_t, std::array<float, 3>>> shifts_;  // by quad, m
  mutable std::vector<std::vector<Index>> found_;                     // [parts]
};

}  // namespace phymul::cpu
