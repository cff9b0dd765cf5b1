// SPDX-License-Identifier: MIT
//
// What the language has no word for and GCC and Clang have: the only file of the library that uses such words
// (tests/checks/house_rules.cmake). Macros, and functions that are always inlined, because kernels compiled for one
// instruction set must leave the linker no function that another file might get.
#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#define PHYMUL_INLINE [[gnu::always_inline]] inline
#define PHYMUL_APART [[gnu::noinline]]
#define PHYMUL_INLINED __attribute__((always_inline))  // after the parameters of a lambda
#define PHYMUL_EXPORT __attribute__((visibility("default")))
#define PHYMUL_LIKE_PRINTF(row, first) [[gnu::format(printf, row, first)]]  // rows of parameters, from 1

#define PHYMUL_PRAGMA(text) _Pragma(#text)
#define PHYMUL_UNROLL(times) PHYMUL_PRAGMA(GCC unroll times)  // before a loop

/// A vector of numbers, with the operators of its numbers, element by element.
#define PHYMUL_VECTOR(number, bytes) number __attribute__((vector_size(bytes)))
#define PHYMUL_CONVERTED(vector, type) __builtin_convertvector(vector, type)
#define PHYMUL_SHUFFLED(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)

// The functions of the standard library, without its headers.
#define PHYMUL_COPY(to, from, bytes) __builtin_memcpy(to, from, bytes)
#define PHYMUL_ROOT(x) __builtin_sqrtf(x)

#define PHYMUL_ALIGNED(pointer, bytes) __builtin_assume_aligned(pointer, bytes)
/// Asks for the line of a cache at an address, to be read: into all caches.
#define PHYMUL_PREFETCH(at) __builtin_prefetch(at)
#define PHYMUL_PREFETCH_TO_WRITE(at) __builtin_prefetch(at, 1)
/// The same, for data that is wanted later than what is at work.
#define PHYMUL_PREFETCH_LATER(at) __builtin_prefetch(at, 0, 2)

/// Whether this x86 processor has some instructions, named as GCC names them, in quotes.
#define PHYMUL_PROCESSOR_HAS(name) __builtin_cpu_supports(name)

namespace phymul {

/// The register that controls this thread's floating-point numbers, and its bits that make numbers below 1e-38 be 0:
/// none where the library knows no such register. Emscripten, which writes SSE2 by WebAssembly's vectors, has none.
#if defined(__SSE2__) && !defined(__EMSCRIPTEN__)
inline constexpr unsigned long long denormals_are_zero = 0x8040;  // FTZ, DAZ
PHYMUL_INLINE unsigned long long float_control() {
  return _mm_getcsr();
}
PHYMUL_INLINE void set_float_control(unsigned long long bits) {
  _mm_setcsr(static_cast<unsigned>(bits));
}
#elif defined(__aarch64__)
inline constexpr unsigned long long denormals_are_zero = 1ULL << 24;  // FZ
PHYMUL_INLINE unsigned long long float_control() {
  unsigned long long bits = 0;
  asm volatile("mrs %0, fpcr" : "=r"(bits) : : "memory");
  return bits;
}
PHYMUL_INLINE void set_float_control(unsigned long long bits) {
  asm volatile("msr fpcr, %0" : : "r"(bits) : "memory");
}
#else
inline constexpr unsigned long long denormals_are_zero = 0;
PHYMUL_INLINE unsigned long long float_control() {
  return 0;
}
PHYMUL_INLINE void set_float_control(unsigned long long) {}
#endif

/// Tells the processor that this thread waits for another one.
PHYMUL_INLINE void pause_a_moment() {
#if defined(__SSE2__)
  _mm_pause();
#elif defined(__aarch64__)
  __asm__ volatile("yield");
#endif
}

}  // namespace phymul
