// SPDX-License-Identifier: MIT
//
// A scene taken apart: vectors that stay, numbers that change with time. Load row r owns the numbers 2 r and 2 r + 1:
// its value (the sine of a rotation) and, of a rotation alone, 1 - cosine.
#include <phymul/load_frame.h>
#include <phymul/scene.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "scene_items.h"

namespace phymul {
namespace {

/// Parts per particle, then one after another.
void flatten(const std::vector<std::vector<LoadModes::Part>>& rows, std::vector<Index>& offset,
             std::vector<LoadModes::Part>& parts) {
  offset.reserve(rows.size() + 1);
  offset.assign(1, 0);
  for (const auto& row : rows) {
    parts.insert(parts.end(), row.begin(), row.end());
    offset.push_back(static_cast<Index>(parts.size()));
  }
}

/// Takes the coordinates of `axes` out of what earlier loads impose: the later one holds.
void release(std::vector<LoadModes::Part>& parts, std::uint8_t axes) {
  for (LoadModes::Part& part : parts) {
    for (int a = 0; a < 3; ++a) {
      if (axes >> a & 1) part.vector[a] = 0.0;
    }
  }
}

void add_part(std::vector<LoadModes::Part>& parts, Index mode, const Vec3& vector) {
  if (vector != Vec3::Zero()) parts.push_back({mode, vector});
}

}  // namespace

double value_at(std::span<const ValueEvent> events, double date) {
  const auto next = std::upper_bound(events.begin(), events.end(), date,
                                     [](double when, const ValueEvent& event) { return when < event.date; });
  if (next == events.begin()) return 0.0;
  const ValueEvent& last = *(next - 1);
  if (next == events.end()) return last.value;
  const double share = (date - last.date) / (next->date - last.date);
  return (1.0 - share) * last.value + share * next->value;
}

LoadModes Scene::modes() const {
  const std::size_t count = model_->rest.size();
  LoadModes modes;
  modes.count = 2 * static_cast<int>(loads_.size());
  modes.gravity = gravity_;
  LoadFrame frame;
  prepare(frame);
  modes.fixed = frame.fixed;
  std::vector<std::vector<LoadModes::Part>> target(frame.fixed.empty() ? 0 : count),
      force(frame.force.empty() ? 0 : count);
  for (std::size_t row = 0; row < loads_.size(); ++row) {
    const Action& action = actions_[row];
    const Index mode = 2 * static_cast<Index>(row);
    if (action.uniform) {
      add_part(modes.acceleration, mode, action.axis);
      continue;
    }
    for (std::size_t k = 0; k < action.particles.size(); ++k) {
      const Index i = action.particles[k];
      if (!imposes(loads_[row].type)) {
        add_part(force[i], mode, action.unit[k]);
        continue;
      }
      if (action.imposed == 0 || model_->mass[i] == 0.0) continue;  // every axis is free, or the particle is removed
      release(target[i], action.imposed);
      if (loads_[row].type == LoadType::rotation) {
        // R r - r = sin a x r + (1 - cos) a x (a x r)
        const Vec3 across = action.axis.cross(action.unit[k]);
        add_part(target[i], mode, across);
        add_part(target[i], mode + 1, action.axis.cross(across));
      } else {
        Vec3 unit = action.unit[k];
        for (int a = 0; a < 3; ++a) {
          if (!(action.imposed >> a & 1)) unit[a] = 0.0;
        }
        add_part(target[i], mode, unit);
      }
    }
  }
  for (auto& parts : target) {
    std::erase_if(parts, [](const LoadModes::Part& part) { return part.vector == Vec3::Zero(); });
  }
  if (!target.empty()) flatten(target, modes.target_offset, modes.target);
  if (!force.empty()) flatten(force, modes.force_offset, modes.force);
  return modes;
}

void Scene::mode_values(double time, std::span<double> values) const {
  assert(values.size() == 2 * loads_.size());
  for (std::size_t row = 0; row < loads_.size(); ++row) {
    const double value = value_at(loads_[row].events, time);
    const bool turns = loads_[row].type == LoadType::rotation;
    values[2 * row] = turns ? std::sin(value) : value;
    const double half = std::sin(0.5 * value);
    values[2 * row + 1] = turns ? 2.0 * half * half : 0.0;
  }
}

}  // namespace phymul
