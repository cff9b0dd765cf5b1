// SPDX-License-Identifier: MIT
//
// What a host's own renderer needs of a body: triangles of its surface, normals where it stands now, and which particle
// is under a pointer. (display.h draws without any of it.)
#pragma once

#include <phymul/model.h>

#include <array>
#include <span>
#include <vector>

namespace phymul {

/// Rows of particles, counter-clockwise seen from outside: the faces that exactly one volume cell has at rest; in a
/// model without volume cells its triangles and quads as they are wound; in 2-D its triangles and quads, seen from +z.
/// Quads are cut in two. Empty for a body of lines and points. They stay while the body moves: make them once, and draw
/// them with the positions of each frame.
std::vector<std::array<Index, 3>> surface_triangles(const Model& model);

/// A weighted mean of up to four particles; -1 and 0 after the last.
struct TissueVertex {
  std::array<Index, 4> particles{-1, -1, -1, -1};
  std::array<double, 4> weights{};
};

/// The surface of what cuts and removals have left of a body: its outer faces as far as they have tissue, and the faces
/// of cuts. Cracks are closed up to rounding, but where a cut ends inside a cell.
struct TissueSurface {
  std::vector<TissueVertex> vertices{};
  std::vector<std::array<Index, 3>> triangles{};     ///< rows of vertices, counter-clockwise seen from outside
  std::vector<char> of_cut{};                        ///< [triangles] 1: on a face of a cut
  VecList at(std::span<const Vec3> position) const;  ///< [vertices] m, for particles at [N] m
};
/// Make it anew after a cut. Throws Error for a model that is not valid, and for one in 2-D.
TissueSurface tissue_surface(const Model& model);

/// Unit normals, outward, for smooth shading: of each particle's triangles the mean, each as its area. Zero for a
/// particle of none, or whose triangles cancel. `normal` gets the size of `position`, [N] m; nothing is allocated where
/// it has it. Throws Error for a triangle of a particle that there is not.
void surface_normals(std::span<const std::array<Index, 3>> triangles, std::span<const Vec3> position, VecList& normal);

/// A line of sight, from the eye on: a pointer's, or a tool's.
struct PickRay {
  Vec3 origin{0, 0, 0};     ///< m
  Vec3 direction{0, 0, 1};  ///< of any length above 0
  double reach = 0.0;       ///< m around the line that still count as on it, at the origin
  double widening = 0.0;    ///< m that the reach grows by in each metre along the line, as pixels do in perspective
};

/// Of the particles in front of the origin and within reach of the ray the one nearest to the origin along it; -1:
/// there is none. Places, [N] m, that are not finite and particles without mass (spare ones, and where all cells are
/// removed) are passed over. Throws Error for a direction whose length is 0 or not finite, and for other than N places.
Index pick_particle(const Model& model, std::span<const Vec3> position, const PickRay& ray);

}  // namespace phymul
