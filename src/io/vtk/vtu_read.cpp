// SPDX-License-Identifier: MIT
//
// VTK XML unstructured grids (.vtu): data as text, base64 or raw appended, zlib-compressed or not, either byte order.
// Format: https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
#include <phymul/error.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <limits>
#include <pugixml.hpp>

#include "base/byte_source.h"
#include "base/files.h"
#include "io/mesh/mesh_parts.h"
#include "io/xml/xml_source.h"
#include "vtk_parts.h"

namespace phymul {
namespace {

/// The file in two: appended data may be raw bytes, which no XML parser takes.
struct VtuText {
  std::string xml;                         // without the appended data
  std::string_view appended;               // from after the underscore
  std::size_t cut_at = std::string::npos;  // offset in xml
  std::size_t cut_length = 0;
};

VtuText split(const std::string& path, std::string_view bytes) {
  VtuText text;
  const std::size_t tag = bytes.find("<AppendedData");
  const std::size_t open = tag == std::string_view::npos ? tag : bytes.find('>', tag);
  if (open == std::string_view::npos || bytes[open - 1] == '/') {
    text.xml = bytes;
    return text;
  }
  const std::size_t close = bytes.rfind("</AppendedData");
  const std::size_t underscore = bytes.find('_', open);
  if (close == std::string_view::npos || close < open || underscore == std::string_view::npos || underscore > close) {
    throw Error(path + ": byte " + std::to_string(open) + ": expected appended data after an underscore, up to " +
                "</AppendedData>, got the end of the file; it is cut off: export it again");
  }
  text.appended = bytes.substr(underscore + 1, close - underscore - 1);
  text.cut_at = open + 1;
  text.cut_length = close - text.cut_at;
  text.xml = std::string(bytes.substr(0, text.cut_at)) + std::string(bytes.substr(close));
  return text;
}

class VtuReader {
 public:
  VtuReader(const std::string& path, std::string_view bytes) : path_(path), bytes_(bytes), text_(split(path, bytes)) {
    parts_.source = path;
  }

  MeshParts read() {
    const pugi::xml_parse_result parsed =
        document_.load_buffer(text_.xml.data(), text_.xml.size(), pugi::parse_default, pugi::encoding_utf8);
    if (!parsed) fail(parsed.offset, std::string("expected well-formed XML: ") + parsed.description());
    const pugi::xml_node root = only(document_, "VTKFile");
    read_header(root);
    const pugi::xml_node grid = only(root, "UnstructuredGrid");
    if (!grid.child("Piece")) fail(root, "expected <UnstructuredGrid> with a <Piece>, got none; export the file again");
    for (const pugi::xml_node piece : grid.children("Piece")) read_piece(piece);
    return std::move(parts_);
  }

 private:
  void read_header(pugi::xml_node root) {
    const std::string type = root.attribute("type").value();
    if (type != "UnstructuredGrid") {
      fail(root, "expected <VTKFile type=\"UnstructuredGrid\">, got " + cited(type) +
                     "; export a volume mesh in one file (.vtu)");
    }
    const std::string order = root.attribute("byte_order").as_string("LittleEndian");
    if (order != "LittleEndian" && order != "BigEndian") {
      fail(root, "expected byte_order LittleEndian or BigEndian, got " + cited(order));
    }
    coding_.swap = (order == "LittleEndian") != (std::endian::native == std::endian::little);
    const std::string header = root.attribute("header_type").as_string("UInt32");
    if (header != "UInt32" && header != "UInt64") {
      fail(root, "expected header_type UInt32 or UInt64, got " + cited(header));
    }
    coding_.header_type = header == "UInt64" ? NumberType::uint64 : NumberType::uint32;
    const std::string compressor = root.attribute("compressor").value();
    if (!compressor.empty() && compressor != "vtkZLibDataCompressor") {
      fail(root, "expected compressor vtkZLibDataCompressor or none, got " + cited(compressor) +
                     "; export with zlib or without compression");
    }
    coding_.compressed = !compressor.empty();
    const std::string encoding = only(root, "AppendedData").attribute("encoding").as_string("base64");
    if (encoding != "raw" && encoding != "base64") {
      fail(root.child("AppendedData"), "expected encoding raw or base64, got " + cited(encoding));
    }
    appended_base64_ = encoding == "base64";
  }

  void read_piece(pugi::xml_node piece) {
    require_attributes_once(piece);
    const std::size_t points = count(piece, "NumberOfPoints");
    const std::size_t cells = count(piece, "NumberOfCells");
    const std::size_t first_point = parts_.points.size();
    if (points + first_point > static_cast<std::size_t>(std::numeric_limits<Index>::max())) {
      fail(piece, "expected fewer than 2^31 points");
    }
    if (points == 0 && cells > 0)
      fail(piece, "expected no cells in a piece without points, got " + std::to_string(cells));
    if (points == 0) return;  // writers leave empty pieces for processors without a share
    read_array(only(only(piece, "Points"), "DataArray"), "Points", 3, points, [&](ByteSource& in, NumberType type) {
      for (std::size_t i = 0; i < points; ++i) parts_.points.push_back(in.point(type));
    });
    const pugi::xml_node arrays = only(piece, "Cells");
    append_vtk_cells(read_cells(arrays, points, cells), static_cast<Index>(first_point), place(arrays), parts_);
    read_groups(piece.child("PointData"), first_point, points);
  }

  VtkCells read_cells(pugi::xml_node arrays, std::size_t points, std::size_t cells) {
    VtkCells result;
    result.offset.push_back(0);
    read_array(named(arrays, "offsets"), "offsets", 1, cells, [&](ByteSource& in, NumberType type) {
      for (std::size_t c = 0; c < cells; ++c) {
        const std::int64_t offset = in.integer(type, "an offset");
        if (offset < result.offset.back()) in.fail("expected offsets that grow, got " + std::to_string(offset));
        result.offset.push_back(offset);
      }
    });
    const auto corners = static_cast<std::size_t>(result.offset.back());
    read_array(named(arrays, "connectivity"), "connectivity", 1, corners, [&](ByteSource& in, NumberType type) {
      for (std::size_t k = 0; k < corners; ++k) {
        const std::int64_t p = in.integer(type, "a point number");
        if (p < 0 || static_cast<std::size_t>(p) >= points) {
          in.fail("expected a point number from 0 to " + std::to_string(points) + " - 1, got " + std::to_string(p) +
                  "; the file is damaged: export it again");
        }
        result.connectivity.push_back(p);
      }
    });
    read_array(named(arrays, "types"), "types", 1, cells, [&](ByteSource& in, NumberType type) {
      for (std::size_t c = 0; c < cells; ++c) result.types.push_back(in.integer(type, "a cell type"));
    });
    return result;
  }

  /// Point data "group:<name>", as write_vtu makes them: the points whose value is not 0.
  void read_groups(pugi::xml_node data, std::size_t first_point, std::size_t points) {
    for (const pugi::xml_node array : data.children("DataArray")) {
      const std::string name = array.attribute("Name").value();
      if (!name.starts_with("group:")) continue;
      std::vector<Index> members;
      read_array(array, name, 1, points, [&](ByteSource& in, NumberType type) {
        for (std::size_t i = 0; i < points; ++i) {
          if (in.real(type, "0 or 1") != 0.0) members.push_back(static_cast<Index>(first_point + i));
        }
      });
      const auto same = [&](const MeshGroup& group) { return group.name == name.substr(6); };
      auto group = std::find_if(parts_.groups.begin(), parts_.groups.end(), same);
      if (group == parts_.groups.end()) group = parts_.groups.insert(group, {name.substr(6), {}, {}});
      group->points.insert(group->points.end(), members.begin(), members.end());
    }
  }

  /// Calls use(source, type) with a source of tuples * components numbers. `name` is for messages.
  template <class Use>
  void read_array(pugi::xml_node array, const std::string& name, int components, std::size_t tuples, Use use) {
    if (!array) fail_format(path_, 0, "expected a <DataArray> of " + name + ", got none; export the file again");
    require_attributes_once(array);
    if (array.attribute("NumberOfComponents").as_int(1) != components) {
      fail(array, "expected " + std::to_string(components) + " components in " + cited(name) + ", got " +
                      cited(array.attribute("NumberOfComponents").value()));
    }
    const NumberType type = number_type(array);
    const std::string format = array.attribute("format").as_string("ascii");
    if (tuples > std::numeric_limits<std::size_t>::max() / 64)
      fail(array, "expected fewer numbers; the file is damaged");
    const std::size_t numbers = tuples * static_cast<std::size_t>(components);
    if (format == "ascii") {
      const pugi::xml_node words = array.first_child();
      const std::string text = text_in(array);
      if (numbers > text.size() / 2 + 1) {
        fail(array, "expected " + std::to_string(numbers) + " numbers in " + cited(name) + ", got " +
                        std::to_string(text.size()) + " characters; the file is cut off: export it again");
      }
      ByteSource in(path_, text, line_of(offset_of(words ? words : array)));
      use(in, type);
      if (!in.word().empty()) {
        fail(array, "expected " + std::to_string(numbers) + " numbers in " + cited(name) +
                        ", got more; a count is wrong or the file is damaged: export it again");
      }
      return;
    }
    VtuCoding coding = coding_;
    const std::string_view coded = coded_bytes(array, format, coding);
    const std::string where = place(array) + ": array " + cited(name);
    const std::string decoded = decode_vtu_array(coded, coding, numbers * size_of(type), where);
    constexpr std::size_t most_of_zlib = 1032;  // bytes that one may become
    if (format == "appended") decoded_ += decoded.size();
    if (decoded_ > text_.appended.size() * (coding.compressed ? most_of_zlib : 1)) {
      fail(array, "expected appended arrays that lie beside each other, got such as overlap; the file is damaged");
    }
    ByteSource in = ByteSource::decoded(where, decoded, coding.swap);
    use(in, type);
  }

  std::string_view coded_bytes(pugi::xml_node array, const std::string& format, VtuCoding& coding) {
    if (format == "binary") {
      coding.base64 = true;
      return coded_text_ = text_in(array);
    }
    if (format != "appended") {
      fail(array, "expected format ascii, binary or appended, got " + cited(format) + "; export the file again");
    }
    coding.base64 = appended_base64_;
    const std::size_t offset = count(array, "offset");
    if (offset >= text_.appended.size()) {
      fail(array, "expected an offset below " + std::to_string(text_.appended.size()) +
                      ", the size of the appended data, got " + std::to_string(offset) + "; the file is cut off");
    }
    return text_.appended.substr(offset);
  }

  pugi::xml_node named(pugi::xml_node arrays, const char* name) {
    pugi::xml_node found;
    for (const pugi::xml_node array : arrays.children("DataArray")) {
      if (array.attribute("Name").value() != std::string_view(name)) continue;
      if (found)
        fail(array, std::string("expected one array ") + cited(name) + ", got a second; export the file again");
      found = array;
    }
    return found;
  }

  /// The child of that name, or none.
  pugi::xml_node only(pugi::xml_node parent, const char* name) {
    const pugi::xml_node found = parent.child(name), second = found.next_sibling(name);
    if (second) fail(second, std::string("expected one <") + name + ">, got a second; export the file again");
    require_attributes_once(found);
    return found;
  }

  void require_attributes_once(pugi::xml_node node) {
    const std::string_view twice = repeated_attribute(node);
    if (!twice.empty()) fail(node, "expected each attribute once, got " + cited(twice) + " twice; the file is damaged");
  }

  /// Without comments, which part it.
  static std::string text_in(pugi::xml_node node) {
    std::string text;
    for (const pugi::xml_node part : node.children()) text += part.value();
    return text;
  }

  NumberType number_type(pugi::xml_node array) {
    const std::string type = array.attribute("type").value();
    using enum NumberType;
    constexpr std::pair<const char*, NumberType> types[] = {
        {"Float64", float64}, {"Float32", float32}, {"Int64", int64},   {"UInt64", uint64}, {"Int32", int32},
        {"UInt32", uint32},   {"Int16", int16},     {"UInt16", uint16}, {"Int8", int8},     {"UInt8", uint8}};
    for (const auto& [name, known] : types) {
      if (type == name) return known;
    }
    fail(array, "expected a number type (Float64, Int32, UInt8, ...), got " + cited(type) + "; export the file again");
  }

  std::size_t count(pugi::xml_node node, const char* attribute) {
    const std::string_view text = node.attribute(attribute).value();
    std::size_t value = 0;
    const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (text.empty() || problem != std::errc() || end != text.data() + text.size()) {
      fail(node, std::string("expected ") + attribute + "= with a whole number of at least 0, got " + cited(text));
    }
    return value;
  }

  static std::size_t offset_of(pugi::xml_node node) {
    return static_cast<std::size_t>(std::max<std::ptrdiff_t>(node.offset_debug(), 0));
  }

  /// Line in the file of an offset in the XML.
  std::size_t line_of(std::size_t offset) const {
    if (offset >= text_.cut_at) offset += text_.cut_length;
    offset = std::min(offset, bytes_.size());
    return 1 + static_cast<std::size_t>(
                   std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(offset), '\n'));
  }

  std::string place(pugi::xml_node node) const { return path_ + ':' + std::to_string(line_of(offset_of(node))); }

  [[noreturn]] void fail(std::size_t offset, const std::string& problem) const {
    fail_format(path_, line_of(offset), problem);
  }
  [[noreturn]] void fail(std::ptrdiff_t offset, const std::string& problem) const {
    fail(static_cast<std::size_t>(std::max<std::ptrdiff_t>(offset, 0)), problem);
  }
  [[noreturn]] void fail(pugi::xml_node node, const std::string& problem) const { fail(offset_of(node), problem); }

  std::string path_;
  std::string_view bytes_;
  VtuText text_;
  pugi::xml_document document_;
  MeshParts parts_;
  VtuCoding coding_;
  bool appended_base64_ = false;
  std::string coded_text_;   // of the array being read
  std::size_t decoded_ = 0;  // bytes of appended arrays
};

}  // namespace

MeshParts read_vtu(const std::string& path, std::string_view bytes) {
  return VtuReader(path, bytes).read();
}

}  // namespace phymul
