// SPDX-License-Identifier: MIT
//
// Gmsh .msh, versions 1, 2.x and 4.1, text and binary. Text and binary hold the same numbers in the same order, so one
// parser reads both: ByteSource knows which. Format: https://gmsh.info/doc/texinfo/gmsh.html#File-formats

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <map>
#include <unordered_map>

#include "base/byte_source.h"
#include "base/decimal.h"
#include "mesh_parts.h"

namespace phymul {
namespace {

constexpr NumberType int_type = NumberType::int32;
constexpr NumberType size_type = NumberType::uint64;
constexpr NumberType real_type = NumberType::float64;

using GroupKey = std::pair<int, std::int64_t>;  // dimension and physical tag

class GmshReader {
 public:
  GmshReader(const std::string& path, std::string_view bytes) : in_(path, bytes) { parts_.source = path; }

  MeshParts read() {
    while (in_.remaining() > 0) {
      std::string_view line = in_.line();
      if (line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3);
      line = trim(line);
      if (line.empty()) continue;
      if (line[0] != '$') {
        in_.fail("expected the start of a section ($Nodes, $Elements, ...), got " + cited(line) +
                 "; the file is damaged: export it again");
      }
      read_section(std::string(line.substr(1)));
    }
    if (!has_nodes_ || !has_elements_) {
      const char* missing = major_ == 1 ? "ELM" : has_nodes_ ? "Elements" : "Nodes";
      in_.fail(std::string("expected a section $") + missing +
               ", got the end of the file; it is cut off or holds no mesh: export it again");
    }
    name_groups();
    return std::move(parts_);
  }

 private:
  void read_section(const std::string& name) {
    if (name == "NOD" && major_ == 0) major_ = 1;  // the first version says none
    if (name != "MeshFormat" && major_ == 0 && name != "Comments") {
      in_.fail("expected $MeshFormat as the first section, got " + cited('$' + name) + "; export the file again");
    }
    if (name == "MeshFormat") {
      read_format();
    } else if (name == "PhysicalNames") {
      read_names();
    } else if (name == "Entities" && major_ == 4) {
      read_entities();
    } else if (name == (major_ == 1 ? "NOD" : "Nodes")) {
      if (has_nodes_) in_.fail("expected one section $Nodes, got a second; join the files in the mesher");
      has_nodes_ = true;
      major_ == 4 ? read_nodes_4() : read_nodes_2();
    } else if (name == (major_ == 1 ? "ELM" : "Elements")) {
      if (!has_nodes_) in_.fail("expected $Nodes before $Elements; export the file again");
      if (has_elements_) in_.fail("expected one section $Elements, got a second; join the files in the mesher");
      has_elements_ = true;
      major_ == 4 ? read_elements_4() : read_elements_2();
    } else {
      if (name == "PartitionedEntities") {
        parts_.notes.push_back(in_.where() + ": the mesh is partitioned; groups of partitioned entities are not read");
      }
      skip_section(name);
      return;
    }
    // Names are text in binary files, too.
    if (in_.is_binary() && name != "PhysicalNames") in_.expect_line_end("binary numbers");
    in_.expect_word(end_of(name));
  }

  std::string end_of(const std::string& name) const { return (major_ == 1 ? "$END" : "$End") + name; }

  void skip_section(const std::string& name) {
    if (!in_.skip_past(end_of(name))) {
      in_.fail("expected " + end_of(name) + ", got the end of the file; it is cut off: export it again");
    }
  }

  void read_format() {
    in_.use_text();
    const std::string version(in_.word());
    if (version != "4.1" && version != "2" && !version.starts_with("2.")) {
      in_.fail("expected .msh version 4.1 or 2.2, got " + cited(version) +
               "; export as one of these (Gmsh: -format msh41, or Mesh.MshFileVersion = 4.1)");
    }
    major_ = version == "4.1" ? 4 : 2;
    const std::int64_t file_type = in_.integer(int_type, "the file type, 0 (text) or 1 (binary)");
    if (file_type != 0 && file_type != 1) {
      in_.fail("expected the file type 0 (text) or 1 (binary), got " + std::to_string(file_type));
    }
    const std::int64_t data_size = in_.integer(int_type, "the data size");
    if (data_size != 8) {
      in_.fail("expected a data size of 8 bytes, got " + std::to_string(data_size) + "; export on a 64-bit machine");
    }
    if (file_type == 0) return;
    in_.line();
    in_.use_binary(false);
    const std::size_t start = in_.position();
    if (in_.integer(int_type, "the number 1 that tells the byte order") == 1) return;
    in_.seek(start);
    swap_ = true;
    in_.use_binary(swap_);
    const std::int64_t swapped = in_.integer(int_type, "the number 1 that tells the byte order");
    if (swapped != 1) in_.fail("expected the number 1 that tells the byte order; the file is damaged: export it again");
  }

  void read_names() {  // text in binary files, too
    const bool binary = in_.is_binary();
    in_.use_text();
    const std::size_t n = in_.count(size_type, 6, "a number of physical names");
    for (std::size_t i = 0; i < n; ++i) {
      const auto dimension = static_cast<int>(std::clamp<std::int64_t>(in_.integer(int_type, "a dimension"), -1, 4));
      const std::int64_t tag = in_.integer(int_type, "a physical tag");
      const std::string_view rest = in_.line();
      const std::size_t open = rest.find('"');
      const std::size_t close = rest.rfind('"');
      if (open == std::string_view::npos || close == open || dimension < 0 || dimension > 3) {
        in_.fail("expected: dimension (0 to 3), tag, name in double quotes; export the file again");
      }
      names_[{dimension, tag}] = std::string(rest.substr(open + 1, close - open - 1));
    }
    if (binary) in_.use_binary(swap_);
  }

  // $Entities: the way from an entity to its physical groups. Coordinates and boundaries are not needed.
  void read_entities() {
    std::array<std::size_t, 4> counts{};
    for (std::size_t& n : counts) n = in_.count(size_type, in_.least_bytes(int_type), "a number of entities");
    for (int dimension = 0; dimension < 4; ++dimension) {
      for (std::size_t i = 0; i < counts[dimension]; ++i) {
        const std::int64_t tag = in_.integer(int_type, "an entity tag");
        in_.skip_numbers(dimension == 0 ? 3 : 6, real_type);
        std::vector<std::int64_t>& physical = entity_groups_[{dimension, tag}];
        const std::size_t n = in_.count(size_type, in_.least_bytes(int_type), "a number of physical tags");
        for (std::size_t k = 0; k < n; ++k) physical.push_back(std::abs(in_.integer(int_type, "a physical tag")));
        std::ranges::sort(physical);
        const auto again = std::ranges::unique(physical);
        physical.erase(again.begin(), again.end());
        if (dimension == 0) continue;
        const std::size_t bounds = in_.count(size_type, in_.least_bytes(int_type), "a number of bounding entities");
        in_.skip_numbers(bounds, int_type);
      }
    }
  }

  void add_node(std::int64_t tag) {
    if (tag < 0 || tag > std::numeric_limits<Index>::max()) {
      in_.fail("expected a node tag from 0 to " + std::to_string(std::numeric_limits<Index>::max()) + ", got " +
               std::to_string(tag) + "; renumber the mesh (Gmsh: RenumberMeshNodes)");
    }
    const auto row = static_cast<Index>(parts_.point_tags.size());
    if (!node_row_.emplace(tag, row).second) {
      in_.fail("expected each node once, got node " + std::to_string(tag) + " again; export the file again");
    }
    parts_.point_tags.push_back(static_cast<Index>(tag));
  }

  /// A count that stands on a line of its own in text even where the section is binary (version 2).
  std::size_t text_count(std::size_t bytes_each, const char* what) {
    const bool binary = in_.is_binary();
    in_.use_text();
    const std::size_t n = in_.count(size_type, bytes_each, what);
    if (binary) {
      in_.line();
      in_.use_binary(swap_);
    }
    return n;
  }

  void read_nodes_2() {
    const std::size_t n = text_count(in_.least_bytes(int_type) + 3 * in_.least_bytes(real_type), "a number of nodes");
    for (std::size_t i = 0; i < n; ++i) {
      add_node(in_.integer(int_type, "a node number"));
      parts_.points.push_back(in_.point(real_type));
    }
  }

  void read_nodes_4() {
    const std::size_t blocks = in_.count(size_type, 4 * in_.least_bytes(int_type), "a number of node blocks");
    const std::int64_t total = take_total();
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::int64_t dimension = in_.integer(int_type, "an entity dimension");
      in_.integer(int_type, "an entity tag");
      const bool parametric = in_.integer(int_type, "0 or 1 for parametric coordinates") != 0;
      if (dimension < 0 || dimension > 3) in_.fail("expected an entity dimension from 0 to 3; the file is damaged");
      const std::size_t n =
          in_.count(size_type, in_.least_bytes(size_type) + 3 * in_.least_bytes(real_type), "a number of nodes");
      for (std::size_t i = 0; i < n; ++i) add_node(in_.integer(size_type, "a node tag"));
      for (std::size_t i = 0; i < n; ++i) {
        parts_.points.push_back(in_.point(real_type));
        if (parametric) in_.skip_numbers(static_cast<std::size_t>(dimension), real_type);
      }
    }
    require_total(total, parts_.points.size(), "nodes");
  }

  std::int64_t take_total() {
    const std::int64_t total = in_.integer(size_type, "a total");
    in_.skip_numbers(2, size_type);  // least and largest tag
    return total;
  }

  void require_total(std::int64_t total, std::size_t read, const char* what) {
    if (static_cast<std::uint64_t>(total) == read) return;
    in_.fail("expected " + std::to_string(total) + ' ' + what + " in all, got " + std::to_string(read) +
             " in the blocks; the file is damaged: export it again");
  }

  struct ElementType {
    CellType cell;
    int dimension, nodes;  // the corners first
  };

  ElementType element_type(std::int64_t number) {
    static constexpr std::pair<int, ElementType> known[] = {
        {1, {CellType::line, 1, 2}},         {2, {CellType::triangle, 2, 3}},     {3, {CellType::quad, 2, 4}},
        {4, {CellType::tetrahedron, 3, 4}},  {5, {CellType::hexahedron, 3, 8}},   {6, {CellType::wedge, 3, 6}},
        {7, {CellType::pyramid, 3, 5}},      {15, {CellType::atom, 0, 1}},        {8, {CellType::line, 1, 3}},
        {9, {CellType::triangle, 2, 6}},     {10, {CellType::quad, 2, 9}},        {11, {CellType::tetrahedron, 3, 10}},
        {12, {CellType::hexahedron, 3, 27}}, {13, {CellType::wedge, 3, 18}},      {14, {CellType::pyramid, 3, 14}},
        {16, {CellType::quad, 2, 8}},        {17, {CellType::hexahedron, 3, 20}}, {18, {CellType::wedge, 3, 15}},
        {19, {CellType::pyramid, 3, 13}},
    };
    for (const auto& [row, type] : known) {
      if (row == number) return type;
    }
    in_.fail("expected elements of first or second order (types 1 to 19), got type " + std::to_string(number) +
             (number > 19 && number < 140 ? ", of higher order" : "") +
             "; export the mesh with first-order elements (Gmsh: Mesh.ElementOrder = 1)");
  }

  Cell read_cell(const ElementType& type, std::int64_t tag) {
    Cell cell;
    cell.type = type.cell;
    const int corners = cell_size(type.cell);
    cell.particles.reserve(static_cast<std::size_t>(corners));
    for (int k = 0; k < corners; ++k) {
      const std::int64_t node = in_.integer(major_ == 4 ? size_type : int_type, "a node tag");
      const auto found = node_row_.find(node);
      if (found == node_row_.end()) {
        in_.fail("expected the tag of a node in $Nodes, got " + std::to_string(node) + " in element " +
                 std::to_string(tag) + "; export the file again");
      }
      cell.particles.push_back(found->second);
    }
    in_.skip_numbers(static_cast<std::size_t>(type.nodes - corners), major_ == 4 ? size_type : int_type);
    return cell;
  }

  void read_elements_4() {
    const std::size_t blocks = in_.count(size_type, 4 * in_.least_bytes(int_type), "a number of element blocks");
    const std::int64_t total = take_total();
    for (std::size_t b = 0; b < blocks; ++b) {
      in_.integer(int_type, "an entity dimension");
      const std::int64_t entity = in_.integer(int_type, "an entity tag");
      const ElementType type = element_type(in_.integer(int_type, "an element type"));
      const auto numbers = static_cast<std::size_t>(1 + type.nodes);
      const std::size_t n = in_.count(size_type, numbers * in_.least_bytes(size_type), "a number of elements");
      const auto groups = entity_groups_.find({type.dimension, entity});
      // A small file must not take much memory: at most 64 bytes for each of its own.
      if (groups != entity_groups_.end()) memberships_ += n * groups->second.size();
      if (memberships_ / 16 > in_.position() + in_.remaining()) {
        in_.fail("expected elements in at most 16 physical groups for each byte of the file; the file is damaged");
      }
      for (std::size_t i = 0; i < n; ++i) {
        const std::int64_t tag = in_.integer(size_type, "an element tag");
        const auto row = static_cast<Index>(parts_.cells.size());
        add_cell(read_cell(type, tag), type, tag);
        if (groups == entity_groups_.end()) continue;
        for (const std::int64_t physical : groups->second) group_cells_[{type.dimension, physical}].push_back(row);
      }
    }
    require_total(total, parts_.cells.size(), "elements");
  }

  void add_cell(Cell cell, const ElementType& type, std::int64_t tag) {
    parts_.higher_order += type.nodes != cell_size(type.cell);
    const bool fits = tag >= 0 && tag <= std::numeric_limits<Index>::max();
    parts_.cells.push_back(std::move(cell));
    parts_.cell_tags.push_back(fits ? static_cast<Index>(tag) : -1);
  }

  void read_elements_2() {
    const std::size_t n = text_count(in_.least_bytes(int_type), "a number of elements");
    for (std::size_t done = 0; done < n;) {
      if (in_.is_binary()) {  // blocks of elements of one type: type, how many, how many tags
        const std::int64_t type = in_.integer(int_type, "an element type");
        const std::size_t block = in_.count(int_type, 2 * size_of(int_type), "a number of elements");
        const std::size_t tags = in_.count(int_type, size_of(int_type), "a number of tags");
        if (block == 0 || block > n - done) in_.fail("expected element blocks that add up to $Elements' count");
        for (std::size_t i = 0; i < block; ++i) {
          const std::int64_t number = in_.integer(int_type, "an element number");
          read_element_2(number, element_type(type), tags);
        }
        done += block;
      } else {
        const std::int64_t number = in_.integer(int_type, "an element number");
        const ElementType type = element_type(in_.integer(int_type, "an element type"));
        // Version 1 has no number of tags: a physical and an elementary one, then the number of nodes.
        read_element_2(number, type, major_ == 1 ? 2 : in_.count(int_type, 2, "a number of tags"));
        in_.expect_line_end("an element");
        ++done;
      }
    }
  }

  /// Version 2 writes an element once for every physical group it is in; here it becomes one cell of several groups.
  void read_element_2(std::int64_t number, ElementType type, std::size_t tags) {
    const std::int64_t physical = tags > 0 ? std::abs(in_.integer(int_type, "a physical tag")) : 0;
    if (tags > 1) in_.skip_numbers(tags - 1, int_type);
    if (major_ == 1 && in_.integer(int_type, "a number of nodes") != type.nodes) {
      in_.fail("expected " + std::to_string(type.nodes) + " nodes of an element of its type; the file is damaged");
    }
    Cell cell = read_cell(type, number);
    const auto [known, is_new] =
        cell_row_.emplace(std::pair(type.cell, cell.particles), static_cast<Index>(parts_.cells.size()));
    if (is_new) add_cell(std::move(cell), type, number);
    if (physical == 0) return;
    std::vector<Index>& members = group_cells_[{type.dimension, physical}];
    if (members.empty() || members.back() != known->second) members.push_back(known->second);
  }

  void name_groups() {
    static constexpr std::array<const char*, 4> kind{"point ", "curve ", "surface ", "volume "};
    for (auto& [key, cells] : group_cells_) {
      const auto named = names_.find(key);
      MeshGroup group;
      group.name = named != names_.end() ? named->second
                                         : kind[static_cast<std::size_t>(key.first)] + std::to_string(key.second);
      group.cells = std::move(cells);
      parts_.groups.push_back(std::move(group));
    }
    for (const auto& [key, name] : names_) {
      if (!group_cells_.contains(key)) parts_.groups.push_back({name, {}, {}});
    }
  }

  ByteSource in_;
  MeshParts parts_;
  int major_ = 0;
  bool swap_ = false;  // a binary file of the other byte order
  bool has_nodes_ = false;
  bool has_elements_ = false;
  std::map<GroupKey, std::string> names_;
  std::map<GroupKey, std::vector<std::int64_t>> entity_groups_;  // per dimension and entity tag
  std::map<GroupKey, std::vector<Index>> group_cells_;
  std::size_t memberships_ = 0;  // of elements in physical groups, version 4
  std::unordered_map<std::int64_t, Index> node_row_;
  std::map<std::pair<CellType, std::vector<Index>>, Index> cell_row_;  // version 2 only
};

}  // namespace

MeshParts read_gmsh(const std::string& path, std::string_view bytes) {
  return GmshReader(path, bytes).read();
}

}  // namespace phymul
