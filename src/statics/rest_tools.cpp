// SPDX-License-Identifier: MIT
#include "rest_tools.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "interaction/joint_set.h"
#include "interaction/tool_shape.h"
#include "scene/anchor_place.h"

namespace phymul {
namespace {

/// Of a point's stiffness, in those of the particles' neighbourhoods: each raise() takes a part of about 1 in so many
/// off the depth that is left.
constexpr double stiffening = 30.0;
/// Of the stiffness of integrals, by each raise().
constexpr double raising = 5.0, most_raised = 125.0;
/// Linearisations at first and after raise() that leave out what makes the stiffness of integrals indefinite.
constexpr int rough_linearisations = 2;
int raises_of(const Tool& tool) {
  return tool.contact == ToolContact::surface ? 3 : std::numeric_limits<int>::max();
}

Vec3 place_of(const ContactPoints::Patch& patch, const ContactPoints::Shares& share, std::span<const Vec3> position) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t c = 0; c < patch.particles().size(); ++c) sum += share[c] * position[patch.corner[c]];
  return sum;
}

template <class Visit>
void for_each_point(const ContactPoints& points, const Visit& visit) {
  for (const ContactPoints::Patch& patch : points.patches) {
    for (const ContactPoints::Shares& share : *patch.points) visit(patch, share);
  }
}

/// N/m, of all points in the order of patches: a particle gets the same from many points as from few.
std::vector<double> stiffness_of(const ContactPoints& points, std::span<const Mat3> stiffness) {
  std::vector<double> area(stiffness.size(), 0.0), of_points;
  for_each_point(points, [&](const ContactPoints::Patch& patch, const ContactPoints::Shares& share) {
    for (int c = 0; c < patch.corners; ++c) area[patch.corner[c]] += share[c] * patch.area;
  });
  for_each_point(points, [&](const ContactPoints::Patch& patch, const ContactPoints::Shares& share) {
    double sum = 0.0;
    for (int c = 0; c < patch.corners; ++c) {
      const Index i = patch.corner[c];
      if (share[c] > 0.0) sum += share[c] * patch.area / area[i] * stiffness[i].trace() / 3.0;
    }
    of_points.push_back(stiffening * sum);
  });
  return of_points;
}

/// Calls visit(particle, +-weight): how the way from anchor `a` to `b` depends on particles.
template <class Visit>
void for_each_weight(const JointSpring& spring, const Visit& visit) {
  for (const auto& [anchor, sign] : {std::pair{&spring.a, -1.0}, std::pair{&spring.b, 1.0}}) {
    for (std::size_t k = 0; k < anchor->particles.size(); ++k) visit(anchor->particles[k], sign * anchor->weights[k]);
  }
}

}  // namespace

RestTools::RestTools(const Scene& scene, std::span<const Mat3> stiffness, std::span<const std::uint8_t> fixed)
    : particles_(stiffness.size()) {
  const auto cannot_move = [&](const ContactPoints::Patch& patch) {
    return !fixed.empty() && std::ranges::all_of(patch.particles(), [&](Index i) { return fixed[i] == 7; });
  };
  std::optional<ContactSurface> body;
  for (const SceneTool& own : scene.tools()) {
    const Tool& tool = own.tool;
    const bool surface = tool.contact == ToolContact::surface;
    if (surface && !body) body = make_contact_surface(scene.model());
    Touching made{.tool = tool,
                  .points = surface ? make_contact_points(*body, tool) : make_particle_points(scene.model()),
                  .shape = shape_of(tool),
                  .frame = ToolFrame(own.pose),
                  .raises_left = raises_of(tool),
                  .stiffness = {},
                  .estimate = {}};
    std::erase_if(made.points.patches, cannot_move);
    made.stiffness = stiffness_of(made.points, stiffness);
    made.estimate.assign(made.stiffness.size(), 0.0);
    tools_.push_back(std::move(made));
  }
}

bool RestTools::follow(const Scene& scene) {
  const auto is_same = [](const Touching& own, const SceneTool& other) {
    const Tool &a = own.tool, &b = other.tool;
    return a.shape == b.shape && a.compliance == b.compliance && a.margin == b.margin && a.contact == b.contact;
  };
  if (!std::ranges::equal(tools_, scene.tools(), is_same)) return false;
  for (std::size_t k = 0; k < tools_.size(); ++k) {
    tools_[k].frame = ToolFrame(scene.tools()[k].pose);
    tools_[k].raises_left = raises_of(tools_[k].tool);
  }
  return true;
}

bool RestTools::Touching::integrates(const ContactPoints::Patch& patch) const {
  return shape.kind == ShapeKind::box && shape.margin == 0.0 && patch.corners == 3 && !patch.of_cut_cell;
}

/// Calls visit(Pressed) for the points that bear a force.
template <class Visit>
void RestTools::for_each_pressed(const Touching& tool, std::span<const Vec3> position, const Visit& visit) {
  std::size_t next = 0;
  const std::vector<ContactPoints::Patch>& patches = tool.points.patches;
  for (const ContactPoints::Patch& patch : patches) {
    const std::size_t first = next, count = patch.points->size();
    next += count;
    ContactPoints::Shares even{};
    std::fill_n(even.begin(), patch.corners, 1.0 / patch.corners);
    const Vec3 middle = place_of(patch, even, position);
    double around = 0.0;
    for (const Index i : patch.particles()) around = std::max(around, (position[i] - middle).norm());
    const auto estimates = std::span(tool.estimate).subspan(first, count);
    if (distance_to(tool.shape, unpacked(tool.frame.inside(middle))).phi > around &&
        std::ranges::all_of(estimates, [](double estimate) { return estimate == 0.0; })) {
      continue;
    }
    if (tool.integrates(patch)) {
      const auto all = std::span(tool.stiffness).subspan(first, count);
      const double area = patch.area * static_cast<double>(count);
      const double stiffness = tool.raised * std::accumulate(all.begin(), all.end(), 0.0) / area;
      const auto at = [&](std::size_t c) { return tool.frame.inside(position[patch.corner[c]]); };
      const Vec3 half = packed(tool.shape.size);
      const auto normal = [&](int face) -> Vec3 {
        return (face % 2 == 0 ? 1.0 : -1.0) * tool.frame.turn.col(face / 2);
      };
      integrate_depth({-half, half}, {at(0), at(1), at(2)}, area, [&](const DepthPoint& own) {
        const Vec3 out = normal(own.face);
        if (own.other_face < 0) {
          const double gain = stiffness * own.weight;
          visit(Pressed{&patch, own.share, no_row, gain * own.depth, gain, out, out});
        } else {
          const double gain = -stiffness * own.line_weight * own.depth;
          visit(Pressed{&patch, own.share, no_row, 0.0, gain, out, out - normal(own.other_face)});
        }
      });
      continue;
    }
    for (std::size_t p = 0; p < count; ++p) {
      const ContactPoints::Shares& share = (*patch.points)[p];
      const auto [phi, normal] = distance_to(tool.shape, unpacked(tool.frame.inside(place_of(patch, share, position))));
      const double gain = tool.stiffness[first + p] / (1.0 + tool.stiffness[first + p] * tool.tool.compliance);
      const double force = gain * (estimates[p] / tool.stiffness[first + p] - phi);
      const Vec3 out = tool.frame.turn * packed(normal);
      if (force > 0.0) visit(Pressed{&patch, share, first + p, force, gain, out, out});
    }
  }
}

VecList RestTools::forces_of(const Touching& tool, std::span<const Vec3> position) const {
  VecList force(particles_, Vec3::Zero());
  for_each_pressed(tool, position, [&](const Pressed& own) {
    for (int c = 0; c < own.patch->corners; ++c) force[own.patch->corner[c]] += own.share[c] * own.force * own.normal;
  });
  return force;
}

/// A particle near a tool may come to it.
void RestTools::mark_held(std::span<char> particles) const {
  if (!tools_.empty()) std::ranges::fill(particles, char{1});
}

void RestTools::add_forces(std::span<const Vec3> position, std::span<Vec3> force) const {
  for (const Touching& tool : tools_) {
    for_each_pressed(tool, position, [&](const Pressed& own) {
      for (int c = 0; c < own.patch->corners; ++c) force[own.patch->corner[c]] += own.share[c] * own.force * own.normal;
    });
  }
}

double RestTools::energy(std::span<const Vec3> position) const {
  double energy = 0.0;
  for (const Touching& tool : tools_) {
    for_each_pressed(tool, position, [&](const Pressed& own) {
      if (own.force > 0.0) energy += 0.5 * own.force * own.force / own.gain;
    });
  }
  return energy;
}

double RestTools::squared_support(std::span<const Vec3> position) const {
  double sum = 0.0;
  for (const Touching& tool : tools_) {
    for (const Vec3& force : forces_of(tool, position)) sum += force.squaredNorm();
  }
  return sum;
}

/// Of points without the turning of normals, which would take definiteness from K. Integrals over triangles on edges
/// have lines that take stiffness: without them tissue would hardly slide past an edge in a step.
void RestTools::linearise(std::span<const Vec3> position) {
  linear_.clear();
  ++linearised_;
  for (const Touching& tool : tools_) {
    for_each_pressed(tool, position, [&](const Pressed& own) {
      if (own.gain > 0.0 || linearised_ > rough_linearisations) linear_.push_back(own);
    });
  }
}

void RestTools::add_product(const Eigen::VectorXd& d, Eigen::VectorXd& result) const {
  const auto row = [](const Pressed& own, int c) { return 3 * Eigen::Index{own.patch->corner[c]}; };
  for (const Pressed& own : linear_) {
    double way = 0.0;
    for (int c = 0; c < own.patch->corners; ++c) way += own.share[c] * own.stiff.dot(d.segment<3>(row(own, c)));
    for (int c = 0; c < own.patch->corners; ++c) {
      result.segment<3>(row(own, c)) += own.share[c] * own.gain * way * own.stiff;
    }
  }
}

void RestTools::add_diagonal(std::span<Mat3> blocks) const {
  for (const Pressed& own : linear_) {
    const Mat3 along = own.gain * own.stiff * own.stiff.transpose();
    for (int c = 0; c < own.patch->corners; ++c) blocks[own.patch->corner[c]] += own.share[c] * own.share[c] * along;
  }
}

double RestTools::squared_miss(std::span<const Vec3> position) const {
  double sum = 0.0;
  for (const Touching& tool : tools_) {
    if (tool.raises_left == 0) continue;
    std::vector<double> miss(tool.estimate.size()), of_particles(particles_, 0.0);
    std::ranges::transform(tool.estimate, miss.begin(), std::negate());
    const double to_be_raised = tool.raised < most_raised ? 1.0 / tool.raised : 0.0;
    for_each_pressed(tool, position, [&](const Pressed& own) {
      if (own.row != no_row) return void(miss[own.row] += own.force);
      for (int c = 0; c < own.patch->corners; ++c) {
        of_particles[own.patch->corner[c]] += own.share[c] * to_be_raised * own.force;
      }
    });
    auto next = miss.begin();
    for_each_point(tool.points, [&](const ContactPoints::Patch& patch, const ContactPoints::Shares& share) {
      for (int c = 0; c < patch.corners; ++c) of_particles[patch.corner[c]] += share[c] * *next;
      ++next;
    });
    for (const double own : of_particles) sum += own * own;
  }
  return sum;
}

void RestTools::raise(std::span<const Vec3> position) {
  linearised_ = 0;
  for (Touching& tool : tools_) {
    if (tool.raises_left == 0) continue;
    --tool.raises_left;
    std::vector<double> next(tool.estimate.size(), 0.0);
    for_each_pressed(tool, position, [&](const Pressed& own) {
      if (own.row != no_row) next[own.row] = own.force;
    });
    tool.estimate = std::move(next);
    tool.raised = std::min(raising * tool.raised, most_raised);
  }
}

void RestTools::append_estimates(std::vector<double>& all) const {
  for (const Touching& tool : tools_) all.insert(all.end(), tool.estimate.begin(), tool.estimate.end());
}

std::span<const double> RestTools::take_estimates(std::span<const double> all) {
  for (Touching& tool : tools_) {
    for (std::size_t k = 0; k < tool.estimate.size(); ++k) tool.estimate[k] = std::max(all[k], 0.0);
    all = all.subspan(tool.estimate.size());
  }
  return all;
}

void RestTools::add_reactions(std::span<const Vec3> position, std::span<ToolForce> all) const {
  for (std::size_t row = 0; row < tools_.size(); ++row) {
    const Touching& tool = tools_[row];
    const VecList forces = forces_of(tool, position);
    for (std::size_t i = 0; i < forces.size(); ++i) {
      if (forces[i] == Vec3::Zero()) continue;
      all[row].force -= forces[i];
      all[row].torque -= (position[i] - tool.frame.position).cross(forces[i]);
      ++all[row].particles;
    }
  }
}

RestJoints::RestJoints(const Scene& scene, const State& state) : scene_(scene) {
  for (const SceneJoint& joint : scene.joints()) {
    const auto known = std::ranges::find(state.joints, joint.name, &JointState::name);
    for (std::size_t row = 0; row < joint.joint.springs.size(); ++row) {
      if (known != state.joints.end() && std::ranges::count(known->broken, static_cast<Index>(row)) > 0) continue;
      if (ends_at_removed(joint.joint.springs[row], scene.model().mass)) continue;
      springs_.push_back({.joint = &joint, .spring = &joint.joint.springs[row]});
    }
  }
}

void RestJoints::mark_held(std::span<char> particles) const {
  for (const Spring& own : springs_) {
    if (!(own.joint->joint.stiffness > 0.0)) continue;
    for_each_weight(*own.spring, [&](Index i, double) { particles[i] = 1; });
  }
}

Vec3 RestJoints::span_of(const JointSpring& spring, std::span<const Vec3> position) const {
  return anchor_place(spring.b, position, scene_.tools()) - anchor_place(spring.a, position, scene_.tools());
}

void RestJoints::add_forces(std::span<const Vec3> position, std::span<Vec3> force) const {
  for (const Spring& own : springs_) {
    const Vec3 on_a = spring_force(own.joint->joint, *own.spring, span_of(*own.spring, position), Vec3::Zero());
    for_each_weight(*own.spring, [&](Index i, double weight) { force[i] -= weight * on_a; });
  }
}

void RestJoints::add_reactions(std::span<const Vec3> position, std::span<ToolForce> tools) const {
  for (const Spring& own : springs_) {
    const Vec3 on_a = spring_force(own.joint->joint, *own.spring, span_of(*own.spring, position), Vec3::Zero());
    for (const auto& [anchor, force] : {std::pair{&own.spring->a, on_a}, std::pair{&own.spring->b, Vec3(-on_a)}}) {
      const auto tool = std::ranges::find(scene_.tools(), anchor->tool, &SceneTool::name);
      if (tool == scene_.tools().end()) continue;  // a tool's name is not empty
      ToolForce& felt = tools[static_cast<std::size_t>(tool - scene_.tools().begin())];
      felt.force += force;
      felt.torque += (anchor_place(*anchor, position, scene_.tools()) - tool->pose.position).cross(force);
    }
  }
}

std::vector<JointReport> RestJoints::reports(std::span<const Vec3> position) const {
  std::vector<JointReport> all;
  for (const SceneJoint& joint : scene_.joints()) {
    JointReport& report = all.emplace_back();
    for (const JointSpring& spring : joint.joint.springs) {
      report.springs.push_back({.length = span_of(spring, position).norm(), .broken = true});
    }
    report.broken = static_cast<int>(report.springs.size());
  }
  for (const Spring& own : springs_) {
    JointReport& report = all[static_cast<std::size_t>(own.joint - scene_.joints().data())];
    SpringReport& spring = report.springs[static_cast<std::size_t>(own.spring - own.joint->joint.springs.data())];
    spring.broken = false;
    spring.force = spring_force(own.joint->joint, *own.spring, span_of(*own.spring, position), Vec3::Zero());
    report.force += spring.force;
    report.largest = std::max(report.largest, spring.force.norm());
    --report.broken;
  }
  return all;
}

double RestJoints::energy(std::span<const Vec3> position) const {
  double energy = 0.0;
  for (const Spring& own : springs_) {
    energy += spring_energy(own.joint->joint, *own.spring, span_of(*own.spring, position).norm());
  }
  return energy;
}

double RestJoints::squared_support(std::span<const Vec3> position) const {
  double sum = 0.0;
  for (const Spring& own : springs_) {
    if (!own.spring->a.particles.empty() && !own.spring->b.particles.empty()) continue;
    sum += spring_force(own.joint->joint, *own.spring, span_of(*own.spring, position), Vec3::Zero()).squaredNorm();
  }
  return sum;
}

void RestJoints::linearise(std::span<const Vec3> position) {
  for (Spring& own : springs_) {
    own.tangent = spring_tangent(own.joint->joint, *own.spring, span_of(*own.spring, position));
  }
}

void RestJoints::add_product(const Eigen::VectorXd& d, Eigen::VectorXd& result) const {
  for (const Spring& own : springs_) {
    Vec3 way = Vec3::Zero();
    for_each_weight(*own.spring, [&](Index i, double weight) { way += weight * d.segment<3>(3 * Eigen::Index{i}); });
    const Vec3 force = own.tangent * way;
    for_each_weight(*own.spring,
                    [&](Index i, double weight) { result.segment<3>(3 * Eigen::Index{i}) += weight * force; });
  }
}

void RestJoints::add_diagonal(std::span<Mat3> blocks) const {
  for (const Spring& own : springs_) {
    for_each_weight(*own.spring, [&](Index i, double weight) { blocks[i] += weight * weight * own.tangent; });
  }
}

std::string RestJoints::overloaded(std::span<const Vec3> position) const {
  for (const Spring& own : springs_) {
    const Vec3 force = spring_force(own.joint->joint, *own.spring, span_of(*own.spring, position), Vec3::Zero());
    if (force.norm() > own.spring->share * own.joint->joint.breaking_force) return own.joint->name;
  }
  return {};
}

}  // namespace phymul
