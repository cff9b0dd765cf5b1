// SPDX-License-Identifier: MIT
#include "body_edit.h"

#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "averaged_body.h"
#include "energies.h"
#include "model/cell_geometry.h"
#include "wall_terms.h"

namespace phymul {
namespace {

/// Bounds, with some reserve, on how much more the largest eigenvalue grows than rate_ says. Measured: 2.13, 1.62
/// for planes, 2.63 where a few light particles set the first value (masses not balanced), 2.5 in sheets and spheres.
constexpr double of_removals = 2.3, of_cuts = 1.8, of_light_particles = 2.8, of_walls = 2.8;

bool has_material(const Model& model, const Cell& cell) {
  return cell.material >= 0 && is_tissue(model, cell);
}

template <class T>
void sort_unique(std::vector<T>& list) {
  std::ranges::sort(list);
  const auto again = std::ranges::unique(list);
  list.erase(again.begin(), again.end());
}

}  // namespace

BodyEdit::BodyEdit(Model& model, TopologyTextures& topology) : model_(model), topology_(topology) {
  if ((topology.domains.empty() && topology.walls.empty()) || is_body_of_points(model)) {
    throw Error(ErrorCode::not_supported,
                "remove_cells: expected a body of cells or walls with a material (set_material), got one without");
  }
  cells_of_.resize(model.rest.size());
  walls_of_.resize(model.rest.size());
  for (Index row = 0; row < static_cast<Index>(model.cells.size()); ++row) {
    at_start_.push_back(model.cells[row].share > 0.0);
    whole_share_.push_back(at_start_.back() != 0 ? model.cells[row].share : 1.0);
    mass_of_corner_.push_back(0.0);
    take_cell(row);
  }
  find_walls();
  first_of_.resize(model.rest.size());
  std::iota(first_of_.begin(), first_of_.end(), 0);
  double squared_edge = 0.0;
  std::vector<Index> tissue;
  for (std::size_t row = 0; row < model.cells.size(); ++row) {
    const Cell& cell = model.cells[row];
    if (!has_material(model, cell)) continue;
    tissue.push_back(static_cast<Index>(row));
    for (auto a = cell.particles.begin(); a != cell.particles.end(); ++a) {
      for (auto b = cell.particles.begin(); b != a; ++b) {
        squared_edge = std::max(squared_edge, (model.rest[*a] - model.rest[*b]).squaredNorm());
      }
    }
  }
  longest_edge_ = std::sqrt(squared_edge);
  spacing_ = tissue_spacing(model, tissue);
  mass_ = model.mass;
  lumped_.resize(mass_.size());
  for (Index i = 0; i < model.particle_count(); ++i) weigh_lumped(i);
  for (Index d = 0; d < static_cast<Index>(topology.domains.size()); ++d) modulus_.push_back(modulus_of(d));
  spare_ = spare_particles_of(model);
  std::ranges::reverse(spare_);
  if (!spare_.empty()) {
    spare_places_ = model.rest;
    // So that no cut waits for the body's lists to be moved: about what is used until there are no spare ones left.
    const std::size_t cells = 6 * spare_.size(), links = 60 * spare_.size();
    model.cells.reserve(model.cells.size() + cells);
    whole_share_.reserve(model.cells.size() + cells);
    mass_of_corner_.reserve(model.cells.size() + cells);
    walls_at_.reserve(model.cells.size() + cells);
    if (!topology.walls.empty()) topology.walls.reserve(topology.walls.size() + cells);
    topology.links.reserve(topology.links.size() + links);
    topology.surface_links.reserve(topology.surface_links.size() + links);
  }
  rate_.assign(mass_.size(), 0.0);
  for (Index i = 0; i < model.particle_count(); ++i) find_rate(i);
  std::vector<double> rates = rate_;
  std::erase(rates, 0.0);  // of spare particles
  std::ranges::sort(rates);
  largest_rate_ = rates.back();
  few_set_the_rate_ = rates[rates.size() * 9 / 10] < 0.6 * largest_rate_;
  room_.resize(topology.domains.size());
  surface_room_.resize(room_.size());
  place_of_.assign(room_.size(), none);
  topology.built = fingerprint(topology);
}

/// Lists a cell by its particles.
void BodyEdit::take_cell(Index row) {
  const auto insert = [row](std::vector<Index>& rows) {
    const auto at = std::ranges::lower_bound(rows, row);
    if (at == rows.end() || *at != row) rows.insert(at, row);
  };
  if (is_clamp(model_.cells[row])) {
    for (const Index i : model_.cells[row].particles) insert(walls_of_[i]);
  }
  if (!has_material(model_, model_.cells[row])) return;
  const bool is_new = at_start_[row] != 0 && !is_listed(row);
  Cell whole = model_.cells[row];
  whole.share = whole_share_[row];
  mass_of_corner_[row] = model_.materials[whole.material].density * tissue_volume(model_, whole) /
                         static_cast<double>(whole.particles.size());
  for (const Index i : whole.particles) {
    insert(cells_of_[i]);
    if (is_new && i == whole.particles.front()) ++cell_count_;  // once it is listed, and nothing before throws
    if (is_of_wall(model_, whole)) insert(walls_of_[i]);
  }
}

void BodyEdit::weigh_lumped(Index i) {
  lumped_[i] = 0.0;
  for (const Index row : cells_of_[i]) lumped_[i] += at_start_[row] != 0 ? mass_of_corner_[row] : 0.0;
}

void BodyEdit::require_cell(Index cell) const {
  const auto count = static_cast<Index>(model_.cells.size());
  if (cell < 0 || cell >= count) {
    throw Error("remove_cells: expected rows of Model::cells from 0 to " + std::to_string(count - 1) + ", got " +
                std::to_string(cell));
  }
  if (has_material(model_, model_.cells[cell])) return;
  throw Error("remove_cells: expected cells that fill space, or triangles of a wall, with a material; " +
              cell_label(model_, static_cast<std::size_t>(cell)) + " is none");
}

void BodyEdit::set_shares(std::span<const Index> cells, double share) {
  for (const Index cell : cells) require_cell(cell);
  std::vector<Index> changed, particles, domains;
  for (const Index row : cells) {
    if ((model_.cells[row].share > 0.0) != (share > 0.0)) changed.push_back(row);
  }
  sort_unique(changed);
  for (const Index row : changed) {
    const Cell& cell = model_.cells[row];
    for (const Index i : cell.particles) {
      particles.push_back(i);
      if (!is_of_wall(model_, cell)) domains.push_back(domain_of(i, cell.material));
    }
  }
  if (changed.empty()) return;
  if (share == 0.0 && topology_.removed.size() + changed.size() == cell_count_) {
    throw Error("remove_cells: expected some cell of the body to be left, got all of them");
  }
  topology_.edited.reserve(topology_.edited.size() + domains.size());
  topology_.removed.reserve(topology_.removed.size() + changed.size());
  for (const Index row : changed) {
    model_.cells[row].share = share * whole_share_[row];
    const auto at = std::ranges::lower_bound(topology_.removed, row);
    if (share == 0.0) {
      topology_.removed.insert(at, row);
    } else if (at != topology_.removed.end() && *at == row) {
      topology_.removed.erase(at);
    }
  }
  follow(std::move(domains), std::move(particles));
}

/// Updates rows, masses and rates where cells at these domains and particles have changed.
void BodyEdit::follow(std::vector<Index> domains, std::vector<Index> particles) {
  sort_unique(domains);
  for (const Index d : domains) {
    integrate(d);
    write(d);
  }
  follow_walls(particles);
  // The own blocks of linked particles change, too.
  for (const Index d : domains) {
    for (const LinkTexel& link : topology_.links_of(d)) {
      particles.push_back(topology_.domains[d + link.offset].particle);
    }
  }
  for (std::size_t k = 0, count = particles.size(); k < count; ++k) {
    const auto family = copies_.find(first_of_[particles[k]]);
    if (family != copies_.end()) particles.insert(particles.end(), family->second.begin(), family->second.end());
  }
  sort_unique(particles);
  std::vector<double> mass_before;
  for (const Index i : particles) mass_before.push_back(model_.mass[i]);
  for (const Index i : particles) {
    const auto family = copies_.find(first_of_[i]);
    if (family == copies_.end()) weigh(i);
    if (family != copies_.end() && i == family->first) weigh_family(family->second);
  }
  for (const Index i : particles) find_rate(i);
  const double growth = largest_rate_ > 0.0 ? std::ranges::max(rate_) / largest_rate_ : 1.0;
  const double beyond = !topology_.walls.empty()    ? of_walls
                        : few_set_the_rate_         ? of_light_particles
                        : topology_.removed.empty() ? of_cuts
                                                    : of_removals;
  const bool is_whole = topology_.removed.empty() && topology_.cuts.empty();
  topology_.stiffened = is_whole ? 1.0 : beyond * std::max(1.0, growth);
  topology_.edited.insert(topology_.edited.end(), domains.begin(), domains.end());
  for (std::size_t k = 0; k < particles.size(); ++k) {
    const Index i = particles[k];
    const bool has_domain = !topology_.domains.empty() && topology_.first_domain[i] < topology_.first_domain[i + 1];
    if (has_domain && model_.mass[i] != mass_before[k]) topology_.edited.push_back(topology_.first_domain[i]);
  }
  ++topology_.edits;
  topology_.model.reset();
}

Index BodyEdit::domain_of(Index particle, Index material) const {
  Index d = topology_.first_domain[particle];
  while (topology_.domains[d].material != material) ++d;
  return d;
}

/// kg, of a particle: density times its share of the volume of its cells.
double BodyEdit::lumped_mass(Index particle) const {
  double sum = 0.0;
  for (const Index row : cells_of_[particle]) sum += model_.cells[row].share > 0.0 ? mass_of_corner_[row] : 0.0;
  return sum;
}

/// Pa: lambda + 2 mu less spread_stiffness, but at least mu, and the part of fibres.
double BodyEdit::modulus_of(Index domain) const {
  const Material& m = model_.materials[topology_.domains[domain].material];
  const double mu = 0.5 * m.young / (1.0 + m.poisson), lambda = 2.0 * mu * m.poisson / (1.0 - 2.0 * m.poisson);
  return std::max(lambda + 2.0 * mu - topology_.domains[domain].spread_stiffness, mu) + (m.fibre_ratio - 1.0) * m.young;
}

/// N/m: a bound on a particle's own block of the stiffness. Each domain d whose mean F has the particle adds
/// modulus |C_di|^2 / V_d, and links add their springs.
double BodyEdit::own_stiffness(Index i) const {
  double sum = own_stiffness_in_walls(i);
  if (topology_.domains.empty()) return sum;
  for (Index d = topology_.first_domain[i]; d < topology_.first_domain[i + 1]; ++d) {
    const auto add = [&](Index e, const Vec3& area) {
      sum += modulus_[e] * topology_.domains[e].inverse_volume * area.squaredNorm();
    };
    const std::span<const SurfaceLinkTexel> surface = topology_.surface_links_of(d);
    auto next = surface.begin();
    for (const LinkTexel& link : topology_.links_of(d)) {
      Vec3 area = -link.area;
      for (; next != surface.end() && next->offset <= link.offset; ++next) {
        if (next->offset == link.offset) area += next->area;
        if (next->offset == 0) add(d, next->area);
      }
      add(d + link.offset, area);
      sum += link.stiffness;
    }
    for (; next != surface.end(); ++next) add(d, next->area);
  }
  return sum;
}

/// Integrals over the cells of a domain that are left: volume_ and pairs_, in order of the other domains.
void BodyEdit::integrate(Index d) {
  const DomainTexel& domain = topology_.domains[d];
  for (const Pair& pair : pairs_) place_of_[pair.domain] = none;  // also where memory ran out
  pairs_.clear();
  volume_ = 0.0;
  for (const Index row : cells_of_[domain.particle]) {
    const Cell& cell = model_.cells[row];
    if (cell.share == 0.0 || cell.material != domain.material) continue;
    cell_points(model_, row, points_);
    const std::size_t vertices = cell.particles.size();
    std::array<Index, 8> domains{};
    for (std::size_t v = 0; v < vertices; ++v) domains[v] = domain_of(cell.particles[v], cell.material);
    s_mu_.clear();
    for (const CellPoint& point : points_) {
      double sum = 0.0;
      for (std::size_t v = 0; v < vertices; ++v) sum += point.value[v] * topology_.domains[domains[v]].spread_stiffness;
      s_mu_.push_back(point.volume * sum);
    }
    for (std::size_t a = 0; a < vertices; ++a) {
      if (domains[a] != d) continue;
      for (std::size_t b = 0; b < vertices; ++b) {
        Index& place = place_of_[domains[b]];
        if (place == none) {
          pairs_.push_back({.domain = domains[b]});
          place = static_cast<Index>(pairs_.size()) - 1;
        }
        Pair& pair = pairs_[place];
        for (std::size_t k = 0; k < points_.size(); ++k) {
          const CellPoint& point = points_[k];
          pair.there += point.volume * point.value[a] * point.gradient[b];
          pair.back += point.volume * point.value[b] * point.gradient[a];
          pair.stiffness -= s_mu_[k] * point.gradient[a].dot(point.gradient[b]);
        }
      }
      for (const CellPoint& point : points_) volume_ += point.volume * point.value[a];
    }
  }
  std::ranges::sort(pairs_, {}, &Pair::domain);
}

/// The rows of a domain from its integrals. Without a cell it keeps its volume, whose energy is that of rest.
void BodyEdit::write(Index d) {
  DomainTexel& domain = topology_.domains[d];
  if (volume_ > 0.0) domain.inverse_volume = 1.0 / volume_;
  links_.clear();
  surface_links_.clear();
  double largest = 0.0;
  for (const Pair& pair : pairs_) largest = std::max(largest, pair.there.cwiseAbs().maxCoeff());
  const auto cleaned = [&](const Vec3& area) {
    return Vec3((area.array().abs() > rounding_of_area * largest).select(area, 0.0));
  };
  for (const Pair& pair : pairs_) {
    const Vec3 surface = cleaned(0.5 * (pair.there + pair.back));
    if (surface != Vec3::Zero()) surface_links_.push_back({pair.domain - d, surface});
    if (pair.domain != d) {
      links_.push_back({pair.domain - d, cleaned(0.5 * (pair.there - pair.back)), pair.stiffness});
    }
  }
  write_rows(links_, topology_.links, room_[d], domain.first_link, domain.link_count);
  write_rows(surface_links_, topology_.surface_links, surface_room_[d], domain.first_surface_link,
             domain.surface_link_count);
  if (topology_.options.strain_energy == StrainEnergy::fibres && volume_ > 0.0) turn_fibres(d);
}

/// Domains that lie alike share rows, so that an edit gives a domain rows of its own, at the end of the table.
template <class Link>
void BodyEdit::write_rows(const std::vector<Link>& rows, std::vector<Link>& table, Room& room, Index& first,
                          Index& count) {
  const auto wanted = static_cast<Index>(rows.size());
  if (room.first == none || wanted > room.count) {
    const Room wider{static_cast<Index>(table.size()), std::max(wanted, count)};
    table.resize(table.size() + static_cast<std::size_t>(wider.count));
    room = wider;
  }
  std::ranges::copy(rows, table.begin() + room.first);
  first = room.first;
  count = wanted;
}

void BodyEdit::turn_fibres(Index d) {
  const DomainTexel& domain = topology_.domains[d];
  Vec3 sum = Vec3::Zero();
  for (const Index row : cells_of_[domain.particle]) {
    const Cell& cell = model_.cells[row];
    if (cell.share == 0.0 || cell.material != domain.material) continue;
    if (!(model_.materials[cell.material].fibre_ratio > 1.0)) return;
    const Vec3 along = std::abs(signed_measure(model_.dimension, cell, model_.rest)) * unit_fibre(cell);
    sum += sum.dot(along) < 0.0 ? Vec3(-along) : along;
  }
  const EnergyConstants own =
      energy_constants(topology_.options.strain_energy, model_.materials[domain.material], Vec3(sum.normalized()));
  if (own == topology_.energy_of(d)) return;
  topology_.energies.push_back(own);
  topology_.domains[d].energy = static_cast<Index>(topology_.energies.size()) - 1;
}

void BodyEdit::weigh(Index i) {
  const double share = lumped_[i] > 0.0 ? lumped_mass(i) / lumped_[i] : 1.0;
  double mass = share * mass_[i];
  if (share > 0.0 && share < 1.0 && largest_rate_ > 0.0) {
    mass = std::clamp(own_stiffness(i) / largest_rate_, mass, std::max(mass, mass_[i]));
  }
  model_.mass[i] = topology_.mass[i] = mass;
}

/// A particle and its copies, which are at one place: what a light one needs so as not to vibrate faster than all of
/// the body did comes from the others, as far as they can spare it.
void BodyEdit::weigh_family(const std::vector<Index>& family) {
  std::vector<double> mass, needed;  // kg
  double total = 0.0, all_needed = 0.0, lacking = 0.0, to_spare = 0.0;
  for (const Index i : family) {
    mass.push_back(lumped_[i] > 0.0 ? lumped_mass(i) / lumped_[i] * mass_[i] : 0.0);
    needed.push_back(largest_rate_ > 0.0 ? own_stiffness(i) / largest_rate_ : 0.0);
    total += mass.back();
    all_needed += needed.back();
    (needed.back() > mass.back() ? lacking : to_spare) += std::abs(needed.back() - mass.back());
  }
  for (std::size_t k = 0; k < family.size(); ++k) {
    const double more = needed[k] - mass[k];
    if (lacking > to_spare) {
      mass[k] = total * needed[k] / all_needed;
    } else if (lacking > 0.0) {
      mass[k] += more > 0.0 ? more : lacking / to_spare * more;
    }
    const double before = topology_.mass[family[k]];
    if (mass[k] != before) topology_.exchanged.push_back({family[k], family.front(), before});
    model_.mass[family[k]] = topology_.mass[family[k]] = mass[k];
  }
}

void BodyEdit::find_rate(Index i) {
  rate_[i] = model_.mass[i] > 0.0 ? own_stiffness(i) / model_.mass[i] : 0.0;
}

}  // namespace phymul
