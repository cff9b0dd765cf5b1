// SPDX-License-Identifier: MIT
//
// What a scene does to a body, in rows for a device: vectors per particle, which change with the scene, and a small
// table of the numbers they are multiplied by, a row per instant of a batch of steps.
#pragma once

#include <phymul/load_frame.h>
#include <phymul/scene.h>

#include <vector>

#include "device/table_rows.h"

namespace phymul::gl {

/// Which shaders a scene needs: one that holds nothing pays nothing.
struct LoadKind {
  bool forces = false, fixed = false;
  bool scaled = false;  ///< the stiffness of some material has a factor
  bool joints = false;
  bool any() const { return forces || fixed; }
  bool operator==(const LoadKind&) const = default;
};

class LoadTable {
 public:
  /// Room for the values of as many instants. `materials`, of the body's domains by row, must outlive it.
  LoadTable(const Scene& scene, int instants, const std::vector<Index>& materials);

  const LoadKind& kind() const { return kind_; }
  int mode_count() const { return modes_.count; }

  /// Per particle: first and end row of its force parts, first row of its target parts, their number * 8 + fixed axes.
  std::vector<Int4> index() const;
  /// Vector, number of the value it is multiplied by.
  std::vector<Float4> parts() const;

  /// Takes over the values at these instants.
  void evaluate(const std::vector<double>& instants);
  /// Of the instants given to evaluate(): [instants][modes]; empty where kind() has nothing.
  const std::vector<float>& values() const { return values_; }
  /// Takes over the factors of the stiffness. True where they are not those of before.
  bool scale();
  /// [domains] as scale() found them; empty where nothing is scaled.
  const std::vector<float>& factors() const { return factors_; }
  /// [instants] m/s^2: gravity and uniform accelerations.
  const std::vector<Float4>& gravity() const { return gravity_; }

 private:
  const Scene* scene_;
  const std::vector<Index>* materials_;
  LoadModes modes_;
  LoadKind kind_;
  std::vector<double> row_;  // [modes] at one instant
  std::vector<float> values_;
  std::vector<Float4> gravity_;
  std::vector<float> factors_;
  std::vector<double> of_materials_;  // that factors_ are for
};

}  // namespace phymul::gl
