// SPDX-License-Identifier: MIT
//
// Sums what clusters and neighbours give a particle, and moves it: integrate_displacement.h, a slice at a time.
#pragma once

#include "job.h"
#include "pack_rows.h"

namespace phymul::cpu::PHYMUL_ISA {

PHYMUL_INLINE Pack3 total_force(const simd::Move& move, int slice) {
  Pack3 force{};
  if (move.force != nullptr) force = gather_row(move.force + move.own[slice]);
  if (move.halo_first != nullptr) {
    for (int r = move.halo_first[slice]; r < move.halo_first[slice + 1]; ++r) {
      force += gather(move.force, move.halo + static_cast<std::int64_t>(r) * lanes);
    }
  }
  if (move.pull != nullptr) {
    force += gather_row(move.pull + static_cast<std::int64_t>(slice) * lanes * 16);
    for (int r = move.give_first[slice]; r < move.give_first[slice + 1]; ++r) {
      const float* row = move.give + static_cast<std::int64_t>(r) * 2 * lanes;
      std::int32_t offset[lanes];
      PHYMUL_COPY(offset, row, sizeof offset);
      force -= load(row + lanes) * gather(move.pull, offset);
    }
  }
  return force;
}

PHYMUL_INLINE bool any_of(Ints mask) {
  std::int32_t any = 0;
  for (int k = 0; k < lanes; ++k) any |= mask[k];
  return any != 0;
}

/// SolverOptions::max_displacement_per_step. Lanes are cut one by one: it is rare.
PHYMUL_INLINE bool cut_force(Pack3& force, Pack inverse_mass, const simd::Move& move, int slice) {
  const Pack3 a = inverse_mass * force;
  const Pack q = dot(a, a);
  const Ints over = (q > all(move.largest_acceleration_squared)) & (q <= all(3.4028234e38f));
  const bool cuts = any_of(over);
  if (!cuts && (move.was_cut == nullptr || move.was_cut[slice] == 0)) return false;
  Pack scale = all(1.0f);
  for (int k = 0; k < lanes; ++k) {
    if (over[k]) scale.v[k] = move.largest_acceleration / PHYMUL_ROOT(q[k]);
  }
  if (move.was_cut != nullptr) {
    store_row(move.withheld + 16 * static_cast<std::int64_t>(slice) * lanes, (all(1.0f) - scale) * force);
    move.was_cut[slice] = cuts ? 1 : 0;
  }
  force = scale * force;
  return cuts;
}

PHYMUL_INLINE float largest_of(Pack p) {
  float largest = 0.0f;
  for (int k = 0; k < lanes; ++k) largest = p[k] > largest ? p[k] : largest;
  return largest;
}

PHYMUL_INLINE void ask_for(const void* from, std::int64_t bytes) {
  const char* at = static_cast<const char*>(from);
  for (int k = 0; k < bytes; k += 64) PHYMUL_PREFETCH(at + k);
}

/// Asks for what a later slice reads and writes: a dozen arrays side by side, each of whose pages begins with a wait
/// for memory, because the processor's own foresight ends with a page.
PHYMUL_INLINE void ask_ahead(const simd::Move& move, int slice) {
  constexpr int ahead = 6;  // slices
  const std::int64_t at = static_cast<std::int64_t>(slice + ahead) * lanes;
  ask_for(move.u + 16 * at, 16 * lanes);
  ask_for(move.next_u + 16 * at, 16 * lanes);
  ask_for(move.v + 3 * at, 12 * lanes);
  ask_for(move.next_v + 3 * at, 12 * lanes);
  ask_for(move.mass + at, 4 * lanes);
  ask_for(move.inverse_mass + at, 4 * lanes);
  if (move.force != nullptr) ask_for(move.force + move.own[slice] + 16 * ahead * lanes, 16 * lanes);
  if (move.pull != nullptr) {
    ask_for(move.pull + 16 * at, 16 * lanes);
    const std::int32_t first = move.give_first[slice], rows = move.give_first[slice + 1] - first;
    ask_for(move.give + (static_cast<std::int64_t>(first) + ahead * rows) * 2 * lanes, rows * 8 * lanes);
    // Pulls of neighbours, which a curve through space puts far apart now and then.
    const int soon = slice + ahead / 2;
    if (soon >= move.slices) return;
    for (std::int32_t r = move.give_first[soon]; r < move.give_first[soon + 1]; ++r) {
      std::int32_t offset[lanes];
      PHYMUL_COPY(offset, move.give + static_cast<std::int64_t>(r) * 2 * lanes, sizeof offset);
      for (int k = 0; k < lanes; ++k) PHYMUL_PREFETCH(move.pull + offset[k]);
    }
  }
}

template <bool imposed>
PHYMUL_INLINE void move_slices_of(const simd::Move& move, int slice, int end, simd::MoveSummary& summary) {
  constexpr float largest_float = 3.4028234e38f;
  const Pack3 gravity{all(move.gravity[0]), all(move.gravity[1]), all(move.gravity[2])};
  const Pack dt = all(move.dt), damping = all(move.damping), runaway = all(move.runaway_squared);
  Pack acceleration{}, push{}, speed{}, motion{}, displacement{};
  Ints ran{};
  bool cut = false;
  for (; slice < end; ++slice) {
    const std::int64_t at = static_cast<std::int64_t>(slice) * lanes;
    if (move.far) ask_ahead(move, slice);
    Pack3 force = total_force(move, slice);
    cut |= cut_force(force, load(move.inverse_mass + at), move, slice);
    if (move.load != nullptr) force += gather_row(move.load + 16 * at);
    const Pack mass = load(move.mass + at);
    const Pack3 u = gather_row(move.u + 16 * at), v = load3(move.v + 3 * at);
    Pack3 a = load(move.inverse_mass + at) * force + gravity;
    Pack3 next_v = damping * v + dt * a;
    Pack3 next_u = u + dt * next_v;
    Pack3 free_v = next_v;
    if constexpr (imposed) {
      Ints fixed;
      PHYMUL_COPY(&fixed, move.fixed + at, sizeof fixed);
      const Ints x = (fixed & 1) != 0, y = (fixed & 2) != 0, z = (fixed & 4) != 0;
      const Pack3 target = gather_row(move.target + 16 * at), w = all(move.inverse_dt) * (target - u);
      a = {select(x, Pack{}, a.x), select(y, Pack{}, a.y), select(z, Pack{}, a.z)};
      free_v = {select(x, Pack{}, next_v.x), select(y, Pack{}, next_v.y), select(z, Pack{}, next_v.z)};
      next_v = {select(x, w.x, next_v.x), select(y, w.y, next_v.y), select(z, w.z, next_v.z)};
      next_u = {select(x, target.x, next_u.x), select(y, target.y, next_u.y), select(z, target.z, next_u.z)};
    }
    const Ints there = mass > 0.0f;
    const Pack a_squared = select(there, dot(a, a), Pack{});
    acceleration = larger(a_squared, acceleration);
    const Pack3 net = mass * a;
    push = larger(select(there, dot(net, net), Pack{}), push);
    speed = larger(select(there, dot(free_v, free_v), Pack{}), speed);
    const Pack reached = dot(next_u, next_u);
    displacement = larger(select(there, reached, Pack{}), displacement);
    const Pack gone = dot(next_v, next_v);
    motion = larger(select(there, gone, Pack{}), motion);
    ran |= there & ~((gone <= runaway) & (reached <= largest_float));
    // Slots that stand for nothing stay at 0, whatever gravity does.
    next_u = {select(there, next_u.x, Pack{}), select(there, next_u.y, Pack{}), select(there, next_u.z, Pack{})};
    store_row(move.next_u + 16 * at, next_u);
    store(move.next_v + 3 * at, next_v.x);
    store(move.next_v + 3 * at + lanes, next_v.y);
    store(move.next_v + 3 * at + 2 * lanes, next_v.z);
  }
  summary.acceleration = largest_of(acceleration);
  summary.force = largest_of(push);
  summary.speed = largest_of(speed);
  summary.motion = largest_of(motion);
  summary.displacement = largest_of(displacement);
  summary.runaway = any_of(ran);
  summary.cut = cut;
}

inline void move_slices(const simd::Move& move, int slice, int end, simd::MoveSummary& summary) {
  if (move.target != nullptr) {
    move_slices_of<true>(move, slice, end, summary);
  } else {
    move_slices_of<false>(move, slice, end, summary);
  }
}

}  // namespace phymul::cpu::PHYMUL_ISA
