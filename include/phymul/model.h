// SPDX-License-Identifier: MIT
//
// Model: what the tissue is. Plain data, const once built and checked, shared by any number of solvers.
// Made by read_pml (pml.h), read_mesh (mesh.h) or a shape builder (shapes.h).
#pragma once

#include <phymul/types.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace phymul {

enum class CellType { atom, line, triangle, quad, tetrahedron, wedge, pyramid, hexahedron, poly_line, poly_vertex };

/// Particles a cell of this type has; 0 where any number is allowed (poly_line, poly_vertex).
int cell_size(CellType type);

/// True for tetrahedron, wedge, pyramid, hexahedron.
bool is_volume(CellType type);

/// Upper-case PML spelling ("HEXAHEDRON").
const char* cell_name(CellType type);

/// A named value that a file carried and phymul does not interpret; kept so that writing loses nothing.
struct Attribute {
  std::string name;
  std::string value;
  bool operator==(const Attribute&) const = default;
};

using Colour = std::array<double, 4>;  ///< red, green, blue, alpha in [0, 1]

/// A geometric cell over particles. Vertex order, as PML has it (VTK's too, but for the wedge): tetrahedron (a,b,c,d)
/// has d on the side that (b-a) x (c-a) points to; hexahedron is the ring 0-1-2-3, then 4-5-6-7 above it; wedge is the
/// triangle 0-1-2, then 3-4-5 above it; pyramid is the ring 0-1-2-3, then the apex 4.
struct Cell {
  CellType type = CellType::tetrahedron;
  std::vector<Index> particles;
  Index material = -1;  ///< row of Model::materials; -1: none
  std::string name;
  std::vector<Attribute> attributes;
  std::optional<Colour> colour;
  bool operator==(const Cell&) const = default;
};

/// A node of the tree of named parts (PML multiComponent and structuralComponent), flattened: a parent
/// always stands before its children.
struct Component {
  std::string name;
  Index parent = -1;             ///< row of Model::components; -1: a root
  bool exclusive = true;         ///< true: part of the body's own partition; false: an overlapping group
  bool structural = true;        ///< true: holds cells and particles; false: holds components only
  std::vector<Index> cells;      ///< cells defined here, rows of Model::cells
  std::vector<Index> cell_refs;  ///< cells defined elsewhere and referred to here
  std::vector<Index> particles;  ///< particles referred to directly
  std::vector<Attribute> attributes;
  std::optional<Colour> colour;
  bool operator==(const Component&) const = default;
};

/// Isotropic elastic material; small-strain meaning of the constants.
struct Material {
  double young = 0.0;    ///< Young's modulus, Pa, > 0
  double poisson = 0.0;  ///< Poisson's ratio, in (-3/8, 1/2)
  double density = 0.0;  ///< kg/m^3, > 0
  bool operator==(const Material&) const = default;
};

struct FileExtras;  // src/model/file_extras.h

struct Model {
  std::string name;
  int dimension = 3;  ///< 3, or 2: particles in the plane z = 0

  VecList rest;                   ///< [N] rest positions, m
  std::vector<double> mass;       ///< [N] kg, > 0; overwritten by set_material
  std::vector<double> stiffness;  ///< [N] shape stiffness k_i, N/m; unused where a material is set
  RaggedList neighbours;          ///< [N rows] ordered neighbours of each particle, itself not among them

  std::vector<Cell> cells;
  std::vector<Component> components;
  std::vector<Material> materials;  ///< empty: stiffness holds; else see set_material

  /// What the file carried beside the model, opaque: numbers and names of particles and cells, further attributes. It
  /// is needed only to write the file back without loss. Null for a built shape. Set it to null after removing
  /// particles.
  std::shared_ptr<const FileExtras> extras;

  /// What reading and checking found or corrected, one sentence each ("file:line: ..."). Not part of equality.
  std::vector<std::string> notes;

  Index particle_count() const { return static_cast<Index>(rest.size()); }

  /// Particles of the component(s) of that name and of the components in them: referred to directly or through cells,
  /// sorted, unique.
  /// Throws Error that lists the known names.
  std::vector<Index> group(std::string_view group_name) const;
  bool has_group(std::string_view group_name) const;

  /// Adds an informative component that names these particles; returns *this.
  Model& add_group(std::string group_name, std::vector<Index> particles);

  Index file_index(Index particle) const;   ///< number of the particle in its file; its row if it has none
  Index cell_file_index(Index cell) const;  ///< number of the cell in its file; -1: none

  bool operator==(const Model& other) const;  ///< everything but notes
};

/// Gives every volume cell the material and every particle the mass density * (its share of the volume of the
/// cells around it). A share is the cell's volume divided evenly over its vertices; in 2-D triangles and quads stand
/// for a metre of thickness. A particle in no such cell keeps its mass, which is noted. Throws Error, and changes
/// nothing, when the model is not valid or has no volume cells, one of them has no positive volume, or a constant is
/// out of its range.
void set_material(Model& model, const Material& material);

/// The same for the cells all of whose particles are in the named group; masses are summed anew from all cells
/// that have a material.
void set_material(Model& model, const Material& material, std::string_view group_name);

/// Rest volume of a volume cell in m^3 (positive when wound as above); 0 for other cells. Hexahedra, wedges and
/// pyramids by their trilinear map.
double cell_volume(const Model& model, const Cell& cell);

/// Mean rest distance between a particle and its neighbours, m: the "spacing" h that relative tolerances use.
double mean_spacing(const Model& model);

/// Largest side of the bounding box of the rest shape, m.
double body_size(const Model& model);

/// Throws Error, naming the first offender, unless there is a particle, the arrays agree in size, every index is in
/// range, masses are positive and finite, coordinates finite (z = 0 in 2-D), stiffness not negative. Called by every
/// reader, builder and make_solver.
void validate(const Model& model);

/// Neighbours from cells: the edges of lines, triangles, quads, hexahedra, wedges and pyramids, all pairs of a
/// tetrahedron. Rows in increasing order. Throws Error when a cell has too few particles, or one out of range.
RaggedList neighbours_from_cells(const std::vector<Cell>& cells, Index particle_count);

}  // namespace phymul
