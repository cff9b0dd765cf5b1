// SPDX-License-Identifier: MIT
//
// Bodies and states that tests, and conformance checks of other backends, share. Analytic, from fixed seeds.
#pragma once

#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <Eigen/Geometry>
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
};

inline Material soft_tissue(double poisson = 0.3) {
  return {10e3, poisson, 1000.0};
}

inline Model with_material(Model model, double poisson = 0.3) {
  set_material(model, soft_tissue(poisson));
  return model;
}

/// Law::particle_averaged.
inline std::vector<Variant> averaged_variants() {
  return {{"material", {}, true},
          {"material nu 0.45", {}, true, 0.45},
          {"material quadratic volume", {.volume_law = VolumeLaw::quadratic}, true},
          {"neo-Hookean", {.strain_energy = StrainEnergy::neo_hookean}, true},
          {"fibres", {}, true, 0.3, 4.0}};
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

inline Model prepared(const Variant& variant, const Body& body) {
  Model model = body.model;
  if (!variant.material) return model;
  Material tissue = soft_tissue(variant.poisson);
  tissue.fibre_ratio = variant.fibre_ratio;
  set_material(model, tissue);
  for (std::size_t c = 0; c < model.cells.size(); ++c) {  // another direction in each cell
    const auto angle = static_cast<double>(c);
    model.cells[c].fibre = {std::cos(angle), std::sin(angle), model.dimension == 2 ? 0.0 : 0.7};
  }
  return model;
}

}  // namespace phymul::test
