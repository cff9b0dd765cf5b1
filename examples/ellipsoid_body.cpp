// SPDX-License-Identifier: MIT
#include "ellipsoid_body.h"

#include <phymul/error.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace {

using phymul::Index;
using phymul::Vec3;

/// The block's half side in a ball of radius 1, and how round it is: 0 a cube, 1 a ball.
constexpr double block = 0.5, roundness = 0.5;

/// A cube's layers bent to spheres: max-norm 1 goes to radius 1.
Vec3 bent(const Vec3& q) {
  const Vec3 s = q.cwiseProduct(q);
  const auto along = [&](int a, int b, int c) {
    return q[a] * std::sqrt(1.0 - 0.5 * s[b] - 0.5 * s[c] + s[b] * s[c] / 3.0);
  };
  return {along(0, 1, 2), along(1, 2, 0), along(2, 0, 1)};
}

class Builder {
 public:
  explicit Builder(const EllipsoidShape& shape) : shape_(shape), n_(shape.core) {
    model_.name = "ellipsoid";
    add_core();
    for (int layer = 1; layer <= shape.organ_layers + shape.shell_layers; ++layer) add_layer(layer);
    add_groups();
    model_.mass.assign(model_.rest.size(), 1.0);
    model_.stiffness.assign(model_.rest.size(), 1.0);
    model_.neighbours = phymul::neighbours_from_cells(model_.cells, model_.particle_count());
    phymul::validate(model_);
  }

  phymul::Model take() { return std::move(model_); }

 private:
  Index corner(int i, int j, int k) const { return static_cast<Index>((k * (n_ + 1) + j) * (n_ + 1) + i); }
  Vec3 lattice(int i, int j, int k) const { return 2.0 / n_ * Vec3(i, j, k) - Vec3::Ones(); }

  void add_core() {
    slot_.assign(static_cast<std::size_t>(n_ + 1) * (n_ + 1) * (n_ + 1), -1);
    for (int k = 0; k <= n_; ++k) {
      for (int j = 0; j <= n_; ++j) {
        for (int i = 0; i <= n_; ++i) {
          const Vec3 q = lattice(i, j, k), ball = bent(q);
          const Vec3 place = block * ((1.0 - roundness) * q + roundness * ball);
          model_.rest.push_back(shape_.semi_axes.cwiseProduct(place));
          if (q.cwiseAbs().maxCoeff() < 1.0 - 0.5 / n_) continue;
          slot_[static_cast<std::size_t>(corner(i, j, k))] = static_cast<Index>(outer_.size());
          outer_.push_back({corner(i, j, k), place, ball});
        }
      }
    }
    for (int k = 0; k < n_; ++k) {
      for (int j = 0; j < n_; ++j) {
        for (int i = 0; i < n_; ++i) {
          add_cell(
              {corner(i, j, k), corner(i + 1, j, k), corner(i + 1, j + 1, k), corner(i, j + 1, k)},
              {corner(i, j, k + 1), corner(i + 1, j, k + 1), corner(i + 1, j + 1, k + 1), corner(i, j + 1, k + 1)});
        }
      }
    }
  }

  /// Particle of a layer over a corner of the block's surface.
  Index over(Index in_block, int layer) const {
    if (layer == 0) return in_block;
    const auto block_size = static_cast<Index>(slot_.size());
    return block_size + (layer - 1) * static_cast<Index>(outer_.size()) + slot_[in_block];
  }

  void add_layer(int layer) {
    const double in_organ = std::min(1.0, static_cast<double>(layer) / shape_.organ_layers);
    const int beyond = std::max(0, layer - shape_.organ_layers);
    const double outward = beyond > 0 ? beyond / static_cast<double>(shape_.shell_layers) : 0.0;
    const Vec3 axes = shape_.semi_axes + Vec3::Constant(outward * shape_.shell), shift = outward * shape_.shell_shift;
    for (const Outer& o : outer_) {
      model_.rest.push_back(shift + axes.cwiseProduct((1.0 - in_organ) * o.in_block + in_organ * o.on_ball));
    }
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {0, n_}) {
        for (int v = 0; v < n_; ++v) {
          for (int u = 0; u < n_; ++u) add_cell_over(axis, side, u, v, layer);
        }
      }
    }
  }

  void add_cell_over(int axis, int side, int u, int v, int layer) {
    constexpr std::array<std::array<int, 2>, 4> ring{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    std::array<Index, 4> low{}, high{};
    for (int c = 0; c < 4; ++c) {
      const int turned = side == 0 ? 3 - c : c;  // counter-clockwise seen from outside
      std::array<int, 3> at{};
      at[axis] = side;
      at[(axis + 1) % 3] = u + ring[turned][0];
      at[(axis + 2) % 3] = v + ring[turned][1];
      const Index in_block = corner(at[0], at[1], at[2]);
      low[c] = over(in_block, layer - 1);
      high[c] = over(in_block, layer);
    }
    add_cell(low, high);
  }

  void add_cell(const std::array<Index, 4>& low, const std::array<Index, 4>& high) {
    phymul::Cell cell;
    cell.type = phymul::CellType::hexahedron;
    cell.particles.assign(low.begin(), low.end());
    cell.particles.insert(cell.particles.end(), high.begin(), high.end());
    model_.cells.push_back(std::move(cell));
  }

  void add_groups() {
    const auto range = [](Index first, Index last) {
      std::vector<Index> rows;
      for (Index i = first; i < last; ++i) rows.push_back(i);
      return rows;
    };
    const auto a_layer = static_cast<Index>(outer_.size());
    const Index organ = static_cast<Index>(slot_.size()) + shape_.organ_layers * a_layer;
    model_.add_group("organ", range(0, organ));
    model_.add_group("surface", range(organ - a_layer, organ));
    if (shape_.shell_layers == 0) return;
    const Index all = model_.particle_count();
    model_.add_group("shell", range(organ - a_layer, all));
    model_.add_group("skin", range(all - a_layer, all));
    model_.add_group("rind", range(all - 2 * a_layer, all));
  }

  struct Outer {
    Index corner;
    Vec3 in_block, on_ball;
  };
  const EllipsoidShape shape_;
  const int n_;
  phymul::Model model_;
  std::vector<Index> slot_;  // [corners of the block] row of outer_; -1: inside
  std::vector<Outer> outer_;
};

}  // namespace

phymul::Model make_ellipsoid(const EllipsoidShape& shape) {
  const bool even = shape.core >= 2 && shape.core % 2 == 0;
  if (!even || shape.organ_layers < 1 || shape.shell_layers < 0 || !(shape.semi_axes.minCoeff() > 0.0) ||
      (shape.shell_layers > 0) != (shape.shell > 0.0)) {
    throw phymul::Error(
        "make_ellipsoid: expected semi-axes above 0, an even core, a layer of the organ or more, and a shell with a "
        "thickness and layers or neither");
  }
  return Builder(shape).take();
}

void set_materials(phymul::Model& model, const EllipsoidShape& shape, const phymul::Material& organ,
                   const phymul::Material& around) {
  phymul::set_material(model, around);
  if (shape.shell_layers > 0) phymul::set_material(model, organ, "organ");
}
