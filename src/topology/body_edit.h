// SPDX-License-Identifier: MIT
//
// Edits a built body: removes, brings back and cuts cells and walls, in the model and its tables at once. The cost
// follows the change, but for passes over [N] numbers. Afterwards the tables are those that build_topology() makes
// of the model with the same stabiliser, but for the order of their rows and for rounding. They depend on the cells
// that are removed and on the cuts, not on the order of edits.
#pragma once

#include <phymul/topology_textures.h>

#include <map>
#include <memory>
#include <span>
#include <vector>

#include "cell_quadrature.h"
#include "model/cell_cutter.h"

namespace phymul {

class BodyEdit {
 public:
  /// `topology` was built from `model`; both must outlive the edit. Looks once at the whole body. Throws Error unless
  /// the body is made of cells or walls with materials.
  BodyEdit(Model& model, TopologyTextures& topology);

  /// Removes these cells (`share` 0) or brings them back (1; no other value). The tables' lists of edits
  /// say what changed. A particle's mass is in proportion to what its cells weigh, but not so small that it would
  /// vibrate faster than all of the body did: what is kept for that is at most its mass at the beginning. Without a
  /// cell it is 0. Throws Error, and changes nothing, for a row that is no cell with a material.
  void set_shares(std::span<const Index> cells, double share);

  /// What such a cut would change; nothing is changed yet. Throws Error as cut_cells() does, and (not_supported) where
  /// it needs more copies than the body has spare particles.
  BodyCut find_cut(const CutCells& cut) const;
  /// Makes a cut, or undoes the last one of TopologyTextures::cuts. No cell that it changes may be removed. make()
  /// throws Error, and changes nothing, for a cut that is not of the body as it is now. Where memory runs out, the body
  /// is without the cut, unless memory runs out again while that is made so.
  void make(std::shared_ptr<const BodyCut> cut);
  void undo();

  double spacing() const { return spacing_; }            ///< m, tissue_spacing()
  double longest_edge() const { return longest_edge_; }  ///< m, of its cells at rest
  const std::vector<std::vector<Index>>& cells_of() const { return cells_of_; }

 private:
  /// Of a domain d, by domains e: C_de, C_ed, m^2, and the stiffness of the link, N/m.
  struct Pair {
    Index domain;
    Vec3 there = Vec3::Zero(), back = Vec3::Zero();
    double stiffness = 0.0;
  };
  struct Room {
    Index first = none, count = 0;  // of rows that no other domain has; none: not yet
  };

  void require_cell(Index cell) const;
  void require_fits(const BodyCut& cut) const;
  void take_cell(Index row);
  void lift_cell(Index row);
  bool is_listed(Index row) const;  // by its particles, as tissue
  void make_parts(const BodyCut& cut);
  void take_back(const std::shared_ptr<const BodyCut>& cut, std::size_t rows);
  void weigh_lumped(Index particle);
  void follow_cut(const BodyCut& cut);
  void follow(std::vector<Index> domains, std::vector<Index> particles);
  Index domain_of(Index particle, Index material) const;
  double lumped_mass(Index particle) const;
  double modulus_of(Index domain) const;
  double own_stiffness(Index particle) const;
  void integrate(Index domain);
  void write(Index domain);
  template <class Link>
  void write_rows(const std::vector<Link>& rows, std::vector<Link>& table, Room& room, Index& first, Index& count);
  void turn_fibres(Index domain);
  void weigh(Index particle);
  void weigh_family(const std::vector<Index>& family);
  void find_rate(Index particle);
  void find_walls();
  void follow_walls(std::vector<Index>& particles);
  double own_stiffness_in_walls(Index particle) const;
  void write_wall(Index row);
  void free_walls(std::span<const Index> terms);
  template <class Visit>
  void each_wall_with(Index particle, Visit visit) const;

  Model& model_;
  TopologyTextures& topology_;
  std::size_t cell_count_ = 0;                // with a material
  std::vector<std::vector<Index>> cells_of_;  // by particle: rows of its tissue with a material, ascending
  std::vector<std::vector<Index>> walls_of_;  // the same of walls and their clamped edges
  std::vector<std::vector<Index>> walls_at_;  // [cells] rows of TopologyTextures::walls
  std::vector<Index> free_walls_;             // rows there that no cell has, the next one last
  std::vector<double> whole_share_;           // [cells] while they are not removed
  std::vector<double> mass_of_corner_;        // [cells] kg, of each particle's share of one
  std::vector<char> at_start_;         // [cells] 1: the cell, or what it was cut from, was there at the beginning
  std::vector<double> mass_, lumped_;  // [N] kg, of the model and of its cells while they are as at the beginning
  std::vector<Index> spare_;           // particles that no cell has, the next one last
  std::vector<Index> first_of_;        // [N] the particle that it is a copy of, and so on; itself
  std::map<Index, std::vector<Index>> copies_;  // by first particle: it and its copies
  VecList spare_places_;                        // [N] m, or empty: at rest, of those
  std::vector<double> modulus_;                 // [D] Pa
  std::vector<double> rate_;                    // [N] 1/s^2, own_stiffness() over the mass
  double spacing_ = 0.0, longest_edge_ = 0.0;   // m
  bool few_set_the_rate_ = false;               // a tenth of the particles, or less
  double largest_rate_ = 0.0;                   // of these, at the beginning
  std::vector<Room> room_, surface_room_;       // [D]
  std::vector<CellPoint> points_;               // of the cell at hand
  std::vector<double> s_mu_;                    // [points_] N m, stabiliser times shear modulus times volume
  std::vector<Pair> pairs_;                     // of the domain at hand
  double volume_ = 0.0;                         // m^3, its
  std::vector<Index> place_of_;                 // [D] in pairs_, none
  std::vector<LinkTexel> links_;
  std::vector<SurfaceLinkTexel> surface_links_;
};

}  // namespace phymul
