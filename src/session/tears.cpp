// SPDX-License-Identifier: MIT
#include "simulation_parts.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "elastic/domain_forces.h"
#include "elastic/rotation.h"
#include "model/cell_geometry.h"
#include "simulation_parts.h"

namespace phymul {
namespace {

/// Of K / sqrt(R), K the stress intensity of a crack: the largest principal stress of the mean around its front.
constexpr double of_intensity = 0.55;
constexpr double usual_radius_of_tear = 2.0, least_radius_of_tear = 1.1;  // spacings
/// Cosine of the angle by which a tear turns at most at once: 70.5 degrees, which is that of a crack in pure shear (F.
/// Erdogan and G. C. Sih, J. Basic Eng. 85 (1963) 519-525).
constexpr double sharpest_turn = 1.0 / 3.0;

/// Cosine of the angle below which two cuts are one that bends.
constexpr double same_way = 0.5;

/// Domains within `radius`, m, of a box, at rest.
std::vector<Index> domains_near(const TopologyTextures& elastic, const Eigen::AlignedBox3d& box, double radius) {
  std::vector<Index> found;
  for (Index d = 0; d < static_cast<Index>(elastic.domains.size()); ++d) {
    const DomainTexel& domain = elastic.domains[d];
    if (domain.link_count > 0 && box.exteriorDistance(elastic.rest[domain.particle]) < radius) found.push_back(d);
  }
  return found;
}

std::vector<Index> domains_around(const TopologyTextures& elastic, std::span<const Index> among, const Vec3& place,
                                  double radius) {
  std::vector<Index> found;
  for (const Index d : among) {
    if ((elastic.rest[elastic.domains[d].particle] - place).norm() < radius) found.push_back(d);
  }
  return found;
}

/// Gradient, at rest, of a function that is linear in the cell.
Vec3 gradient_of(const CellCut& values, const Cell& cell, const VecList& rest) {
  Mat3 edges;
  Vec3 rises;
  for (int k = 0; k < 3; ++k) {
    edges.row(k) = (rest[cell.particles[k + 1]] - rest[cell.particles[0]]).transpose();
    rises[k] = values[k + 1] - values[0];
  }
  return edges.inverse() * rises;
}

double cosine(const Vec3& a, const Vec3& b) {
  return a.normalized().dot(b.normalized());
}

/// Whether a cut of the cell goes through this face of it.
bool is_cut_at(const Cell& cell, const std::array<Index, 3>& face) {
  return std::ranges::any_of(cell.cuts, [&](const CellCut& cut) {
    bool above = false, below = false;
    for (std::size_t v = 0; v < 4; ++v) {
      if (std::ranges::find(face, cell.particles[v]) == face.end()) continue;
      above = above || cut[v] > 0.0;
      below = below || cut[v] < 0.0;
    }
    return above && below;
  });
}

}  // namespace

bool Tears::can_tear(Index cell) const {
  const Cell& own = model_->cells[cell];
  return own.share > 0.0 && own.material >= 0 && scene_->tearing()[own.material].toughness > 0.0;
}

double Tears::radius_at(Index cell) const {
  return radius_of(scene_->tearing()[model_->cells[cell].material]);
}

double Tears::radius_of(const Tearing& law) const {
  return law.radius > 0.0 ? std::max(law.radius, least_radius_of_tear * edit_->spacing())
                          : usual_radius_of_tear * edit_->spacing();
}

void Tears::follow(const Model& model, const TopologyTextures& topology, const BodyEdit& edit, const Scene& scene) {
  model_ = &model;
  edit_ = &edit;
  scene_ = &scene;
  laws_ = scene.tearing();
  surface_known_ = false;
  stress_.assign(topology.domains.size(), {});
  stressed_.clear();
  fronts_.clear();
  for (Index row = 0; row < static_cast<Index>(model.cells.size()); ++row) {
    if (!model.cells[row].cuts.empty() && model.cells[row].share > 0.0) look_behind(row);
  }
  Eigen::AlignedBox3d box;
  for (const Front& front : fronts_) box.extend(front.place);
  widest_ = 0.0;
  for (const Tearing& law : laws_) widest_ = std::max(widest_, radius_of(law));
  const std::vector<Index> near = domains_near(topology, box, widest_);
  for (Front& front : fronts_) front.around = domains_around(topology, near, front.place, radius_at(front.cell));
}

/// The two parts of a cell have a face in common where the cut that parts them ends there.
void Tears::look_behind(Index row) {
  const Cell& cell = model_->cells[row];
  const Vec3 centre = cell_centre(cell, model_->rest);
  for (std::size_t apex = 0; apex < 4; ++apex) {
    Front front;
    for (std::size_t v = 0, k = 0; v < 4; ++v) {
      if (v != apex) front.face[k++] = cell.particles[v];
    }
    const CellCut* parted = nullptr;  // by it
    std::vector<Index> ahead;
    for (const Index other : edit_->cells_of()[front.face[0]]) {
      const Cell& there = model_->cells[other];
      if (other == row || there.share == 0.0) continue;
      const auto has = [&](Index i) { return std::ranges::find(there.particles, i) != there.particles.end(); };
      if (!std::ranges::all_of(front.face, has)) continue;
      if (cell_centre(there, model_->rest) != centre) {
        ahead.push_back(other);
        continue;
      }
      const auto is_opposite = [&](const CellCut& cut) {
        return std::ranges::find(there.cuts, CellCut{-cut[0], -cut[1], -cut[2], -cut[3]}) != there.cuts.end();
      };
      const auto cut = std::ranges::find_if(cell.cuts, is_opposite);
      if (row < other && cut != cell.cuts.end()) parted = &*cut;
    }
    if (parted == nullptr) continue;
    int crossings = 0;
    for (std::size_t v = 0, k = 0; v < 4; ++v) {
      if (v != apex) front.value[k++] = (*parted)[v];
    }
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t b = (a + 1) % 3;
      if (!(front.value[a] * front.value[b] < 0.0)) continue;
      const double t = front.value[a] / (front.value[a] - front.value[b]);
      front.place += model_->rest[front.face[a]] + t * (model_->rest[front.face[b]] - model_->rest[front.face[a]]);
      ++crossings;
    }
    if (crossings == 0) continue;
    front.place /= crossings;
    front.normal = gradient_of(*parted, cell, model_->rest).normalized();
    for (const Index other : ahead) {
      if (is_cut_at(model_->cells[other], front.face)) continue;
      front.cell = other;
      fronts_.push_back(front);
    }
  }
}

/// sym(R^T P), Pa: P the first Piola stress and R the rotation of F, so that it turns with the body.
const Mat3& Tears::stress_of(Index d, const TopologyTextures& elastic, const State& now) {
  auto& [known, stress] = stress_[d];
  if (!known) {
    known = true;
    const Mat3 F = Mat3::Identity() + mean_gradient(elastic, d, displacements_at(elastic, now.position));
    Mat3 P;
    energy_density<double>(elastic.options, elastic.energy_of(d), F, &P);
    const Mat3 turned = rotation_of(F).transpose() * P;
    stress = 0.5 * (turned + turned.transpose());
    stressed_.push_back(d);
  }
  return stress;
}

/// The mean over `radius`, weighted by 1 - (r/R)^2, over what the cell's material bears.
Tears::Pull Tears::pull_at(const TopologyTextures& elastic, const State& now, const Vec3& place, Index cell,
                           double radius, std::span<const Index> around) {
  const auto material = static_cast<std::size_t>(model_->cells[cell].material);
  const Tearing& law = scene_->tearing()[material];
  Pull pull;
  if (law.toughness == 0.0) return pull;
  Mat3 sum = Mat3::Zero();
  double weights = 0.0;
  for (const Index d : around) {
    const DomainTexel& domain = elastic.domains[d];
    const double nearness = 1.0 - (elastic.rest[domain.particle] - place).squaredNorm() / (radius * radius);
    if (!(nearness > 0.0)) continue;
    sum += nearness / domain.inverse_volume * stress_of(d, elastic, now);
    weights += nearness / domain.inverse_volume;
  }
  if (weights == 0.0) return pull;
  const Eigen::SelfAdjointEigenSolver<Mat3> principal(sum / weights);
  pull.direction = principal.eigenvectors().col(2);
  const Material& own = model_->materials[material];
  const std::vector<double>& factors = scene_->stiffness_factors();
  const double young = own.young * (factors.empty() ? 1.0 : factors[material]);
  pull.excess = principal.eigenvalues()[2] /
                (of_intensity * std::sqrt(law.toughness * young / ((1.0 - own.poisson * own.poisson) * radius)));
  return pull;
}

/// m: what a cut that goes about the same way has given the particle, if that is within a spacing of `own`.
std::optional<double> Tears::known_distance(Index particle, double own, const Vec3& normal) const {
  std::optional<double> nearest;
  for (const Index row : edit_->cells_of()[particle]) {
    const Cell& cell = model_->cells[row];
    for (const CellCut& cut : cell.cuts) {
      const double along = cosine(gradient_of(cut, cell, model_->rest), normal);
      if (std::abs(along) < same_way) continue;
      const double value = cut[std::ranges::find(cell.particles, particle) - cell.particles.begin()];
      const double signed_value = along < 0.0 ? -value : value;
      const double off = std::abs(signed_value - own);
      if (off < edit_->spacing() && (!nearest || off < std::abs(*nearest - own))) nearest = signed_value;
    }
  }
  return nearest;
}

Tears::Found Tears::find(const TopologyTextures& elastic, const State& now) {
  for (const Index d : stressed_) stress_[d].first = false;
  stressed_.clear();
  Found found;
  std::vector<Pull> pulls;
  std::vector<char> torn(model_->cells.size(), 0), faces(torn.size(), 0);
  for (const Front& front : fronts_) ++faces[front.cell];
  std::size_t strongest = 0;
  for (std::size_t k = 0; k < fronts_.size(); ++k) {
    const Front& front = fronts_[k];
    Pull& pull =
        pulls.emplace_back(pull_at(elastic, now, front.place, front.cell, radius_at(front.cell), front.around));
    if (faces[front.cell] > 1) {  // what bridges the tear behind its front, among tissue that bears nothing
      const double near_by = least_radius_of_tear * edit_->spacing();
      const Pull bridge = pull_at(elastic, now, front.place, front.cell, near_by, front.around);
      if (bridge.excess > pull.excess) pull = bridge;
    }
    if (std::abs(pull.direction.dot(front.normal)) < sharpest_turn) pull.excess = 0.0;
    if (pull.excess > pulls[strongest].excess) strongest = k;
    if (pull.excess > 1.0) torn[front.cell] = 1;
  }
  const Vec3 above = pulls.empty() ? Vec3::Zero() : fronts_[strongest].normal;
  std::unordered_map<Index, int> planes;  // of particles without a value so far, how many were added
  for (const bool known : {true, false}) {
    for (std::size_t k = 0; k < fronts_.size(); ++k) {
      const Front& front = fronts_[k];
      if (torn[front.cell] == 0) continue;
      const double sign = front.normal.dot(above) < 0.0 ? -1.0 : 1.0;
      for (std::size_t v = 0; known && v < 3; ++v) found.distance[front.face[v]] = sign * front.value[v];
      if (known || !(pulls[k].excess > 1.0)) continue;
      const Vec3 normal = pulls[k].direction * (pulls[k].direction.dot(sign * front.normal) < 0.0 ? -1.0 : 1.0);
      for (const Index i : model_->cells[front.cell].particles) {
        if (found.distance.contains(i) && !planes.contains(i)) continue;
        const double own = normal.dot(model_->rest[i] - front.place);
        if (const auto of_cut = known_distance(i, own, normal)) {
          found.distance[i] = *of_cut;
          planes.erase(i);
          continue;
        }
        found.distance[i] += own;
        ++planes[i];
      }
    }
  }
  for (const auto& [i, count] : planes) found.distance[i] /= count;
  for (Index row = 0; row < static_cast<Index>(torn.size()); ++row) {
    if (torn[row] != 0) found.cells.push_back(row);
  }
  if (found.cells.empty()) begin_near_grasps(elastic, now, found);
  // Beside particles, by so much that no part is thin; not through them, as a cut goes.
  for (auto& [i, distance] : found.distance) {
    double shortest = HUGE_VAL;
    for (const Index row : edit_->cells_of()[i]) {
      for (const Index j : model_->cells[row].particles) {
        if (j != i) shortest = std::min(shortest, (model_->rest[i] - model_->rest[j]).norm());
      }
    }
    const double least = on_cut_surface * shortest;
    if (planes.contains(i) && std::abs(distance) < least) distance = std::copysign(least, distance);
  }
  return found;
}

void Tears::find_surface() {
  outer_.follow(*model_);
  surface_.clear();
  outer_.each(*model_, [&](std::span<const OuterFace> faces) {
    for (const Index i : faces.front().ring) {
      if (i >= 0) surface_.push_back(i);
    }
  });
  std::ranges::sort(surface_);
  surface_.erase(std::ranges::unique(surface_).begin(), surface_.end());
  surface_known_ = true;
}

/// Where tissue is whole: at the particle of the surface that bears most of those that are near grasped ones, and are
/// not grasped themselves.
void Tears::begin_near_grasps(const TopologyTextures& elastic, const State& now, Found& found) {
  std::vector<Index> held;
  for (const ToolState& tool : now.tools) held.insert(held.end(), tool.held.begin(), tool.held.end());
  if (held.empty()) return;
  if (!surface_known_) find_surface();
  std::ranges::sort(held);
  Eigen::AlignedBox3d box;
  for (const Index k : held) box.extend(model_->rest[k]);
  const std::vector<Index> near = domains_near(elastic, box, 2.0 * widest_);
  Pull most{.excess = 1.0};
  Index at = -1;
  for (const Index i : surface_) {
    const auto known = std::ranges::find_if(edit_->cells_of()[i], [this](Index row) { return can_tear(row); });
    if (known == edit_->cells_of()[i].end() || std::ranges::binary_search(held, i)) continue;
    const Index cell = *known;
    const double radius = radius_at(cell);
    const auto is_near = [&](const Vec3& place) { return (place - model_->rest[i]).norm() < radius; };
    if (std::ranges::none_of(held, [&](Index k) { return is_near(model_->rest[k]); }) ||
        std::ranges::any_of(fronts_, [&](const Front& front) { return is_near(front.place); })) {
      continue;
    }
    const Pull pull =
        pull_at(elastic, now, model_->rest[i], cell, radius, domains_around(elastic, near, model_->rest[i], radius));
    if (!(pull.excess > most.excess)) continue;
    most = pull;
    at = i;
  }
  if (at < 0) return;
  for (const Index row : edit_->cells_of()[at]) {
    if (!can_tear(row)) continue;
    found.cells.push_back(row);
    for (const Index i : model_->cells[row].particles) {
      found.distance[i] = most.direction.dot(model_->rest[i] - model_->rest[at]);
    }
  }
}

/// By at most a row of cells along each front in a call, so that stresses follow before the next row parts.
void Simulation::Parts::tear(StepReport& report) {
  if (scene.tearing().empty()) return;
  if (report.steps == 0) return;
  if (tears_version != scene.body_version() + 1 || !tears.is_by(scene.tearing())) {
    tears.follow(model, *topology, body_edit(), scene);
    tears_version = scene.body_version() + 1;
  }
  if (!tears.has_fronts() && scene.tools().empty()) return;
  const Tears::Found torn = tears.find(elastic(), solver().read());
  if (keeps_body()) {
    report.uncut += static_cast<int>(torn.cells.size());
    return;
  }
  std::size_t refused = 0;
  BodyCut found = body_edit().find_cut({.cells = torn.cells,
                                        .distance = [&](Index i) { return torn.distance.at(i); },
                                        .passed = [](Index, const auto&) { return true; },
                                        .who = "tearing",
                                        .refused = &refused});
  report.uncut += static_cast<int>(refused);
  if (found.empty()) return;
  const auto added = static_cast<int>(found.added.size());
  make_cut(std::move(found), torn.cells.size() - refused, report);
  if (!keeps_body()) report.torn += added;
}

}  // namespace phymul
