// SPDX-License-Identifier: MIT
//
// Bodies and states that tests, and conformance checks of other backends, share. Analytic, from fixed seeds.
#pragma once

#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <Eigen/Geometry>
#include <array>
#include <initializer_list>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "print.h"

namespace phymul::test {

struct Body {
  std::string name;
  Model model;
};

inline Model cylinder_275() {
  return make_cylinder(0.010, 0.040, 3, 8, 11);
}

inline Model jittered_block() {
  Model model = make_block({0.04, 0.03, 0.03}, 4, 3, 3, 18);
  jitter(model, 0.2, 7);
  return model;
}

/// One of every kind: builders, valences, jittered, unstructured, two-dimensional.
inline std::vector<Body> bodies() {
  std::vector<Body> all;
  all.push_back({"tetrahedron", make_tetrahedron(0.01)});
  all.push_back({"cylinder275", cylinder_275()});
  for (int valence : {6, 14, 18, 26}) {
    all.push_back({"block" + std::to_string(valence), make_block({0.03, 0.02, 0.02}, 3, 2, 2, valence)});
  }
  all.push_back({"jittered", jittered_block()});
  all.push_back({"tetrahedra", make_tetrahedral_block({0.03, 0.02, 0.02}, 3, 2, 2, 0.2, 5)});
  all.push_back({"strip", make_strip(0.04, 0.02, 4, 2)});
  return all;
}

/// Uniform in [-1, 1), from the generator's bits alone: the same on every machine. Draw one a statement or a
/// declarator: in which order a call's arguments are evaluated is each compiler's own choice.
inline double uniform(std::mt19937& bits) {
  return static_cast<double>(bits()) / 2147483648.0 - 1.0;
}

inline Vec3 random_vector(std::mt19937& bits, int dimension) {
  const double z = uniform(bits), y = uniform(bits), x = uniform(bits);
  return {x, y, dimension == 2 ? 0.0 : z};
}

/// The rest shape with every particle off its place by up to `amount` mean spacings along each axis.
inline VecList random_positions(const Model& model, double amount, std::uint32_t seed) {
  std::mt19937 bits(seed);
  const double h = mean_spacing(model);
  VecList x = model.rest;
  for (Vec3& p : x) p += amount * h * random_vector(bits, model.dimension);
  return x;
}

/// The body there, standing still.
inline State displaced(const Model& model, double amount, std::uint32_t seed) {
  State state = rest_state(model);
  state.position = random_positions(model, amount, seed);
  return state;
}

inline std::vector<Index> every_particle(const Model& model) {
  return model.particles_in([](const Vec3&) { return true; });
}

/// A random rotation (about z in 2-D) and a translation of a few body sizes.
inline VecList rigidly_moved(const Model& model, std::uint32_t seed) {
  std::mt19937 bits(seed);
  const Vec3 axis = model.dimension == 2 ? Vec3::UnitZ() : random_vector(bits, 3).normalized();
  const Mat3 turn = Eigen::AngleAxisd(3.0 * uniform(bits), axis).toRotationMatrix();
  const Vec3 shift = 3.0 * body_size(model) * random_vector(bits, model.dimension);
  VecList x = model.rest;
  for (Vec3& p : x) p = turn * p + shift;
  return x;
}

/// Elastic forces, N, at positions x [N].
inline VecList forces_at(const TopologyTextures& tables, const VecList& x) {
  VecList force(x.size());
  elastic_forces(tables, x, force);
  return force;
}

inline double largest_norm(const VecList& list) {
  double largest = 0.0;
  for (const Vec3& v : list) largest = std::max(largest, v.norm());
  return largest;
}

inline double norm(const VecList& list) {
  double sum = 0.0;
  for (const Vec3& v : list) sum += v.squaredNorm();
  return std::sqrt(sum);
}

inline VecList sum_of(const VecList& a, const VecList& b) {
  VecList total = a;
  for (std::size_t i = 0; i < a.size(); ++i) total[i] += b[i];
  return total;
}

inline double largest_distance(const VecList& a, const VecList& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double distance = (a[i] - b[i]).norm();
    if (!(distance <= largest)) largest = distance;  // takes one that is not a number
  }
  return largest;
}

inline double total_mass(const Model& model) {
  double total = 0.0;
  for (const double mass : model.mass) total += mass;
  return total;
}

inline Vec3 sum(const VecList& list) {
  Vec3 total = Vec3::Zero();
  for (const Vec3& v : list) total += v;
  return total;
}

/// Net torque about the centre of the positions, N m.
inline Vec3 torque(const VecList& position, const VecList& force) {
  const Vec3 centre = sum(position) / static_cast<double>(position.size());
  Vec3 total = Vec3::Zero();
  for (std::size_t i = 0; i < position.size(); ++i) total += (position[i] - centre).cross(force[i]);
  return total;
}

/// A way of building the tables, with a name for messages.
struct Variant {
  std::string name;
  TopologyOptions options;
  bool material = false;  ///< gives the body soft_tissue first
  double poisson = 0.3;
  double fibre_ratio = 1.0;
  Stiffening stiffening{};
};

inline Material soft_tissue(double poisson = 0.3) {
  return {10e3, poisson, 1000.0};
}

/// Forces as large as they are: a cut one has no counterpart.
inline SolverOptions uncut() {
  return {.max_displacement_per_step = std::numeric_limits<double>::infinity()};
}

inline SolverOptions damped(double rate) {
  return {.damping = {.rate = rate}};
}

inline Model with_material(Model model, const Material& material = soft_tissue()) {
  set_material(model, material);
  return model;
}

/// Another particle, of 1 kg: its row.
inline Index add_particle(Model& model, const Vec3& place, const std::vector<Index>& neighbours = {},
                          double stiffness = 1.0) {
  model.rest.push_back(place);
  model.mass.push_back(1.0);
  model.stiffness.push_back(stiffness);
  model.neighbours.push_row(neighbours.begin(), neighbours.end());
  return model.particle_count() - 1;
}

/// Every hexahedron cut into six pyramids, around a particle in its middle.
inline Model cut_into_pyramids(Model model) {
  const std::array<std::array<int, 4>, 6> face{
      {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};
  std::vector<Cell> cells;
  for (const Cell& cell : model.cells) {
    if (cell.type != CellType::hexahedron) continue;
    Vec3 middle = Vec3::Zero();
    for (const Index i : cell.particles) middle += model.rest[i] / 8.0;
    const Index apex = add_particle(model, middle);
    for (const auto& [a, b, c, d] : face) {
      const std::vector<Index>& v = cell.particles;
      cells.push_back({.type = CellType::pyramid, .particles = {v[d], v[c], v[b], v[a], apex}});
    }
  }
  model.cells = cells;
  model.components.clear();
  model.neighbours = neighbours_from_cells(cells, model.particle_count());
  return model;
}

inline Model without_cells(Model model) {
  model.cells.clear();
  model.components.clear();
  model.extras = nullptr;
  return model;
}

/// One model of several bodies, as by merge_models().
inline Model merged(std::initializer_list<NamedBody> bodies) {
  return merge_models({bodies.begin(), bodies.size()});
}

inline constexpr double cubes_edge = 0.02;  // m

/// Two cubes, one above the other with a gap between: "lower" and "upper".
inline Model cubes_apart(double gap) {
  const Model lower = make_block(Vec3::Constant(cubes_edge), 3, 3, 3), upper = moved(lower, {0, 0, cubes_edge + gap});
  return with_material(merged({{"lower", &lower}, {"upper", &upper}}));
}

/// A body with groups x0 and x1, whose half where x is least is of the second material.
inline Model with_harder_half(Model model, const Material& soft, const Material& hard) {
  const double middle = 0.5 * (model.rest[model.group("x0").front()] + model.rest[model.group("x1").front()]).x();
  set_material(model, soft);
  set_material(model, hard, [=](const Vec3& place) { return place.x() < middle; });
  return model;
}

/// Nearly those of human cortex (docs/measurements/truth.md, B).
inline constexpr Stiffening like_cortex{.exponential = 0.3, .exponent = 40.0, .second = 10.0, .second_fades = 20.0};

/// Law::particle_averaged.
inline std::vector<Variant> averaged_variants() {
  return {{"material", {}, true},
          {"material nu 0.45", {}, true, 0.45},
          {"material quadratic volume", {.volume_law = VolumeLaw::quadratic}, true},
          {"fibres", {}, true, 0.3, 4.0},
          {"stiffening", {}, true, 0.45, 1.0, like_cortex}};
}

/// Every other energy the library has that is exactly conservative.
inline std::vector<Variant> clustered_variants() {
  const TopologyOptions springs{.law = Law::springs};
  TopologyOptions swollen = springs;
  swollen.volume_stiffness = 50.0;
  swollen.volume_law = VolumeLaw::quadratic;
  return {{"springs", springs},
          {"springs+volume", swollen},
          {"averaged", {.reaction = Reaction::averaged}},
          {"conservative", {}},
          {"conservative all", {.bases = BaseSelection::all}},
          {"conservative+volume", {.volume_stiffness = 50.0}}};
}

/// Every energy the library has that is exactly conservative.
inline std::vector<Variant> conservative_variants() {
  std::vector<Variant> all = clustered_variants();
  for (Variant& variant : averaged_variants()) all.push_back(std::move(variant));
  return all;
}

/// Those, and the older reactions.
inline std::vector<Variant> all_variants() {
  std::vector<Variant> all = conservative_variants();
  for (const auto& [name, reaction] : {std::pair{"full", Reaction::full}, std::pair{"shared", Reaction::shared},
                                       std::pair{"barycentric", Reaction::barycentric}}) {
    all.push_back({name, {.reaction = reaction}});
    all.push_back({std::string(name) + " all", {.reaction = reaction, .bases = BaseSelection::all}});
  }
  return all;
}

inline Model prepared(const Variant& variant, const Body& body) {
  Model model = body.model;
  if (!variant.material) return model;
  Material tissue = soft_tissue(variant.poisson);
  tissue.fibre_ratio = variant.fibre_ratio;
  tissue.stiffening = variant.stiffening;
  set_material(model, tissue);
  for (std::size_t c = 0; c < model.cells.size(); ++c) {  // another direction in each cell
    const auto angle = static_cast<double>(c);
    model.cells[c].fibre = {std::cos(angle), std::sin(angle), model.dimension == 2 ? 0.0 : 0.7};
  }
  return model;
}

}  // namespace phymul::test
