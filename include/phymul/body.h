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

/// A surface of triangles. Closed and wound one way it bounds a body.
struct Surface {
  VecList vertices;                             ///< m
  std::vector<std::array<Index, 3>> triangles;  ///< rows of vertices, counter-clockwise seen from outside
  std::vector<std::string> notes;               ///< what reading and checking found or mended, one sentence each
};

/// Makes the surface one that bounds a body: merges vertices closer than a millionth of its size, drops triangles with
/// a repeated corner and vertices without a triangle, turns triangles until all are counter-clockwise seen from outside
/// (a cavity's, seen from within it). Several shells may lie apart, touch or lie in each other. Surface::notes says
/// what was changed, and where the size is not between 1 mm and 1 m. Throws Error, and changes nothing, if a coordinate
/// is not finite, an edge is open, the surface has one side only or triangles cross.
void mend_surface(Surface& surface);

/// A solid that a function describes: `distance` is negative inside, positive outside and continuous. It need not be a
/// true distance.
struct Solid {
  std::function<double(const Vec3&)> distance;  ///< at a place, m
  Vec3 low{0, 0, 0}, high{0, 0, 0};             ///< m, opposite corners of its box: what lies out of it is cut off
};

/// Balls, ellipsoids, capsules (within `radius` of the segment from a to b) and boxes; lengths in m. Throw Error for a
/// size that is not above 0 and finite.
Solid solid_ball(const Vec3& centre, double radius);
Solid solid_ellipsoid(const Vec3& centre, const Vec3& semi_axes);
Solid solid_capsule(const Vec3& a, const Vec3& b, double radius);
Solid solid_box(const Vec3& low, const Vec3& high);
/// All that lies in one of them (in all of them; in the first but not in the second). Throws Error for an empty list.
Solid solid_union(std::vector<Solid> solids);
Solid solid_intersection(std::vector<Solid> solids);
Solid solid_difference(Solid solid, Solid hole);

/// Spacing at a place of the rest shape; both in m.
using SpacingField = std::function<double(const Vec3& place)>;

/// The field `fine` within `radius` of a place, which grows outside of it by `growth` metres per metre of distance, up
/// to `coarse`. The least of several such fields is fine at several places. Throws Error for a place that is not
/// finite, for a radius or growth that is not above 0 and finite, and unless 0 < fine <= coarse, both finite.
SpacingField fine_near(const Vec3& place, double radius, double fine, double coarse, double growth = 0.5);

struct BodyOptions {
  double spacing = 0.0;              ///< m, > 0: mean distance between neighbours inside the body, where coarsest
  double most_volume_error = 0.05;   ///< share of the volume asked for; a body that is further off is an Error
  Index most_particles = 1'000'000;  ///< a spacing that needs more is an Error
  /// Asks for a finer spacing in parts of the body. The body has `spacing` halved as often as needed to be at most what
  /// is asked, up to three times. Values above `spacing` count as `spacing`. It is asked at places in the shape's box
  /// and up to two spacings outside of it, some tenths of the local spacing apart: what is smaller may be missed.
  /// Empty: `spacing` everywhere. Throws Error for a value that is not above 0 or not finite, or below spacing / 8.
  SpacingField spacing_at{};
};

/// What make_body() made of one region of a labelled image (labels.h).
struct RegionReport {
  std::string name;
  double wanted_volume = 0.0;  ///< m^3, of its voxels
  double volume = 0.0;         ///< m^3, of its cells
  Index cells = 0;
  Index particles = 0;  ///< of its cells: those between two regions count in both
};

/// What make_body() made.
struct BodyReport {
  Index particles = 0, cells = 0;
  int parts = 0;                      ///< connected parts of the body
  double volume = 0.0;                ///< m^3, of the body
  double wanted_volume = 0.0;         ///< m^3, inside the surface or solid
  double moved = 0.0;                 ///< m, outward, by which the surface was moved to meet the volume, at most
  double smallest_angle = 0.0;        ///< degrees, of the dihedral angles of all cells
  double largest_angle = 0.0;         ///< degrees
  double smallest_spacing = 0.0;      ///< m, of the lattice where it is finest; where coarsest, the next
  double largest_spacing = 0.0;       ///< m
  std::vector<RegionReport> regions;  ///< of a labelled image, in the order of the options; else empty
};

/// Fills the inside with tetrahedra by isosurface stuffing (F. Labelle, J. R. Shewchuk, 2007): a body-centred cubic
/// lattice, whose points near the surface move onto it, and whose tetrahedra are cut where it still crosses them.
/// Particles inside have the lattice's 14 neighbours; the others those that they share a tetrahedron with. Dihedral
/// angles stay between about 10 and 165 degrees. Because flat triangles cut off what is round, the surface is then
/// moved outward, everywhere alike and by at most 5 % of the spacing, until the volume is met. Edges and parts thinner
/// than the spacing are rounded off. Mass and stiffness are 1 until set_material; the group "surface" holds the
/// particles on the surface.
///
/// With BodyOptions::spacing_at the lattice is that of a balanced octree (the same paper, section 3): leaves that touch
/// differ by a factor of 2 at most, and tetrahedra share whole faces. Angles are not bounded where the spacing changes
/// at the surface; cells below 15 degrees are improved by moving their particles, those on the surface along it. The
/// surface is moved outward with the square of the local spacing. If the field asks for `spacing` everywhere, the body
/// is the same, bit by bit, as without it.
///
/// The surface is first mended as by mend_surface(). Model::notes has its notes, and says if the body has several
/// parts. Throws Error as mend_surface() does, for an option out of range, for a distance that is not a number and if
/// the volume is missed by more than the options allow: the shape is thinner than the spacing.
Model make_body(const Surface& surface, const BodyOptions& options, BodyReport* report = nullptr);
Model make_body(const Solid& solid, const BodyOptions& options, BodyReport* report = nullptr);

}  // namespace phymul
