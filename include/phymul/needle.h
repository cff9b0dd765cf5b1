// SPDX-License-Identifier: MIT
//
// A needle: the part of its law that is the tissue's. How it is computed: src/cpu/needle_path.h.
#pragma once

#include <phymul/types.h>

#include <vector>

namespace phymul {

/// A straight shaft. Its tip is the tool's position, the shaft goes along the tool's +z axis to the hub, so the needle
/// is pushed in along -z.
///
/// All three forces are limits, as in dry friction: below its limit nothing moves relative to the tissue, at it
/// something gives way. So a force curve depends neither on the step nor on the speed. Insertion force = stiffness of
/// the tissue up to the puncture, cutting at the tip and friction along the shaft after it: A. M. Okamura, C. Simone,
/// M. D. O'Leary, "Force modeling for needle insertion into soft tissue", IEEE Trans. Biomed. Eng. 51 (2004) 1707-1716.
///
/// The defaults are of the order of magnitude that paper finds for bovine liver; tissues, needles and their speeds
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
  /// curves agree between meshes. At least 1.5 spacings of the body. 0: two spacings.
  double spread = 0.0;
  bool operator==(const Needle&) const = default;
};

/// A point of the tissue that a needle has passed: the weighted mean of some particles.
struct NeedleNode {
  std::vector<Index> particles;
  std::vector<double> weights;  ///< sum 1
  bool slides = false;          ///< relative to the shaft, in the last step
  bool operator==(const NeedleNode&) const = default;
};

/// The hole a needle has made, from the surface inward.
struct NeedleState {
  std::vector<NeedleNode> hole;  ///< empty: no contact
  int inside = 0;                ///< of them behind the tip; the others are hole that the needle has left
  bool punctured = false;
  double slip = 0.0;  ///< m by which the tip has gone beyond the surface point or the end of the hole it pushes
  bool operator==(const NeedleState&) const = default;
};

}  // namespace phymul
