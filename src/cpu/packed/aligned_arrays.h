// SPDX-License-Identifier: MIT
//
// Aligned arrays, which kernels read in whole SIMD vectors and from end to end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace phymul::cpu {

/// Aligned to 64 bytes. Large ones lie on large pages where the system has them: with small ones a processor spends a
/// good part of a pass over them looking up pages. Throws std::bad_alloc.
void* allocate_aligned(std::size_t bytes);
void free_aligned(void* memory, std::size_t bytes) noexcept;

template <class T>
struct AlignedAllocator {
  using value_type = T;
  AlignedAllocator() = default;
  template <class U>
  explicit AlignedAllocator(const AlignedAllocator<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(allocate_aligned(n * sizeof(T))); }
  void deallocate(T* p, std::size_t n) { free_aligned(p, n * sizeof(T)); }
  bool operator==(const AlignedAllocator&) const = default;
};
using Floats = std::vector<float, AlignedAllocator<float>>;
using Offsets = std::vector<std::int32_t, AlignedAllocator<std::int32_t>>;

inline char* bytes(Floats& floats) {
  return reinterpret_cast<char*>(floats.data());
}

}  // namespace phymul::cpu
