// SPDX-License-Identifier: MIT
#include "averaged_body.h"

#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "cell_quadrature.h"
#include "model/cell_geometry.h"
#include "model/point_cells.h"
#include "point_domains.h"
#include "stabiliser.h"
#include "transpose.h"

namespace phymul {
namespace {

/// What rounding leaves of a weight that is zero by symmetry, over the largest one of its domain.
constexpr double rounding = 1e-11;

bool solid(const Model& model, Index row) {
  return is_solid(model.dimension, model.cells[row].type);
}

/// Calls with (domains of its vertices, their number, its points) of every solid cell.
template <class Visit>
void for_each_cell(const Model& model, const Domains& domains, const Visit& visit) {
  std::vector<CellPoint> points;
  for (Index row = 0; row < domains.of_cell.rows(); ++row) {
    if (domains.of_cell.size(row) == 0) continue;
    cell_points(model, row, points);
    visit(domains.of_cell.begin(row), domains.of_cell.size(row), points);
  }
}

/// Domain numbers: one for each particle and each material around it.
void number_domains(const Model& model, Domains& domains) {
  std::vector<std::pair<Index, Index>> keys;  // particle, material
  for (Index row = 0; row < static_cast<Index>(model.cells.size()); ++row) {
    const Cell& cell = model.cells[row];
    if (!solid(model, row)) continue;
    if (cell.material < 0) {
      throw Error(cell_label(model, static_cast<std::size_t>(row)) +
                  " has no material although others have; give every solid cell one with set_material");
    }
    for (const Index i : cell.particles) keys.emplace_back(i, cell.material);
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
  std::vector<Index> of_vertex;
  for (Index row = 0; row < static_cast<Index>(model.cells.size()); ++row) {
    const Cell& cell = model.cells[row];
    of_vertex.clear();
    if (solid(model, row)) {
      for (const Index i : cell.particles) {
        Index d = first[i];
        while (domains.material[d] != cell.material) ++d;
        of_vertex.push_back(d);
      }
    }
    domains.of_cell.push_row(of_vertex.begin(), of_vertex.end());
  }
}

/// Rows of the domains that share a cell, with zeros for weights.
void pair_domains(Domains& domains) {
  const Index count = domains.count();
  std::vector<Index> owner(domains.of_cell.entry.size());
  for (Index row = 0; row < domains.of_cell.rows(); ++row) {
    std::fill(owner.begin() + domains.of_cell.offset[row], owner.begin() + domains.of_cell.offset[row + 1], row);
  }
  const RaggedList cells = transpose(count, static_cast<Index>(owner.size()), 1,
                                     [&](Index entry, Index) { return domains.of_cell.entry[entry]; });
  std::vector<Index> row;
  for (Index d = 0; d < count; ++d) {
    row.clear();
    for (const Index* entry = cells.begin(d); entry != cells.end(d); ++entry) {
      const Index cell = owner[*entry];
      row.insert(row.end(), domains.of_cell.begin(cell), domains.of_cell.end(cell));
    }
    std::ranges::sort(row);
    row.erase(std::ranges::unique(row).begin(), row.end());
    for (const Index e : row) domains.pairs.push_back({e, Vec3::Zero()});
    domains.first_pair.push_back(static_cast<Index>(domains.pairs.size()));
  }
}

/// k_de = -integral of s mu grad N_d . grad N_e, s mu averaged over the domains, per row of pairs.
std::vector<double> pair_stiffness(const Model& model, const Domains& domains, const std::vector<double>& spread) {
  std::vector<double> stiffness(domains.pairs.size(), 0.0);
  for_each_cell(model, domains, [&](const Index* domain, Index vertices, const std::vector<CellPoint>& points) {
    for (Index a = 0; a < vertices; ++a) {
      for (Index b = 0; b < vertices; ++b) {
        if (a == b) continue;
        double sum = 0.0;
        for (const CellPoint& point : points) {
          double s_mu = 0.0;
          for (Index v = 0; v < vertices; ++v) s_mu += point.value[v] * spread[domain[v]];
          sum += point.volume * s_mu * point.gradient[a].dot(point.gradient[b]);
        }
        stiffness[domains.pair(domain[a], domain[b])] -= sum;
      }
    }
  });
  return stiffness;
}

/// s of each domain: the mean over its cells of their types' values.
std::vector<double> stabiliser_of_domains(const Model& model, const Domains& domains, TopologyOptions& options) {
  if (options.stabiliser) return std::vector<double>(domains.particle.size(), *options.stabiliser);
  const std::vector<CalibratedStabiliser> calibrated = calibrated_stabilisers(model, domains);
  std::vector<double> sum(domains.particle.size(), 0.0), weight(sum);
  for (Index row = 0; row < domains.of_cell.rows(); ++row) {
    double s = least_stabiliser;
    for (const CalibratedStabiliser& it : calibrated) {
      if (it.type == model.cells[row].type) s = it.value;
    }
    const double volume = std::abs(signed_measure(model.dimension, model.cells[row], model.rest));
    for (const Index* d = domains.of_cell.begin(row); d != domains.of_cell.end(row); ++d) {
      sum[*d] += volume * s;
      weight[*d] += volume;
    }
  }
  double mean = 0.0, whole = 0.0;
  for (std::size_t d = 0; d < sum.size(); ++d) {
    mean += sum[d];
    whole += weight[d];
    sum[d] /= weight[d];
  }
  options.stabiliser = mean / whole;
  return sum;
}

void add_links(const Domains& domains, const std::vector<double>& stiffness, TopologyTextures& topology) {
  for (Index d = 0; d < domains.count(); ++d) {
    double largest = 0.0;
    for (Index r = domains.first_pair[d]; r < domains.first_pair[d + 1]; ++r) {
      largest = std::max(largest, domains.pairs[r].area.cwiseAbs().maxCoeff());
    }
    const auto cleaned = [&](const Vec3& area) {
      return Vec3((area.array().abs() > rounding * largest).select(area, 0.0));
    };
    for (Index r = domains.first_pair[d]; r < domains.first_pair[d + 1]; ++r) {
      const Index e = domains.pairs[r].domain;
      const Vec3& there = domains.pairs[r].area;
      const Vec3& back = domains.pairs[domains.pair(e, d)].area;
      const Vec3 surface = cleaned(0.5 * (there + back));
      if (surface != Vec3::Zero()) topology.surface_links.push_back({e, surface});
      if (e != d) topology.links.push_back({e, cleaned(0.5 * (there - back)), stiffness[r]});
    }
    topology.first_link.push_back(static_cast<Index>(topology.links.size()));
    topology.first_surface_link.push_back(static_cast<Index>(topology.surface_links.size()));
  }
}

}  // namespace

Index Domains::pair(Index d, Index e) const {
  const auto first = pairs.begin() + first_pair[d], last = pairs.begin() + first_pair[d + 1];
  return static_cast<Index>(std::ranges::lower_bound(first, last, e, {}, &DomainPair::domain) - pairs.begin());
}

Domains domains_of(const Model& model) {
  Domains domains;
  number_domains(model, domains);
  pair_domains(domains);
  domains.volume.assign(domains.particle.size(), 0.0);
  for_each_cell(model, domains, [&](const Index* domain, Index vertices, const std::vector<CellPoint>& points) {
    for (Index a = 0; a < vertices; ++a) {
      for (const CellPoint& point : points) domains.volume[domain[a]] += point.volume * point.value[a];
      for (Index b = 0; b < vertices; ++b) {
        Vec3 area = Vec3::Zero();
        for (const CellPoint& point : points) area += point.volume * point.value[a] * point.gradient[b];
        domains.pairs[domains.pair(domain[a], domain[b])].area += area;
      }
    }
  });
  return domains;
}

void add_averaged_terms(const Model& model, TopologyTextures& topology) {
  const bool points = is_body_of_points(model);
  PointDomains body;
  if (points) body = point_domains(model);
  const Domains domains = points ? std::move(body.domains) : domains_of(model);
  if (points && !topology.options.stabiliser) topology.options.stabiliser = body.stabiliser;
  std::vector<double> spread = stabiliser_of_domains(model, domains, topology.options);
  for (Index d = 0; d < domains.count(); ++d) {
    const Material& material = model.materials[domains.material[d]];
    const Calibration energy = calibrate(material, PoissonRoute::volume_term);
    spread[d] *= 0.5 * material.young / (1.0 + material.poisson);
    topology.domains.push_back({domains.particle[d], 1.0 / domains.volume[d], energy.c, energy.kappa, spread[d]});
  }
  topology.first_domain.assign(model.rest.size() + 1, 0);
  for (const Index i : domains.particle) ++topology.first_domain[i + 1];
  std::partial_sum(topology.first_domain.begin(), topology.first_domain.end(), topology.first_domain.begin());
  if (points) {
    for (double& stiffness : body.stiffness) stiffness *= spread.front();  // one material
    add_links(domains, body.stiffness, topology);
  } else {
    add_links(domains, pair_stiffness(model, domains, spread), topology);
  }
}

}  // namespace phymul
