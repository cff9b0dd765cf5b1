// SPDX-License-Identifier: MIT
//
// The global operator new of this test program (tests/solver/allocation_test.cpp): counted, and made to fail.
#pragma once

#include <cstddef>

namespace phymul {

/// Calls so far, by all threads.
std::size_t allocation_count();

/// Of those, what has not been deleted.
std::ptrdiff_t live_allocations();

/// While it lives, the k-th call from now on fails, k >= 1, and no other; by whatever thread.
class FailingAllocation {
 public:
  explicit FailingAllocation(std::size_t k);
  ~FailingAllocation();
  FailingAllocation(const FailingAllocation&) = delete;
  FailingAllocation& operator=(const FailingAllocation&) = delete;

  bool has_failed() const;

 private:
  std::size_t last_;
};

}  // namespace phymul
