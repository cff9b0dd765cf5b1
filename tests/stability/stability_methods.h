// SPDX-License-Identifier: MIT
//
// The methods that the stability suite and its atlas compare, each on a cube of the same tissue, and the distance of a
// body from its rest shape that no rigid motion changes.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "support/bodies.h"

namespace phymul::test {

struct Method {
  std::string name;
  TopologyOptions options;
  bool material = false;  ///< else k = E h
  double poisson = 0.3;
  int valence = 6;
};

/// True where the stiffness is symmetric: no growth and no flutter at rest.
inline bool is_conservative(const Method& method) {
  const Reaction reaction = method.options.reaction;
  return method.options.law == Law::springs || reaction == Reaction::conservative || reaction == Reaction::averaged;
}

inline std::vector<Method> stability_methods() {
  std::vector<Method> all;
  const auto add = [&](std::string name, auto&& set) {
    Method m{.name = std::move(name), .options = {.on_sparse = SparseParticle::springs}};
    set(m);
    all.push_back(std::move(m));
  };
  for (const int valence : {6, 18, 26}) {
    add("springs " + std::to_string(valence), [&](Method& m) { m.options.law = Law::springs, m.valence = valence; });
  }
  add("springs 18, volume", [](Method& m) {
    m.options.law = Law::springs, m.valence = 18;
    m.options.volume_stiffness = 10e3;
  });
  for (const auto& [name, reaction] :
       {std::pair{"full", Reaction::full}, std::pair{"shared", Reaction::shared},
        std::pair{"barycentric", Reaction::barycentric}, std::pair{"averaged", Reaction::averaged}}) {
    add(name, [r = reaction](Method& m) { m.options.reaction = r; });
  }
  add("material, nu 0.3", [](Method& m) { m.material = true; });
  add("material, nu 0.45", [](Method& m) { m.material = true, m.poisson = 0.45; });
  return all;
}

/// A body of soft_tissue with masses by volume; its own k where the method has no calibration.
inline Model of_tissue(Model model, const Method& method) {
  set_material(model, soft_tissue(method.poisson));
  if (method.material) return model;
  const double stiffness = soft_tissue().young * mean_spacing(model);
  model.materials.clear();
  for (Cell& cell : model.cells) cell.material = -1;
  model.stiffness.assign(model.rest.size(), stiffness);
  return model;
}

inline Model tissue_cube(const Method& method, double side, int cells) {
  return of_tissue(make_block({side, side, side}, cells, cells, cells, method.valence), method);
}

/// Root mean square distance to the rest shape, turned and moved to lie best, over the rest shape's own radius of
/// gyration. A mirrored body is far: only proper rotations count.
inline double distance_from_rest_shape(const Model& model, const VecList& position) {
  using Points = Eigen::Matrix<double, 3, Eigen::Dynamic>;
  const auto n = static_cast<Eigen::Index>(position.size());
  Points rest(3, n), now(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    rest.col(i) = model.rest[static_cast<std::size_t>(i)];
    now.col(i) = position[static_cast<std::size_t>(i)];
  }
  rest.colwise() -= rest.rowwise().mean().eval();
  now.colwise() -= now.rowwise().mean().eval();
  const Eigen::JacobiSVD<Mat3> svd(Mat3(now * rest.transpose()), Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vec3 signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
  const Mat3 turn = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  return (now - turn * rest).norm() / rest.norm();
}

}  // namespace phymul::test
