// SPDX-License-Identifier: MIT
#include "mirror_volumes.h"

#include <cmath>

#include "volume_root.h"

namespace phymul::cpu {
namespace {

// A facet of a closed surface whose volume is kept, in float: the twin of glsl/volume/kept_facet.glsl, operation by
// operation.

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

}  // namespace

using Float3 = Vector3<float>;

Float3 MirrorVolumes::direction(std::size_t i, std::span<const Float3> u, float inverse_mass) const {
  const auto [first, end, volume, unused] = tables_.ranges[i];
  const Float4& unit = law(volume, 0);
  Float3 area;
  for (std::int32_t row = first; row < end; ++row) {
    const auto& [a, b, c, facet] = tables_.around[at(row)];
    const Float3& u_a = u[at(a)];
    area += facet_area({.a = {},
                        .e = edge(at(facet), 1),
                        .f = edge(at(facet), 2),
                        .da = {},
                        .de = unit[1] * (u[at(b)] - u_a),
                        .df = unit[1] * (u[at(c)] - u_a)});
  }
  return (unit[2] * inverse_mass) * area;
}

Float4 MirrorVolumes::facet(std::size_t row, std::span<const Float3> u, float inverse_unit) const {
  const auto& [corner_a, corner_b, corner_c, seen_from] = tables_.facets[row];
  const std::size_t a = at(corner_a), b = at(corner_b), c = at(corner_c), o = at(seen_from);
  const KeptFacet facet{.a = edge(row, 0),
                        .e = edge(row, 1),
                        .f = edge(row, 2),
                        .da = inverse_unit * (u[a] - u[o]),
                        .de = inverse_unit * (u[b] - u[a]),
                        .df = inverse_unit * (u[c] - u[a])};
  return facet_volume(facet, along_[a], along_[b] - along_[a], along_[c] - along_[a]);
}

Float4 MirrorVolumes::sum_of(const Int4& node, bool of_facets, std::span<const Float3> u) const {
  Float4 sum{};
  for (std::size_t row = at(node[0]); row < at(node[1]); ++row) {
    const Float4 term = of_facets ? facet(row, u, law(node[2], 0)[1]) : sums_[row];
    for (std::size_t k = 0; k < 4; ++k) sum[k] = sum[k] + term[k];
  }
  return sum;
}

int MirrorVolumes::find_roots(std::span<const Float3> u) {
  sums_.resize(tables_.nodes.size());
  for (std::size_t level = 0; level < tables_.levels.size(); ++level) {
    const Int4& rows = tables_.levels[level];
    for (std::size_t node = at(rows[0]); node < at(rows[1]); ++node) {
      sums_[node] = sum_of(tables_.nodes[node], level == 0, u);
    }
  }
  roots_.assign(at(tables_.count()), 0.0f);
  int lost = -1;
  for (std::int32_t volume = tables_.count(); volume-- > 0;) {  // the first one is told of
    Float4 total = sums_[at(tables_.levels.back()[0] + volume)];
    for (float& sum : total) sum = (1.0f / 6.0f) * sum;
    const float missing = law(volume, 1)[0] - total[0];
    const VolumeRoot root = root_of_cubic(total[1], total[2], total[3], missing);
    if (root.found) {
      roots_[at(volume)] = law(volume, 0)[0] * root.s;
    } else if (std::abs(missing) > law(volume, 1)[1]) {
      lost = volume;
    }
  }
  return lost;
}

}  // namespace phymul::cpu
