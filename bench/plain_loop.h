// SPDX-License-Identifier: MIT
//
// A step of the model as one would first write it: positions in float, one particle and one base after another, no
// vectors, no rearrangement. What the vector backend is measured against.
#pragma once

#include <phymul/model.h>
#include <phymul/state.h>
#include <phymul/topology_textures.h>

#include <array>
#include <vector>

namespace phymul::bench {

class PlainLoop {
 public:
  /// Whether it has all terms of the body: bases and springs, 3-D.
  static bool covers(const TopologyTextures& topology);

  PlainLoop(const TopologyTextures& topology, const State& start);
  void step(int steps, float dt);
  const std::vector<std::array<float, 3>>& position() const { return x_; }

 private:
  struct Base {
    std::array<int, 3> vertex{};
    std::array<float, 3> lambda{};
    float beta = 0, weight = 0;
  };
  struct Spring {
    std::array<int, 2> end{};
    float length = 0, stiffness = 0;
  };

  void add_attractor(int i);
  void add_conservative(int i);
  void add_springs();

  Reaction reaction_;
  std::vector<int> first_base_, first_neighbour_;  // [particles + 1]
  std::vector<Base> bases_;
  std::vector<int> neighbours_;
  std::vector<float> share_;  // of an attractor's force that a neighbour bears
  std::vector<Spring> springs_;
  std::vector<float> stiffness_, inverse_mass_;
  std::vector<std::array<float, 3>> x_, v_, force_;
};

}  // namespace phymul::bench
