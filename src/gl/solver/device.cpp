// SPDX-License-Identifier: MIT
#include "device.h"

#include <phymul/error.h>

#include <limits>

namespace phymul::gl {

BatchReport::BatchReport(const Int4& events, const Float4& largest)
    : max_speed(largest[0]), max_acceleration(largest[1]), max_force(largest[2]), max_displacement(largest[3]) {
  constexpr std::int32_t never = std::numeric_limits<std::int32_t>::max();
  if (events[0] < 1) throw Error(ErrorCode::device, "the device gave no report of its steps");
  cut = events[0] == never - 1;
  if (events[0] < never - 1) {
    runaway_step = events[0];
    particle = events[1];
  }
  first_unquiet = events[2] == never ? 0 : events[2];
  last_unquiet = events[3];
}

void BatchReport::see_volumes(std::span<const Float4> roots) {
  for (std::size_t row = 0; row < roots.size(); ++row) {
    const int step = static_cast<int>(roots[row][1]);
    if (step == 0 || (lost_step > 0 && lost_step <= step)) continue;
    lost_step = step;
    lost_volume = static_cast<int>(row);
  }
}

}  // namespace phymul::gl
