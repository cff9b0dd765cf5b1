// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

namespace phymul {

/// Calls of the global operator new in this test program so far, by all threads.
std::size_t allocation_count();

}  // namespace phymul
