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
     {0x3993143812daeebc, 0xec199d566662cb10, 0x156f79dcae7f2083, 0xda7c75dfa9e01125, 0x6836f7e707c67ae9,
      0xdfa604827ed1a318, 0x6285607f0a35ac3, 0x8b17bc2bd0717cc0, 0x1a214ad680120c1b, 0x7492c670a8a79348,
      0xc3517ccc669d3687, 0x4069b976fab804de}},
    {"portable",
     {0x56988b1da07a077, 0x8ff2660e6b99dc5a, 0x45dd957810e876af, 0x70fd97c197d3bf67, 0xe4028c24dd3e92b,
      0x4f40ae29dc17c397, 0xc0ea48b7ee2bdbc4, 0xa0d4c7bb983c2df6, 0x70fc1f961d02b358, 0x91ec5a9200eb9496,
      0x327aa6547600a6af, 0x443c5b6648922077}},
    {"neon",
     {0x63a3233fa1b7dec4, 0x86e0d89be23e2fd, 0xbd88a04c7fc92aec, 0xa5cbb4fabcf22a45, 0xd12061f5f8686bde,
      0x8bff6b28dc21a69b, 0xf2e66d673192b65b, 0xdd335739ceafa224, 0x8fc1efd135915190, 0x63f8fef97f919a94,
      0x8aed227cf7adb8a1, 0x19d42d8d16e373cb}},
    {"avx2",
     {0x63a3233fa1b7dec4, 0x86e0d89be23e2fd, 0xbd88a04c7fc92aec, 0xb32548a3a42b92f3, 0xd12061f5f8686bde,
      0x8bff6b28dc21a69b, 0xf2e66d673192b65b, 0xdd335739ceafa224, 0x8fc1efd135915190, 0x63f8fef97f919a94,
      0x8aed227cf7adb8a1, 0x19d42d8d16e373cb}},
    {"avx512",
     {0x63a3233fa1b7dec4, 0x86e0d89be23e2fd, 0xbd88a04c7fc92aec, 0xd1e98c3fcdbb8a63, 0xd12061f5f8686bde,
      0x8bff6b28dc21a69b, 0xf2e66d673192b65b, 0xdd335739ceafa224, 0x8fc1efd135915190, 0x63f8fef97f919a94,
      0x8aed227cf7adb8a1, 0x19d42d8d16e373cb}},
};

inline const HashRow* expected_row(const std::string& key) {
  const auto* row = std::ranges::find(expected_hashes, key, &HashRow::key);
  return row == std::end(expected_hashes) ? nullptr : row;
}

}  // namespace phymul::test
