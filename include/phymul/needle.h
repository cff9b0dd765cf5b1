// SPDX-License-Identifier: MIT
//
// A needle: the part of its law that is the tissue's, and how its shaft bends. How it is computed:
// src/interaction/needle_path.h, and on devices glsl/needle/needle_tables.glsl.
#pragma once

#include <phymul/types.h>

#include <span>
#include <vector>

namespace phymul {

/// A shaft that is straight where nothing bends it. Its tip is then the tool's position, and it goes along the tool's
/// +z axis to the hub, which the tool holds and turns; so the needle is pushed in along -z.
///
/// All three forces are limits, as in dry friction: below its limit nothing moves relative to the tissue, at it
/// something gives way. So a force curve depends neither on the step nor on the speed. A. M. Okamura, C. Simone, M. D.
/// O'Leary, "Force modeling for needle insertion into soft tissue", IEEE Trans. Biomed. Eng. 51 (2004) 1707-1716, split
/// what they measured on bovine liver ex vivo so: stiffness up to the puncture, constant cutting, friction by length.
///
/// The defaults are round numbers of that order, for an 18 gauge needle in liver: no table's. Tissues, tips and speeds
/// differ by more than a factor of two, so measured values should take their place.
struct Needle {
  double length = 0.15;            ///< m, from tip to hub
  double radius = 0.64e-3;         ///< m; 0.64 mm: 18 gauge
  double puncture = 2.0;           ///< N on the surface at which its skin gives way
  double cutting = 0.9;            ///< N at the tip while it cuts; at most `puncture`
  double static_friction = 15.0;   ///< N per m of inserted shaft that is at rest in the tissue
  double kinetic_friction = 10.0;  ///< N per m of inserted shaft that slides; at most `static_friction`
  /// m: how far around the shaft a force on it spreads in the tissue. A force on a point of an elastic body moves that
  /// point by infinitely much, and on a mesh by what the mesh makes of it: a length that is no mesh's is what makes
  /// curves agree between meshes, from 1.7 spacings of the body on. With less the weights widen until they have
  /// particles enough, so that a force spreads as far as the mesh makes it and curves are that mesh's; and the hole has
  /// a point every `spread`, whose number squared is a step's time. Below a tenth of a spacing Scene::add_tool throws
  /// Error: such points are means of the same particles. 0: two spacings.
  double spread = 0.0;
  /// N m^2: Young's modulus times the section's second moment of area, tube_bending_stiffness(). 0: stiff. The shaft is
  /// a beam clamped in the hub whose tip is free; linear theory, good to deflections of about a tenth of its length.
  /// What pushes along a bent shaft does not bend it further: no buckling.
  double bending_stiffness = 0.0;
  bool operator==(const Needle&) const = default;
};

/// N m^2 of a tube, or of a wire where the inner radius is 0; m, Pa. The default is steel's modulus: 18 gauge with a
/// bore of 0.84 mm (0.635e-3, 0.42e-3) has 0.021, a solid wire of 0.3 mm radius 1.3e-3.
double tube_bending_stiffness(double outer_radius, double inner_radius, double young = 200e9);

/// A point of the tissue that a needle has passed: the weighted mean of some particles.
struct NeedleNode {
  std::vector<Index> particles{};
  std::vector<double> weights{};  ///< sum 1
  bool slides = false;            ///< relative to the shaft, in the last step
  bool operator==(const NeedleNode&) const = default;
};

/// A force across the shaft, that bends it.
struct ShaftLoad {
  double along = 0.0;       ///< m from the tip
  double x = 0.0, y = 0.0;  ///< N, in the tool's frame
  bool operator==(const ShaftLoad&) const = default;
};

/// `count` places, 2 or more, evenly along a shaft under loads, from the tip to the hub: m, in the tool's frame.
VecList shaft_points(const Needle& needle, std::span<const ShaftLoad> loads, int count);

/// The hole a needle has made, from the surface inward. Nodes are as far apart as a force spreads; the last one is
/// where the tip cuts on, unless it came out on the other side.
struct NeedleState {
  std::vector<NeedleNode> hole{};  ///< empty: no contact; one node and not `punctured`: the tip presses on the surface
  bool punctured = false;
  bool through = false;            ///< the tip came out again
  double slip = 0.0;               ///< m by which the tip has gone beyond the last node
  std::vector<ShaftLoad> shaft{};  ///< what the tissue bends it with; empty for a stiff needle
  bool operator==(const NeedleState&) const = default;
};

}  // namespace phymul
