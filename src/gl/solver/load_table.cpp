// SPDX-License-Identifier: MIT
#include "load_table.h"

#include <algorithm>

#include "device/float_domains.h"

namespace phymul::gl {

LoadTable::LoadTable(const Scene& scene, int instants, const std::vector<Index>& materials)
    : scene_(&scene), materials_(&materials), modes_(scene.modes()) {
  kind_ = {.forces = !modes_.force_offset.empty(),
           .fixed = !modes_.fixed.empty(),
           .scaled = !scene.stiffness_factors().empty() && !materials.empty(),
           .joints = !scene.joints().empty()};
  row_.resize(static_cast<std::size_t>(modes_.count));
  gravity_.resize(static_cast<std::size_t>(instants));
  if (kind_.any()) values_.resize(gravity_.size() * row_.size());
  if (kind_.scaled) factors_.resize(materials.size());
}

std::vector<Float4> LoadTable::parts() const {
  std::vector<Float4> parts;
  for (const auto* list : {&modes_.force, &modes_.target}) {
    for (const LoadModes::Part& part : *list) parts.push_back(float4(part.vector, static_cast<float>(part.mode)));
  }
  return parts;
}

std::vector<Int4> LoadTable::index() const {
  const auto targets = static_cast<Index>(modes_.force.size());
  std::vector<Int4> index(scene_->model().rest.size(), Int4{});
  for (std::size_t i = 0; i < index.size(); ++i) {
    if (kind_.forces) {
      index[i][0] = modes_.force_offset[i];
      index[i][1] = modes_.force_offset[i + 1];
    }
    if (kind_.fixed) {
      index[i][2] = targets + modes_.target_offset[i];
      index[i][3] = (modes_.target_offset[i + 1] - modes_.target_offset[i]) * 8 + modes_.fixed[i];
    }
  }
  return index;
}

void LoadTable::evaluate(const std::vector<double>& instants) {
  float* out = values_.data();
  for (std::size_t at = 0; at < instants.size(); ++at) {
    scene_->mode_values(instants[at], row_);
    Vec3 gravity = modes_.gravity;
    for (const LoadModes::Part& part : modes_.acceleration) gravity += row_[part.mode] * part.vector;
    gravity_[at] = float4(gravity);
    if (kind_.any())
      out = std::transform(row_.begin(), row_.end(), out, [](double v) { return static_cast<float>(v); });
  }
}

bool LoadTable::scale() {
  const std::vector<double>& now = scene_->stiffness_factors();
  if (!kind_.scaled || now == of_materials_) return false;
  of_materials_ = now;
  spread_factors(*materials_, now, factors_);
  return true;
}

}  // namespace phymul::gl
