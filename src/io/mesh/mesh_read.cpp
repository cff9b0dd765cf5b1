// SPDX-License-Identifier: MIT
//
// Picks the reader by content, and turns what it read into a checked Model.
#include <phymul/check.h>
#include <phymul/error.h>
#include <phymul/mesh.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <new>
#include <stdexcept>

#include "base/byte_source.h"
#include "base/decimal.h"
#include "base/files.h"
#include "io/xml/xml_source.h"
#include "mesh_parts.h"
#include "model/file_extras.h"

namespace phymul {
namespace {

bool holds_points_only(CellType type) {
  return type == CellType::atom || type == CellType::poly_vertex;
}

bool has_volume(const MeshParts& parts) {
  return std::ranges::any_of(parts.cells, [](const Cell& cell) { return is_volume(cell.type); });
}

/// Row in the model of each point, -1 for those that no volume uses; in a mesh without volumes, no line or face. A
/// point that only vertex cells use counts as unused: meshers write such for the centres of arcs and other construction
/// points.
std::vector<Index> number_used_points(const MeshParts& parts, Index& used) {
  std::vector<Index> row(parts.points.size(), -1);
  const bool volumes_alone = has_volume(parts);
  for (const Cell& cell : parts.cells) {
    if (volumes_alone ? !is_volume(cell.type) : holds_points_only(cell.type)) continue;
    for (const Index p : cell.particles) row[p] = 0;
  }
  used = 0;
  for (Index& r : row) {
    if (r == 0) r = used++;
  }
  return row;
}

void note_dropped_points(MeshParts& parts, const std::vector<Index>& row, Index used) {
  const std::size_t dropped = row.size() - static_cast<std::size_t>(used);
  if (dropped == 0) return;
  std::string listed;
  std::size_t shown = 0;
  for (std::size_t p = 0; p < row.size() && shown < 5; ++p) {
    if (row[p] >= 0) continue;
    listed +=
        (shown++ ? ", " : "") + std::to_string(parts.point_tags.empty() ? static_cast<Index>(p) : parts.point_tags[p]);
  }
  if (dropped > shown) listed += ", ...";
  parts.notes.push_back(parts.source + ": " + std::to_string(dropped) + " of " + std::to_string(row.size()) +
                        " points are in no cell and were dropped (" + listed + ")");
}

/// "2 line, 1 polygon".
std::string kinds_left_out(const MeshParts& parts) {
  std::string text;
  for (const auto& [kind, n] : parts.left_out) text += (text.empty() ? "" : ", ") + std::to_string(n) + ' ' + kind;
  return text;
}

/// Renumbers the cells' points and drops cells over dropped points, counted by kind. Returns the new row of each cell,
/// or -1.
std::vector<Index> move_cells(MeshParts& parts, const std::vector<Index>& row, std::vector<Cell>& cells) {
  std::vector<Index> cell_row(parts.cells.size(), -1);
  for (std::size_t c = 0; c < parts.cells.size(); ++c) {
    Cell& cell = parts.cells[c];
    for (Index& p : cell.particles) p = row[p];
    if (std::find(cell.particles.begin(), cell.particles.end(), -1) != cell.particles.end()) {
      ++parts.left_out[lower_case(cell_name(cell.type))];
      continue;
    }
    cell_row[c] = static_cast<Index>(cells.size());
    cells.push_back(std::move(cell));
  }
  return cell_row;
}

std::vector<Index> renumber(const std::vector<Index>& items, const std::vector<Index>& row) {
  std::vector<Index> result;
  for (const Index item : items) {
    if (row[item] >= 0) result.push_back(row[item]);
  }
  return result;
}

/// The first of "Elements", "Elements 2" and so on that no group has: components of one name are one group.
std::string name_of_all(const std::vector<MeshGroup>& groups) {
  std::string name = "Elements";
  for (int k = 2; std::ranges::find(groups, name, &MeshGroup::name) != groups.end(); ++k) {
    name = "Elements " + std::to_string(k);
  }
  return name;
}

void add_components(const MeshParts& parts, const std::vector<Index>& point_row, const std::vector<Index>& cell_row,
                    Model& model) {
  Component body{.name = name_of_all(parts.groups)};
  if (body.name != "Elements") {
    model.notes.push_back(parts.source + ": the component of all cells is called " + cited(body.name) +
                          ", because a group is called \"Elements\"");
  }
  for (std::size_t c = 0; c < model.cells.size(); ++c) body.cells.push_back(static_cast<Index>(c));
  model.components.push_back(std::move(body));
  for (const MeshGroup& group : parts.groups) {
    Component component{.name = group.name,
                        .exclusive = false,
                        .cell_refs = renumber(group.cells, cell_row),
                        .particles = renumber(group.points, point_row)};
    if (component.cell_refs.empty() && component.particles.empty()) {
      model.notes.push_back(parts.source + ": group " + cited(group.name) + " has no elements and was left out");
      continue;
    }
    model.components.push_back(std::move(component));
  }
}

/// Faces in the plane z = 0 alone make a two-dimensional body.
bool is_planar(const Model& model) {
  return std::none_of(model.cells.begin(), model.cells.end(), [](const Cell& cell) { return is_volume(cell.type); }) &&
         std::all_of(model.rest.begin(), model.rest.end(), [](const Vec3& x) { return x.z() == 0.0; });
}

[[noreturn]] void refuse_content(const std::string& path, std::string_view start) {
  const std::string extension = file_ending(path);
  std::string expected = "$MeshFormat (Gmsh .msh), # vtk DataFile (legacy .vtk) or <VTKFile (.vtu)";
  if (extension == ".msh") expected = "$MeshFormat, as a Gmsh .msh file has it";
  if (extension == ".vtk") expected = "# vtk DataFile, as a legacy .vtk file has it";
  if (extension == ".vtu") expected = "<VTKFile, as a .vtu file has it";
  fail_format(path, 1,
              "expected " + expected + ", got " +
                  (start.empty() ? "an empty file" : cited(start.substr(0, start.find_first_of("\r\n")))) +
                  "; export the mesh as .msh 4.1, .vtk or .vtu" +
                  (extension == ".pml" ? ", or read it with read_pml" : ""));
}

MeshParts read_parts(const std::string& path, std::string_view bytes) {
  std::string_view start = bytes;
  if (start.starts_with("\xEF\xBB\xBF")) start.remove_prefix(3);
  while (!start.empty() && std::isspace(static_cast<unsigned char>(start.front()))) start.remove_prefix(1);
  if (start.starts_with('$')) return read_gmsh(path, bytes);
  if (start.starts_with("# vtk DataFile")) return read_vtk_legacy(path, bytes);
  if (start.starts_with('<') && start.substr(0, 4096).find("<VTKFile") != std::string_view::npos) {
    return read_vtu(path, bytes);
  }
  refuse_content(path, start);
}

}  // namespace

Model assemble(MeshParts parts, const MeshOptions& options) {
  Index used = 0;
  const std::vector<Index> point_row = number_used_points(parts, used);
  if (used == 0 || (!parts.left_out.empty() && !has_volume(parts))) {
    fail_format(parts.source, 0,
                "expected cells (tetrahedra, hexahedra, wedges, pyramids, faces of 3 or 4 corners, or lines), got " +
                    (parts.left_out.empty() ? "none" : kinds_left_out(parts)) + "; mesh the volume before exporting");
  }
  note_dropped_points(parts, point_row, used);

  Model model;
  FileExtras extras;
  model.name = std::filesystem::path(parts.source).stem().string();
  for (MeshGroup& group : parts.groups) group.name = as_utf8(std::move(group.name));  // some writers use Latin-1
  const bool numbered = !parts.point_tags.empty() || used != static_cast<Index>(parts.points.size());
  for (std::size_t p = 0; p < point_row.size(); ++p) {
    if (point_row[p] < 0) continue;
    model.rest.push_back(parts.points[p] * options.length_unit);
    if (numbered)
      extras.particle_index.push_back(parts.point_tags.empty() ? static_cast<Index>(p) : parts.point_tags[p]);
  }
  const std::vector<Index> cell_row = move_cells(parts, point_row, model.cells);
  if (!parts.left_out.empty()) {
    parts.notes.push_back(parts.source + ": cells that are no volume and not part of one were left out (" +
                          kinds_left_out(parts) + ")");
  }
  if (parts.higher_order > 0) {
    parts.notes.push_back(parts.source + ": cells of second or higher order (" + std::to_string(parts.higher_order) +
                          "): their corners were taken and the points between left out; curved edges are straight");
  }
  for (std::size_t c = 0; c < parts.cell_tags.size(); ++c) {
    if (cell_row[c] >= 0) extras.cell_index.push_back(parts.cell_tags[c]);
  }
  model.extras = std::move(extras).share();
  model.notes = std::move(parts.notes);
  model.notes.push_back(parts.source + ": a mesh has no masses and no stiffness: " + to_decimal(options.default_mass) +
                        " kg and " + to_decimal(options.default_stiffness) +
                        " N/m a particle are assumed (MeshOptions), until set_material gives others");
  add_components(parts, point_row, cell_row, model);
  if (is_planar(model)) model.dimension = 2;
  model.mass.assign(model.rest.size(), options.default_mass);
  model.stiffness.assign(model.rest.size(), options.default_stiffness);
  model.neighbours = neighbours_from_cells(model.cells, model.particle_count());
  validate(model);
  check_mesh(model, parts.source);
  return model;
}

Model mesh_from_bytes(const std::string& source, std::string_view bytes, const MeshOptions& options) {
  const auto require = [](bool right, const char* what, double got) {
    if (!right || !std::isfinite(got))
      throw Error(std::string("read_mesh: expected ") + what + ", got " + to_decimal(got));
  };
  require(options.length_unit > 0.0, "a length_unit above 0 (metres per file unit)", options.length_unit);
  require(options.default_mass > 0.0, "a default_mass above 0 kg", options.default_mass);
  require(options.default_stiffness >= 0.0, "a default_stiffness of 0 N/m or more", options.default_stiffness);
  try {
    return reading(source, [&] { return assemble(read_parts(source, bytes), options); });
  } catch (const std::bad_alloc&) {
    fail_memory(source);
  } catch (const std::length_error&) {
    fail_memory(source);
  }
}

Model read_mesh(const std::string& path, const MeshOptions& options) {
  return mesh_from_bytes(path, read_whole_file(path, options.max_bytes), options);
}

}  // namespace phymul
