// SPDX-License-Identifier: MIT
//
// The bytes of one data array of a VTK XML file: base64 or raw, zlib-compressed or not.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "base/byte_source.h"

namespace phymul {

struct VtuCoding {
  bool base64 = false;
  bool compressed = false;                      ///< blocks of zlib
  bool swap = false;                            ///< the file's byte order is not this machine's
  NumberType header_type = NumberType::uint32;  ///< of the byte counts before the data
};

/// Decodes the array that begins at the start of `coded` (which may go on beyond it). It must have `expected_bytes`.
/// `place` begins the messages. Throws Error.
std::string decode_vtu_array(std::string_view coded, const VtuCoding& coding, std::size_t expected_bytes,
                             const std::string& place);

}  // namespace phymul
