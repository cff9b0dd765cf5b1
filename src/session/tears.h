// SPDX-License-Identifier: MIT
//
// Where a body may tear, and the cut by which it does (phymul/tearing.h).
#pragma once

#include <phymul/scene.h>
#include <phymul/state.h>
#include <phymul/topology_textures.h>

#include <array>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "model/outer_faces.h"
#include "topology/body_edit.h"

namespace phymul {

class Tears {
 public:
  /// The body as it is; model, edit and scene must outlive the next find().
  void follow(const Model& model, const TopologyTextures& topology, const BodyEdit& edit, const Scene& scene);

  bool has_fronts() const { return !fronts_.empty(); }
  bool is_by(const std::vector<Tearing>& laws) const { return laws_ == laws; }  ///< follow() saw these

  /// What tears now, at most one row of cells along each front. `elastic`: tables of the forces that `now` has.
  struct Found {
    std::vector<Index> cells{};                    ///< rows, ascending
    std::unordered_map<Index, double> distance{};  ///< m, of their particles from the new surface
  };
  Found find(const TopologyTextures& elastic, const State& now);

 private:
  /// A face of a cell that is whole, behind which the cells are cut: a piece of the front.
  struct Front {
    Index cell = -1;
    std::array<Index, 3> face{};    // particles
    std::array<double, 3> value{};  // m, theirs of the cut behind it
    Vec3 normal{0, 0, 0};           // of the cut, at rest
    Vec3 place{0, 0, 0};            // m at rest, the middle of the cut's edge
    std::vector<Index> around{};    // domains over which the stress is averaged
  };
  struct Pull {
    Vec3 direction{0, 0, 0};  // at rest, of the largest principal stress
    double excess = 0.0;      // that over what the material bears; more than 1: it tears
  };

  void look_behind(Index row);
  const Mat3& stress_of(Index d, const TopologyTextures& elastic, const State& now);
  Pull pull_at(const TopologyTextures& elastic, const State& now, const Vec3& place, Index cell, double radius,
               std::span<const Index> around);
  std::optional<double> known_distance(Index particle, double own, const Vec3& normal) const;
  void find_surface();
  void begin_near_grasps(const TopologyTextures& elastic, const State& now, Found& found);
  bool can_tear(Index cell) const;     // whether it is there and its material tears
  double radius_at(Index cell) const;  // m, of means
  double radius_of(const Tearing& law) const;

  const Model* model_ = nullptr;
  const BodyEdit* edit_ = nullptr;
  const Scene* scene_ = nullptr;
  std::vector<Tearing> laws_;  // Scene::tearing()
  double widest_ = 0.0;        // m, radius_of() any of these
  std::vector<Front> fronts_;
  OuterFaces outer_;
  bool surface_known_ = false;
  std::vector<Index> surface_;                 // particles of outer faces
  std::vector<std::pair<bool, Mat3>> stress_;  // [D] whether it is known, of the state at hand
  std::vector<Index> stressed_;                // of which it is
};

}  // namespace phymul
