// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <bit>
#include <string>

namespace phymul {

TextureShape fit_texture(std::int64_t rows, int limit, const char* table) {
  if (limit < 1) {
    throw Error("the longest side of a texture is " + std::to_string(limit) + "; one has at least 1 x 1 texels");
  }
  const std::int64_t wanted = std::max<std::int64_t>(rows, 1);
  const std::int64_t widest = static_cast<std::int64_t>(std::bit_floor(static_cast<std::uint64_t>(limit)));
  std::int64_t width = 1;
  while (width < widest && width * width < wanted) width *= 2;
  const std::int64_t height = (wanted + width - 1) / width;
  if (height > limit) {
    throw Error(ErrorCode::not_supported,
                "the table of " + std::string(table) + " needs " + std::to_string(rows) + " rows; textures of up to " +
                    std::to_string(limit) + " texels a side hold " + std::to_string(widest * limit) +
                    " (widths are powers of two). Use fewer particles or neighbours, or a sparser base selection");
  }
  return {static_cast<int>(width), static_cast<int>(height)};
}

}  // namespace phymul
