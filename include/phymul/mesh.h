// SPDX-License-Identifier: MIT
//
// Tetrahedral, hexahedral, wedge and pyramid meshes from the file formats of meshers.
#pragma once

#include <phymul/model.h>

#include <string>

namespace phymul {

struct MeshOptions {
  double length_unit = 1.0;                      ///< metres per file unit
  double default_mass = 1.0;                     ///< kg per particle, until set_material
  double default_stiffness = 1.0;                ///< N/m per particle
  std::size_t max_bytes = std::size_t{4} << 30;  ///< larger files are refused
};

/// Reads by extension and content: Gmsh .msh (1, 2.2 and 4.1, text and binary), legacy .vtk and XML .vtu unstructured
/// grids (text, base64 and raw binary, zlib). Of cells of second order the corners are taken. In a mesh with volumes,
/// faces, lines and points that are not part of a volume are left out. Points no cell uses are dropped. Notes have the
/// numbers of all these. Physical groups of a .msh become named groups. Cells are oriented and checked (check.h).
/// Meshes have neither masses nor stiffnesses: the defaults are taken, and noted in Model::notes with their values.
/// Throws Error.
Model read_mesh(const std::string& path, const MeshOptions& options = {});

}  // namespace phymul
