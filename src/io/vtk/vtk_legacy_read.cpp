// SPDX-License-Identifier: MIT
//
// Legacy VTK files with an unstructured grid, versions 1 to 5.x, ASCII and BINARY (always big-endian).
// Format: https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html

#include <bit>
#include <limits>

#include "base/byte_source.h"
#include "base/files.h"
#include "io/mesh/mesh_parts.h"
#include "vtk_parts.h"

namespace phymul {
namespace {

class VtkLegacyReader {
 public:
  VtkLegacyReader(const std::string& path, std::string_view bytes) : in_(path, bytes) { parts_.source = path; }

  MeshParts read() {
    read_header();
    while (true) {
      const std::string keyword = lower_case(in_.word());
      if (keyword.empty() || keyword == "point_data" || keyword == "cell_data") break;
      read_section(keyword);
    }
    if (!has_points_ || !has_cells_ || cells_.types.size() + 1 != cells_.offset.size()) {
      in_.fail(std::string("expected ") +
               (!has_points_  ? "POINTS"
                : !has_cells_ ? "CELLS"
                              : "CELL_TYPES") +
               ", got the end of the geometry; the file is cut off or holds no mesh: export it again");
    }
    append_vtk_cells(cells_, 0, parts_.source, parts_);
    return std::move(parts_);
  }

 private:
  void read_header() {
    // "# vtk DataFile Version x.y", after blank lines; the version tells nothing that the sections do not.
    while (in_.remaining() > 0 && in_.line().find("# vtk DataFile") == std::string_view::npos) {
    }
    in_.line();  // title
    const std::string kind = lower_case(in_.word());
    if (kind != "ascii" && kind != "binary") in_.fail("expected ASCII or BINARY, got " + cited(kind));
    binary_ = kind == "binary";
    const std::string dataset = lower_case(in_.word());
    const std::string type = lower_case(in_.word());
    if (dataset != "dataset" || type != "unstructured_grid") {
      in_.fail("expected DATASET UNSTRUCTURED_GRID, got " + cited(dataset + ' ' + type) +
               "; export a volume mesh, not a surface or an image");
    }
  }

  void read_section(const std::string& keyword) {
    if (keyword == "points") {
      read_points();
    } else if (keyword == "cells") {
      read_cells();
    } else if (keyword == "cell_types") {
      read_types();
    } else if (keyword == "field") {
      skip_field();
    } else if (keyword == "metadata") {
      skip_metadata();
    } else {
      in_.fail("expected POINTS, CELLS, CELL_TYPES, FIELD or METADATA, got " + cited(keyword) +
               "; the counts before it are wrong or the file is damaged: export it again");
    }
  }

  NumberType number_type() {
    const std::string name = lower_case(in_.word());
    if (name == "float") return NumberType::float32;
    if (name == "double") return NumberType::float64;
    if (name == "char" || name == "signed_char" || name == "vtktypeint8") return NumberType::int8;
    if (name == "unsigned_char" || name == "vtktypeuint8") return NumberType::uint8;
    if (name == "short" || name == "vtktypeint16") return NumberType::int16;
    if (name == "unsigned_short" || name == "vtktypeuint16") return NumberType::uint16;
    if (name == "int" || name == "vtktypeint32" || name == "vtkidtype") return NumberType::int32;  // as VTK writes ids
    if (name == "unsigned_int" || name == "vtktypeuint32") return NumberType::uint32;
    if (name == "long" || name == "vtktypeint64") return NumberType::int64;
    if (name == "unsigned_long" || name == "vtktypeuint64") return NumberType::uint64;
    in_.fail("expected a number type (float, double, int, vtktypeint64, ...), got " + cited(name) +
             "; leave this array out and export again");
  }

  /// Numbers begin on the line after the words that announce them.
  void begin_numbers() {
    if (!binary_) return;
    in_.line();
    in_.use_binary(std::endian::native == std::endian::little);
  }

  /// Binary ones are followed by a line end: else bytes of them are missing, or there are too many.
  void end_numbers() {
    if (binary_) in_.expect_line_end("binary numbers");
    in_.use_text();
  }

  /// Least bytes of a number in the body of a section, while its head, which is text, is being read.
  std::size_t body_bytes(NumberType type) const { return binary_ ? size_of(type) : 2; }

  void read_points() {
    if (has_points_) in_.fail("expected POINTS once, got them again; the file is damaged");
    has_points_ = true;
    const std::size_t n = in_.count(NumberType::int64, 3 * body_bytes(NumberType::int8), "a number of points");
    if (n > static_cast<std::size_t>(std::numeric_limits<Index>::max())) in_.fail("expected fewer than 2^31 points");
    const NumberType type = number_type();
    begin_numbers();
    require_room(n, 3 * body_bytes(type), "points");
    parts_.points.reserve(n);
    for (std::size_t i = 0; i < n; ++i) parts_.points.push_back(in_.point(type));
    end_numbers();
  }

  void require_room(std::size_t n, std::size_t bytes_each, const char* what) {
    if (n > in_.remaining() / bytes_each + 1) {  // the last number in text needs no separator after it
      in_.fail("expected " + std::to_string(n) + ' ' + what + ", got only " + std::to_string(in_.remaining()) +
               " bytes to the end of the file; it is cut off: export it again");
    }
  }

  std::int64_t point_number(NumberType type) {
    const std::int64_t p = in_.integer(type, "a point number");
    if (p < 0 || static_cast<std::size_t>(p) >= parts_.points.size()) {
      in_.fail("expected a point number from 0 to " + std::to_string(parts_.points.size()) + " - 1, got " +
               std::to_string(p) + "; the file is damaged: export it again");
    }
    return p;
  }

  void read_cells() {
    if (!has_points_) in_.fail("expected POINTS before CELLS; export the file again");
    if (has_cells_) in_.fail("expected CELLS once, got them again; the file is damaged");
    has_cells_ = true;
    const std::size_t first = in_.count(NumberType::int64, 1, "a number of cells");
    const std::size_t second = in_.count(NumberType::int64, 1, "a number of numbers");
    const std::size_t head = in_.position();
    if (lower_case(in_.word()) == "offsets") {
      read_offsets(first, second);
    } else {
      in_.seek(head);
      read_cell_list(first, second);
    }
    end_numbers();
  }

  /// Version 5: OFFSETS type, one more than cells; CONNECTIVITY type, the point numbers.
  void read_offsets(std::size_t offsets, std::size_t entries) {
    const NumberType offset_type = number_type();
    begin_numbers();
    require_room(offsets, body_bytes(offset_type), "offsets");
    for (std::size_t c = 0; c < offsets; ++c) {
      const std::int64_t offset = in_.integer(offset_type, "an offset");
      const std::int64_t least = cells_.offset.empty() ? 0 : cells_.offset.back();
      if (offset < least || static_cast<std::size_t>(offset) > entries || (c == 0 && offset != 0)) {
        in_.fail("expected offsets that grow from 0 to " + std::to_string(entries) + ", got " + std::to_string(offset) +
                 "; the file is damaged: export it again");
      }
      cells_.offset.push_back(offset);
    }
    if (offsets > 0 && static_cast<std::size_t>(cells_.offset.back()) != entries) {
      in_.fail("expected offsets up to " + std::to_string(entries) + ", the number of point numbers, got " +
               std::to_string(cells_.offset.back()) + " as the last; the file is damaged: export it again");
    }
    end_numbers();
    const std::string keyword = lower_case(in_.word());
    if (keyword != "connectivity") in_.fail("expected CONNECTIVITY, got " + cited(keyword) + "; the file is damaged");
    const NumberType type = number_type();
    begin_numbers();
    require_room(entries, body_bytes(type), "point numbers");
    for (std::size_t k = 0; k < entries; ++k) cells_.connectivity.push_back(point_number(type));
    if (cells_.offset.empty()) cells_.offset.push_back(0);
  }

  /// Up to version 4.2: per cell the number of its points, then the points.
  void read_cell_list(std::size_t cells, std::size_t numbers) {
    begin_numbers();
    require_room(numbers, body_bytes(NumberType::int32), "numbers of cells");
    cells_.offset.push_back(0);
    std::size_t used = 0;
    for (std::size_t c = 0; c < cells; ++c) {
      const std::int64_t corners = in_.integer(NumberType::int32, "the number of a cell's points");
      if (corners < 0 || used + 1 + static_cast<std::size_t>(corners) > numbers) {
        in_.fail("expected cells of " + std::to_string(numbers) + " numbers in all, got a cell of " +
                 std::to_string(corners) + " points after " + std::to_string(used) + " numbers; the file is damaged");
      }
      for (std::int64_t k = 0; k < corners; ++k) cells_.connectivity.push_back(point_number(NumberType::int32));
      used += 1 + static_cast<std::size_t>(corners);
      cells_.offset.push_back(static_cast<std::int64_t>(cells_.connectivity.size()));
    }
    if (used != numbers) {
      in_.fail("expected cells of " + std::to_string(numbers) + " numbers in all, got " + std::to_string(used) +
               "; the file is damaged: export it again");
    }
  }

  void read_types() {
    const std::size_t n = in_.count(NumberType::int64, 1, "a number of cell types");
    if (!has_cells_ || n + 1 != cells_.offset.size()) {
      in_.fail("expected CELLS, then as many CELL_TYPES, got " + std::to_string(n) + " types for " +
               std::to_string(has_cells_ ? cells_.offset.size() - 1 : 0) + " cells; export the file again");
    }
    if (!cells_.types.empty()) in_.fail("expected CELL_TYPES once, got them again; the file is damaged");
    begin_numbers();
    for (std::size_t c = 0; c < n; ++c) cells_.types.push_back(in_.integer(NumberType::int32, "a cell type"));
    end_numbers();
  }

  void skip_field() {
    in_.word();  // its name
    const std::size_t arrays = in_.count(NumberType::int64, 1, "a number of arrays");
    for (std::size_t a = 0; a < arrays; ++a) {
      const std::string name = lower_case(in_.word());
      if (name == "metadata") {
        skip_metadata();
        in_.word();
      }
      const std::size_t components = in_.count(NumberType::int64, 1, "a number of components");
      const std::size_t tuples = in_.count(NumberType::int64, 1, "a number of tuples");
      const NumberType type = number_type();
      begin_numbers();
      if (components != 0) require_room(tuples, components * body_bytes(type), "tuples");
      in_.skip_numbers(components * tuples, type);
      end_numbers();
    }
  }

  void skip_metadata() {  // ends with an empty line
    in_.line();
    while (in_.remaining() > 0 && !in_.line().empty()) {
    }
  }

  ByteSource in_;
  MeshParts parts_;
  VtkCells cells_;
  bool binary_ = false;
  bool has_points_ = false;
  bool has_cells_ = false;
};

}  // namespace

MeshParts read_vtk_legacy(const std::string& path, std::string_view bytes) {
  return VtkLegacyReader(path, bytes).read();
}

}  // namespace phymul
