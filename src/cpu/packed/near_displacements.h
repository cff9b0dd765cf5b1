// SPDX-License-Identifier: MIT
//
// A cluster's displacements side by side, as its kernels read them.
#pragma once

#include <cstdint>
#include <cstring>

#include "base/compiler.h"
#include "packed_body.h"

namespace phymul::cpu {

/// `u`: 16 bytes a particle; `near`: as many a slot. The last slot, which stands for nothing, is set to 0. Returns
/// `near`.
inline const char* near_displacements(const Cluster& cluster, const char* u, char* const near) {
  char* to = near;
  std::memcpy(to, u + 16 * static_cast<std::size_t>(cluster.first), 16 * static_cast<std::size_t>(cluster.own));
  to += 16 * static_cast<std::size_t>(cluster.own);
  for (const std::int32_t quad : cluster.halo) {
    std::memcpy(to, u + 16 * static_cast<std::size_t>(quad), 16);
    to += 16;
  }
  std::memset(to, 0, 16);
  return near;
}

inline constexpr std::size_t page = 4096;

/// The first place from `near` on that is half a page from `other`, whole pages aside. Processors take a load for one
/// of a recent store where the two agree in their last twelve bits: a slot's displacement must not stand there relative
/// to its force, or the kernels run at half their pace.
inline char* half_a_page_from(const char* other, char* near) {
  const auto distance = reinterpret_cast<std::uintptr_t>(other) + page / 2 - reinterpret_cast<std::uintptr_t>(near);
  return near + distance % page;
}

/// Asks for them ahead, into the second cache: a halo lies scattered in memory, where no processor foresees it.
inline void ask_for_displacements(const Cluster& cluster, const char* u) {
  const char* own = u + 16 * static_cast<std::size_t>(cluster.first);
  for (std::size_t k = 0; k < 16 * static_cast<std::size_t>(cluster.own); k += 64) PHYMUL_PREFETCH_LATER(own + k);
  for (const std::int32_t quad : cluster.halo) {
    PHYMUL_PREFETCH_LATER(u + 16 * static_cast<std::size_t>(quad));
  }
}

}  // namespace phymul::cpu
