// SPDX-License-Identifier: MIT
//
// What a mesh file reader hands over, whatever the format, and its way into a Model.
#pragma once

#include <phymul/mesh.h>
#include <phymul/model.h>

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace phymul {

struct MeshGroup {
  std::string name;
  std::vector<Index> cells;   ///< rows of MeshParts::cells
  std::vector<Index> points;  ///< rows of MeshParts::points
};

struct MeshParts {
  std::string source;             ///< file name, for messages
  VecList points;                 ///< [P] file units
  std::vector<Index> point_tags;  ///< [P] the file's own numbers of the points; empty: they are the rows
  std::vector<Cell> cells;        ///< particles are rows of points, checked to be in range
  std::vector<Index> cell_tags;   ///< [cells] or empty: the file's own numbers of the cells; -1: none
  std::vector<MeshGroup> groups;
  std::vector<std::string> notes;
  std::map<std::string, std::size_t> left_out;  ///< cells that are no volume and not read, by kind
  std::size_t higher_order = 0;                 ///< cells of which the corners alone were taken
};

/// What read_mesh does, with a file already in memory. `source` stands for its name.
Model mesh_from_bytes(const std::string& source, std::string_view bytes, const MeshOptions& options);

/// Drops points that no cell uses, makes neighbours, masses and groups, validates and checks. Throws Error.
Model assemble(MeshParts parts, const MeshOptions& options);

MeshParts read_gmsh(const std::string& path, std::string_view bytes);
MeshParts read_vtk_legacy(const std::string& path, std::string_view bytes);
MeshParts read_vtu(const std::string& path, std::string_view bytes);

}  // namespace phymul
