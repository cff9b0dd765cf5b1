// SPDX-License-Identifier: MIT
//
// A needle, straight or an arc: the limits of the forces between tissue and shaft, and the bending of the shaft. The
// algorithm is in src/interaction/needle_path.h.
#pragma once

#include <phymul/types.h>

#include <span>
#include <vector>

namespace phymul {

/// The tip of the unbent needle is the tool's position. A straight shaft goes from there along the tool's +z axis to
/// the hub, which the tool holds and turns. So the needle is pushed in along -z. A shaft with `arc_radius` leaves the
/// tip along +z too and bends toward +x, around the point arc_radius along +x; turned about that point by -y it goes in
/// along itself. It ends at a tail, beyond which its hole is left to the thread (Scene::swage). The shaft goes in and
/// out of one body or several as often as its way does. Scene::add_tool throws Error for a value out of its range, for
/// an arc that bends or is longer than nine tenths of a circle, and for a two-dimensional model.
///
/// All four forces are limits, as in dry friction: below its limit nothing moves relative to the tissue, at the limit
/// the tissue gives way. So a force curve depends neither on the step nor on the speed. A. M. Okamura, C. Simone, M. D.
/// O'Leary, "Force modeling for needle insertion into soft tissue", IEEE Trans. Biomed. Eng. 51 (2004) 1707-1716,
/// divide their measurements on bovine liver ex vivo in this way: stiffness up to the puncture, constant cutting force,
/// friction per length.
///
/// Tissue also gives way where it has reached its own limit of stretch: where a push over spread^2 is
/// E / (1.25 + 6 x + 8.5 x^2), with x = 1 - 2 nu, E and nu of the tissue's material, a little below what turns cells
/// inside out (docs/guide/needles.md). That limits the tip's push, and what it and the shaft beside it do together.
/// StepReport::tissue_gave_way counts punctures by that. Tissue without a material has no such limit.
///
/// The defaults are round numbers of that order for an 18 gauge needle in liver, not values of a table. Tissues, tips
/// and speeds differ by more than a factor of two, so use measured values where you have them.
struct Needle {
  double length = 0.15;            ///< m, from tip to hub
  double radius = 0.64e-3;         ///< m; 0.64 mm: 18 gauge
  double puncture = 2.0;           ///< N on the surface, at which the surface gives way at the latest
  double cutting = 0.9;            ///< N at the tip while it cuts, at the most; not above `puncture`
  double static_friction = 15.0;   ///< N per m of inserted shaft that is at rest in the tissue
  double kinetic_friction = 10.0;  ///< N per m of inserted shaft that slides; at most `static_friction`
  /// m: distance over which a force on the shaft is spread into the tissue around it. 0: 34 radii, but at least two
  /// spacings of the body, which is what it can carry; so bodies of different spacing are punctured alike. A
  /// force on a single point of an elastic body would move that point infinitely far, and on a mesh by an amount that
  /// depends on the mesh. With the same `spread`, force curves of different meshes agree within 10 % from 2.7 spacings
  /// on. Below about 1.5 spacings the weights widen until they have enough particles, and curves depend on the mesh.
  /// The hole has a node every `spread`; the time of a step grows as the square of their number. Scene::add_tool throws
  /// Error below a tenth of a spacing.
  double spread = 0.0;
  /// N m^2, 0 or at least 1e-12: Young's modulus times the section's second moment of area, tube_bending_stiffness().
  /// 0: rigid. The shaft is a linear beam, clamped in the hub and free at the tip, valid for deflections up to about a
  /// tenth of its length. Axial forces do not bend it: no buckling.
  double bending_stiffness = 0.0;
  double arc_radius = 0.0;  ///< m; 0: straight. The arc's angle is length / arc_radius
  double leaving = 0.0;     ///< N on the surface from inside, at which the tip comes out; up to `cutting`: at once
  bool operator==(const Needle&) const = default;
};

/// Bending stiffness, N m^2, of a tube, or of a wire if the inner radius is 0. Radii in m, `young` in Pa (default:
/// steel). 18 gauge with a bore of 0.84 mm (0.635e-3, 0.42e-3) has 0.021, a solid wire of 0.3 mm radius 1.3e-3. Throws
/// Error unless 0 <= inner_radius < outer_radius and young > 0, all finite.
double tube_bending_stiffness(double outer_radius, double inner_radius, double young = 200e9);

/// A point of the tissue that a needle has passed: the weighted mean of some particles.
struct NeedleNode {
  std::vector<Index> particles{};
  std::vector<double> weights{};  ///< sum 1
  bool slides = false;            ///< relative to the shaft, in the last step
  bool out = false;               ///< on the surface where the tip comes out, or came; a next node is where it goes in
  bool operator==(const NeedleNode&) const = default;
};

/// A transverse force that bends the shaft.
struct ShaftLoad {
  double along = 0.0;       ///< m from the tip
  double x = 0.0, y = 0.0;  ///< N, in the tool's frame
  bool operator==(const ShaftLoad&) const = default;
};

/// m, in the tool's frame: the unbent shaft at so many m from the tip; at Needle::length the hub, or the tail.
Vec3 shaft_place(const Needle& needle, double along);

/// Returns `count` evenly spaced points of a shaft under loads, from tip to hub, m, in the tool's frame. Throws Error
/// if count is below 2.
VecList shaft_points(const Needle& needle, std::span<const ShaftLoad> loads, int count);

/// The holes that a needle has made, from the surface inward, one after the other. Nodes are Needle::spread apart. The
/// last one is where the tip continues to cut, unless the tip has come out on the far side. `punctured`, `through` and
/// `slip` are of the last hole.
struct NeedleState {
  std::vector<NeedleNode> hole{};  ///< empty: no contact; not `punctured`: the tip presses the last one, on the surface
  bool punctured = false;
  bool through = false;            ///< the tip came out again
  double slip = 0.0;               ///< m by which the tip has gone beyond the last node
  std::vector<ShaftLoad> shaft{};  ///< forces of the tissue that bend it; empty for a stiff needle
  bool free = false;               ///< let go: rests in the tissue (ToolHandle::release)
  bool operator==(const NeedleState&) const = default;
};

}  // namespace phymul
