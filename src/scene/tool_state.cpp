// SPDX-License-Identifier: MIT
#include "tool_state.h"

#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <span>

#include "model/cell_geometry.h"

namespace phymul {
namespace {

constexpr double longest_needle = 10.0;  // m: no needle slips farther
constexpr double largest_load = 1e6;     // N on a shaft
constexpr double largest_weight = 100.0;

bool fits(const ShaftLoad& load) {
  return std::abs(load.along) <= longest_needle && std::abs(load.x) <= largest_load && std::abs(load.y) <= largest_load;
}

/// A weighted mean.
bool fits(std::span<const double> weights) {
  double sum = 0.0;
  for (const double w : weights) sum += w;
  return std::abs(sum - 1.0) <= 1e-6 &&
         std::ranges::all_of(weights, [](double w) { return std::abs(w) <= largest_weight; });
}

bool fits(const ToolState& tool, Index particle_count) {
  const auto is_particle = [&](Index i) { return i >= 0 && i < particle_count; };
  const auto finite = [](const Vec3& v) { return v.allFinite(); };
  if (!finite(tool.pose.position) || !finite(tool.pose.velocity) || !finite(tool.pose.spin)) return false;
  const double turn = tool.pose.orientation.norm();
  if (!(turn > 0.0) || !std::isfinite(turn)) return false;
  if (tool.held.size() != tool.held_at.size()) return false;
  if (!(std::abs(tool.needle.slip) <= longest_needle)) return false;
  if (!std::ranges::all_of(tool.needle.shaft, [](const ShaftLoad& load) { return fits(load); })) return false;
  if (!std::ranges::all_of(tool.blade, [](const BladePoint& p) {
        return std::isfinite(p.along) && std::isfinite(p.ahead) && fits(p.weights);
      })) {
    return false;
  }
  if (!std::ranges::all_of(tool.held, is_particle) || !std::ranges::all_of(tool.held_at, finite)) return false;
  if (std::set(tool.held.begin(), tool.held.end()).size() != tool.held.size()) return false;
  return std::ranges::all_of(tool.needle.hole, [&](const NeedleNode& node) {
    return !node.particles.empty() && node.particles.size() == node.weights.size() &&
           std::ranges::all_of(node.particles, is_particle) && fits(node.weights);
  });
}

bool is_blade(const SceneTool& tool) {
  return std::holds_alternative<Blade>(tool.tool.shape);
}

bool is_needle(const SceneTool& tool) {
  return std::holds_alternative<Needle>(tool.tool.shape);
}

constexpr const char* what_to_do =
    "; give the scene the tool that the state was taken with, another name to this one, or take its entry out of "
    "State::tools";

void require_fitting_shape(const ToolState& state, const SceneTool& tool) {
  if ((is_needle(tool) || is_blade(tool)) && !state.held.empty()) {
    throw Error("Solver::reset: the state of tool \"" + state.name + "\" holds " + std::to_string(state.held.size()) +
                " particles, but the scene's tool of that name is a " + (is_needle(tool) ? "needle" : "blade") +
                ", which cannot" + what_to_do);
  }
  if (!is_blade(tool) && !state.blade.empty()) {
    throw Error("Solver::reset: the state of tool \"" + state.name +
                "\" has points of a blade, but the scene's tool of that name is no blade" + what_to_do);
  }
  const bool pierces =
      !state.needle.hole.empty() || !state.needle.shaft.empty() || state.needle.punctured || state.needle.free;
  if (!is_needle(tool) && pierces) {
    throw Error("Solver::reset: the state of tool \"" + state.name +
                "\" has a needle's hole, but the scene's tool of that name is no needle" + what_to_do);
  }
}

}  // namespace

bool has_needle(const std::vector<SceneTool>& tools) {
  return std::ranges::any_of(tools, is_needle);
}

bool touches_surface(const std::vector<SceneTool>& tools) {
  return std::ranges::any_of(
      tools, [](const SceneTool& tool) { return tool.tool.contact == ToolContact::surface || is_blade(tool); });
}

void require_tool_states(const State& state, Index particle_count, const std::vector<SceneTool>& tools) {
  for (const ToolState& tool : state.tools) {
    if (!fits(tool, particle_count)) {
      throw Error("Solver::reset: the state of tool \"" + tool.name +
                  "\" has particles that this model does not have, lists of unlike lengths, or numbers that no tool "
                  "has, or holds a particle twice");
    }
    const auto own = std::ranges::find(tools, tool.name, &SceneTool::name);
    if (own != tools.end()) require_fitting_shape(tool, *own);
  }
}

namespace {

/// So that bodies of up to 10.9 mm spacing carry the default spread of an 18 gauge needle.
constexpr double spread_in_radii = 34.0;

/// Pa. On lattices of 1.3 to 6 spacings in the spread s, cells under a tip turn inside out from a push of F on, for
/// which F / s^2 is 0.25 to 0.4 of Young's modulus (nu 0.3), 0.4 (0.4), 0.7 to 0.9 (0.45) or 0.82 to 1.4 (0.49): tissue
/// that is easily compressed is crushed sooner. This is below all of them.
double limit_of(const Material& material) {
  const double gives = 1.0 - 2.0 * material.poisson;
  return material.young / (1.25 + (6.0 + 8.5 * gives) * gives);
}

}  // namespace

double needle_spacing(const Model& model) {
  const double spacing = mean_spacing(model);
  return spacing > 0.0 ? spacing : body_size(model) / std::cbrt(static_cast<double>(model.particle_count()));
}

double needle_spread(const Needle& needle, const Model& model) {
  return needle.spread > 0.0 ? needle.spread : std::max(spread_in_radii * needle.radius, 2.0 * needle_spacing(model));
}

/// A force on a particle is one on its cell already, spread evenly over the spacing h, which has the variance h^2 / 12
/// along each axis. The weights, whose own over a surface is reach^2 / 8, add what is missing; below 1.5 spacings they
/// would find too few particles.
double needle_support_radius(double spread, const Model& model) {
  const double spacing = needle_spacing(model);
  const double left = spread * spread - 8.0 / 12.0 * spacing * spacing;
  return std::max(std::sqrt(std::max(left, 0.0)), std::min(spread, 1.5 * spacing));
}

void needle_bearing(const Model& model, std::span<const double> factors, std::vector<double>& bearing) {
  const auto limit = [&](Index material) {
    return limit_of(model.materials[material]) * (factors.empty() ? 1.0 : factors[material]);
  };
  const std::size_t count = model.rest.size();
  bearing.assign(count, std::numeric_limits<double>::infinity());
  std::vector<int> cells(count, 0);
  const bool in_space = is_made_of_cells(model);  // then a capsule says nothing of the tissue below it
  for (const Cell& cell : model.cells) {
    if (cell.material < 0 || cell.share == 0.0 || (in_space && !is_solid(model.dimension, cell))) continue;
    for (const Index i : cell.particles) bearing[i] = (cells[i]++ == 0 ? 0.0 : bearing[i]) + limit(cell.material);
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (cells[i] > 0) bearing[i] /= cells[i];
  }
  // A body of points has one material.
  if (is_body_of_points(model) && !model.materials.empty()) bearing.assign(count, limit(0));
}

double needle_turn(const ToolPose& start, const ToolPose& end) {
  const Eigen::AngleAxisd turn(Eigen::Quaterniond(end.orientation * start.orientation.conjugate()));
  const Vec3 axis = end.orientation * Vec3::UnitZ();
  const double angle = turn.angle() * turn.axis().dot(axis);
  return std::abs(angle) > 1e-9 ? angle : 0.0;
}

}  // namespace phymul
