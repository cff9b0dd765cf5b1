// SPDX-License-Identifier: MIT
#include "run_schedule.h"

#include <algorithm>
#include <cmath>

namespace {

using phymul::Load;
using phymul::LoadType;
using phymul::ValueEvent;

bool is_imposed(const Load& load) {
  return load.type == LoadType::translation || load.type == LoadType::rotation;
}

bool has_value(const Load& load) {
  return std::any_of(load.events.begin(), load.events.end(),
                     [](const ValueEvent& event) { return event.value != 0.0; });
}

void add_particles(std::vector<phymul::Index>& set, const Load& load) {
  set.insert(set.end(), load.particles.begin(), load.particles.end());
  std::sort(set.begin(), set.end());
  set.erase(std::unique(set.begin(), set.end()), set.end());
}

}  // namespace

bool is_driving(const Load& load) {
  const bool has_axis = load.type == LoadType::rotation ||
                        std::find(load.axes.begin(), load.axes.end(), phymul::Axis::driven) != load.axes.end();
  return is_imposed(load) && has_axis && has_value(load);
}

bool is_pushing(const Load& load) {
  return !is_imposed(load) && has_value(load);
}

RunSchedule schedule_of(const std::vector<Load>& loads) {
  RunSchedule schedule;
  double largest = 0.0;
  for (const Load& load : loads) {
    if (!is_driving(load)) {
      for (const ValueEvent& event : load.events) schedule.last_date = std::max(schedule.last_date, event.date);
      if (is_imposed(load)) add_particles(schedule.held, load);
      continue;
    }
    schedule.has_driven = true;
    add_particles(schedule.driven, load);
    for (const ValueEvent& event : load.events) {
      schedule.let_go = std::max(schedule.let_go, event.date);
      if (std::abs(event.value) > largest) {
        largest = std::abs(event.value);
        schedule.largest_pull = event.date;
      }
    }
  }
  return schedule;
}

void let_go(phymul::Scene& scene) {
  for (std::size_t row = scene.loads().size(); row-- > 0;) {
    if (is_driving(scene.loads()[row])) scene.remove(row);
  }
}
