// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/writer.h>

#include <Eigen/QR>
#include <array>
#include <charconv>
#include <ostream>

#include "base/files.h"
#include "model/cell_geometry.h"

namespace phymul {
namespace {

void append_number(std::string& line, double value) {
  std::array<char, 32> text;
  // to_chars knows no locale: a comma for the decimal point would be another column.
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 17).ptr;
  line += ',';
  line.append(text.data(), end);
}

void require_size(const Model& model, const State& state, const char* caller) {
  if (state.position.size() == model.rest.size() && state.velocity.size() == model.rest.size()) return;
  throw Error(std::string(caller) + ": expected positions and velocities of " + std::to_string(model.rest.size()) +
              " particles, got " + std::to_string(state.position.size()) + " and " +
              std::to_string(state.velocity.size()) + "; give the state together with its own model");
}

/// The linear map that comes nearest to the way of a cell's particles from their middle.
Mat3 mean_motion(const Cell& cell, const VecList& from, const VecList& to) {
  const Vec3 middle = cell_centre(cell, from), there = cell_centre(cell, to);
  Mat3 both = Mat3::Zero(), own = Mat3::Zero();
  for (const Index i : cell.particles) {
    both += (to[i] - there) * (from[i] - middle).transpose();
    own += (from[i] - middle) * (from[i] - middle).transpose();
  }
  return both * own.completeOrthogonalDecomposition().pseudoInverse();
}

}  // namespace

void write_csv(const Model& model, const State& state, const std::string& path) {
  require_size(model, state, "write_csv");
  replace_file(path, [&](std::ostream& out) {
    out << "particle,x,y,z,ux,uy,uz,vx,vy,vz\n";
    for (Index i = 0; i < model.particle_count(); ++i) {
      const Vec3 displacement = state.position[i] - model.rest[i];
      std::string line = std::to_string(i);
      for (const Vec3& value : {state.position[i], displacement, state.velocity[i]}) {
        for (int axis = 0; axis < 3; ++axis) append_number(line, value[axis]);
      }
      out << line << '\n';
    }
  });
}

Model deformed_model(const Model& model, const State& state) {
  require_size(model, state, "deformed_model");
  Model deformed = model;
  deformed.rest = state.position;
  for (Cell& cell : deformed.cells) {
    if (cell.fibre != Vec3::Zero()) cell.fibre = mean_motion(cell, model.rest, state.position) * cell.fibre;
  }
  return deformed;
}

}  // namespace phymul
