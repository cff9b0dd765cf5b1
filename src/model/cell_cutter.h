// SPDX-License-Identifier: MIT
//
// Cuts by virtual nodes: a cut cell becomes two cells over the same places, each with its share of the volume, and a
// particle gets a copy for each group of parts around it that the cut leaves connected (N. Molino, Z. Bao, R. Fedkiw,
// "A virtual node algorithm for changing mesh topology during simulation", ACM Trans. Graph. 23 (2004) 385-392; here
// parts count by their share, so that neither mass nor stiffness doubles and the stable step stays). Triangles of walls
// are cut as tetrahedra are: their sides are edges in place of faces.
#pragma once

#include <phymul/body_cut.h>

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

namespace phymul {

/// Spacings by which the front is ahead of the blade. Cells part as wholes: without it slits are too short by 0.25 to
/// 0.4 spacings.
constexpr double lead_of_front = 0.3;
/// Of the shortest edge at a particle: the surface passes through one that is nearer. Thinner parts would be whipped
/// about by what they hang on.
constexpr double on_cut_surface = 0.1;

/// A body as a cut finds it.
struct CutBody {
  const Model& model;
  const std::vector<std::vector<Index>>&
      cells_of;                     ///< [N] rows of its tissue (is_tissue), ascending; removed ones are passed over
  const std::vector<double>& mass;  ///< [N] kg, while no cell is removed
  std::function<double(Index row)> mass_of_corner;  ///< kg, of a corner of this cell, while no cell is removed
  std::function<Index(std::size_t)> spare;          ///< particle for the copy of this number
};

/// Where a blade went.
struct CutCells {
  std::span<const Index> cells;           ///< that it may have crossed: rows of tissue, ascending
  std::function<double(Index)> distance;  ///< of a particle from the surface, signed; 0: it passes through
  /// Whether the edge has passed the middle of a section, whose barycentric coordinates these are: of a triangle the
  /// first three.
  std::function<bool(Index row, const Eigen::Vector4d& middle)> passed;
  const char* who = "cut_body";  ///< begins messages
  /// Not null: what it would throw for is left as it is, and the cells are counted here.
  std::size_t* refused = nullptr;
};

/// Particles without mass, neighbours and cell after all that have one (with_spare_particles), ascending.
std::vector<Index> spare_particles_of(const Model& model);

/// What it cuts; the body stays as it is. Throws Error (not_supported) for a cell that would be cut a fourth time.
BodyCut cut_cells(const CutBody& body, const CutCells& cut);

/// Makes a cut of the model, or undoes the last one that was made. Copies get or lose place, stiffness and groups, but
/// masses are left alone. `cells`: how many there were before; what was made in part can be undone, too, and undone
/// again.
void make_cut(const BodyCut& cut, Model& model);
void undo_cut(const BodyCut& cut, Model& model, std::size_t cells);

}  // namespace phymul
