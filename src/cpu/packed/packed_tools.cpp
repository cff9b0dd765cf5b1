// SPDX-License-Identifier: MIT
#include "packed_tools.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/box_tree.h"
#include "base/denormals.h"
#include "packed_loads.h"

namespace phymul::cpu {
namespace {

/// Particles from which on looking for those near a tool takes longer than waking another thread for it, some 10 us.
constexpr std::size_t worth_threads = 32768;

/// Places in a block. They follow a curve through space, so that a block is small and a tool meets few.
constexpr std::size_t block_size = 32;

/// More than rounding in floats makes of a length and its square.
constexpr double of_floats = 1e-5;

/// m: no particle goes farther in a step whose last pass left this. What rounds in floats counts.
double longest_way(const simd::MoveSummary& moved, double dt) {
  return (1.0 + of_floats) * dt * std::sqrt(double{moved.motion}) + 0x1p-22 * std::sqrt(double{moved.displacement});
}

/// Of the coordinates: what rounds where places and regions are compared.
constexpr double rounding = 1e-12;

}  // namespace

/// A step whose prediction is in move.next_u and move.next_v.
class PackedTools::Step final : public PredictedStep {
 public:
  Step(PackedTools& tools, const simd::Move& move, ThreadPool& pool, double farthest, double going)
      : tools_(tools), move_(move), pool_(pool), farthest_(farthest), going_(going) {}

  Vec3 position(Index i) const override { return place_at(move_.u, tools_.place_of_[i]); }

  Vec3 predicted_velocity(Index i) const override {
    const float* v = move_.next_v;
    const auto at = [&](int axis) { return velocity_at(tools_.body_, tools_.place_of_[i], axis); };
    return {v[at(0)], v[at(1)], v[at(2)]};
  }

  void fetch(std::span<const Index> rows, VecList& at, VecList& velocity) const override {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      at[k] = Step::position(rows[k]);
      velocity[k] = Step::predicted_velocity(rows[k]);
    }
  }

  double gone() const override { return tools_.gone_; }
  double going() const override { return going_; }

  Vec3 withheld(Index i) const override {
    const float* row = &tools_.withheld_[4 * tools_.quad_of_particle(i)];
    return {row[0], row[1], row[2]};
  }

  void find(const Region& region, std::vector<Index>& found) const override {
    if (tools_.rest_.size() < worth_threads) {
      find_among(0, tools_.blocks_.size(), region, found);
      return;
    }
    pool_.run([&](int part, int parts) {
      const DenormalsAreZero guard;
      const auto bound = [&](int k) { return tools_.blocks_.size() * static_cast<std::size_t>(k) / parts; };
      tools_.found_[part].clear();
      find_among(bound(part), bound(part + 1), region, tools_.found_[part]);
    });
    for (int part = 0; part < pool_.parts(); ++part) {
      found.insert(found.end(), tools_.found_[part].begin(), tools_.found_[part].end());
    }
  }

  void add_force(Index i, const Vec3& force) override {
    const std::size_t quad = tools_.quad_of_particle(i);
    tools_.pushed_.push_back(quad);
    for (int a = 0; a < 3; ++a) tools_.load_[4 * quad + a] += static_cast<float>(force[a]);
  }

  void shift(Index i, const Vec3& by) override {
    tools_.shifts_.push_back({tools_.quad_of_particle(i),
                              {static_cast<float>(by.x()), static_cast<float>(by.y()), static_cast<float>(by.z())}});
  }

 private:
  void find_among(std::size_t first, std::size_t last, const Region& region, std::vector<Index>& found) const {
    for (std::size_t block = first; block < last; ++block) {
      if (misses(tools_.blocks_[block], region)) continue;
      const std::size_t end = std::min(tools_.rest_.size(), (block + 1) * block_size);
      for (std::size_t place = block * block_size; place < end; ++place) {
        if (misses(place, region) || !region.meets(place_at(move_.u, place), place_at(move_.next_u, place))) continue;
        found.push_back(tools_.body_.order[place]);
      }
    }
  }

  /// Wherever its particles went.
  bool misses(const Block& block, const Region& region) const {
    const bool apart = ((block.low.array() - farthest_) > region.high.array()).any() ||
                       ((block.high.array() + farthest_) < region.low.array()).any();
    if (apart || region.normal == Vec3::Zero()) return apart;
    const Vec3 nearest = (region.normal.array() > 0.0).select(block.low, block.high);
    return region.normal.dot(nearest) - farthest_ * region.normal.norm() > region.offset;
  }

  /// Axis by axis: most particles are far along the first one already, and this looks at all of them.
  bool misses(std::size_t place, const Region& region) const {
    const std::size_t quad = tools_.body_.quad_of(place);
    const float* u = reinterpret_cast<const float*>(move_.u) + 4 * quad;
    const float* next_u = reinterpret_cast<const float*>(move_.next_u) + 4 * quad;
    for (int a = 0; a < 3; ++a) {
      const double rest = tools_.rest_[place][a], from = rest + u[a], to = rest + next_u[a];
      if (std::min(from, to) > region.high[a] || std::max(from, to) < region.low[a]) return true;
    }
    return false;
  }

  Vec3 place_at(const char* displacements, std::size_t place) const {
    const float* u = reinterpret_cast<const float*>(displacements) + 4 * tools_.body_.quad_of(place);
    return tools_.rest_[place] + Vec3(u[0], u[1], u[2]);
  }

  PackedTools& tools_;
  const simd::Move& move_;
  ThreadPool& pool_;
  const double farthest_, going_;
};

PackedTools::PackedTools(const PackedBody& body, const TopologyTextures& topology, int parts)
    : body_(body), topology_(topology), found_(static_cast<std::size_t>(parts)) {}

void PackedTools::follow(const Scene& scene, std::span<const std::uint8_t> fixed) {
  set_.follow(scene);
  touching_.follow(scene, set_.surface());
  shifts_.clear();
  pushed_.clear();
  load_.clear();
  withheld_.clear();
  was_cut_.clear();
  farthest_ = std::numeric_limits<double>::infinity();
  if (empty()) return;
  const std::size_t count = body_.order.size();
  touched_.prepare(topology_.mass, fixed, topology_.dimension == 2);
  place_of_ = places_of(body_);
  rest_.resize(count);
  for (std::size_t place = 0; place < count; ++place) rest_[place] = topology_.rest[body_.order[place]];
  blocks_.assign((count + block_size - 1) / block_size, {});
  for (std::size_t block = 0; block < blocks_.size(); ++block) blocks_[block] = around(block);
  load_.assign(4 * static_cast<std::size_t>(body_.places), 0.0f);
  withheld_.assign(load_.size(), 0.0f);
  was_cut_.assign(static_cast<std::size_t>(body_.slices()), 0);
  pushed_.reserve(count);
  shifts_.reserve(count);
  for (auto& own : found_) own.reserve(count);
}

PackedTools::Block PackedTools::around(std::size_t block) const {
  const std::size_t first = block * block_size, count = std::min(rest_.size() - first, block_size);
  const Eigen::AlignedBox3d box = bounding_box(std::span(rest_).subspan(first, count));
  Block found{box.min(), box.max()};
  const double more = rounding * found.low.cwiseAbs().cwiseMax(found.high.cwiseAbs()).maxCoeff();
  found.low.array() -= more;
  found.high.array() += more;
  return found;
}

std::size_t PackedTools::quad_of_particle(Index i) const {
  return body_.quad_of(place_of_[i]);
}

void PackedTools::ask(simd::Move& move) {
  move.withheld = reinterpret_cast<char*>(withheld_.data());
  move.was_cut = was_cut_.data();
}

bool PackedTools::act(const simd::Move& move, ThreadPool& pool, double dt, double last_dt,
                      const simd::MoveSummary& moved, WorkLaps& laps) {
  if (move.load != nullptr) {
    std::memcpy(load_.data(), move.load, sizeof(float) * load_.size());
  } else {
    for (const std::size_t quad : pushed_) std::memset(&load_[4 * quad], 0, 4 * sizeof(float));
  }
  pushed_.clear();
  shifts_.clear();
  const double farthest = std::max(std::sqrt(double{moved.displacement}), farthest_);
  Step step(*this, move, pool, (1.0 + of_floats) * farthest, longest_way(moved, dt));
  touched_.begin(step, dt, last_dt);
  set_.act(touched_);
  if (!set_.empty()) laps.end(Work::tools);
  lost_volume_ = touching_.act(touched_);
  set_.feel(touched_);
  if (touches()) laps.end(Work::contacts);
  touched_.end();
  return !pushed_.empty();
}

void PackedTools::shift(float* next_u) {
  farthest_shift_ = 0.0;
  for (const auto& [quad, by] : shifts_) {
    for (int a = 0; a < 3; ++a) next_u[4 * quad + a] += by[a];
    farthest_shift_ = std::max(farthest_shift_, Vec3(by[0], by[1], by[2]).norm());
  }
}

void PackedTools::reset(const Scene& scene, const State& state) {
  set_.reset(scene, state);
  touching_.reset(scene, state);
  farthest_ = std::numeric_limits<double>::infinity();
}

void PackedTools::accept(const simd::MoveSummary& moved, double dt) {
  set_.accept();
  touching_.accept(dt);
  farthest_ = std::sqrt(double{moved.displacement}) + farthest_shift_;
  gone_ += longest_way(moved, dt) + farthest_shift_;
}

}  // namespace phymul::cpu
