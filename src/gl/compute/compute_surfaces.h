// SPDX-License-Identifier: MIT
//
// The points at which tools touch surfaces among the rows of a scene's loads, and what the passes of surface_passes.h
// write of one tool at a time.
#pragma once

#include <vector>

#include "compute_tables.h"
#include "device/float_surfaces.h"
#include "device/float_tools.h"

namespace phymul::gl {

class ComputeSurfaces {
 public:
  ComputeSurfaces(FloatSurfaces surfaces, const ComputeTables& tables, StorageRows& rows);

  int patches() const { return patches_; }
  bool is_one(int tool) const { return law_of_[static_cast<std::size_t>(tool)] >= 0; }
  int first_law(int tool) const { return law_of_[static_cast<std::size_t>(tool)]; }

  /// Takes over in which steps of a batch tools were put where they are.
  void set_frames(const FloatTools& tools) { placed_ = tools.placed(); }
  bool was_placed(int tool, int instant) const {
    return placed_[static_cast<std::size_t>(instant) * law_of_.size() + static_cast<std::size_t>(tool)] != 0;
  }

 private:
  int patches_;
  std::vector<int> law_of_;
  std::vector<char> placed_;  // [instants][tools]
};

}  // namespace phymul::gl
