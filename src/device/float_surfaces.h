// SPDX-License-Identifier: MIT
//
// FloatSurfaces: the points at which tools with ToolContact::surface touch bodies (contact_points.h), for backends that
// compute in float. Packed once from the scene.
#pragma once

#include <phymul/scene.h>

#include <utility>
#include <vector>

#include "float_tools.h"
#include "interaction/surface_press.h"
#include "table_rows.h"

namespace phymul {

struct FloatSurfaces {
  std::vector<Int4> corners;  ///< [patches] particles; -1
  /// [tools of ToolContact::surface][patches] first and end row of `points`; bits of the area that each of them stands
  /// for, m^2; 0.
  std::vector<Int4> laws;
  std::vector<Float4> points;  ///< shares of the patch's corners; 0
  std::vector<Int4> ranges;    ///< [particles] first and end row of `around`; 0, 0
  std::vector<Int4> around;    ///< per particle, ascending: patch, the corner of it that is the particle; 0, 0
  std::vector<int> law_of;     ///< [tools] first row of `laws`, -1: of a tool that touches particles

  bool empty() const { return laws.empty(); }
  int patches() const { return static_cast<int>(corners.size()); }
};

/// What of FloatSurfaces passes are told tool by tool.
class SurfaceTools {
 public:
  explicit SurfaceTools(std::vector<int> law_of) : law_of_(std::move(law_of)) {}

  int tools() const { return static_cast<int>(law_of_.size()); }
  bool is_one(int tool) const { return first_law(tool) >= 0; }
  int first_law(int tool) const { return law_of_[static_cast<std::size_t>(tool)]; }

  /// Takes over in which steps of a batch tools were put where they are.
  void set_frames(const FloatTools& tools) { placed_ = tools.placed(); }
  bool was_placed(int tool, int instant) const {
    return placed_[static_cast<std::size_t>(instant) * law_of_.size() + static_cast<std::size_t>(tool)] != 0;
  }

 private:
  std::vector<int> law_of_;
  std::vector<char> placed_;  // [instants][tools]
};

/// Empty where no tool of the scene has ToolContact::surface.
FloatSurfaces pack_surfaces(const Scene& scene);

}  // namespace phymul
