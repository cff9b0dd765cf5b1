// SPDX-License-Identifier: MIT
//
// Whether this is a build with sanitizers, which runs numerical tests some thirty times slower.
#pragma once

namespace phymul::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool sanitized = true;
#else
inline constexpr bool sanitized = false;
#endif

}  // namespace phymul::test
