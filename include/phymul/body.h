// SPDX-License-Identifier: MIT
//
// Bodies of tetrahedra from a closed surface, as segmentation gives it, or from a solid that a function describes.
#pragma once

#include <phymul/model.h>

#include <array>
#include <functional>
#include <string>
#include <vector>

namespace phymul {

/// A surface of triangles. It bounds a body if it is closed and all triangles have the same winding.
struct Surface {
  VecList vertices;                             ///< m
  std::vector<std::array<Index, 3>> triangles;  ///< rows of vertices, counter-clockwise seen from outside
  std::vector<std::string> notes;               ///< what reading and checking found or mended, one sentence each
};

/// Makes the surface one that bounds a body: merges vertices closer than a millionth of its size, drops triangles with
/// a repeated corner and vertices without a triangle, turns triangles until all are counter-clockwise seen from outside
/// (a cavity's, seen from within it). Several shells may lie apart, touch or lie in each other. Surface::notes lists
/// the changes and shells that enclose nothing, and says if the size is not between 1 mm and 1 m. Throws Error, and
/// changes nothing, if a coordinate is not finite, an index is out of range, an edge is open, the surface is one-sided
/// or triangles cross.
void mend_surface(Surface& surface);

/// A solid that a function describes: `distance` is negative inside, positive outside and continuous. It need not be a
/// true distance.
struct Solid {
  std::function<double(const Vec3&)> distance;  ///< at a place, m
  Vec3 low{0, 0, 0}, high{0, 0, 0};             ///< m, opposite corners of its box; parts outside the box are cut off
};

/// Balls, ellipsoids, capsules (within `radius` of the segment from a to b) and boxes; lengths in m. They throw Error
/// for a size that is not above 0 and finite.
Solid solid_ball(const Vec3& centre, double radius);
Solid solid_ellipsoid(const Vec3& centre, const Vec3& semi_axes);
Solid solid_capsule(const Vec3& a, const Vec3& b, double radius);
Solid solid_box(const Vec3& low, const Vec3& high);
/// The inside of a surface, mended as by mend_surface(), with the true distance to its triangles. Throws Error as
/// mend_surface() does, if shells touch along an edge or overlap by more than 1/64 of the size, and for a triangle
/// without area.
Solid solid_within(Surface surface);
/// Union, intersection, and `solid` without `hole`. They throw Error for an empty list, function or box.
Solid solid_union(std::vector<Solid> solids);
Solid solid_intersection(std::vector<Solid> solids);
Solid solid_difference(Solid solid, Solid hole);

/// Spacing at a place of the rest shape; both in m.
using SpacingField = std::function<double(const Vec3& place)>;

/// A field with the spacing `fine` within `radius` of a place. Outside, the spacing grows by `growth` metres per metre
/// of distance, up to `coarse`. For several places take the minimum of their fields. Throws Error for a place that is
/// not finite, for a radius or growth that is not above 0 and finite, and unless 0 < fine <= coarse, both finite.
SpacingField fine_near(const Vec3& place, double radius, double fine, double coarse, double growth = 0.5);

struct BodyOptions {
  double spacing = 0.0;              ///< m, > 0: mean distance between neighbours inside the coarsest parts of the body
  double most_volume_error = 0.05;   ///< > 0, share of the wanted volume; make_body() throws Error for a larger error
  Index most_particles = 1'000'000;  ///< make_body() throws Error if the spacing needs more
  /// Asks for a finer spacing in parts of the body. There make_body() halves `spacing` up to three times, until it is
  /// at most the value of the field. Values above `spacing` count as `spacing`. The field is sampled in the shape's box
  /// and up to two spacings outside of it, some tenths of the local spacing apart; smaller details may be missed.
  /// Empty: `spacing` everywhere. make_body() throws Error for a value that is not finite or is below spacing / 8.
  SpacingField spacing_at{};
};

/// What make_body() made of one region of a labelled image (labels.h).
struct RegionReport {
  std::string name;
  double wanted_volume = 0.0;  ///< m^3, of its voxels
  double volume = 0.0;         ///< m^3, of its cells
  Index cells = 0;
  Index particles = 0;  ///< of its cells; those on the boundary of two regions count in both
};

/// What make_body() made.
struct BodyReport {
  Index particles = 0, cells = 0;
  int parts = 0;                      ///< connected parts of the body
  double volume = 0.0;                ///< m^3, of the body
  double wanted_volume = 0.0;         ///< m^3, inside the surface or solid
  double unmoved_volume = 0.0;        ///< m^3, of the body before its surface was moved to meet the volume
  double moved = 0.0;                 ///< m, largest outward shift of the surface to meet the volume; negative: inward
  double smallest_angle = 0.0;        ///< degrees, of the dihedral angles of all cells
  double largest_angle = 0.0;         ///< degrees
  double smallest_spacing = 0.0;      ///< m, of the finest part of the lattice
  double largest_spacing = 0.0;       ///< m, of the coarsest part
  std::vector<RegionReport> regions;  ///< of a labelled image, in the order of the options; else empty
};

/// Fills the inside with tetrahedra by isosurface stuffing (F. Labelle, J. R. Shewchuk, 2007): points of a body-centred
/// cubic lattice near the surface move onto it, and tetrahedra are cut where the surface still crosses them. Particles
/// inside have the lattice's 14 neighbours, the others those that they share a tetrahedron with. Dihedral angles stay
/// between about 10 and 165 degrees. Flat triangles cut off volume where the surface is curved. Therefore the surface
/// is then moved outward, by the same distance everywhere and at most 5 % of the spacing, until the volume is met.
/// Edges are rounded off within a spacing, and parts thinner than the spacing are lost. Of a Surface, notes name the
/// parts farther from the body than the spacing asked for there, and say if the surface of the body has another number
/// of shells or another Euler number, because narrow walls or gaps were fused. Mass and stiffness are 1 until
/// set_material. The group "surface" holds the particles on the surface.
///
/// With BodyOptions::spacing_at the lattice is that of a balanced octree (the same paper, section 3): neighbouring
/// leaves differ by a factor of 2 at most, and tetrahedra share whole faces. With and without, cells with an angle
/// below 15 degrees at the surface are improved by moving their particles (particles on the surface move along it). The
/// outward shift of the surface is proportional to the square of the local spacing, and at most 5 % of the coarsest
/// spacing that the surface has. If the field asks for `spacing` everywhere, the body is bitwise equal to the one
/// without a field.
///
/// A Surface is first mended as by mend_surface(); Model::notes has its notes, and says if the body has several parts.
/// Throws Error as mend_surface() does, for an option out of range, if a distance is NaN, and if the error of the
/// volume is above most_volume_error: parts of the shape are then thinner than the spacing, or its edges and corners
/// are a large share of it; the message says which. Fills `report` if not null.
Model make_body(const Surface& surface, const BodyOptions& options, BodyReport* report = nullptr);
Model make_body(const Solid& solid, const BodyOptions& options, BodyReport* report = nullptr);

/// Where a blade went, in the rest shape.
struct CutSurface {
  std::function<double(const Vec3&)> distance;  ///< m, signed, to the surface that its edge swept; continuous
  /// m, signed, to the edge: below 0 behind it, where the surface has been cut. Empty: everywhere.
  std::function<double(const Vec3&)> front;
};
CutSurface cut_plane(const Vec3& point, const Vec3& normal);  ///< throws Error for a normal that is 0 or not finite

/// A body of tetrahedra or walls with a cut, by virtual nodes. Nothing of the mesh moves: a cell that the surface
/// crosses behind the front becomes two over the same places, each with its Cell::share of the volume, and particles
/// get copies (after all particles there were) so that the two sides hold together as far as they do beside the cut.
/// Volume and mass are kept. `copies`, if not null, gets the particle that each added one copies. A body may be cut
/// again, up to three times through a cell. A particle within a tenth of its shortest edge of the surface lies on it; a
/// cell is cut when the edge, led by 0.3 spacings, passes the middle of its section. Groups get the copies of particles
/// that lie on the surface. Of copies the one with the particle's number is that on its own side of the cut; the others
/// only carry their cells. Under Scene::contacts the faces of the cut touch; tools go through them. Set the materials
/// before. Triangles of walls are cut as tetrahedra are; a clamped edge (clamp_edges) that is crossed is free there.
/// Throws Error (not_supported) where a cell that fills space is no tetrahedron, or would be cut a fourth time, and for
/// a distance that is not finite.
Model cut_body(Model model, const CutSurface& cut, std::vector<Index>* copies = nullptr);

/// The same body with room for the copies of so many particles, which cuts of a running Simulation need: particles
/// without mass, cell and neighbour, after all others. About 2.3 are used for each square spacing of cut surface, and
/// for each spacing of a cut through a wall. They are particles like others in every state, picture and file, and rest
/// at the place of the first one until a cut uses them; Model::particles_in() and displacement_norms() leave them out.
/// Throws Error for a negative number and a body without cells.
Model with_spare_particles(Model model, Index count);

}  // namespace phymul
