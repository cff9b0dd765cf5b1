// SPDX-License-Identifier: MIT
//
// Model: shape, masses and materials of a body. Plain data. Any number of solvers may share a model that nobody
// changes. Made by read_pml (pml.h), read_mesh (mesh.h) or a shape builder (shapes.h).
#pragma once

#include <phymul/types.h>

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace phymul {

enum class CellType { atom, line, triangle, quad, tetrahedron, wedge, pyramid, hexahedron, poly_line, poly_vertex };

/// Number of particles of a cell of this type; 0 if any number is allowed (poly_line, poly_vertex).
int cell_size(CellType type);

/// True for tetrahedron, wedge, pyramid, hexahedron.
bool is_volume(CellType type);

/// Upper-case PML spelling ("HEXAHEDRON").
const char* cell_name(CellType type);

/// A named value of a file that phymul does not interpret, kept for writing it back.
struct Attribute {
  std::string name;
  std::string value;
  bool operator==(const Attribute&) const = default;
};

using Colour = std::array<double, 4>;  ///< red, green, blue, alpha in [0, 1]

using CellCut = std::array<double, 4>;  ///< of Cell::cuts

/// A geometric cell over particles. The order of vertices is that of PML (and of VTK, except for the wedge):
/// - tetrahedron (a, b, c, d): d is on the side to which (b-a) x (c-a) points.
/// - hexahedron: the ring 0-1-2-3, then 4-5-6-7 above it. "Above" is in the direction of the ring's right-hand normal.
/// - wedge: the triangle 0-1-2, then 3-4-5 above it.
/// - pyramid: the ring 0-1-2-3, then the apex 4 above it.
struct Cell {
  CellType type = CellType::tetrahedron;
  std::vector<Index> particles{};
  Index material = -1;        ///< row of Model::materials; -1: none
  Vec3 fibre = Vec3::Zero();  ///< direction of its fibres at rest, any length > 0; used where Material::fibre_ratio > 1
  std::string name{};
  std::vector<Attribute> attributes{};
  std::optional<Colour> colour{};
  /// Of its rest volume, filled by tissue: 1; less where it is part of a cut cell (cut_body); 0 once
  /// Simulation::remove_cells has removed it. A removed cell keeps its row, and is in no volume, mass, surface or law.
  double share = 1.0;
  /// Of a tetrahedron or a triangle of a wall, each cut through it: tissue is where the linear function with these
  /// values at its particles, m, is above 0. They make its share.
  std::vector<CellCut> cuts{};
  bool operator==(const Cell&) const = default;
};

/// A node of the tree of named parts (PML multiComponent and structuralComponent). In Model::components a parent comes
/// before its children.
struct Component {
  std::string name{};
  Index parent = -1;           ///< row of Model::components; -1: a root
  bool exclusive = true;       ///< true: one part of a partition of the body; false: a group that may overlap others
  bool structural = true;      ///< true: holds cells and particles; false: holds components only
  std::vector<Index> cells{};  ///< cells defined here, rows of Model::cells
  std::vector<Index> cell_refs{};  ///< cells defined elsewhere and referred to here
  std::vector<Index> particles{};  ///< particles referred to directly
  std::vector<Attribute> attributes{};
  std::optional<Colour> colour{};
  bool operator==(const Component&) const = default;
};

/// How the stress of a material rises beyond small strains: constants k, b, c, d of StrainEnergy::stiffening
/// (topology.h), without units. They change neither Young's modulus nor Poisson's ratio. All 0: neo-Hookean.
/// fit_material() finds them from a test.
struct Stiffening {
  double exponential = 0.0;   ///< k, >= 0: of the shear modulus, what grows exponentially (Demiray 1972)
  double exponent = 0.0;      ///< b, >= 0
  double second = 0.0;        ///< c: of the shear modulus, what the second invariant has (Mooney 1940, Rivlin 1948)
  double second_fades = 0.0;  ///< d, >= 0: that term falls to half where J^(-2/3) tr(F^T F) - 3 = 1 / d
  bool operator==(const Stiffening&) const = default;
};

/// Elastic material. The constants are those of small strains.
struct Material {
  double young = 0.0;    ///< Young's modulus, Pa, > 0
  double poisson = 0.0;  ///< Poisson's ratio, in (-1, 1/2)
  double density = 0.0;  ///< kg/m^3, > 0
  /// Young's modulus along the fibres (Cell::fibre), divided by `young`, the modulus of the tissue between them. 1: no
  /// fibres. The modulus across the fibres is young / (1 - poisson^2 (1 - 1 / fibre_ratio)). build_topology() throws
  /// Error below 1.
  double fibre_ratio = 1.0;

  // Dissipation (0: none). It depends on the change of strain, so it does not damp rigid motion. It needs
  // Law::particle_averaged. C is the elasticity tensor of young and poisson, E Green's strain (docs/theory/physics.md).
  /// s, >= 0. Kelvin-Voigt: a viscous stress of retardation_time * C : dE/dt. The loss factor of a small vibration of
  /// angular frequency w is w * retardation_time.
  double retardation_time = 0.0;
  /// >= 0. Standard linear solid: under a sudden strain the stiffness is (1 + relaxation_strength) times the long-term
  /// one, that of `young`; the difference decays as exp(-t / relaxation_time). Name: Nowick and Berry, Anelastic
  /// Relaxation in Crystalline Solids, 1972, ch. 3.
  double relaxation_strength = 0.0;
  double relaxation_time = 0.0;  ///< s; > 0 where relaxation_strength is

  /// m, >= 0. Above 0 the material is that of walls: of triangles in space (Law::walls), not of cells that fill it. A
  /// wall dissipates nothing, and has neither fibres nor stiffening.
  double thickness = 0.0;

  /// Beyond small strains. Not in a model that has fibres. set_material() throws Error if the stress of the material,
  /// as if it were incompressible, does not rise with every stretch of 0.6 to 1.7 and amount of shear up to 1.
  Stiffening stiffening{};
  bool operator==(const Material&) const = default;
};

/// Returns true if a position in the rest shape, m, is in a region of the body.
using Contains = std::function<bool(const Vec3&)>;

struct FileExtras;  // src/model/file_extras.h

struct Model {
  std::string name;
  int dimension = 3;  ///< 3, or 2: particles in the plane z = 0

  VecList rest;  ///< [N] rest positions, m
  /// [N] kg, > 0, or 0 where all cells around a particle are removed; overwritten by set_material.
  std::vector<double> mass;
  std::vector<double> stiffness;  ///< [N] shape stiffness k_i, N/m; unused if there are materials
  RaggedList neighbours;          ///< [N rows] neighbours of each particle, in order, without itself

  std::vector<Cell> cells;
  std::vector<Component> components;
  std::vector<Material> materials;  ///< if empty, stiffness is used; set_material adds them
  /// Largest share of the mass that set_material moves between particles of the same cells, >= 0; 0: none.
  double most_mass_moved = 0.03;

  /// Further content of the file, opaque: numbers and names of particles and cells, further attributes. It is needed
  /// only to write the file back without loss. Null for a built shape. Set it to null after adding or removing
  /// particles.
  std::shared_ptr<const FileExtras> extras;

  /// What reading and checking found or corrected, one sentence each ("file:line: ..."). Not part of equality.
  std::vector<std::string> notes;

  Index particle_count() const { return static_cast<Index>(rest.size()); }

  /// Particles of all components of this name and of the components in them, listed directly or by cells; sorted, each
  /// once. Throws Error, with the known names, for an unknown name.
  std::vector<Index> group(std::string_view group_name) const;
  bool has_group(std::string_view group_name) const;

  /// Those whose rest positions it accepts, sorted; without spare ones (with_spare_particles).
  std::vector<Index> particles_in(const Contains& contains) const;
  /// Rows of the cells, but those that are removed, whose centre (mean of their vertices) at these positions, [N] m, it
  /// accepts; at rest, where there are none. Where cells fill space or are of walls, of these alone: mesh files also
  /// have faces and edges of them. Throws Error for another number of positions.
  std::vector<Index> cells_in(const Contains& contains, std::span<const Vec3> position = {}) const;

  /// Adds a component with these particles, not exclusive; returns *this. Throws Error for an empty name or a particle
  /// out of range.
  Model& add_group(std::string group_name, std::vector<Index> particles);

  Index file_index(Index particle) const;   ///< number of the particle in its file; its row if it has none
  Index cell_file_index(Index cell) const;  ///< number of the cell in its file; -1: none

  bool operator==(const Model& other) const;  ///< everything but notes
};

/// Gives every volume cell the material, and every particle the mass density * (its share of the volume of its cells).
/// A cell's volume is divided evenly among its vertices. In 2-D the cells are triangles and quads, one metre thick. A
/// particle without such a cell keeps its mass, and Model::notes says so.
/// If a few light particles set the stable step alone, they then get mass from particles in the same cells, at most the
/// share Model::most_mass_moved of all mass; total mass, centre of mass and moments of inertia stay (mass scaling:
/// docs/theory/physics.md). Model::notes has the share and the estimated gain.
/// A material with a thickness is given to the triangles of a 3-D model in place of its volume cells (Law::walls): the
/// volume of a triangle is its area times the thickness. A quad becomes two triangles, along its shorter diagonal; the
/// second is a new row at the end of Model::cells.
/// In a body of points, which has no such cell, all particles get the material. The volume of a particle is that of its
/// Voronoi cell among its neighbours; Model::notes has the sum. If the body has no neighbours it gets
/// nearest_neighbours(rest, 20). Throws Error, and changes nothing, if the model is not valid, has a volume cell
/// without positive volume or a point in one plane with its neighbours, or if a constant is out of its range.
void set_material(Model& model, const Material& material);

/// The same for the cells of the group: the volume cells (2-D and walls: triangles, quads) that a component lists, as
/// for regions of a labelled image and physical groups of Gmsh, or, if it lists none, the cells whose particles are all
/// in it. Masses are then computed from all cells with a material. Throws Error also for an unknown group or one
/// without them.
void set_material(Model& model, const Material& material, std::string_view group_name);

/// The same for the cells whose centre (mean of their vertices) `contains` accepts. Their volume is close to that of
/// the region; a group of particles would have only the cells wholly in the region. Returns the volume of these cells,
/// m^3 (2-D: m^3 per metre of thickness), for comparison. Throws Error also if there is no such cell.
double set_material(Model& model, const Material& material, const Contains& contains);

/// True if a cell is a triangle in space whose material has a thickness (Law::walls).
bool has_walls(const Model& model);

/// Rest volume of a volume cell, m^3, by its trilinear map; negative if its vertices are in the opposite order. 0 for
/// other cells.
double cell_volume(const Model& model, const Cell& cell);

/// Mean rest distance between a particle and its neighbours, m: the "spacing", the unit of relative tolerances.
double mean_spacing(const Model& model);

/// Largest side of the bounding box of the rest shape, m.
double body_size(const Model& model);

/// Throws Error for the first fault. A valid model has a particle, arrays of equal sizes, indices in range, positive
/// finite masses (0 where all cells around are removed), finite coordinates (z = 0 in 2-D) and no negative stiffness.
/// All readers, builders and make_solver call it.
void validate(const Model& model);

/// Neighbours along the edges of cells, in increasing order. Throws Error if a cell has too few particles or one out of
/// range.
RaggedList neighbours_from_cells(const std::vector<Cell>& cells, Index particle_count);

/// Neighbours for particles without cells, in increasing order. Two particles are neighbours if one of them is among
/// the `count` nearest of the other; particles at the same distance as the last one count, too. `rest`: [N] m. Throws
/// Error unless 1 <= count < N and all positions are finite.
RaggedList nearest_neighbours(const VecList& rest, int count);

}  // namespace phymul
