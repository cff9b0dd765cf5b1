// SPDX-License-Identifier: MIT
#include "machine_ceilings.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <thread>
#include <vector>

#include "stopwatch.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace phymul::bench {
namespace {

constexpr int chains = 12;  // enough to hide the latency of each
constexpr long rounds = 1000000;

float scalar_chains() {
  float sum[chains]{};
  for (long r = 0; r < rounds; ++r) {
    for (float& s : sum) s = s * 0.5f + 1.0f;
    asm volatile("" : : "r"(sum) : "memory");
  }
  return sum[0];
}

#if defined(__x86_64__)
#define PHYMUL_CHAINS(vector, set, multiply_add)                                                                    \
  vector s0 = set(0.0f), s1 = s0, s2 = s0, s3 = s0, s4 = s0, s5 = s0, s6 = s0, s7 = s0, s8 = s0, s9 = s0, s10 = s0, \
         s11 = s0;                                                                                                  \
  const vector a = set(0.5f), b = set(1.0f);                                                                        \
  for (long r = 0; r < rounds; ++r) {                                                                               \
    s0 = multiply_add(s0, a, b), s1 = multiply_add(s1, a, b), s2 = multiply_add(s2, a, b);                          \
    s3 = multiply_add(s3, a, b), s4 = multiply_add(s4, a, b), s5 = multiply_add(s5, a, b);                          \
    s6 = multiply_add(s6, a, b), s7 = multiply_add(s7, a, b), s8 = multiply_add(s8, a, b);                          \
    s9 = multiply_add(s9, a, b), s10 = multiply_add(s10, a, b), s11 = multiply_add(s11, a, b);                      \
    asm volatile("" : "+x"(s0), "+x"(s1), "+x"(s2), "+x"(s3), "+x"(s4), "+x"(s5));                                  \
    asm volatile("" : "+x"(s6), "+x"(s7), "+x"(s8), "+x"(s9), "+x"(s10), "+x"(s11));                                \
  }                                                                                                                 \
  return s0[0] + s1[0] + s2[0] + s3[0] + s4[0] + s5[0] + s6[0] + s7[0] + s8[0] + s9[0] + s10[0] + s11[0]

[[gnu::target("avx512f")]] float avx512_chains() {
  PHYMUL_CHAINS(__m512, _mm512_set1_ps, _mm512_fmadd_ps);
}
[[gnu::target("avx2,fma")]] float avx2_chains() {
  PHYMUL_CHAINS(__m256, _mm256_set1_ps, _mm256_fmadd_ps);
}
#undef PHYMUL_CHAINS
#endif

float widest_chains() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f")) return avx512_chains();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return avx2_chains();
#endif
  return scalar_chains();
}

}  // namespace

double vector_multiply_adds(double seconds) {
  double best = 0.0;
  const double end = processor_seconds() + seconds;
  while (processor_seconds() < end) {
    const double start = processor_seconds();
    volatile float result = widest_chains();
    static_cast<void>(result);
    best = std::max(best, static_cast<double>(chains) * rounds / (processor_seconds() - start));
  }
  return best;
}

double threads_gain(int threads, int pairs, double seconds) {
  using Clock = std::chrono::steady_clock;
  const auto rate = [seconds](int count) {
    std::atomic<long> done = 0;
    const Clock::time_point begin = Clock::now(),
                            end = begin + duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
    const auto work = [&] {
      while (Clock::now() < end) {
        volatile float result = widest_chains();
        static_cast<void>(result);
        ++done;
      }
    };
    std::vector<std::thread> others;
    for (int k = 1; k < count; ++k) others.emplace_back(work);
    work();
    for (std::thread& other : others) other.join();
    return static_cast<double>(done) / std::chrono::duration<double>(Clock::now() - begin).count();
  };
  std::vector<double> gains(static_cast<std::size_t>(pairs));
  for (double& gain : gains) {
    const double one = rate(1);
    gain = rate(threads) / one;
  }
  return median(std::move(gains));
}

double read_bandwidth(double bytes, double seconds) {
  const std::vector<double> array(static_cast<std::size_t>(bytes / sizeof(double)) / 16 * 16, 1.0);
  double best = 0.0;
  const double end = processor_seconds() + seconds;
  while (processor_seconds() < end) {
    const double start = processor_seconds();
    double sum[16]{};
    for (std::size_t i = 0; i < array.size(); i += 16) {
      for (std::size_t k = 0; k < 16; ++k) sum[k] += array[i + k];
    }
    asm volatile("" : : "r"(sum) : "memory");
    best = std::max(best, static_cast<double>(array.size() * sizeof(double)) / (processor_seconds() - start));
  }
  return best;
}

}  // namespace phymul::bench
