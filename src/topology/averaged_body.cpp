// SPDX-License-Identifier: MIT
#include "averaged_body.h"

#include <phymul/error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "base/side_by_side.h"
#include "cell_quadrature.h"
#include "energies.h"
#include "model/cell_geometry.h"
#include "model/material.h"
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

/// Calls visit(domains of its vertices, its points, is_own) for every solid cell, from two threads, each with one half
/// of the domains for its own and the cells around them. Who visits writes rows of its own domains only; these see the
/// cells in their order.
template <class Visit>
void for_each_cell(const Model& model, const Domains& domains, const Visit& visit) {
  in_halves(domains.count(), domains.host, [&](int, Index first, Index last) {
    const auto is_own = [&](Index d) { return first <= d && d < last; };
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
  for (Index row = 0; row < static_cast<Index>(model.cells.size()); ++row) {
    const Cell& cell = model.cells[row];
    if (!solid(model, row)) continue;
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
    if (solid(model, row)) {
      for (const Index i : cell.particles) {
        Index d = first[i];
        while (domains.material[d] != cell.material) ++d;
        domains.of_cell.entry.push_back(d);
      }
    }
    domains.of_cell.offset.push_back(static_cast<Index>(domains.of_cell.entry.size()));
  }
}

constexpr Index most_vertices = 8;  // of a cell

/// Rows of Domains::pairs for the domains first ... last - 1. cells: per domain the entries cell * most_vertices +
/// vertex.
RaggedList pair_rows(const RaggedList& of_cell, const RaggedList& cells, Index first, Index last) {
  RaggedList rows;
  std::vector<Index> row;
  std::vector<Index> seen(static_cast<std::size_t>(cells.rows()), none);  // the last row that has it
  for (Index d = first; d < last; ++d) {
    row.clear();
    for (const Index* entry = cells.begin(d); entry != cells.end(d); ++entry) {
      const Index cell = *entry / most_vertices;
      for (const Index* e = of_cell.begin(cell); e != of_cell.end(cell); ++e) {
        if (std::exchange(seen[*e], d) != d) row.push_back(*e);
      }
    }
    std::ranges::sort(row);
    rows.push_row(row.begin(), row.end());
  }
  return rows;
}

void pair_domains(Domains& domains) {
  const RaggedList& of_cell = domains.of_cell;
  const RaggedList cells = transpose(domains.count(), of_cell.rows(), most_vertices, [&](Index row, Index vertex) {
    return vertex < of_cell.size(row) ? of_cell.begin(row)[vertex] : none;
  });
  std::array<RaggedList, 2> rows;
  in_halves(domains.count(), domains.host,
            [&](int part, Index first, Index last) { rows[part] = pair_rows(of_cell, cells, first, last); });
  domains.pairs = std::move(rows[0]);
  for (Index d = 0; d < rows[1].rows(); ++d) domains.pairs.push_row(rows[1].begin(d), rows[1].end(d));
}

/// -integral of s mu grad N_d . grad N_e for every pair with e < d, s mu (`spread`) averaged over the domains; of the
/// other pairs, where it is the same, 0.
std::vector<double> pair_stiffness(const Model& model, const Domains& domains, const std::vector<double>& spread) {
  std::vector<double> stiffness(domains.pairs.entry.size(), 0.0);
  for_each_cell(model, domains, [&](std::span<const Index> domain, std::span<const CellPoint> points, auto is_own) {
    std::array<double, 8> weight{};  // of each point
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
        if (is_own(d)) stiffness[domains.pair(d, e)] -= sum;
      }
    }
  });
  return stiffness;
}

/// s of each domain: the mean over its cells, by volume.
std::vector<double> stabiliser_of_domains(const Model& model, const Domains& domains, TopologyOptions& options) {
  if (options.stabiliser) return std::vector<double>(domains.particle.size(), *options.stabiliser);
  const std::vector<double> of_cell =
      calibrated_stabilisers(model, domains).of_cells(model, domains, kind_of(options.strain_energy).least_stabiliser);
  std::vector<double> sum(domains.particle.size(), 0.0), weight(sum);
  for (Index row = 0; row < domains.of_cell.rows(); ++row) {
    if (domains.of_cell.size(row) == 0) continue;
    const double volume = std::abs(signed_measure(model.dimension, model.cells[row], model.rest));
    for (const Index* d = domains.of_cell.begin(row); d != domains.of_cell.end(row); ++d) {
      sum[*d] += volume * of_cell[row];
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
  const RaggedList& pairs = domains.pairs;
  topology.links.reserve(pairs.entry.size() - domains.particle.size());
  // Where row e has d: both rows are in increasing order, so that it is where the row has been read to.
  std::vector<Index> next(pairs.offset.begin(), pairs.offset.end() - 1);
  for (Index d = 0; d < domains.count(); ++d) {
    double largest = 0.0;
    for (Index r = pairs.offset[d]; r < pairs.offset[d + 1]; ++r) {
      largest = std::max(largest, domains.area[r].cwiseAbs().maxCoeff());
    }
    const auto cleaned = [&](const Vec3& area) {
      return Vec3((area.array().abs() > rounding * largest).select(area, 0.0));
    };
    for (Index r = pairs.offset[d]; r < pairs.offset[d + 1]; ++r) {
      const Index e = pairs.entry[r];
      const Vec3& there = domains.area[r];
      const Index reverse = next[e]++;
      const Vec3& back = domains.area[reverse];
      const Vec3 surface = cleaned(0.5 * (there + back));
      if (surface != Vec3::Zero()) topology.surface_links.push_back({e, surface});
      if (e != d) topology.links.push_back({e, cleaned(0.5 * (there - back)), stiffness[e < d ? r : reverse]});
    }
    topology.first_link.push_back(static_cast<Index>(topology.links.size()));
    topology.first_surface_link.push_back(static_cast<Index>(topology.surface_links.size()));
  }
  topology.surface_links.shrink_to_fit();
}

}  // namespace

Index Domains::pair(Index d, Index e) const {
  // Rows have some 15 or 27 entries: counting, which does not branch, beats a search.
  Index before = 0;
  for (const Index* at = pairs.begin(d); at != pairs.end(d); ++at) before += *at < e ? 1 : 0;
  return pairs.offset[d] + before;
}

Domains domains_of(const Model& model, TaskRunner* host) {
  Domains domains;
  domains.host = host;
  number_domains(model, domains);
  pair_domains(domains);
  domains.volume.assign(domains.particle.size(), 0.0);
  domains.area.assign(domains.pairs.entry.size(), Vec3::Zero());
  for_each_cell(model, domains, [&](std::span<const Index> domain, std::span<const CellPoint> points, auto is_own) {
    for (std::size_t a = 0; a < domain.size(); ++a) {
      if (!is_own(domain[a])) continue;
      for (const CellPoint& point : points) domains.volume[domain[a]] += point.volume * point.value[a];
      for (std::size_t b = 0; b < domain.size(); ++b) {
        Vec3 area = Vec3::Zero();
        for (const CellPoint& point : points) area += point.volume * point.value[a] * point.gradient[b];
        domains.area[domains.pair(domain[a], domain[b])] += area;
      }
    }
  });
  return domains;
}

namespace {

bool has_fibres(const Model& model) {
  return std::ranges::any_of(model.materials, [](const Material& material) { return material.fibre_ratio > 1.0; });
}

/// TopologyTextures::dissipation.
std::vector<DissipationTexel> dissipation_of(const Model& model, const Domains& domains) {
  bool any = false;
  std::vector<DissipationTexel> of_material;
  for (const Material& m : model.materials) {
    require_dissipation_in_range(m);
    any = any || m.retardation_time > 0.0 || m.relaxation_strength > 0.0;
    const double mu = 0.5 * m.young / (1.0 + m.poisson);
    of_material.push_back({mu, 2.0 * mu * m.poisson / (1.0 - 2.0 * m.poisson), m.retardation_time,
                           m.relaxation_strength, m.relaxation_time});
  }
  std::vector<DissipationTexel> found;
  if (!any) return found;
  for (const Index material : domains.material) found.push_back(of_material[material]);
  return found;
}

void choose_energy(const Model& model, StrainEnergy& energy) {
  if (!has_fibres(model)) return;
  if (energy == StrainEnergy::neo_hookean) {
    throw Error(
        "StrainEnergy::neo_hookean has no fibres, and a material has a fibre_ratio above 1. Set it to 1, or leave "
        "StrainEnergy::shape_memory");
  }
  energy = StrainEnergy::fibres;
}

/// Unit vectors along the fibres of each domain: the mean over its cells. A fibre has no sign: each is turned to the
/// one before.
VecList fibres_of(const Model& model, const Domains& domains) {
  VecList sum(domains.particle.size(), Vec3::Zero());
  if (!has_fibres(model)) return sum;
  for (Index row = 0; row < domains.of_cell.rows(); ++row) {
    const Cell& cell = model.cells[row];
    if (domains.of_cell.size(row) == 0 || !(model.materials[cell.material].fibre_ratio > 1.0)) continue;
    if (!(cell.fibre.norm() > 0.0) || !cell.fibre.allFinite()) {
      throw Error(ErrorCode::invalid_model, cell_label(model, static_cast<std::size_t>(row)) +
                                                " has a material with fibres but no direction: set Cell::fibre");
    }
    const Vec3 along = std::abs(signed_measure(model.dimension, cell, model.rest)) * cell.fibre.normalized();
    for (const Index* d = domains.of_cell.begin(row); d != domains.of_cell.end(row); ++d) {
      sum[*d] += sum[*d].dot(along) < 0.0 ? Vec3(-along) : along;
    }
  }
  for (Vec3& along : sum) along.normalize();
  return sum;
}

}  // namespace

void add_averaged_terms(const Model& model, TopologyTextures& topology) {
  choose_energy(model, topology.options.strain_energy);
  const bool points = is_body_of_points(model);
  PointDomains body;
  if (points) body = point_domains(model);
  const Domains domains = points ? std::move(body.domains) : domains_of(model, topology.options.runner.get());
  if (points && !topology.options.stabiliser) {
    topology.options.stabiliser = std::max(body.stabiliser, kind_of(topology.options.strain_energy).least_stabiliser);
  }
  std::vector<double> spread = stabiliser_of_domains(model, domains, topology.options);
  const VecList fibres = fibres_of(model, domains);
  topology.domains.reserve(domains.particle.size());
  for (Index d = 0; d < domains.count(); ++d) {
    const Material& material = model.materials[domains.material[d]];
    spread[d] *= 0.5 * material.young / (1.0 + material.poisson);
    topology.domains.push_back({domains.particle[d], domains.material[d], 1.0 / domains.volume[d], spread[d],
                                energy_constants(topology.options.strain_energy, material, fibres[d])});
  }
  topology.dissipation = dissipation_of(model, domains);
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
