// SPDX-License-Identifier: MIT
//
// Layout. Not compressed: [bytes] data. Compressed: [blocks][bytes per block][bytes of the last block, 0: full]
// [compressed bytes of each block], then the blocks. Base64 may begin anew (after padding) between header and data.
#include "vtk_parts.h"

#include <phymul/error.h>

#include <zlib.h>
#include <algorithm>
#include <array>
#include <iterator>
#include <utility>
#include <vector>

#include "model/cell_geometry.h"

namespace phymul {
namespace {

enum VtkType : std::int64_t { empty = 0, strip = 6, polygon = 7, pixel = 8, voxel = 11, higher_polygon = 36 };

struct TypeRow {
  std::int64_t vtk;
  CellType type;
  std::ptrdiff_t points;  // of the whole cell, the corners first; 0: any number
};

/// Of several numbers of one type the first is written. From 21 on: cells of higher order.
constexpr TypeRow type_rows[] = {
    {1, CellType::atom, 1},           {2, CellType::poly_vertex, 0},  {3, CellType::line, 2},
    {4, CellType::poly_line, 0},      {5, CellType::triangle, 3},     {9, CellType::quad, 4},
    {pixel, CellType::quad, 4},       {10, CellType::tetrahedron, 4}, {12, CellType::hexahedron, 8},
    {voxel, CellType::hexahedron, 8}, {13, CellType::wedge, 6},       {14, CellType::pyramid, 5},
    {21, CellType::line, 3},          {22, CellType::triangle, 6},    {23, CellType::quad, 8},
    {24, CellType::tetrahedron, 10},  {25, CellType::hexahedron, 20}, {26, CellType::wedge, 15},
    {27, CellType::pyramid, 13},      {28, CellType::quad, 9},        {29, CellType::hexahedron, 27},
    {30, CellType::quad, 6},          {31, CellType::wedge, 12},      {32, CellType::wedge, 18},
    {33, CellType::hexahedron, 24},   {34, CellType::triangle, 7},    {35, CellType::line, 4},
    {37, CellType::pyramid, 19},
};

/// VTK's documentation has a wedge's first triangle look outward; many writers have it look inward, as Model has it.
/// The volume tells which it is, as it tells check_mesh().
bool first_triangle_looks_out(const VecList& points, const std::vector<Index>& particles) {
  return signed_volume(CellType::wedge, particles, points) < 0.0;
}

void turn_wedge(std::vector<Index>& p) {
  std::swap(p[1], p[2]);
  std::swap(p[4], p[5]);
}

}  // namespace

void append_vtk_cells(const VtkCells& vtk, Index first_point, const std::string& where, MeshParts& parts) {
  for (std::size_t c = 0; c < vtk.types.size(); ++c) {
    std::int64_t type = vtk.types[c];
    const auto begin = vtk.connectivity.begin() + static_cast<std::ptrdiff_t>(vtk.offset[c]);
    const std::ptrdiff_t points = vtk.offset[c + 1] - vtk.offset[c];
    if (type == empty && points == 0) continue;
    if (type == polygon && (points == 3 || points == 4)) type = points == 3 ? 5 : 9;
    if (type == strip || type == polygon || type == higher_polygon) {
      ++parts.left_out[type == strip ? "triangle strip" : "polygon"];
      continue;
    }
    const auto* const row = std::ranges::find(type_rows, type, &TypeRow::vtk);
    const auto refuse = [&](const std::string& what) {
      throw Error(where + ": cell " + std::to_string(c) + ": expected " + what);
    };
    if (row == std::end(type_rows)) {
      refuse("VTK types 1 to 14 or 21 to 37, of first or second order, got type " + std::to_string(type) +
             "; export tetrahedra, hexahedra, wedges or pyramids");
    }
    if (row->points != 0 ? points != row->points : points == 0) {
      refuse((row->points != 0 ? std::to_string(row->points) + " points" : "points") + " for VTK type " +
             std::to_string(type) + ", got " + std::to_string(points) + "; the file is damaged: export it again");
    }
    const int corners = cell_size(row->type);
    parts.higher_order += corners != 0 && points > corners;
    Cell cell;
    cell.type = row->type;
    for (auto p = begin; p != begin + (corners != 0 ? corners : points); ++p) {
      cell.particles.push_back(first_point + static_cast<Index>(*p));
    }
    if (type == pixel || type == voxel) std::swap(cell.particles[2], cell.particles[3]);
    if (type == voxel) std::swap(cell.particles[6], cell.particles[7]);
    if (cell.type == CellType::wedge && first_triangle_looks_out(parts.points, cell.particles)) {
      turn_wedge(cell.particles);
    }
    parts.cells.push_back(std::move(cell));
  }
}

std::uint8_t vtk_type(CellType type) {
  return static_cast<std::uint8_t>(std::ranges::find(type_rows, type, &TypeRow::type)->vtk);
}

std::vector<Index> vtk_order(const Cell& cell) {
  std::vector<Index> particles = cell.particles;
  if (cell.type == CellType::wedge) turn_wedge(particles);
  return particles;
}

namespace {

constexpr std::size_t zlib_best_ratio = 1032;  // zlib cannot compress better, so a larger claim is a lie

int base64_value(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+') return 62;
  if (c == '/') return 63;
  return -1;
}

bool is_space(char c) {
  return c == ' ' || c == '\n' || c == '\r' || c == '\t';
}

/// Hands out decoded bytes in order.
class CodedBytes {
 public:
  CodedBytes(std::string_view coded, bool base64, const std::string& place)
      : coded_(coded), base64_(base64), place_(place) {}

  std::string take(std::size_t n) {
    if (n > most_left()) fail_short(n);
    if (!base64_) {
      position_ += n;
      return std::string(coded_.substr(position_ - n, n));
    }
    std::string result;
    result.reserve(n);
    while (result.size() < n) {
      if (next_ == held_) decode_four();
      result += quad_[next_++];
    }
    return result;
  }

  std::size_t most_left() const {
    const std::size_t coded = coded_.size() - position_;
    return base64_ ? coded / 4 * 3 + 3 + (held_ - next_) : coded;
  }

 private:
  void decode_four() {
    std::array<int, 4> value{};
    std::size_t padding = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      while (position_ < coded_.size() && is_space(coded_[position_])) ++position_;
      if (position_ == coded_.size()) fail_short(1);
      const char c = coded_[position_++];
      value[k] = base64_value(c);
      if (c == '=' && k >= 2) {
        ++padding;
        value[k] = 0;
      } else if (value[k] < 0 || padding > 0) {
        throw Error(place_ + ": expected base64 characters, got " + cited(std::string(1, c)) +
                    "; the file is damaged: export it again");
      }
    }
    const int bits = value[0] << 18 | value[1] << 12 | value[2] << 6 | value[3];
    quad_ = {static_cast<char>(bits >> 16 & 255), static_cast<char>(bits >> 8 & 255), static_cast<char>(bits & 255)};
    held_ = 3 - padding;
    next_ = 0;
  }

  [[noreturn]] void fail_short(std::size_t n) const {
    throw Error(place_ + ": expected " + std::to_string(n) +
                " more bytes, got the end of the data; the file is cut off: "
                "export it again");
  }

  std::string_view coded_;
  std::size_t position_ = 0;
  bool base64_;
  std::array<char, 3> quad_{};
  std::size_t held_ = 0;
  std::size_t next_ = 0;
  const std::string& place_;
};

std::size_t take_count(CodedBytes& in, const VtuCoding& coding, const std::string& place) {
  const std::string bytes = in.take(size_of(coding.header_type));
  ByteSource source = ByteSource::decoded(place, bytes, coding.swap);
  return static_cast<std::size_t>(source.integer(coding.header_type, "a byte count"));
}

void require_size(std::size_t got, std::size_t expected, const std::string& place) {
  if (got == expected) return;
  throw Error(place + ": expected " + std::to_string(expected) +
              " bytes, as the counts of points and cells ask for, got " + std::to_string(got) +
              "; the file is damaged: export it again");
}

std::string inflate_block(const std::string& packed, std::size_t size, const std::string& place) {
  std::string block(size, '\0');
  auto length = static_cast<uLongf>(size);
  const int result = uncompress(reinterpret_cast<Bytef*>(block.data()), &length,
                                reinterpret_cast<const Bytef*>(packed.data()), static_cast<uLong>(packed.size()));
  if (result != Z_OK || length != size) {
    throw Error(place + ": expected a zlib block of " + std::to_string(size) +
                " bytes, got damaged data; export it again");
  }
  return block;
}

std::string decode_compressed(CodedBytes& in, const VtuCoding& coding, std::size_t expected, const std::string& place) {
  const std::size_t blocks = take_count(in, coding, place);
  if (blocks == 0) {
    require_size(0, expected, place);
    return {};
  }
  if (blocks > in.most_left() / size_of(coding.header_type)) {
    throw Error(place + ": expected fewer than " + std::to_string(blocks) + " compressed blocks; the file is damaged");
  }
  const std::size_t full = take_count(in, coding, place);
  const std::size_t partial = take_count(in, coding, place);
  std::vector<std::size_t> packed_size(blocks);
  std::size_t packed_total = 0;
  for (std::size_t& size : packed_size) {
    size = take_count(in, coding, place);
    if (size > in.most_left()) require_size(size, in.most_left(), place);
    packed_total += size;
  }
  // Divisions instead of products: the counts are the file's word and may overflow.
  const std::size_t last = partial == 0 ? full : partial;
  const bool fits = last <= expected && (blocks == 1 || full <= (expected - last) / (blocks - 1)) &&
                    expected / zlib_best_ratio <= packed_total;
  if (!fits || (blocks - 1) * full + last != expected) {
    throw Error(place + ": expected " + std::to_string(expected) +
                " bytes, as the counts of points and cells ask for, got " + std::to_string(blocks) +
                " blocks of other sizes; the file is damaged: export it again");
  }
  std::string result;
  for (std::size_t b = 0; b < blocks; ++b) {
    result += inflate_block(in.take(packed_size[b]), b + 1 < blocks ? full : last, place);
  }
  return result;
}

}  // namespace

std::string decode_vtu_array(std::string_view coded, const VtuCoding& coding, std::size_t expected_bytes,
                             const std::string& place) {
  CodedBytes in(coded, coding.base64, place);
  if (coding.compressed) return decode_compressed(in, coding, expected_bytes, place);
  require_size(take_count(in, coding, place), expected_bytes, place);
  return in.take(expected_bytes);
}

}  // namespace phymul
