// SPDX-License-Identifier: MIT
//
// Arrays that kernels read in whole vectors, and from end to end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace phymul::cpu {

/// Aligned to 64 bytes. Large ones lie on large pages where the system has them: with small ones a processor spends a
/// good part of a pass over them looking up pages. Throws std::bad_alloc.
void* allocate_vectors(std::size_t bytes);
void free_vectors(void* memory, std::size_t bytes) noexcept;

template <class T>
struct VectorAligned {
  using value_type = T;
  VectorAligned() = default;
  template <class U>
  explicit VectorAligned(const VectorAligned<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(allocate_vectors(n * sizeof(T))); }
  void deallocate(T* p, std::size_t n) { free_vectors(p, n * sizeof(T)); }
  bool operator==(const VectorAligned&) const = default;
};
using Floats = std::vector<float, VectorAligned<float>>;
using Offsets = std::vector<std::int32_t, VectorAligned<std::int32_t>>;

}  // namespace phymul::cpu
