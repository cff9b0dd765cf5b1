// SPDX-License-Identifier: MIT
//
// Which cells of a body set its largest stable step, and what the step would be without them.
#pragma once

#include <phymul/model.h>
#include <phymul/topology_textures.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace phymul {

/// A place of the body that sets the step: where its fastest vibration is.
struct LimitingPlace {
  Index cell = -1;               ///< row of Model::cells that moves most in the vibration; -1: a body without cells
  std::vector<Index> particles;  ///< of the cell, or the one that moves most
  Vec3 place{0, 0, 0};           ///< m, their mean at rest
  double share = 0.0;            ///< of the vibration's kinetic energy that is in these particles
  double stable_step = 0.0;      ///< s, while they move; the places before this one do not
};

struct StepLimit {
  double stable_step = 0.0;           ///< s, of the whole body, without SolverOptions::damping
  std::vector<LimitingPlace> places;  ///< the first sets the step; empty if the vibration is spread over the body
  double without = 0.0;               ///< s, if the particles of all these places were held
  std::string message() const;        ///< a sentence or two for people
};

/// Looks for the fastest vibration (Lanczos iteration, two passes), names the cell where it is, holds that cell's
/// particles and looks again, at most `most_places` times. It ends before where no single place stands out: where the
/// vibration moves more than an eighth of the particles. Each place costs about two estimate_spectrum(). `fixed` [N] as
/// LoadFrame::fixed, or empty. Throws Error for other sizes, and for the reactions full, shared and barycentric, whose
/// stiffness is not symmetric.
StepLimit describe_limit(const Model& model, const TopologyTextures& topology, int most_places = 8,
                         std::span<const std::uint8_t> fixed = {});

}  // namespace phymul
