// SPDX-License-Identifier: MIT
#include "device_solver.h"

#include <phymul/surface.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

namespace phymul::gl {
namespace {

/// More than rounding in floats makes of a length.
constexpr double of_floats = 1e-5;

/// Whether a place that may have moved by `room`, m, since it was seen may be in the region.
bool may_meet(const Region& region, const Vec3& place, double room) {
  for (int a = 0; a < 3; ++a) {
    if (place[a] - room > region.high[a] || place[a] + room < region.low[a]) return false;
  }
  return region.normal == Vec3::Zero() || region.normal.dot(place) - room * region.normal.norm() <= region.offset;
}

}  // namespace

DeviceStep::DeviceStep(const Model& model)
    : rest_(model.rest), spacing_(mean_spacing(model)), seen_(model.rest.size()) {
  follow_body(model);
  asked_.reserve(rest_.size());
  used_.reserve(rest_.size());
  rows_.reserve(rest_.size());
  pushes_.reserve(2 * rest_.size());
}

void DeviceStep::follow_body(const Model& model) {
  triangles_ = surface_triangles(model);
  surface_.clear();
  for (const auto& t : triangles_) surface_.insert(surface_.end(), t.begin(), t.end());
  std::ranges::sort(surface_);
  surface_.erase(std::ranges::unique(surface_).begin(), surface_.end());
}

/// Where no particle can have gone farther than a spacing, what is out of reach mostly shows.
void DeviceStep::look(Device& device) {
  if (read_at_ >= 0.0 && gone_ - read_at_ <= spacing_) return;
  device_ = &device;
  asked_.resize(seen_.size());
  std::iota(asked_.begin(), asked_.end(), Index{0});
  gather();
  take();
  read_at_ = gone_;
}

bool DeviceStep::any_in(const Region& region, double more) const {
  return std::ranges::any_of(
      seen_, [&](const Seen& seen) { return may_meet(region, seen.position, gone_ - seen.gone + more); });
}

double DeviceStep::wide(double more) const {
  double longest = 0.0;  // squared
  for (const auto& t : triangles_) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto &a = seen_[static_cast<std::size_t>(t[c])], &b = seen_[static_cast<std::size_t>(t[(c + 1) % 3])];
      longest = std::max(longest, (b.position - a.position).squaredNorm());
    }
  }
  return std::sqrt(longest) + 2.0 * (gone_ - read_at_ + more);
}

void DeviceStep::begin(Device& device, double dt, double largest_displacement) {
  look(device);
  device_ = &device;
  dt_ = dt;
  rounding_ = 0x1p-22 * largest_displacement;
  ++step_;
  asked_.swap(used_);
  used_.clear();
  device.open_step();
  gather();
  going_ = (1.0 + of_floats) * dt * device.report().max_speed + rounding_;
  take();
}

void DeviceStep::gather() const {
  device_->gather(asked_);
  rows_.resize(asked_.size());
}

void DeviceStep::take() const {
  device_->read_gathered(rows_);
  for (std::size_t k = 0; k < asked_.size(); ++k) {
    const auto i = static_cast<std::size_t>(asked_[k]);
    Seen& seen = seen_[i];
    seen.position = rest_[i] + widened(rows_[k].displacement);
    seen.velocity = widened(rows_[k].velocity);
    seen.withheld = widened(rows_[k].withheld);
    seen.gone = gone_;
    seen.step = step_;
  }
}

void DeviceStep::ask_more() const {
  if (asked_.empty()) return;
  gather();
  take();
}

void DeviceStep::use(Seen& seen, Index i) const {
  if (seen.used == step_) return;
  seen.used = step_;
  used_.push_back(i);
}

const DeviceStep::Seen& DeviceStep::see(Index i) const {
  Seen& seen = seen_[static_cast<std::size_t>(i)];
  if (!is_known(i)) {
    // Who looks at a part of the surface looks at the rest of it as well.
    asked_.clear();
    if (std::ranges::binary_search(surface_, i)) {
      std::ranges::copy_if(surface_, std::back_inserter(asked_), [this](Index k) { return !is_known(k); });
    } else {
      asked_.push_back(i);
    }
    ask_more();
  }
  use(seen, i);
  return seen;
}

Vec3 DeviceStep::position(Index i) const {
  return see(i).position;
}

Vec3 DeviceStep::predicted_velocity(Index i) const {
  return see(i).velocity;
}

Vec3 DeviceStep::withheld(Index i) const {
  return see(i).withheld;
}

void DeviceStep::fetch(std::span<const Index> rows, VecList& at, VecList& velocity) const {
  asked_.clear();
  std::ranges::copy_if(rows, std::back_inserter(asked_), [this](Index i) { return !is_known(i); });
  ask_more();
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const Seen& seen = see(rows[k]);
    at[k] = seen.position;
    velocity[k] = seen.velocity;
  }
}

void DeviceStep::find(const Region& region, std::vector<Index>& found) const {
  const std::size_t first = found.size();
  asked_.clear();
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    const Seen& seen = seen_[i];
    if (!may_meet(region, seen.position, gone_ - seen.gone + going_)) continue;
    found.push_back(static_cast<Index>(i));
    if (!is_known(static_cast<Index>(i))) asked_.push_back(static_cast<Index>(i));
  }
  ask_more();
  const auto misses = [&](Index i) {
    Seen& seen = seen_[static_cast<std::size_t>(i)];
    use(seen, i);
    return !region.meets(seen.position, seen.position + dt_ * seen.velocity);
  };
  found.erase(std::remove_if(found.begin() + static_cast<std::ptrdiff_t>(first), found.end(), misses), found.end());
}

void DeviceStep::add_force(Index i, const Vec3& force) {
  pushes_.push_back({.particle = i, .force = float4(force)});
}

/// After the particle's force, where it has one.
void DeviceStep::shift(Index i, const Vec3& by) {
  if (pushes_.empty() || pushes_.back().particle != i) pushes_.push_back({.particle = i});
  pushes_.back().shift = float4(by);
}

void DeviceStep::close() {
  std::ranges::sort(pushes_, {}, &Push::particle);
  device_->close_step(pushes_);
  pushes_.clear();
}

}  // namespace phymul::gl
