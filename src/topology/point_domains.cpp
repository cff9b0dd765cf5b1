// SPDX-License-Identifier: MIT
#include "averaged_body.h"

#include <phymul/error.h>

#include <algorithm>
#include <numeric>
#include <string>

#include "base/decimal.h"
#include "bending.h"
#include "body_frames.h"
#include "isotropic_edges.h"
#include "model/point_cells.h"

namespace phymul {
namespace {

/// Of the volume that masses and density give over that of the shape, or the other way round: beyond it the masses were
/// not made for the density.
constexpr double most_excess = 10.0;

using Edges = std::vector<std::vector<WeightedEdge>>;  // [N], by rows of particles

std::vector<double> volumes(const Model& model, const std::vector<PointCell>& cells) {
  std::vector<double> volume;
  double whole = 0.0, seen = 0.0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    volume.push_back(model.mass[i] / model.materials.front().density);
    whole += volume.back();
    seen += cells[i].volume;
  }
  if (!(whole < most_excess * seen && seen < most_excess * whole)) {
    throw Error(ErrorCode::invalid_model, "the masses say that the body's volume is " + to_decimal(whole) +
                                              " m^3, the places of its particles " + to_decimal(seen) +
                                              "; call set_material, which gives particles without cells their masses");
  }
  return volume;
}

[[noreturn]] void refuse(const Model& model, Index i) {
  const bool plane = model.dimension == 2;
  throw Error(ErrorCode::invalid_model,
              "particle " + std::to_string(model.file_index(i)) + " has " + std::to_string(model.neighbours.size(i)) +
                  " neighbours, from which no gradient follows: expected at least " + (plane ? "3" : "4") +
                  " that are not all in one " + (plane ? "line" : "plane") +
                  " with it. Give it more, as nearest_neighbours does, or cells");
}

Edges edges_of(const Model& model, const RaggedList& neighbours, const std::vector<double>& volume) {
  Edges all;
  VecList r;
  for (Index i = 0; i < model.particle_count(); ++i) {
    r.clear();
    for (const Index* j = neighbours.begin(i); j != neighbours.end(i); ++j) {
      r.push_back(model.rest[*j] - model.rest[i]);
    }
    all.push_back(isotropic_edges(r, model.dimension, volume[i]));
    if (all.back().empty()) refuse(model, i);
    for (WeightedEdge& edge : all.back()) {
      const auto at = [&](Index place) { return place == 0 ? i : neighbours.begin(i)[place - 1]; };
      edge.from = at(edge.from);
      edge.to = at(edge.to);
    }
  }
  return all;
}

/// Rows of all pairs that an edge needs, with zeros for areas: its ends with each other and with the particle.
void pair_domains(const Edges& edges, Domains& domains) {
  std::vector<std::vector<Index>> rows(edges.size());
  const auto pair = [&](Index d, Index e) {
    rows[d].push_back(e);
    rows[e].push_back(d);
  };
  for (Index i = 0; i < static_cast<Index>(edges.size()); ++i) {
    rows[i].push_back(i);
    for (const WeightedEdge& edge : edges[i]) {
      pair(edge.from, edge.to);
      pair(i, edge.from);
      pair(i, edge.to);
    }
  }
  for (Index d = 0; d < static_cast<Index>(rows.size()); ++d) {
    std::vector<Index>& row = rows[d];
    for (Index& e : row) e -= d;
    std::ranges::sort(row);
    row.erase(std::ranges::unique(row).begin(), row.end());
    domains.pairs.push_row(row.begin(), row.end());
  }
  domains.kind.resize(edges.size());
  std::iota(domains.kind.begin(), domains.kind.end(), 0);
  domains.first_of_kind = domains.kind;
  domains.area.assign(domains.pairs.entry.size(), Vec3::Zero());
}

auto neighbour_pairs(const Model& model) {
  return [&model](const auto& visit) {
    for (Index i = 0; i < model.particle_count(); ++i) {
      for (const Index* j = model.neighbours.begin(i); j != model.neighbours.end(i); ++j) visit(i, *j);
    }
  };
}

/// Energies of a bending: exact, of the means, and of the spread at s = 1.
struct PointEnergies {
  double exact = 0.0, means = 0.0, spread = 0.0;
};

/// The stabiliser, as calibrated_stabilisers finds it for cells; here the exact energy is an integral over the
/// particles' shares of space, each scaled to the particle's volume.
class BendingOfPoints {
 public:
  BendingOfPoints(const Model& model, const Edges& edges, const std::vector<double>& volume,
                  const std::vector<PointCell>& cells)
      : model_(model),
        edges_(edges),
        volume_(volume),
        cells_(cells),
        elastic_(model.materials[0], model.dimension),
        frames_(model, volume, neighbour_pairs(model)) {}

  double stabiliser() const {
    double sum = 0.0;
    int found = 0;
    for (const Bending& way : bendings(model_.dimension)) {
      const PointEnergies energy = energies(way);
      if (!(energy.spread > 1e-9 * energy.exact)) continue;  // nothing to calibrate by
      sum += (energy.exact - energy.means) / energy.spread;
      ++found;
    }
    return found > 0 ? sum / found : 0.0;
  }

 private:
  PointEnergies energies(const Bending& way) const {
    PointEnergies sum;
    for (Index i = 0; i < model_.particle_count(); ++i) {
      const PointCell& cell = cells_[i];
      const Vec3 across = frames_.of_part(frames_.part(i)).axes.col(way.b);
      const double height = frames_.local(i)[way.b];
      const double square =
          cell.volume * height * height + 2.0 * height * cell.first.dot(across) + across.dot(cell.second * across);
      sum.exact += 0.5 * elastic_.young * volume_[i] / cell.volume * square;
      Mat3 H = Mat3::Zero();
      double squares = 0.0;
      for (const WeightedEdge& edge : edges_[i]) {
        const Vec3 from = frames_.local(edge.from), to = frames_.local(edge.to);
        const Vec3 apart =
            bent(to, way, elastic_.poisson, model_.dimension) - bent(from, way, elastic_.poisson, model_.dimension);
        H += edge.weight / volume_[i] * apart * (to - from).transpose();
        squares += edge.weight * apart.squaredNorm();
      }
      sum.means += volume_[i] * elastic_.energy(H);
      sum.spread += 0.5 * elastic_.mu * (squares - volume_[i] * H.squaredNorm());
    }
    return sum;
  }

  const Model& model_;
  const Edges& edges_;
  const std::vector<double>& volume_;
  const std::vector<PointCell>& cells_;
  Elastic elastic_;
  BodyFrames frames_;
};

}  // namespace

PointDomains point_domains(const Model& model) {
  if (model.materials.size() != 1) {
    throw Error(ErrorCode::invalid_model, "a body without cells has one material for all its particles, this one has " +
                                              std::to_string(model.materials.size()) +
                                              "; add cells where materials differ");
  }
  const RaggedList neighbours = point_neighbours(model);
  const std::vector<PointCell> cells = point_cells(model, neighbours);
  PointDomains body;
  Domains& domains = body.domains;
  domains.volume = volumes(model, cells);
  const Edges edges = edges_of(model, neighbours, domains.volume);
  domains.material.assign(edges.size(), 0);
  pair_domains(edges, domains);
  body.stiffness = {domains.pairs.offset, std::vector<double>(domains.pairs.entry.size(), 0.0)};
  const auto row = [&](Index d, Index e) { return domains.first_pair(d) + domains.place(d, e); };
  for (Index i = 0; i < static_cast<Index>(edges.size()); ++i) {
    domains.particle.push_back(i);
    for (const WeightedEdge& edge : edges[i]) {
      const Vec3 area = edge.weight * (model.rest[edge.to] - model.rest[edge.from]);
      domains.area[row(i, edge.to)] += area;
      domains.area[row(i, edge.from)] -= area;
      body.stiffness.value[row(edge.from, edge.to)] += edge.weight;
      body.stiffness.value[row(edge.to, edge.from)] += edge.weight;
    }
  }
  body.stabiliser = BendingOfPoints(model, edges, domains.volume, cells).stabiliser();
  return body;
}

}  // namespace phymul
