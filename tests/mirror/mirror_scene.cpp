// SPDX-License-Identifier: MIT
#include "mirror_scene.h"

#include <cmath>
#include <cstdlib>

#include "kernels.h"
#include "mirror_forces.h"

namespace phymul::cpu {
namespace {

using Law = Kernels<float>;

Float4 texel(const Float3& v, float w) {
  return {v.x, v.y, v.z, w};
}

}  // namespace

void MirrorJoints::follow(const Scene& scene, const FloatTools& tools) {
  scene_ = &scene;
  tools_ = &tools;
  rows_.emplace(scene, tools.middle());
}

MirrorJoints::Way MirrorJoints::mean_way(const Step& step, std::int32_t first, std::int32_t end) const {
  Way way;
  for (std::int32_t row = first; row < end; ++row) {
    const Int4& anchor = rows_->anchors()[row];
    const float weight = as_float(anchor[1]);
    way.from += weight * step.u[anchor[0]];
    way.speed += weight * step.v[anchor[0]];
  }
  return way;
}

MirrorJoints::ToolAnchor MirrorJoints::tool_anchor(const Step& step, int tool, const Float3& point) const {
  const Float4* const rows = &tools_->frames()[FloatTools::frame_rows * static_cast<std::size_t>(tool)];
  const auto turned = [&](int first) {
    return point.x * xyz(rows[first]) + point.y * xyz(rows[first + 1]) + point.z * xyz(rows[first + 2]);
  };
  const Float3 gone{rows[4][3], rows[5][3], rows[6][3]};
  const Float3 moved = gone + turned(4);
  Float3 offset = turned(0), speed = step.inverse_dt * moved;
  if (step.tools_at_once) {
    offset += moved;
    speed = {};
  }
  return {{rows[0][3], rows[1][3], rows[2][3]}, xyz(rows[3]), offset, speed, offset - gone};
}

void MirrorJoints::act(const Step& step, std::size_t s) {
  const Int4& ends = rows_->springs()[s];
  const Float4 &law = rows_->laws()[FloatJoints::law_rows * s], &lengths = rows_->laws()[FloatJoints::law_rows * s + 1];
  const Float4* const places = &rows_->places()[FloatJoints::place_rows * s];
  const Float3 R = xyz(places[0]);
  const Way a = mean_way(step, ends[0], ends[1]), b = mean_way(step, ends[1], ends[2]);
  const Float3 d = b.from - a.from;
  Float3 r = R + d, v = b.speed - a.speed, arm;
  if (ends[3] != 0) {
    const ToolAnchor at = tool_anchor(step, std::abs(ends[3]) - 1, xyz(places[2]));
    r = ((at.high - R) + (at.low - xyz(places[1]))) + (at.offset - (a.from + b.from));
    v = at.speed - (a.speed + b.speed);
    arm = at.arm;
    if (ends[3] < 0) {
      r = -r;
      v = -v;
    }
  }
  if (scene_->model().dimension == 2) r.z = v.z = 0.0f;
  const float length = std::sqrt(inner_product(r, r));
  const float stretch = ends[3] != 0 ? length - lengths[0] : Law::spring_stretch(R, d, r, length) + lengths[1];
  Float4* const state = &state_[FloatJoints::state_rows * s];
  const bool broken = state[0][3] > 0.0f;
  Float3 f;
  if (!broken) f = Law::joint_pull(r, v, length, stretch, law[0], law[1], lengths[0] == 0.0f, law[3] > 0.0f);
  const bool breaks = inner_product(f, f) > law[2] * law[2];
  const Float3 torque = ends[3] != 0 ? cross_product(arm, ends[3] > 0 ? -f : f) : Float3{};
  state[0] = texel(f, broken || breaks ? 1.0f : 0.0f);
  state[1] = texel(torque, length);
  state[2] = texel(f, 0.0f);
  state[3] = texel(torque, 0.0f);
}

void MirrorJoints::act(const Step& step, const JointSet& known) {
  rows_->follow();
  state_ = joint_rows(scene_->joints(), known);
  for (std::size_t s = 0; s < rows_->springs().size(); ++s) act(step, s);
}

void MirrorJoints::add_forces(Index i, Float3& force) const {
  const Int4& range = rows_->ranges()[i];
  for (std::int32_t row = range[0]; row < range[1]; ++row) {
    const Int4& end = rows_->ends()[row];
    force += as_float(end[1]) * xyz(state_[FloatJoints::state_rows * end[0]]);
  }
}

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

/// Six times what the tetrahedron o, a, b, c has gained, and its c1, c2, c3 (closed_surface.h) along p at a, q more at
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
