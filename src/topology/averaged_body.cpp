// SPDX-License-Identifier: MIT
#include "averaged_body.h"

#include <phymul/error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "base/side_by_side.h"
#include "cell_quadrature.h"
#include "energies.h"
#include "model/body_type.h"
#include "model/cell_cutter.h"
#include "model/cell_geometry.h"
#include "transpose.h"

namespace phymul {
namespace {

bool solid(const Model& model, Index row) {
  return is_solid(model.dimension, model.cells[row]);
}

/// Calls visit(domains of the vertices, points, is_own) for every solid cell that has a domain which `chosen` accepts.
/// Two threads do it, each for one half of the domains. A visit writes to rows of domains that is_own accepts, and to
/// no others; a domain is given its cells in their order.
template <class Chosen, class Visit>
void for_each_cell(const Model& model, const Domains& domains, const Chosen& chosen, const Visit& visit) {
  in_halves(domains.count(), domains.host, [&](int, Index first, Index last) {
    const auto is_own = [&](Index d) { return first <= d && d < last && chosen(d); };
    std::vector<CellPoint> points;
    for (Index row = 0; row < domains.of_cell.rows(); ++row) {
      const std::span<const Index> vertices(domains.of_cell.begin(row), domains.of_cell.end(row));
      if (std::ranges::none_of(vertices, is_own)) continue;
      cell_points(model, row, points);
      visit(vertices, points, is_own);
    }
  });
}

/// Domain numbers: one for each particle and each material around it.
void number_domains(const Model& model, Domains& domains) {
  std::vector<std::pair<Index, Index>> keys;  // particle, material
  keys.reserve(model.rest.size());
  std::size_t vertices = 0;
  std::vector<Index> last(model.rest.size(), none);  // material that a particle was last seen with
  const std::vector<char> without_tissue = cells_without_tissue(model);
  for (Index row = 0; row < static_cast<Index>(model.cells.size()); ++row) {
    const Cell& cell = model.cells[row];
    if (!solid(model, row) || (cell.material < 0 && without_tissue[row])) continue;
    if (cell.material < 0) {
      throw Error(cell_label(model, static_cast<std::size_t>(row)) +
                  " has no material although others have; give every solid cell one with set_material");
    }
    vertices += cell.particles.size();
    for (const Index i : cell.particles) {
      if (std::exchange(last[i], cell.material) != cell.material) keys.emplace_back(i, cell.material);
    }
  }
  std::ranges::sort(keys);
  keys.erase(std::ranges::unique(keys).begin(), keys.end());
  std::vector<Index> first(model.rest.size() + 1, 0);
  for (const auto& [particle, material] : keys) {
    domains.particle.push_back(particle);
    domains.material.push_back(material);
    ++first[particle + 1];
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  domains.of_cell.offset.reserve(model.cells.size() + 1);
  domains.of_cell.entry.reserve(vertices);
  for (Index row = 0; row < static_cast<Index>(model.cells.size()); ++row) {
    const Cell& cell = model.cells[row];
    if (solid(model, row) && cell.material >= 0) {
      for (const Index i : cell.particles) {
        Index d = first[i];
        while (domains.material[d] != cell.material) ++d;
        domains.of_cell.entry.push_back(d);
      }
    }
    domains.of_cell.offset.push_back(static_cast<Index>(domains.of_cell.entry.size()));
  }
}

/// As find_kinds() takes them.
RaggedList cells_around(const Domains& domains) {
  const RaggedList& of_cell = domains.of_cell;
  return transpose(domains.count(), of_cell.rows(), most_vertices, [&](Index row, Index vertex) {
    return vertex < of_cell.size(row) ? of_cell.begin(row)[vertex] : none;
  });
}

/// Rows of Domains::pairs for the kinds first ... last - 1. `cells`: as of cells_around().
RaggedList pair_rows(const Domains& domains, const RaggedList& cells, Index first, Index last) {
  RaggedList rows;
  std::vector<Index> row;
  std::vector<Index> seen(static_cast<std::size_t>(cells.rows()), none);  // the last kind that has it
  for (Index kind = first; kind < last; ++kind) {
    const Index d = domains.first_of_kind[kind];
    row.clear();
    for (const Index* entry = cells.begin(d); entry != cells.end(d); ++entry) {
      const Index cell = *entry / most_vertices;
      for (const Index* e = domains.of_cell.begin(cell); e != domains.of_cell.end(cell); ++e) {
        if (std::exchange(seen[*e], kind) != kind) row.push_back(*e - d);
      }
    }
    std::ranges::sort(row);
    rows.push_row(row.begin(), row.end());
  }
  return rows;
}

void pair_domains(const RaggedList& cells, Domains& domains) {
  std::array<RaggedList, 2> rows;
  in_halves(static_cast<Index>(domains.first_of_kind.size()), domains.host,
            [&](int part, Index first, Index last) { rows[part] = pair_rows(domains, cells, first, last); });
  domains.pairs = std::move(rows[0]);
  for (Index k = 0; k < rows[1].rows(); ++k) domains.pairs.push_row(rows[1].begin(k), rows[1].end(k));
}

/// s mu (`spread`) is averaged over the domains of a cell. A domain shares the values of the first of its kind if the
/// s mu around both are equal.
PairStiffness pair_stiffness(const Model& model, const Domains& domains, const std::vector<double>& spread) {
  PairStiffness stiffness;
  std::vector<char> has_own(domains.particle.size());
  Index rows = 0;
  for (Index d = 0; d < domains.count(); ++d) {
    const Index other = domains.first_of_kind[domains.kind[d]];
    has_own[d] = d == other;
    domains.for_each_pair(d, [&](Index e, Index) {
      if (spread[e] != spread[e - d + other]) has_own[d] = 1;
    });
    stiffness.first.push_back(has_own[d] ? rows : stiffness.first[other]);
    if (has_own[d]) rows += domains.pair_count(d);
  }
  stiffness.value.assign(static_cast<std::size_t>(rows), 0.0);
  const auto chosen = [&](Index d) { return has_own[d] != 0; };
  for_each_cell(model, domains, chosen, [&](std::span<const Index> domain, const auto& points, const auto& is_own) {
    std::array<double, most_vertices> weight{};  // of each point
    for (std::size_t k = 0; k < points.size(); ++k) {
      double s_mu = 0.0;
      for (std::size_t v = 0; v < domain.size(); ++v) s_mu += points[k].value[v] * spread[domain[v]];
      weight[k] = points[k].volume * s_mu;
    }
    for (std::size_t a = 0; a < domain.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        double sum = 0.0;
        for (std::size_t k = 0; k < points.size(); ++k) {
          sum += weight[k] * points[k].gradient[a].dot(points[k].gradient[b]);
        }
        const auto [e, d] = std::minmax(domain[a], domain[b]);
        if (is_own(d)) stiffness.value[stiffness.first[d] + domains.place(d, e)] -= sum;
      }
    }
  });
  return stiffness;
}

/// s of each domain: the mean over its cells, by volume.
std::vector<double> stabiliser_of_domains(const Model& model, const Domains& domains, TopologyOptions& options) {
  if (options.stabiliser) return std::vector<double>(domains.particle.size(), *options.stabiliser);
  const std::vector<double> of_cell = calibrated_stabilisers(model, domains).of_cells(model, domains);
  struct Mean {
    double sum = 0.0, weight = 0.0, least = std::numeric_limits<double>::infinity(), most = -least;
    /// Of equal values exactly theirs: rounding would tell domains apart that lie alike.
    double value() const { return least == most ? least : sum / weight; }
  };
  std::vector<Mean> means(domains.particle.size());
  Mean all;
  for (Index row = 0; row < domains.of_cell.rows(); ++row) {
    if (domains.of_cell.size(row) == 0) continue;
    const double volume = std::abs(signed_measure(model.dimension, model.cells[row], model.rest));
    for (const Index* d = domains.of_cell.begin(row); d != domains.of_cell.end(row); ++d) {
      for (Mean* mean : {&means[*d], &all}) {
        mean->sum += volume * of_cell[row];
        mean->weight += volume;
        mean->least = std::min(mean->least, of_cell[row]);
        mean->most = std::max(mean->most, of_cell[row]);
      }
    }
  }
  options.stabiliser = all.value();
  std::vector<double> values;
  values.reserve(means.size());
  for (const Mean& mean : means) values.push_back(mean.value());
  return values;
}

}  // namespace

Index Domains::place(Index d, Index e) const {
  // Rows have some 15 or 27 entries: counting, which does not branch, beats a search.
  Index before = 0;
  for (const Index* at = pairs.begin(kind[d]); at != pairs.end(kind[d]); ++at) before += *at < e - d ? 1 : 0;
  return before;
}

Domains domains_of(const Model& model, TaskRunner* host) {
  Domains domains;
  domains.host = host;
  number_domains(model, domains);
  {
    const RaggedList cells = cells_around(domains);
    find_kinds(model, cells, domains);
    pair_domains(cells, domains);
  }
  domains.volume.assign(domains.first_of_kind.size(), 0.0);
  domains.area.assign(domains.pairs.entry.size(), Vec3::Zero());
  const auto chosen = [&](Index d) { return domains.is_first_of_kind(d); };
  for_each_cell(model, domains, chosen, [&](std::span<const Index> domain, const auto& points, const auto& is_own) {
    for (std::size_t a = 0; a < domain.size(); ++a) {
      const Index d = domain[a];
      if (!is_own(d)) continue;
      for (const CellPoint& point : points) domains.volume[domains.kind[d]] += point.volume * point.value[a];
      for (std::size_t b = 0; b < domain.size(); ++b) {
        Vec3 area = Vec3::Zero();
        for (const CellPoint& point : points) area += point.volume * point.value[a] * point.gradient[b];
        domains.area[domains.first_pair(d) + domains.place(d, domain[b])] += area;
      }
    }
  });
  return domains;
}

namespace {

/// Of the materials that domains have: rows of Model::materials that no cell has say nothing.
template <class Is>
bool any_material(const Model& model, const Domains& domains, Is is) {
  return std::ranges::any_of(domains.material, [&](Index row) { return is(model.materials[row]); });
}

bool has_fibres(const Model& model, const Domains& domains) {
  return any_material(model, domains, [](const Material& m) { return m.fibre_ratio > 1.0; });
}

bool dissipates(const Material& m) {
  return m.retardation_time > 0.0 || m.relaxation_strength > 0.0;
}

/// TopologyTextures::dissipation.
std::vector<DissipationTexel> dissipation_of(const Model& model, const Domains& domains) {
  std::vector<DissipationTexel> of_material, found;
  if (!any_material(model, domains, dissipates)) return found;
  for (const Material& m : model.materials) {
    const double mu = 0.5 * m.young / (1.0 + m.poisson);
    of_material.push_back({mu, 2.0 * mu * m.poisson / (1.0 - 2.0 * m.poisson), m.retardation_time,
                           m.relaxation_strength, m.relaxation_time});
  }
  for (const Index material : domains.material) found.push_back(of_material[material]);
  return found;
}

/// Unit vectors along the fibres of each domain: the mean over its cells. A fibre has no sign: each is turned to the
/// one before. Empty if no material has fibres.
VecList fibres_of(const Model& model, const Domains& domains) {
  if (!has_fibres(model, domains)) return {};
  VecList sum(domains.particle.size(), Vec3::Zero());
  for (Index row = 0; row < domains.of_cell.rows(); ++row) {
    const Cell& cell = model.cells[row];
    if (domains.of_cell.size(row) == 0 || !(model.materials[cell.material].fibre_ratio > 1.0)) continue;
    if (cell.fibre.isZero(0.0) || !cell.fibre.allFinite()) {
      throw Error(ErrorCode::invalid_model, cell_label(model, static_cast<std::size_t>(row)) +
                                                " has a material with fibres but no direction: set Cell::fibre");
    }
    const Vec3 along = std::abs(signed_measure(model.dimension, cell, model.rest)) * unit_fibre(cell);
    for (const Index* d = domains.of_cell.begin(row); d != domains.of_cell.end(row); ++d) {
      sum[*d] += sum[*d].dot(along) < 0.0 ? Vec3(-along) : along;
    }
  }
  for (Vec3& along : sum) along.normalize();
  return sum;
}

/// Spare particles (with_spare_particles) get a domain of every material, which has no links and is at rest until a cut
/// uses it.
void add_spare_domains(const Model& model, TopologyTextures& topology) {
  const std::vector<Index> spare = spare_particles_of(model);
  if (spare.empty()) return;
  double volume = 0.0;  // m^3, of a domain
  std::vector<DomainTexel> last(model.materials.size());
  std::vector<DissipationTexel> dissipation(last.size());
  for (std::size_t d = 0; d < topology.domains.size(); ++d) {
    const DomainTexel& domain = topology.domains[d];
    volume += 1.0 / domain.inverse_volume / static_cast<double>(topology.domains.size());
    last[domain.material] = domain;
    if (!topology.dissipation.empty()) dissipation[domain.material] = topology.dissipation[d];
  }
  for (const Index i : spare) {
    for (std::size_t material = 0; material < last.size(); ++material) {
      if (last[material].particle == none) continue;
      topology.domains.push_back({.particle = i,
                                  .material = last[material].material,
                                  .energy = last[material].energy,
                                  .inverse_volume = 1.0 / volume,
                                  .spread_stiffness = last[material].spread_stiffness});
      if (!topology.dissipation.empty()) topology.dissipation.push_back(dissipation[material]);
    }
    topology.first_domain[i + 1] = static_cast<Index>(topology.domains.size());
  }
}

}  // namespace

void add_averaged_terms(const Model& model, TopologyTextures& topology) {
  const bool points = is_body_of_points(model);
  PointDomains body;
  if (points) body = point_domains(model);
  const Domains domains = points ? std::move(body.domains) : domains_of(model, topology.options.runner.get());
  const bool fibres_there = has_fibres(model, domains);
  if (fibres_there) topology.options.strain_energy = StrainEnergy::fibres;
  if (any_material(model, domains, [](const Material& m) { return m.stiffening != Stiffening{}; })) {
    if (fibres_there) {
      throw Error(ErrorCode::invalid_model,
                  "a model has a material with fibre_ratio above 1 and one with stiffening; expected one of the two, "
                  "because a body has one strain energy: set fibre_ratio to 1 or stiffening to zeros everywhere");
    }
    topology.options.strain_energy = StrainEnergy::stiffening;
  }
  if (points && !topology.options.stabiliser) {
    topology.options.stabiliser = std::max(body.stabiliser, least_stabiliser);
  }
  std::vector<double> spread = stabiliser_of_domains(model, domains, topology.options);
  const VecList fibres = fibres_of(model, domains);
  topology.domains.reserve(domains.particle.size());
  std::vector<Index> last(model.materials.size(), none);  // row of each material's constants
  const auto energy_row = [&](Index d) {
    Index& row = last[domains.material[d]];
    const EnergyConstants own = energy_constants(topology.options.strain_energy, model.materials[domains.material[d]],
                                                 fibres.empty() ? Vec3(Vec3::Zero()) : fibres[d]);
    if (row == none || topology.energies[row] != own) {  // another direction of fibres
      row = static_cast<Index>(topology.energies.size());
      topology.energies.push_back(own);
    }
    return row;
  };
  for (Index d = 0; d < domains.count(); ++d) {
    const Material& material = model.materials[domains.material[d]];
    spread[d] *= 0.5 * material.young / (1.0 + material.poisson);
    topology.domains.push_back({.particle = domains.particle[d],
                                .material = domains.material[d],
                                .energy = energy_row(d),
                                .inverse_volume = 1.0 / domains.volume[domains.kind[d]],
                                .spread_stiffness = spread[d]});
  }
  topology.dissipation = dissipation_of(model, domains);
  topology.first_domain.assign(model.rest.size() + 1, 0);
  for (const Index i : domains.particle) ++topology.first_domain[i + 1];
  std::partial_sum(topology.first_domain.begin(), topology.first_domain.end(), topology.first_domain.begin());
  if (points) {
    for (double& stiffness : body.stiffness.value) stiffness *= spread.front();  // one material
    add_links(domains, body.stiffness, topology);
  } else {
    add_links(domains, pair_stiffness(model, domains, spread), topology);
    add_spare_domains(model, topology);
  }
}

}  // namespace phymul
