// SPDX-License-Identifier: MIT
//
// Cuts of a body and its tables.
#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "body_edit.h"
#include "model/cell_geometry.h"
#include "wall_terms.h"

namespace phymul {
namespace {

// Walls of a body that is changed.

/// What a removed triangle has.
WallTexel without_energy(const WallTexel& wall) {
  WallTexel none_left;
  std::ranges::copy_n(wall.vertex.begin(), 3, none_left.vertex.begin());
  none_left.tangent = {Vec3::UnitX(), Vec3::UnitY()};
  none_left.compliance = wall.compliance;
  return none_left;
}

/// N/m, or bounds on it: what a triangle adds to the own block of vertex v of its patch.
double own_stiffness_of(const WallTexel& wall, std::size_t v) {
  Eigen::Vector2d g = Eigen::Vector2d::Zero();
  Vec3 h = Vec3::Zero();
  for (std::size_t k = v == 0 ? 1 : v; k < (v == 0 ? 6 : v + 1); ++k) {
    g += Eigen::Vector2d(wall.gradient[k].data());
    h += Vec3(wall.hessian[k].data());
  }
  const auto& b = wall.bending;
  Mat3 bending;
  bending << b[0], b[5], b[4], b[5], b[1], b[3], b[4], b[3], b[2];
  // E / (1 - nu^2) over the shear modulus.
  const double plane = 2.0 * (2.0 + wall.compliance) / (1.0 + 2.0 * wall.compliance);
  return plane * wall.shear * g.squaredNorm() + h.dot(bending * h);
}

}  // namespace

BodyCut BodyEdit::find_cut(const CutCells& cut) const {
  const CutBody body{.model = model_,
                     .cells_of = cells_of_,
                     .mass = mass_,
                     .mass_of_corner = [&](Index row) { return mass_of_corner_[row]; },
                     .spare = [&](std::size_t k) { return k < spare_.size() ? spare_[spare_.size() - 1 - k] : none; }};
  BodyCut found = cut_cells(body, cut);
  if (found.copies.size() > spare_.size()) {
    if (cut.refused != nullptr) {
      *cut.refused += std::max(found.added.size(), std::size_t{1});  // none is added along faces of cells
      return {};
    }
    throw Error(ErrorCode::not_supported,
                std::string(cut.who) + ": the cut needs copies of " + std::to_string(found.copies.size()) +
                    " particles, and the body has " + std::to_string(spare_.size()) +
                    " spare ones left; make more with with_spare_particles(), about 2.3 for each square spacing of cut "
                    "surface");
  }
  return found;
}

/// Cuts come from files, too. A corner changes to a copy of itself alone, so that what is checked of copies is enough.
void BodyEdit::require_fits(const BodyCut& cut) const {
  const auto require = [](bool fits) {
    if (!fits) throw Error("expected a cut of the body as it is now, got one that does not fit its cells or particles");
  };
  const auto in = [](Index row, const auto& list) { return row >= 0 && static_cast<std::size_t>(row) < list.size(); };
  const auto domains_of = [&](Index i) {
    if (topology_.domains.empty()) return std::span<const DomainTexel>();
    const Index first = topology_.first_domain[i];
    return std::span<const DomainTexel>(topology_.domains).subspan(first, topology_.first_domain[i + 1] - first);
  };
  const auto has_domain = [&](Index i, Index material) {
    return std::ranges::find(domains_of(i), material, &DomainTexel::material) != domains_of(i).end();
  };
  require(cut.copies.size() <= spare_.size());
  std::unordered_map<Index, Index> copied;  // by copy
  for (std::size_t k = 0; k < cut.copies.size(); ++k) {
    const auto& [copy, of, shared] = cut.copies[k];
    require(copy == spare_[spare_.size() - 1 - k] && in(of, cells_of_) && !cells_of_[of].empty());
    for (const DomainTexel& domain : domains_of(of)) require(has_domain(copy, domain.material));
    copied[copy] = of;
  }
  const auto require_part = [&](const BodyCut::Part& part, const BodyCut::Part& whole) {
    for (std::size_t v = 0; v < whole.particles.size(); ++v) {
      const auto copy = copied.find(part.particles[v]);
      require(part.particles[v] == whole.particles[v] || (copy != copied.end() && copy->second == whole.particles[v]));
    }
    require(part.share > 0.0 && part.share <= whole.share);
    for (const CellCut& cut_of : part.cuts) {
      for (const double value : cut_of) require(std::isfinite(value));
    }
  };
  Index last = none;
  for (const auto& [row, before, after] : cut.changed) {
    require(row > last && in(row, model_.cells));
    last = row;
    const Cell& cell = model_.cells[row];
    const auto corners = static_cast<std::ptrdiff_t>(cell.particles.size());
    require((cell.type == CellType::tetrahedron && cell.material >= 0) || is_of_wall(model_, cell) || is_clamp(cell));
    require(
        std::equal(cell.particles.begin(), cell.particles.end(), before.particles.begin()) &&
        std::all_of(before.particles.begin() + corners, before.particles.end(), [](Index i) { return i == none; }) &&
        before.share == cell.share && before.cuts == cell.cuts);
    for (const Index i : cell.particles) {
      require(model_.materials[cell.material].thickness > 0.0 || has_domain(i, cell.material));
    }
    require_part(after, before);
  }
  for (const auto& [of, part] : cut.added) {
    const auto change = std::ranges::lower_bound(cut.changed, of, {}, &BodyCut::Change::row);
    require(change != cut.changed.end() && change->row == of);
    require_part(part, change->before);
  }
  for (const auto& [particle, before, after] : cut.masses) {
    require(in(particle, mass_) && before == mass_[particle] && after >= 0.0 && std::isfinite(after));
  }
}

void BodyEdit::lift_cell(Index row) {
  if (is_listed(row) && at_start_[row] != 0) --cell_count_;
  for (const Index i : model_.cells[row].particles) {
    std::erase(cells_of_[i], row);
    std::erase(walls_of_[i], row);
  }
}

bool BodyEdit::is_listed(Index row) const {
  const std::vector<Index>& particles = model_.cells[row].particles;
  return !particles.empty() && std::ranges::binary_search(cells_of_[particles.front()], row);
}

void BodyEdit::make(std::shared_ptr<const BodyCut> cut) {
  require_fits(*cut);
  const std::size_t rows = model_.cells.size();
  try {
    make_parts(*cut);
    topology_.cuts.push_back(cut);
    follow_cut(*cut);
  } catch (...) {
    take_back(cut, rows);
    throw;
  }
}

void BodyEdit::make_parts(const BodyCut& cut) {
  for (const BodyCut::Change& change : cut.changed) lift_cell(change.row);
  make_cut(cut, model_);
  for (const BodyCut::Change& change : cut.changed) {
    whole_share_[change.row] = change.after.share;
    take_cell(change.row);
  }
  auto row = static_cast<Index>(whole_share_.size());
  for (const BodyCut::Added& added : cut.added) {
    whole_share_.push_back(added.part.share);
    mass_of_corner_.push_back(0.0);
    at_start_.push_back(at_start_[added.of]);
    walls_at_.emplace_back();
    take_cell(row++);
  }
  for (const BodyCut::Copy& copy : cut.copies) {
    spare_.pop_back();
    topology_.rest[copy.particle] = model_.rest[copy.particle];
    topology_.stiffness[copy.particle] = model_.stiffness[copy.particle];
    topology_.copied.push_back({copy.particle, copy.of});
    const Index first = first_of_[copy.particle] = first_of_[copy.of];
    std::vector<Index>& family = copies_[first];
    if (family.empty()) family.push_back(first);
    family.push_back(copy.particle);
    const bool has_domains = !topology_.domains.empty();
    for (Index d = has_domains ? topology_.first_domain[copy.of] : 0;
         has_domains && d < topology_.first_domain[copy.of + 1]; ++d) {
      const Index own = domain_of(copy.particle, topology_.domains[d].material);
      topology_.domains[own].energy = topology_.domains[d].energy;
      topology_.domains[own].spread_stiffness = topology_.domains[d].spread_stiffness;
      modulus_[own] = modulus_[d];
    }
  }
  for (const BodyCut::Mass& mass : cut.masses) mass_[mass.particle] = mass.after;
}

void BodyEdit::undo() {
  const std::shared_ptr<const BodyCut> cut = topology_.cuts.back();
  const std::size_t rows = model_.cells.size() - cut->added.size();
  try {
    take_back(cut, rows);
  } catch (...) {
    take_back(cut, rows);
    throw;
  }
}

/// Undoes the last cut, also where it was made or undone in part. `rows`: of cells before it.
void BodyEdit::take_back(const std::shared_ptr<const BodyCut>& cut, std::size_t rows) {
  if (!topology_.cuts.empty() && topology_.cuts.back() == cut) topology_.cuts.pop_back();
  for (const BodyCut::Change& change : cut->changed) lift_cell(change.row);
  for (std::size_t row = rows; row < model_.cells.size(); ++row) lift_cell(static_cast<Index>(row));
  undo_cut(*cut, model_, rows);
  for (; walls_at_.size() > rows; walls_at_.pop_back()) free_walls(walls_at_.back());
  whole_share_.resize(rows);
  mass_of_corner_.resize(rows);
  at_start_.resize(rows);
  for (const BodyCut::Change& change : cut->changed) {
    whole_share_[change.row] = change.before.share;
    take_cell(change.row);
  }
  for (auto copy = cut->copies.rbegin(); copy != cut->copies.rend(); ++copy) {
    const bool is_spare = !spare_.empty() && spare_.back() <= copy->particle;  // they descend
    const auto family = copies_.find(first_of_[copy->particle]);
    if (family != copies_.end()) {
      for (const Index i : family->second) topology_.exchanged.push_back({i, family->first, topology_.mass[i]});
      std::erase(family->second, copy->particle);
      if (family->second.size() <= 1) copies_.erase(family);
    }
    if (!is_spare) spare_.push_back(copy->particle);
    first_of_[copy->particle] = copy->particle;
    topology_.rest[copy->particle] = model_.rest[copy->particle] = spare_places_[copy->particle];
    topology_.stiffness[copy->particle] = model_.stiffness[copy->particle];
  }
  for (const BodyCut::Mass& mass : cut->masses) mass_[mass.particle] = mass.before;
  follow_cut(*cut);
}

void BodyEdit::follow_cut(const BodyCut& cut) {
  std::vector<Index> domains, particles;
  const auto add = [&](const BodyCut::Part& part, Index material) {
    for (const Index i : part.particles) {
      if (i < 0) continue;
      particles.push_back(i);
      if (model_.materials[material].thickness == 0.0) domains.push_back(domain_of(i, material));
    }
  };
  for (const BodyCut::Change& change : cut.changed) {
    add(change.before, model_.cells[change.row].material);
    add(change.after, model_.cells[change.row].material);
  }
  for (const BodyCut::Added& added : cut.added) add(added.part, model_.cells[added.of].material);
  for (const Index i : particles) weigh_lumped(i);
  follow(std::move(domains), std::move(particles));
}

/// Whose terms are which.
void BodyEdit::find_walls() {
  const std::vector<WallTexel>& walls = topology_.walls;
  std::size_t next = 0;
  for (Index row = 0; row < static_cast<Index>(model_.cells.size()); ++row) {
    const Cell& cell = model_.cells[row];
    const auto is_its_own = [&](const WallTexel& wall) {
      return std::equal(cell.particles.begin(), cell.particles.end(), wall.vertex.begin());
    };
    walls_at_.emplace_back();
    while (is_wall(model_, cell) && next < walls.size() && is_its_own(walls[next])) {
      walls_at_.back().push_back(static_cast<Index>(next++));
    }
  }
}

/// The triangles that have one of these particles in their patch; the particles of these patches are added.
void BodyEdit::follow_walls(std::vector<Index>& particles) {
  std::vector<Index> walls;
  for (const Index i : particles) {
    for (const Index row : walls_of_[i]) {
      if (is_of_wall(model_, model_.cells[row])) walls.push_back(row);
    }
  }
  std::ranges::sort(walls);
  const auto again = std::ranges::unique(walls);
  walls.erase(again.begin(), again.end());
  for (const Index row : walls) {
    const auto add_patch = [&] {
      for (const Index term : walls_at_[row]) {
        for (const Index i : topology_.walls[term].vertex) {
          if (i != none) particles.push_back(i);
        }
      }
    };
    add_patch();
    write_wall(row);
    add_patch();
  }
}

double BodyEdit::own_stiffness_in_walls(Index particle) const {
  double sum = 0.0;
  each_wall_with(particle, [&](const WallTexel& wall, std::size_t v) { sum += own_stiffness_of(wall, v); });
  return sum;
}

/// Calls visit(wall, v) for each triangle of whose patch the particle is vertex v.
template <class Visit>
void BodyEdit::each_wall_with(Index particle, Visit visit) const {
  const auto visit_at = [&](Index row, std::size_t first, std::size_t last) {
    for (const Index term : walls_at_[row]) {
      const WallTexel& wall = topology_.walls[term];
      for (std::size_t v = first; v < last; ++v) {
        if (wall.vertex[v] == particle) visit(wall, v);
      }
    }
  };
  for (const Index row : walls_of_[particle]) {
    visit_at(row, 0, 3);
    const Cell& cell = model_.cells[row];
    if (cell.type != CellType::triangle) continue;
    // Across the side that is opposite to the particle.
    const std::ptrdiff_t at = std::ranges::find(cell.particles, particle) - cell.particles.begin();
    for (const Index beside : walls_of_[cell.particles[(at + 1) % 3]]) {
      const std::vector<Index>& further = walls_of_[cell.particles[(at + 2) % 3]];
      if (beside != row && std::ranges::binary_search(further, beside)) visit_at(beside, 3, 6);
    }
  }
}

/// The terms of a triangle as it is now. Rows that it no longer needs stay its own; their energy is 0.
void BodyEdit::write_wall(Index row) {
  std::vector<WallTexel> now;
  if (is_wall(model_, model_.cells[row])) now = wall_terms_of(model_, row, walls_of_);
  std::vector<Index>& terms = walls_at_[row];
  terms.reserve(now.size());  // so that no row gets lost where memory runs out
  while (terms.size() < now.size()) {
    if (free_walls_.empty()) {
      topology_.walls.emplace_back();
      terms.push_back(static_cast<Index>(topology_.walls.size()) - 1);
    } else {
      terms.push_back(free_walls_.back());
      free_walls_.pop_back();
    }
  }
  for (std::size_t k = 0; k < terms.size(); ++k) {
    WallTexel& wall = topology_.walls[terms[k]];
    wall = k < now.size() ? now[k] : without_energy(wall);
  }
}

void BodyEdit::free_walls(std::span<const Index> terms) {
  free_walls_.reserve(free_walls_.size() + terms.size());
  for (std::size_t k = terms.size(); k-- > 0;) {
    topology_.walls[terms[k]] = without_energy(topology_.walls[terms[k]]);
    free_walls_.push_back(terms[k]);
  }
}

}  // namespace phymul
