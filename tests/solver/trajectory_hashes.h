// SPDX-License-Identifier: MIT
//
// Where the twelve scenes of trajectories_test.cpp end. Their failure message has the row that would be right.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <sstream>
#include <string>

#include "base/fnv.h"
#include "support/sanitized.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace phymul::test {

struct HashRow {
  const char* key;
  std::array<std::uint64_t, 12> hashes;
};

inline constexpr HashRow reference_hashes = {
    "reference",
    {0xb1204857253b1f44, 0xbc921175e1d99f24, 0xad59daa31d430166, 0xda7c75dfa9e01125, 0x6836f7e707c67ae9,
     0xdfa604827ed1a318, 0x504938fdc92b4f35, 0x4a51a381f7f75152, 0x63aa1c67f075cc5b, 0x5d02593d41c6ca59,
     0x7a4f17b199f30a3e, 0x23772d525eafb3d}};

/// The neo-Hookean energy takes std::pow, whose last bit is each C library's own choice, and glibc's also that of the
/// processor: whether it has an instruction for a * b + c. Row `neo_hookean` of the hashes, by rounding_of_pow().
inline constexpr std::size_t neo_hookean = 1;
struct PowHash {
  std::uint64_t rounding, hash;
};
inline constexpr PowHash pow_hashes[] = {
    {0x5d6c6689926ed7c1, reference_hashes.hashes[neo_hookean]},  // glibc, with the instruction
    {0x571d58a89c988245, 0xbdc36897c864111c},                    // glibc, without
    {0x1a50caf8826fba8f, 0x92324c0634a0d973},                    // MinGW-w64
};

inline std::uint64_t rounding_of_pow() {
  Fnv hash;
  for (int k = 0; k < 4096; ++k) hash.add(std::pow(0.5 + k / 2048.0, -2.0 / 3.0));
  return hash.value();
}

/// Rough roots fb50: AMD EPYC with AVX-512; 7d24: QEMU, which has none but rounded ones.
inline constexpr HashRow cpu_hashes[] = {
    {"portable x86-64, rough roots fb50",
     {0xdc258f1ee9fe2de9, 0x9858889aad54b721, 0xbf6ee26ed3981f80, 0xc577872eee782cc2, 0x3f69f872416172b6,
      0xe333b11a2dfa965d, 0x619e70255107a1c1, 0xde02108ef9e470d6, 0xa208d0ee05ef1a52, 0xa6f7728b02eabd43,
      0xc91c36b759ab3719, 0x953806489f76ec4}},
    {"avx2 x86-64, GCC 12, rough roots fb50",
     {0x9b321cd421d14e0f, 0x1481a97c4eab4b96, 0xded0335efdf0675c, 0xce85514998db1368, 0x45bdb9958b90f223,
      0x9e4cdd45ed89f8e3, 0xe895038bc0eb4c0d, 0x628bcc221d9704, 0x63abab5fcbb08b92, 0x1417f5bc2d117330,
      0x7964bfd5e36de537, 0x19d0393b936486bf}},
    {"avx512 x86-64, GCC 12, rough roots fb50",
     {0x913e5511f8d3ac57, 0x3dac163992d00f4c, 0x94f3c6f3d7e19afa, 0x3f9c8e2c80822a48, 0x45bdb9958b90f223,
      0xa3c39cfab9473f33, 0xe946563207a77632, 0x37295a95ff1bad35, 0x4c5788165c9c4999, 0x9c5794135f5f13e7,
      0xbe97cd15c19dd8a1, 0x61dcb324c8bf4216}},
    {"portable aarch64, GCC 12",
     {0x5ffd60323bc5d405, 0xa19d36b2125679aa, 0x2684fe6e463d3a85, 0xf7b75041cd7a2ac1, 0xb8b1dc2a5017ace6,
      0xd15a26872a97f293, 0xc085cac8427c8ecf, 0xffc436c1be085bd5, 0xd8ea1897466b2dff, 0xde405c7af66e2281,
      0x3e2baf3a968decb0, 0x833c290206a85fd4}},
    {"portable x86-64, rough roots 7d24",
     {0x5aed3b0a7a39de72, 0x9ab3dabdc3b87f08, 0x2ce405658d45a721, 0xb1ca193e56d7fa62, 0x910f0d67f4450bf6,
      0x8e89b1632619c1d3, 0xf52378a3ba331170, 0xf18b9e04595c386a, 0x3b7ca52f7d440829, 0x7f6b22e637318648,
      0x5a60b311dd58ddd3, 0xd05d7a1dafc3a1ac}},
};

inline const HashRow* known_row(const std::string& key) {
  const auto* row = std::find_if(std::begin(cpu_hashes), std::end(cpu_hashes), [&](auto& r) { return key == r.key; });
  return row == std::end(cpu_hashes) ? nullptr : row;
}

/// Of the instruction for rough inverse roots of x86: each maker of processors has a table of its own behind it.
inline std::string rough_roots() {
#if defined(__SSE2__)
  Fnv hash;
  for (int k = 0; k < 4096; ++k) {
    const float x = 1.0f + 3.0f * static_cast<float>(k) / 4096.0f;
    hash.add(static_cast<double>(_mm_cvtss_f32(_mm_rsqrt_ss(_mm_set_ss(x)))));
  }
  std::ostringstream text;
  text << ", rough roots " << std::hex << (hash.value() & 0xffff);
  return text.str();
#else
  return "";
#endif
}

/// What decides how kernels round: their width; where the target has an instruction for a * b + c, the compiler, which
/// chooses where to use it; and the processor's rough roots.
inline std::string rounding_of(const std::string& kernels) {
#if defined(__x86_64__)
  std::string key = kernels + " x86-64";
  const bool merges = kernels != "portable";
#else
  std::string key = kernels +
                    " "
#if defined(__aarch64__)
                    "aarch64";
#else
                    "other";
#endif
  const bool merges = true;
#endif
  if (merges) {
#if defined(__clang__)
    key += ", clang " + std::to_string(__clang_major__);
#elif defined(__GNUC__)
    key += ", GCC " + std::to_string(__GNUC__);
#endif
    if (sanitized) key += ", sanitized";
  }
  return key + rough_roots();
}

}  // namespace phymul::test
