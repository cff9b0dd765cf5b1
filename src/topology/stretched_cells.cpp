// SPDX-License-Identifier: MIT
#include "stretched_cells.h"

#include <phymul/bodies.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "model/cell_geometry.h"

namespace phymul {
namespace {

constexpr double most_stretched = 3.001;  // a lattice of just 3 passes

/// Mean of x x^T over the vertices, x from their middle.
Mat3 spread(const Cell& cell, const VecList& rest) {
  const auto count = static_cast<double>(cell.particles.size());
  Vec3 middle = Vec3::Zero();
  for (const Index i : cell.particles) middle += rest[i] / count;
  Mat3 sum = Mat3::Zero();
  for (const Index i : cell.particles) sum += (rest[i] - middle) * (rest[i] - middle).transpose() / count;
  return sum;
}

double ratio(const Mat3& spread, int dimension) {
  const Vec3 squares = Eigen::SelfAdjointEigenSolver<Mat3>(spread, Eigen::EigenvaluesOnly).eigenvalues();
  const double least = squares[3 - dimension];  // they increase; in 2-D the first is none
  return least > 0.0 ? std::sqrt(squares[2] / least) : 1.0;
}

}  // namespace

std::vector<std::string> notes_on_stretched_cells(const Model& model) {
  std::vector<Mat3> around(model.rest.size(), Mat3::Zero());
  std::vector<double> volume(model.rest.size(), 0.0), ratios(model.rest.size(), 1.0);
  for (const Cell& cell : model.cells) {
    if (!is_solid(model.dimension, cell) || cell.material < 0) continue;
    const double measure = std::abs(signed_measure(model.dimension, cell, model.rest));
    const Mat3 of_cell = measure * spread(cell, model.rest);
    for (const Index i : cell.particles) {
      around[i] += of_cell;
      volume[i] += measure;
    }
  }
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    if (volume[i] > 0.0) ratios[i] = ratio(around[i], model.dimension);
  }
  std::vector<std::string> notes;
  if (!std::ranges::any_of(ratios, [](double it) { return it > most_stretched; })) return notes;
  for (const ConnectedBody& body : connected_bodies(model)) {
    double sum = 0.0, whole = 0.0;
    for (const Index i : body.particles) {
      sum += volume[i] * ratios[i];
      whole += volume[i];
    }
    if (!(sum > most_stretched * whole)) continue;
    char stretch[32];
    std::snprintf(stretch, sizeof stretch, "%.1f", sum / whole);
    const std::string first = std::to_string(model.file_index(body.particles.front()));
    notes.push_back((body.name.empty() ? "the body of particle " + first : "body \"" + body.name + "\"") +
                    ": its cells are " + stretch +
                    " times as long as thick; it bends too little, whatever the stabiliser. Mesh it with cells that "
                    "are less than twice as long as thick");
  }
  return notes;
}

}  // namespace phymul
