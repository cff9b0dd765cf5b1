// SPDX-License-Identifier: MIT
//
// Where the twelve scenes of trajectories_test.cpp end. Their failure message has the row that would be right.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>

namespace phymul::test {

/// Of a backend, or of kernels of `cpu`: the same on every processor and system, by every compiler.
struct HashRow {
  const char* key;
  std::array<std::uint64_t, 12> hashes;
};

inline constexpr HashRow expected_hashes[] = {
    {"reference",
     {0xe41ceac595bae916, 0xf5bf8fe66f196cd4, 0x88e2abce5481fd52, 0xda7c75dfa9e01125, 0x6836f7e707c67ae9,
      0x1a9001a0b6985b3c, 0x47024be8ea3fe99f, 0x3c8a227a08172a7c, 0x9c33d5feb615b470, 0xab02b2b572d06b19,
      0xb7d338af5c5ac50d, 0xea9d0ced30b89c84}},
    {"portable",
     {0x872e2d7e03976391, 0xabbadd5f44455672, 0x9a5e1ec4e98309b0, 0x70fd97c197d3bf67, 0xe4028c24dd3e92b,
      0xbca370ff64ad1956, 0x117fc4acabefab41, 0x986bdbf499692f85, 0x855946194adab192, 0x11d5d8213482d5e,
      0xa3fb7464c6da4dc, 0xfd02c97ca1d1fe5a}},
    {"neon",
     {0x5d81417c830aea45, 0xabc6fb7f7adc5bcf, 0x9b701b25f809d036, 0xa5cbb4fabcf22a45, 0xd12061f5f8686bde,
      0x109d41f5ffc56a8a, 0x68c40cea1bb1b2fa, 0xfd9ac7befb8a1c9f, 0xfdeec091c0c690cb, 0x266802f9e8434937,
      0x92273b302ebc486d, 0xd67f3f64800396f5}},
    {"avx2",
     {0x5d81417c830aea45, 0xabc6fb7f7adc5bcf, 0x9b701b25f809d036, 0xb32548a3a42b92f3, 0xd12061f5f8686bde,
      0x109d41f5ffc56a8a, 0x68c40cea1bb1b2fa, 0xfd9ac7befb8a1c9f, 0xfdeec091c0c690cb, 0x266802f9e8434937,
      0x92273b302ebc486d, 0xd67f3f64800396f5}},
    {"avx512",
     {0x5d81417c830aea45, 0xabc6fb7f7adc5bcf, 0x9b701b25f809d036, 0xd1e98c3fcdbb8a63, 0xd12061f5f8686bde,
      0x109d41f5ffc56a8a, 0x68c40cea1bb1b2fa, 0xfd9ac7befb8a1c9f, 0xfdeec091c0c690cb, 0x266802f9e8434937,
      0x92273b302ebc486d, 0xd67f3f64800396f5}},
};

inline const HashRow* expected_row(const std::string& key) {
  const auto* row = std::ranges::find(expected_hashes, key, &HashRow::key);
  return row == std::end(expected_hashes) ? nullptr : row;
}

}  // namespace phymul::test
