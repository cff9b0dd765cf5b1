// SPDX-License-Identifier: MIT
//
// A CutSurface of the rest shape, as the cell cutter takes it.
#pragma once

#include <phymul/body.h>
#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "model/cell_cutter.h"
#include "model/cell_geometry.h"

namespace phymul {

/// Refers to its arguments.
class CutPlaces {
 public:
  /// `cells`: rows of all tissue, ascending. Throws Error for a distance that is not finite.
  CutPlaces(const Model& model, std::span<const Index> cells, const CutSurface& surface, const char* who)
      : model_(model), surface_(surface), who_(who), distance_(model.rest.size(), 0.0) {
    if (!surface.distance) throw Error(std::string(who) + ": expected CutSurface::distance");
    std::vector<double> shortest(model.rest.size(), HUGE_VAL);
    for (const Index row : cells) {
      const Cell& cell = model.cells[row];
      for (const Index i : cell.particles) {
        for (const Index j : cell.particles) {
          if (i != j) shortest[i] = std::min(shortest[i], (model.rest[i] - model.rest[j]).norm());
        }
      }
    }
    for (std::size_t i = 0; i < shortest.size(); ++i) {
      if (shortest[i] == HUGE_VAL) continue;
      const double distance = surface.distance(model.rest[i]);
      if (!std::isfinite(distance)) throw Error(std::string(who) + ": expected finite distances to the surface");
      distance_[i] = std::abs(distance) < on_cut_surface * shortest[i] ? 0.0 : distance;
    }
    spacing_ = tissue_spacing(model, cells);
    for (const Index row : cells) {
      const auto [least, most] =
          std::ranges::minmax(model.cells[row].particles, {}, [&](Index i) { return distance_[i]; });
      if (distance_[least] <= 0.0 && distance_[most] >= 0.0) cells_.push_back(row);
    }
  }

  CutCells cut() const {
    return {.cells = cells_,
            .distance = [this](Index i) { return distance_[i]; },
            .passed =
                [this](Index row, const Eigen::Vector4d& middle) {
                  if (!surface_.front) return true;
                  Vec3 place = Vec3::Zero();
                  const std::vector<Index>& particles = model_.cells[row].particles;
                  for (std::size_t v = 0; v < particles.size(); ++v) {
                    place += middle[static_cast<Eigen::Index>(v)] * model_.rest[particles[v]];
                  }
                  const double front = surface_.front(place);
                  if (std::isnan(front)) throw Error(std::string(who_) + ": expected distances to the front, got NaN");
                  return front < lead_of_front * spacing_;
                },
            .who = who_};
  }

 private:
  const Model& model_;
  const CutSurface& surface_;
  const char* who_;
  double spacing_ = 0.0;          // m
  std::vector<double> distance_;  // [N] m
  std::vector<Index> cells_;
};

}  // namespace phymul
