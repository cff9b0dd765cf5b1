// SPDX-License-Identifier: MIT
#include "packed_loads.h"

#include "sleep_blocks.h"

namespace phymul::cpu {

PackedLoads::Sums::Sums(const std::vector<Index>& offset, const std::vector<LoadModes::Part>& parts,
                        const PackedBody& body)
    : parts_(parts), at_(4 * static_cast<std::size_t>(body.places), 0.0f) {
  for (std::size_t place = 0; place < body.order.size(); ++place) {
    const Index i = body.order[place];
    if (offset[i] < offset[i + 1]) rows_.push_back({body.quad_of(place), offset[i], offset[i + 1]});
  }
}

void PackedLoads::Sums::evaluate(const std::vector<double>& value, std::uint8_t* changed) {
  if (value == evaluated_) return;
  evaluated_ = value;  // of the same size but for the first time
  for (const Row& row : rows_) {
    Vec3 sum = Vec3::Zero();
    for (Index k = row.first; k < row.last; ++k) sum += value[parts_[k].mode] * parts_[k].vector;
    for (int a = 0; a < 3; ++a) {
      const auto now = static_cast<float>(sum[a]);
      if (changed != nullptr && now != at_[4 * row.quad + a]) changed[SleepBlocks::of_quad(row.quad)] = 1;
      at_[4 * row.quad + a] = now;
    }
  }
}

PackedLoads::PackedLoads(const Scene& scene, const PackedBody& body) {
  LoadModes modes = scene.modes();
  acceleration_ = std::move(modes.acceleration);
  steady_gravity_ = gravity_ = modes.gravity;
  value_.assign(static_cast<std::size_t>(modes.count), 0.0);
  if (!modes.force_offset.empty()) force_ = Sums(modes.force_offset, modes.force, body);
  if (modes.fixed.empty()) return;
  target_ = Sums(modes.target_offset, modes.target, body);
  fixed_.assign(static_cast<std::size_t>(body.places), 0);
  for (std::size_t place = 0; place < body.order.size(); ++place) fixed_[place] = modes.fixed[body.order[place]];
}

void PackedLoads::act_at(const Scene& scene, double time, std::uint8_t* changed) {
  if (acceleration_.empty() && force_.empty()) return;
  scene.mode_values(time, value_);
  gravity_ = steady_gravity_;
  for (const LoadModes::Part& part : acceleration_) gravity_ += value_[part.mode] * part.vector;
  if (!force_.empty()) force_.evaluate(value_, changed);
}

void PackedLoads::impose_at(const Scene& scene, double time, std::uint8_t* changed) {
  if (target_.empty()) return;
  scene.mode_values(time, value_);
  target_.evaluate(value_, changed);
}

void PackedLoads::point(simd::Move& move) const {
  move.load = force_.empty() ? nullptr : force_.data();
  move.target = target_.empty() ? nullptr : target_.data();
  move.fixed = target_.empty() ? nullptr : fixed_.data();
  for (int a = 0; a < 3; ++a) move.gravity[a] = static_cast<float>(gravity_[a]);
}

}  // namespace phymul::cpu
