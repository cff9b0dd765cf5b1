// SPDX-License-Identifier: MIT
#include "float_scene.h"

#include <phymul/error.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "model/closed_surface.h"
#include "scene/anchor_place.h"

namespace phymul {
namespace {

/// A power of 2 m, which scales without rounding.
double unit_of(double volume) {
  return std::ldexp(1.0, static_cast<int>(std::lround(std::log2(volume) / 3.0)));
}

double mean_mass(const VolumeConstraint& kept, const std::vector<double>& mass) {
  double sum = 0.0;
  for (const auto& t : kept.triangles) {
    for (const Index i : t) sum += mass[static_cast<std::size_t>(i)];
  }
  return sum / static_cast<double>(3 * kept.triangles.size());
}

void add_volume(const VolumeConstraint& kept, const Model& model, FloatVolumes& tables) {
  const int volume = tables.count();
  const double unit = unit_of(kept.volume), cube = unit * unit * unit;
  const double at_rest = enclosed_volume(kept.triangles, model.rest);
  tables.laws.push_back({static_cast<float>(unit), static_cast<float>(1.0 / unit),
                         static_cast<float>(mean_mass(kept, model.mass) / 6.0), 0.0f});
  tables.laws.push_back({static_cast<float>((kept.volume - at_rest) / cube),
                         static_cast<float>(rounded_volume_share * kept.volume / cube), 0.0f, 0.0f});
  const Index o = kept.triangles.front()[0];
  const auto X = [&](Index i) -> const Vec3& { return model.rest[static_cast<std::size_t>(i)]; };
  for (const auto& [a, b, c] : kept.triangles) {
    tables.facets.push_back({a, b, c, o});
    tables.edges.push_back(float4((X(a) - X(o)) / unit));
    tables.edges.push_back(float4((X(b) - X(a)) / unit));
    tables.edges.push_back(float4((X(c) - X(a)) / unit));
    for (const Index i : {a, b, c}) tables.ranges[static_cast<std::size_t>(i)][2] = volume;
  }
}

/// What each particle gathers, in the order of the facets.
void fill_around(FloatVolumes& tables) {
  std::vector<std::int32_t> count(tables.ranges.size(), 0);
  for (const Int4& facet : tables.facets) {
    for (std::size_t k = 0; k < 3; ++k) ++count[static_cast<std::size_t>(facet[k])];
  }
  std::int32_t first = 0;
  for (std::size_t i = 0; i < count.size(); ++i) {
    tables.ranges[i][0] = tables.ranges[i][1] = first;
    first += count[i];
  }
  tables.around.resize(static_cast<std::size_t>(first));
  for (std::size_t row = 0; row < tables.facets.size(); ++row) {
    const auto [a, b, c, o] = tables.facets[row];
    for (const std::int32_t i : {a, b, c}) {
      const std::int32_t at = tables.ranges[static_cast<std::size_t>(i)][1]++;
      tables.around[static_cast<std::size_t>(at)] = {a, b, c, static_cast<std::int32_t>(row)};
    }
  }
}

/// `rows`: first and end facet of each volume.
void fill_sums(std::vector<Int2> rows, FloatVolumes& tables) {
  bool summed = false;
  while (!summed) {
    const auto start = static_cast<std::int32_t>(tables.nodes.size());
    summed = true;
    for (std::size_t volume = 0; volume < rows.size(); ++volume) {
      const auto [first, end] = rows[volume];
      rows[volume][0] = static_cast<std::int32_t>(tables.nodes.size());
      for (std::int32_t row = first; row < end; row += FloatVolumes::terms_a_sum) {
        tables.nodes.push_back(
            {row, std::min(row + FloatVolumes::terms_a_sum, end), static_cast<std::int32_t>(volume), 0});
      }
      rows[volume][1] = static_cast<std::int32_t>(tables.nodes.size());
      summed = summed && rows[volume][1] - rows[volume][0] == 1;
    }
    tables.levels.push_back({start, static_cast<std::int32_t>(tables.nodes.size()), 0, 0});
  }
}

}  // namespace

FloatVolumes pack_volumes(const Scene& scene) {
  FloatVolumes tables;
  if (scene.volume_constraints().empty()) return tables;
  tables.ranges.assign(scene.model().rest.size(), {0, 0, -1, 0});
  std::vector<Int2> rows;
  for (const VolumeConstraint& kept : scene.volume_constraints()) {
    const auto first = static_cast<std::int32_t>(tables.facets.size());
    add_volume(kept, scene.model(), tables);
    rows.push_back({first, static_cast<std::int32_t>(tables.facets.size())});
  }
  fill_around(tables);
  fill_sums(std::move(rows), tables);
  return tables;
}

namespace {

Int4 weighed(Index row, double weight) {
  return {row, std::bit_cast<std::int32_t>(static_cast<float>(weight)), 0, 0};
}

}  // namespace

FloatJoints::FloatJoints(const Scene& scene, const Vec3& middle) : scene_(&scene), middle_(middle) {
  for (const SceneJoint& joint : scene.joints()) {
    for (const JointSpring& spring : joint.joint.springs) add(spring);
  }
  if (empty()) return;
  gather();
  laws_.resize(law_rows * springs_.size());
  follow();
}

void FloatJoints::add_anchor(const Anchor& anchor) {
  for (std::size_t k = 0; k < anchor.particles.size(); ++k) {
    anchors_.push_back(weighed(anchor.particles[k], anchor.weights[k]));
  }
}

void FloatJoints::add(const JointSpring& spring) {
  Int4& row = springs_.emplace_back();
  const auto end = [this] { return static_cast<Index>(anchors_.size()); };
  row[0] = end();
  add_anchor(spring.a);
  row[1] = end();
  add_anchor(spring.b);
  row[2] = end();
  const auto at_rest = [this](const Anchor& anchor) {
    return anchor_place(anchor, scene_->model().rest, scene_->tools());
  };
  const bool on_a = !spring.a.tool.empty();
  const Anchor& on_tool = on_a ? spring.a : spring.b;
  if (on_tool.tool.empty()) {
    const Vec3 R = at_rest(spring.b) - at_rest(spring.a);
    rest_distance_.push_back(R.norm());
    places_.insert(places_.end(), {float4(R), Float4{}, Float4{}});
    return;
  }
  any_tool_ = true;
  const auto tool = std::ranges::find(scene_->tools(), on_tool.tool, &SceneTool::name);
  row[3] = static_cast<Index>(tool - scene_->tools().begin()) + 1;
  if (on_a) row[3] = -row[3];
  const auto [high, low] = halves(at_rest(on_a ? spring.b : spring.a) - middle_);
  rest_distance_.push_back(0.0);
  places_.insert(places_.end(), {high, low, float4(on_tool.point)});
}

/// Ends in the order of the springs, so that sums over them are in that of JointSet.
void FloatJoints::gather() {
  const VecList& rest = scene_->model().rest;
  std::vector<std::vector<Int4>> of_particle(rest.size());
  for (Index s = 0; s < count(); ++s) {
    const Int4& row = springs_[s];
    for (Index at = row[0]; at < row[2]; ++at) {
      const float weight = std::bit_cast<float>(anchors_[at][1]);
      of_particle[anchors_[at][0]].push_back(weighed(s, at < row[1] ? weight : -weight));
    }
  }
  for (const std::vector<Int4>& own : of_particle) {
    const auto first = static_cast<Index>(ends_.size());
    ends_.insert(ends_.end(), own.begin(), own.end());
    ranges_.push_back({first, static_cast<Index>(ends_.size()), 0, 0});
  }
}

bool FloatJoints::follow() {
  if (empty() || seen_ == scene_->values_version() + 1) return false;
  seen_ = scene_->values_version() + 1;
  std::size_t row = 0;
  for (const SceneJoint& joint : scene_->joints()) {
    for (const JointSpring& spring : joint.joint.springs) {
      const double share = spring.share;
      laws_[law_rows * row] = {to_float(share * joint.joint.stiffness), to_float(share * joint.joint.damping),
                               to_float(share * joint.joint.breaking_force), joint.joint.slack ? 1.0f : 0.0f};
      laws_[law_rows * row + 1] = {to_float(spring.rest_length),
                                   static_cast<float>(rest_distance_[row] - spring.rest_length), 0.0f, 0.0f};
      ++row;
    }
  }
  return true;
}

std::vector<JointSet::Told> told_joints(std::span<const Float4> rows) {
  std::vector<JointSet::Told> told;
  for (std::size_t at = 0; at < rows.size(); at += FloatJoints::state_rows) {
    told.push_back({.spring = {.force = widened(rows[at]), .length = rows[at + 1][3], .broken = rows[at][3] > 0.0f},
                    .torque = widened(rows[at + 1]),
                    .sum_force = widened(rows[at + 2]),
                    .sum_torque = widened(rows[at + 3])});
  }
  return told;
}

std::vector<Float4> joint_rows(const std::vector<SceneJoint>& joints, const JointSet& known) {
  std::vector<Float4> rows;
  for (const SceneJoint& joint : joints) {
    for (const SpringReport& spring : known.report(joint).springs) {
      rows.push_back({0.0f, 0.0f, 0.0f, spring.broken ? 1.0f : 0.0f});
      rows.insert(rows.end(), FloatJoints::state_rows - 1, Float4{});
    }
  }
  return rows;
}

namespace {

/// Edges from the middle: cells are at least one wide, and floats know places that far away to 1/128 of it, which the
/// cells' slack in contact_grid_kernel.glsl is for, with as much again for motion.
constexpr double furthest = 65536.0;

}  // namespace

FloatContacts::FloatContacts(const Scene& scene) : options(*scene.contacts()) {
  const ContactSurface surface = make_contact_surface(scene.model());
  longest_edge = surface.longest_edge;
  Vec3 middle = Vec3::Zero();
  for (const Vec3& X : scene.model().rest) middle += X / static_cast<double>(scene.model().rest.size());
  // Bodies that have triangles, in their order: each particle may meet each of these, and no other.
  std::map<Index, Index> solid;
  for (const ContactSurface::Triangle& own : surface.triangles) solid.emplace(own.body, 0);
  for (auto& [body, number] : solid) number = bodies++;
  for (std::size_t k = 0; k < surface.particles.size(); ++k) {
    const ContactSurface::Particle& own = surface.particles[k];
    const auto number = solid.find(own.body);
    particle.push_back(
        {own.row, number == solid.end() ? -1 : number->second, bits_of(static_cast<float>(own.edge)), 0});
    const Vec3 X = surface.rest[k] - middle;
    if (X.cwiseAbs().maxCoeff() > furthest * longest_edge) {
      throw Error(ErrorCode::not_supported,
                  "contacts in single precision: expected surfaces within 65536 of their longest edges (" +
                      std::to_string(longest_edge) + " m) of the middle of all particles, got particle " +
                      std::to_string(own.row) + " at " + std::to_string(X.norm()) +
                      " m; bring the bodies nearer to each other, or use the backend \"cpu\"");
    }
    for (const Float4& half : halves(X)) rest.push_back(half);
  }
  for (const ContactSurface::Triangle& own : surface.triangles) {
    triangle.push_back(
        {own.corner[0], own.corner[1], own.corner[2], 2 * solid.at(own.body) + (own.has_inside ? 1 : 0)});
    triangle_law.push_back({static_cast<float>(own.edge), 0.0f, 0.0f, 0.0f});
  }
}

}  // namespace phymul
