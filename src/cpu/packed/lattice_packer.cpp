// SPDX-License-Identifier: MIT
#include "lattice_packer.h"

#include "packed_rows.h"

namespace phymul::cpu {
namespace {

constexpr int all_octants = 0xff;

}  // namespace

LatticePacker::LatticePacker(Hexahedra& hexahedra, const VecList& rest, const std::optional<LatticeFrame>& frame,
                             Index size, std::size_t clusters, PackedBody& body)
    : body_(body), boxes_(take_boxes(hexahedra)), grid_(boxes_, rest, frame, size, clusters, body), starts_(clusters) {
  const auto corners = [](const Hexahedron& h) -> auto& {
    return h.vertex;
  };
  hexahedra_ = hexahedra.all;
  hexahedron_rows_ = by_cluster(hexahedra_, size, clusters, corners, {});
  box_rows_ = by_cluster(boxes_.boxes, size, clusters, corners, {});
  star_rows_.resize(clusters);
  for (std::size_t s = 0; s < boxes_.stars.size(); ++s) {
    star_rows_[boxes_.stars[s].centre / size].push_back(static_cast<Index>(s));
  }
  for (const auto& shape : hexahedra.shapes) {
    for (const double value : shape) body_.hexahedron_shapes.push_back(narrow(value));
  }
  body_.box_shapes = boxes_.shapes;
}

void LatticePacker::pack(int c, Slots& slots) {
  starts_[c] = {body_.hexahedra.size(), body_.stars.size(), body_.boxes.size()};
  simd::Job& job = body_.clusters[c].job;
  job.hexahedra.count = pack_cells(hexahedra_, hexahedron_rows_[c], slots, body_.hexahedra, body_.hexahedron_shape);
  job.boxes.count = pack_cells(boxes_.boxes, box_rows_[c], slots, body_.boxes, body_.box_shape);
  job.stars.count = pack_stars(star_rows_[c], true, slots) + pack_stars(star_rows_[c], false, slots);
  grid_.pack(c, slots);
}

/// Shape after shape, so that a row has one.
int LatticePacker::pack_cells(const std::vector<Hexahedron>& all, const std::vector<Index>& here, Slots& slots,
                              Floats& to, Offsets& shape_of) {
  int count = 0;
  for (int shape = 0; shape < static_cast<int>(boxes_.shapes.size()); ++shape) {
    std::vector<Index> chosen;
    for (const Index h : here) {
      if (all[h].shape == shape) chosen.push_back(h);
    }
    const SpreadLanes spread(chosen.size(), body_.lanes);
    LaneRows rows(to, 8, body_.lanes);
    rows.add(spread.rows(), 8);
    for (std::size_t k = 0; k < chosen.size(); ++k) {
      const auto [row, lane] = spread.place(k);
      for (int v = 0; v < 8; ++v) rows.offset(row, v, lane, slots.offset_of(all[chosen[k]].vertex[v]));
    }
    shape_of.insert(shape_of.end(), static_cast<std::size_t>(spread.rows()), shape);
    count += spread.rows();
  }
  return count;
}

/// Whole stars apart from those that lack an octant, which cost more.
int LatticePacker::pack_stars(const std::vector<Index>& here, bool whole, Slots& slots) {
  int count = 0;
  for (int shape = 0; shape < static_cast<int>(boxes_.shapes.size()); ++shape) {
    std::vector<Index> chosen;
    for (const Index s : here) {
      const Star& star = boxes_.stars[s];
      if (star.shape == shape && (star.octants == all_octants) == whole) chosen.push_back(s);
    }
    const SpreadLanes spread(chosen.size(), body_.lanes);
    LaneRows rows(body_.stars, simd::star_columns, body_.lanes);
    rows.add(spread.rows(), 7);
    for (std::size_t k = 0; k < chosen.size(); ++k) {
      const Star& star = boxes_.stars[chosen[k]];
      const auto [row, lane] = spread.place(k);
      rows.offset(row, 0, lane, slots.offset_of(star.centre));
      for (int s = 0; s < 6; ++s) {
        rows.offset(row, 1 + s, lane, slots.offset_of(star.spoke[s] == none ? star.centre : star.spoke[s]));
      }
      rows.offset(row, 7, lane, star.octants);
    }
    body_.star_shape.insert(body_.star_shape.end(), static_cast<std::size_t>(spread.rows()),
                            whole ? shape : shape | simd::cut_star);
    count += spread.rows();
  }
  return count;
}

void LatticePacker::fill_idle_lanes(int c, std::int32_t idle) {
  fill_idle(body_.hexahedra, starts_[c].hexahedron, 8, 8, body_.lanes, idle);
  fill_idle(body_.boxes, starts_[c].box, 8, 8, body_.lanes, idle);
  fill_idle(body_.stars, starts_[c].star, simd::star_columns, 7, body_.lanes, idle);
  grid_.fill_idle_lanes(c, idle);
}

void LatticePacker::point(int c, simd::Job& job) const {
  const Start& start = starts_[c];
  const auto row = [&](std::size_t at) { return at / (8 * static_cast<std::size_t>(body_.lanes)); };
  job.hexahedra.rows = body_.hexahedra.data() + start.hexahedron;
  job.hexahedron_shape = body_.hexahedron_shape.data() + row(start.hexahedron);
  job.hexahedron_shapes = body_.hexahedron_shapes.data();
  job.boxes.rows = body_.boxes.data() + start.box;
  job.box_shape = body_.box_shape.data() + row(start.box);
  job.stars.rows = body_.stars.data() + start.star;
  job.star_shape = body_.star_shape.data() + row(start.star);
  job.box_shapes = body_.box_shapes.data();
  grid_.point(c, job);
}

double LatticePacker::cost(const simd::Job& job) const {
  return 550.0 * job.hexahedra.count + 80.0 * job.boxes.count + 220.0 * job.stars.count + grid_.cost(job);
}

}  // namespace phymul::cpu
