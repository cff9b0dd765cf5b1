// SPDX-License-Identifier: MIT
//
// Writers: one state, or a series of them, as files other programs open. They throw Error when a file cannot be
// written.
#pragma once

#include <phymul/model.h>
#include <phymul/state.h>

#include <iosfwd>
#include <string>
#include <utility>
#include <vector>

namespace phymul {

/// One named value per particle, [N].
struct Field {
  std::string name;  ///< not empty, and not that of another array of the file
  std::vector<double> values;
};

/// One frame as a VTK XML unstructured grid (.vtu): the model's cells at the state's positions (vertices where it has
/// none), point data "displacement", "velocity", "mass" and the given fields; group membership as "group:<name>".
void write_vtu(const Model& model, const State& state, const std::string& path, const std::vector<Field>& fields = {});

/// A time series for ParaView: `<stem>_000000.vtu`, ... and `<stem>.pvd`, which is complete after every frame. A frame
/// whose write() throws does not count: the next one takes its number.
class VtkSeries {
 public:
  explicit VtkSeries(std::string stem);  ///< folder must exist
  void write(const Model& model, const State& state, const std::vector<Field>& fields = {});
  std::size_t frames() const { return frames_.size(); }

 private:
  std::string stem_;
  std::vector<std::pair<double, std::string>> frames_;
};

/// particle,x,y,z,ux,uy,uz,vx,vy,vz with a header line; SI; 17 significant digits.
void write_csv(const Model& model, const State& state, const std::string& path);

/// The model with its rest shape moved to the state's positions: for writing the deformed body as PML, or going on
/// from it as a new rest shape. Fibres of cells go along.
Model deformed_model(const Model& model, const State& state);

}  // namespace phymul
