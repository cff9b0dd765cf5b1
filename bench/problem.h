// SPDX-License-Identifier: MIT
//
// A reference case at one level and one resolution: body, loads, and the answer to be met.
#pragma once

#include <phymul/phymul.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "reference_case.h"

namespace phymul::bench {

struct Problem {
  struct Reaction {
    std::vector<Index> particles;
    std::array<std::optional<double>, 3> value;  ///< of the supports on the body, N; N m where it is a torque
    bool torque = false;                         ///< about the rest centroid of the particles
  };

  struct Push {
    std::string tool;
    std::array<std::optional<double>, 3> value;  ///< of the body on the tool, N
  };
  struct NamedTool {
    std::string name;
    Tool tool;
  };

  Model model;                        ///< material set; neighbours are cell edges
  std::vector<Load> loads;            ///< imposed motion and forces, in full from time 0 on
  Vec3 gravity{0, 0, 0};              ///< m/s^2
  std::vector<NamedTool> tools;       ///< where they have come to; the null model does not know them
  std::vector<std::uint8_t> imposed;  ///< [N] bit a set: coordinate a is imposed
  VecList displacement;               ///< [N] m: imposed coordinates as loads say, the others harmonic (see below)
  std::optional<Skin> samples;        ///< the sample points that are not prescribed; none: forces alone are known
  VecList sample_point;               ///< their rest places, m
  VecList reference;                  ///< their displacement, m
  int prescribed_samples = 0;         ///< left out
  std::vector<Reaction> reactions;
  std::vector<Push> pushes;
  double floor = 0.0, force_floor = 0.0;  ///< error of the reference itself

  void load(Scene& scene) const;              ///< adds gravity, loads and tools
  Scene scene(const Model& same_body) const;  ///< loads and tools on a model with the same particles
  bool has_forces() const;                    ///< gravity, forces or pressures: the answer depends on E
};

/// Throws Error. `displacement` is the null model: the prescribed displacement spread harmonically through the body (on
/// the graph of cell edges), which between two plates is the linear ramp. It is the start of a relaxation, too.
Problem make_problem(const ReferenceCase& it, const std::string& level, int n);

}  // namespace phymul::bench
