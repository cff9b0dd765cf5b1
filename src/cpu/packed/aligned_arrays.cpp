// SPDX-License-Identifier: MIT
#include "aligned_arrays.h"

#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace phymul::cpu {
namespace {

constexpr std::size_t line = 64, large_page = std::size_t{1} << 21;

std::align_val_t alignment_of(std::size_t bytes) {
  return std::align_val_t{bytes >= 2 * large_page ? large_page : line};
}

}  // namespace

void* allocate_aligned(std::size_t bytes) {
  void* memory = ::operator new(bytes, alignment_of(bytes));
#if defined(__linux__) && defined(MADV_HUGEPAGE)
  // A request; the system may refuse it, and nothing depends on it.
  if (bytes >= 2 * large_page) madvise(memory, bytes / large_page * large_page, MADV_HUGEPAGE);
#endif
  return memory;
}

void free_aligned(void* memory, std::size_t bytes) noexcept {
  ::operator delete(memory, alignment_of(bytes));
}

}  // namespace phymul::cpu
