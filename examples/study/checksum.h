// SPDX-License-Identifier: MIT
//
// CRC-32 over texts, by zlib: against torn lines and mixed-up files, not against forgery.
#pragma once

#include <zlib.h>

#include <cstdint>
#include <string_view>

class Checksum {
 public:
  /// The text and its end, so that "ab", "c" is not "a", "bc".
  void add(std::string_view text) {
    crc_ = crc32_z(crc_, reinterpret_cast<const Bytef*>(text.data()), text.size());
    const Bytef end = 0;
    crc_ = crc32_z(crc_, &end, 1);
  }
  std::uint32_t value() const { return static_cast<std::uint32_t>(crc_); }

 private:
  uLong crc_ = crc32_z(0, nullptr, 0);
};
