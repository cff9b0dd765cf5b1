// SPDX-License-Identifier: MIT
//
// A facet of a closed surface whose volume is kept, in float: the twin of glsl/volume/kept_facet.glsl, operation by
// operation.
#pragma once

#include "base/vector3.h"

namespace phymul::cpu {

/// Seen from a particle o of the surface, over the unit of the volume.
struct KeptFacet {
  Vector3<float> a, e, f;     // at rest: from o to a, from a to b, from a to c
  Vector3<float> da, de, df;  // what they have gained
};

/// Twice its area, outward.
inline Vector3<float> facet_area(const KeptFacet& facet) {
  return cross_product(facet.e + facet.de, facet.f + facet.df);
}

/// Six times what the tetrahedron o, a, b, c has gained, and its c1, c2, c3 (enclosed_volume.h) along p at a, q more at
/// b, r more at c.
inline Float4 facet_volume(const KeptFacet& facet, const Vector3<float>& p, const Vector3<float>& q,
                           const Vector3<float>& r) {
  const Vector3<float> a = facet.a + facet.da, e = facet.e + facet.de, f = facet.f + facet.df;
  const Vector3<float> area = cross_product(e, f);
  const Vector3<float> area_gained = cross_product(facet.de, f) + cross_product(facet.e, facet.df);
  const Vector3<float> first = cross_product(q, f) + cross_product(e, r), second = cross_product(q, r);
  return {inner_product(facet.da, area) + inner_product(facet.a, area_gained),
          inner_product(p, area) + inner_product(a, first), inner_product(p, first) + inner_product(a, second),
          inner_product(p, second)};
}

}  // namespace phymul::cpu
