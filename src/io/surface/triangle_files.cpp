// SPDX-License-Identifier: MIT
#include "triangle_files.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <optional>
#include <utility>

#include "base/byte_source.h"
#include "base/decimal.h"
#include "base/files.h"

namespace phymul {
namespace {

constexpr bool is_big = std::endian::native == std::endian::big;

/// The place among the corners of the first whose fan folds back nowhere, up to rounding of coordinates; their number:
/// there is none.
std::size_t fan_corner(const std::vector<std::int64_t>& corners, const VecList& vertices) {
  const std::size_t count = corners.size();
  const auto at = [&](std::size_t k) -> const Vec3& { return vertices[corners[k % count]]; };
  const auto area = [&](std::size_t first, std::size_t k) {  // twice that of a triangle
    return Vec3((at(first + k - 1) - at(first)).cross(at(first + k) - at(first)));
  };
  Vec3 all = Vec3::Zero();
  double longest = 0.0;  // squared
  for (std::size_t k = 1; k < count; ++k) {
    all += area(0, k);
    longest = std::max(longest, (at(k) - at(0)).squaredNorm());
  }
  for (std::size_t first = 0; first < count; ++first) {
    std::size_t k = 2;
    while (k < count && !(area(first, k).dot(all) < -1e-5 * longest * all.norm())) ++k;
    if (k >= count) return first;
  }
  return count;
}

/// As a fan from a corner that sees all others. Corners are rows of vertices that were read before.
void add_polygon(const ByteSource& in, const std::vector<std::int64_t>& corners, Surface& surface) {
  if (corners.size() < 3) in.fail("expected a face of 3 or more corners, got " + std::to_string(corners.size()));
  for (const std::int64_t corner : corners) {
    if (corner >= 0 && corner < std::ssize(surface.vertices)) continue;
    in.fail("expected corners among the " + std::to_string(surface.vertices.size()) +
            " vertices before it, got another; the file is damaged: export it again");
  }
  const std::size_t first = fan_corner(corners, surface.vertices);
  if (first == corners.size()) in.fail("expected a face that one of its corners sees whole; triangulate on export");
  const auto row = [&](std::size_t k) { return static_cast<Index>(corners[(first + k) % corners.size()]); };
  for (std::size_t k = 2; k < corners.size(); ++k) surface.triangles.push_back({row(0), row(k - 1), row(k)});
}

void add_corner(const Vec3& place, Surface& surface) {
  surface.vertices.push_back(place);
  const auto count = static_cast<Index>(surface.vertices.size());
  if (count % 3 == 0) surface.triangles.push_back({count - 3, count - 2, count - 1});
}

/// A head of 80 bytes, the number of triangles, and of each its normal, three corners and two bytes.
Surface read_binary_stl(const std::string& path, std::string_view bytes) {
  ByteSource in(path, bytes);
  in.use_binary(is_big);
  in.seek(84);
  Surface surface;
  while (in.remaining() > 0) {
    in.skip_numbers(3, NumberType::float32);
    for (int corner = 0; corner < 3; ++corner) add_corner(in.point(NumberType::float32), surface);
    in.skip_numbers(1, NumberType::int16);
  }
  return surface;
}

Surface read_text_stl(const std::string& path, std::string_view bytes) {
  ByteSource in(path, bytes);
  const auto next = [&] { return lower_case(in.word()); };
  const auto expect = [&](std::string_view words) {
    for (; !words.empty(); words.remove_prefix(std::min(words.find(' '), words.size() - 1) + 1)) {
      const std::string got = next();
      if (got != words.substr(0, words.find(' '))) {
        in.fail("expected " + std::string(words) + ", got " + cited(got) + "; the file is cut off or damaged");
      }
    }
  };
  Surface surface;
  for (std::string word = next(); !word.empty(); word = next()) {
    if (word != "solid") in.fail("expected solid, got " + cited(word) + "; the file is damaged: export it again");
    in.line();  // its name
    for (word = next(); word == "facet"; word = next()) {
      expect("normal");
      for (int axis = 0; axis < 3; ++axis) in.word();  // programs write what they like
      expect("outer loop");
      for (int corner = 0; corner < 3; ++corner) {
        expect("vertex");
        add_corner(in.point(NumberType::float64), surface);
      }
      expect("endloop endfacet");
    }
    if (word != "endsolid") in.fail("expected facet or endsolid, got " + cited(word) + "; the file is cut off");
    in.line();
  }
  return surface;
}

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  ByteSource in("", line);
  for (std::string_view word = in.word(); !word.empty(); word = in.word()) words.push_back(word);
  return words;
}

struct PlyProperty {
  std::string name;
  NumberType type;
  std::optional<NumberType> count;  // of a list
};

struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;
};

class PlyReader {
 public:
  PlyReader(const std::string& path, std::string_view bytes) : in_(path, bytes) {}

  Surface read() {
    read_head();
    for (const PlyElement& element : elements_) {
      for (std::size_t row = 0; row < element.count; ++row) read_row(element);
    }
    in_.use_text();
    if (!in_.word().empty())
      in_.fail("expected the end of the file; the counts in its head are wrong: export it again");
    return std::move(surface_);
  }

 private:
  void read_head() {
    bool is_said = false;
    for (auto line = words_of(in_.line()); line.empty() || line[0] != "end_header"; line = words_of(in_.line())) {
      if (in_.remaining() == 0) in_.fail("expected end_header, got the end of the file; it is cut off");
      if (line.empty() || line[0] == "ply" || line[0] == "comment" || line[0] == "obj_info") continue;
      if (line[0] == "format" && line.size() == 3) {
        is_said = true;
        is_text_ = line[1] == "ascii";
        swap_ = (line[1] == "binary_big_endian") != is_big;
        if (!is_text_ && line[1] != "binary_little_endian" && line[1] != "binary_big_endian") {
          in_.fail("expected format ascii, binary_little_endian or binary_big_endian, got " + cited(line[1]));
        }
      } else if (line[0] == "element" && line.size() == 3 && parse_integer(line[2]).value_or(-1) >= 0) {
        elements_.push_back({std::string(line[1]), static_cast<std::size_t>(*parse_integer(line[2])), {}});
      } else if (line[0] == "property" && !elements_.empty() && line.size() > 2 &&
                 line.size() == (line[1] == "list" ? 5 : 3)) {
        const bool is_list = line[1] == "list";
        PlyProperty property{std::string(line.back()), type_of(line[line.size() - 2]), {}};
        if (is_list) property.count = type_of(line[2]);
        elements_.back().properties.push_back(property);
      } else {
        in_.fail("expected a line of a PLY file's head (format, element, property, comment, end_header) with its " +
                 std::string("names and counts; export the file again"));
      }
    }
    if (!is_said) in_.fail("expected format ascii, binary_little_endian or binary_big_endian in the head, got none");
    require("vertex", {"x", "y", "z"});
    require("face", {});
    if (!is_text_) in_.use_binary(swap_);
    for (const PlyElement& element : elements_) {
      if (element.properties.empty()) in_.fail("expected properties of " + cited(element.name) + ", got none");
    }
  }

  void require(std::string_view element, const std::vector<std::string>& properties) {
    const auto found = std::ranges::find(elements_, element, &PlyElement::name);
    if (found == elements_.end()) in_.fail("expected an element " + cited(element) + ", got none in the head");
    const auto has = [&](const std::string& name) {
      return std::ranges::count(found->properties, name, &PlyProperty::name) == 1;
    };
    const bool has_corners = element != "face" || has("vertex_indices") || has("vertex_index");
    if (has_corners && std::ranges::all_of(properties, has)) return;
    in_.fail("expected a vertex with x, y and z and a face with vertex_indices, once each; export the file again");
  }

  NumberType type_of(std::string_view name) {
    using enum NumberType;
    constexpr std::pair<std::string_view, NumberType> known[] = {
        {"char", int8},     {"int8", int8},       {"uchar", uint8},    {"uint8", uint8},
        {"short", int16},   {"int16", int16},     {"ushort", uint16},  {"uint16", uint16},
        {"int", int32},     {"int32", int32},     {"uint", uint32},    {"uint32", uint32},
        {"float", float32}, {"float32", float32}, {"double", float64}, {"float64", float64}};
    for (const auto& [word, type] : known) {
      if (word == name) return type;
    }
    in_.fail("expected a number type (float, uchar, int, ...), got " + cited(name) + "; export the file again");
  }

  void read_row(const PlyElement& element) {
    Vec3 place = Vec3::Zero();
    for (const auto& [name, type, count] : element.properties) {
      if (element.name == "vertex" && !count && name.size() == 1 && name[0] >= 'x' && name[0] <= 'z') {
        place[name[0] - 'x'] = in_.real(type, "a coordinate");
        continue;
      }
      const std::size_t numbers =
          count ? in_.count(*count, in_.is_binary() ? size_of(type) : 1, "the length of a list") : 1;
      if (element.name != "face" || !name.starts_with("vertex_ind")) {
        in_.skip_numbers(numbers, type);
        continue;
      }
      std::vector<std::int64_t> corners(numbers);
      for (std::int64_t& corner : corners) corner = in_.integer(type, "the row of a corner");
      add_polygon(in_, corners, surface_);
    }
    if (element.name == "vertex") surface_.vertices.push_back(place);
    if (is_text_) in_.expect_line_end("a row");
  }

  ByteSource in_;
  Surface surface_;
  std::vector<PlyElement> elements_;
  bool is_text_ = false, swap_ = false;
};

}  // namespace

Surface read_stl(const std::string& path, std::string_view bytes) {
  std::size_t count = 0;
  for (int k = 4; bytes.size() >= 84 && k-- > 0;) count = count << 8 | static_cast<unsigned char>(bytes[80 + k]);
  if (bytes.size() >= 84 && bytes.size() == 84 + 50 * count) return read_binary_stl(path, bytes);
  if (lower_case(trim(bytes.substr(0, 512))).starts_with("solid")) return read_text_stl(path, bytes);
  fail_format(path, 0,
              "expected \"solid\" or, in a binary STL file, 84 bytes and 50 for each of its " + std::to_string(count) +
                  " triangles, got " + std::to_string(bytes.size()) + " bytes; it is cut off or damaged");
}

Surface read_obj(const std::string& path, std::string_view bytes) {
  Surface surface;
  ByteSource in(path, bytes);
  const auto next = [&] {
    const std::string_view text = in.line();
    return text.substr(0, text.find('#'));
  };
  while (in.remaining() > 0) {
    std::string line(next());
    while (line.ends_with('\\')) line.back() = ' ', line += next();
    const auto words = words_of(line);
    if (words.empty() || (words[0] != "v" && words[0] != "f")) continue;
    std::vector<std::int64_t> corners;
    Vec3 place;
    for (std::size_t k = 1; k < words.size(); ++k) {
      const std::optional<double> number = parse_decimal(words[k]);
      const std::optional<std::int64_t> row = parse_integer(words[k].substr(0, words[k].find('/')));
      if (words[0] == "v" ? !number : !row || *row == 0) {
        in.fail(std::string("expected ") + (words[0] == "v" ? "coordinates" : "rows of vertices, from 1 or -1") +
                ", got " + cited(words[k]) + "; correct it, or export the file again");
      }
      if (words[0] == "f") corners.push_back(*row > 0 ? *row - 1 : *row + std::ssize(surface.vertices));
      if (words[0] == "v" && k <= 3) place[static_cast<Index>(k) - 1] = *number;
    }
    if (words[0] == "f") add_polygon(in, corners, surface);
    if (words[0] == "v" && words.size() < 4)
      in.fail("expected three coordinates, got " + std::to_string(words.size() - 1));
    if (words[0] == "v") surface.vertices.push_back(place);
  }
  return surface;
}

Surface read_ply(const std::string& path, std::string_view bytes) {
  if (!bytes.starts_with("ply")) fail_format(path, 1, "expected ply at the beginning, as a PLY file has it");
  return PlyReader(path, bytes).read();
}

}  // namespace phymul
