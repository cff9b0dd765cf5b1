// SPDX-License-Identifier: MIT
#include "problem.h"

#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "case_body.h"
#include "case_tool.h"

namespace phymul::bench {
namespace {

/// Loads of one imposed motion: particles with the same displacement share one.
std::vector<Load> motions(const ReferenceCase& it, const ReferenceCase::OnGroup& motion, const Variables& variables,
                          Problem& problem) {
  const Model& model = problem.model;
  std::map<std::array<double, 3>, std::vector<Index>> by_displacement;
  for (const Index i : model.group(motion.group)) {
    const Variables here = at_point(it, variables, model.rest[i]);
    std::array<double, 3> u{0, 0, 0};
    for (int axis = 0; axis < 3; ++axis) {
      if (motion.value[axis] == "-") continue;
      u[axis] = evaluate(motion.value[axis], here);
      problem.imposed[i] = static_cast<std::uint8_t>(problem.imposed[i] | 1 << axis);
      problem.displacement[i][axis] = u[axis];
    }
    by_displacement[u].push_back(i);
  }
  std::vector<Load> loads;
  for (auto& [u, particles] : by_displacement) {
    Load load;
    load.type = LoadType::translation;
    load.particles = std::move(particles);
    load.direction = {u[0], u[1], u[2]};
    const double size = load.direction.norm();
    load.events = {{0.0, size}};
    for (int axis = 0; axis < 3; ++axis) {
      load.axes[axis] = motion.value[axis] == "-" ? Axis::free : size > 0.0 ? Axis::driven : Axis::held;
    }
    loads.push_back(std::move(load));
  }
  return loads;
}

Load push(LoadType type, const Vec3& vector, std::vector<Index> particles) {
  Load load;
  load.type = type;
  load.direction = vector;
  load.events = {{0.0, vector.norm()}};
  load.particles = std::move(particles);
  return load;
}

void add_loads(const ReferenceCase& it, const Variables& variables, Problem& problem) {
  for (const ReferenceCase::OnGroup& motion : it.imposed) {
    for (Load& load : motions(it, motion, variables, problem)) problem.loads.push_back(std::move(load));
  }
  for (const ReferenceCase::OnGroup& force : it.forces) {
    std::vector<Index> members = problem.model.group(force.group);
    const Vec3 share = vector_of(force.value, variables) / static_cast<double>(members.size());
    problem.loads.push_back(push(LoadType::force, share, std::move(members)));
  }
  for (const ReferenceCase::OnGroup& traction : it.tractions) {
    problem.loads.push_back(
        push(LoadType::pressure, vector_of(traction.value, variables), problem.model.group(traction.group)));
  }
  for (const auto& [group, text] : it.pressures) {
    Load load;
    load.type = LoadType::pressure;
    load.events = {{0.0, evaluate(text, variables)}};
    load.particles = problem.model.group(group);
    problem.loads.push_back(std::move(load));
  }
  problem.gravity = vector_of(it.gravity, variables);
  for (const ReferenceCase::PlacedTool& tool : it.tools)
    problem.tools.push_back({tool.name, make_tool(tool, variables)});
}

/// Coordinates that are not imposed become the mean of their neighbours', by conjugate gradients on the graph.
void spread_harmonically(Problem& problem, int axis) {
  const Model& model = problem.model;
  const auto n = model.rest.size();
  const auto free = [&](Index i) { return (problem.imposed[i] >> axis & 1) == 0; };
  if (std::ranges::all_of(problem.displacement, [&](const Vec3& u) { return u[axis] == 0.0; })) return;
  std::vector<double> u(n), r(n), d(n), image(n);
  for (std::size_t i = 0; i < n; ++i) u[i] = problem.displacement[i][axis];
  const auto laplace = [&](const std::vector<double>& v, std::vector<double>& result) {
    for (Index i = 0; i < model.particle_count(); ++i) {
      result[i] = 0.0;
      if (!free(i)) continue;
      for (const Index* j = model.neighbours.begin(i); j != model.neighbours.end(i); ++j) result[i] += v[i] - v[*j];
    }
  };
  const auto dot = [&](const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < n; ++i) sum += a[i] * b[i];
    return sum;
  };
  laplace(u, image);
  for (std::size_t i = 0; i < n; ++i) d[i] = r[i] = -image[i];
  double rr = dot(r, r);
  const double target = 1e-24 * rr;
  for (int k = 0; k < 10000 && rr > target; ++k) {
    laplace(d, image);
    const double step = rr / dot(d, image);
    for (std::size_t i = 0; i < n; ++i) u[i] += step * d[i], r[i] -= step * image[i];
    const double next = dot(r, r);
    for (std::size_t i = 0; i < n; ++i) d[i] = r[i] + next / rr * d[i];
    rr = next;
  }
  for (std::size_t i = 0; i < n; ++i) problem.displacement[i][axis] = u[i];
}

struct Samples {
  VecList point, displacement;
};

/// None where the case knows forces alone.
Samples samples_of(const ReferenceCase& it, const std::string& level, const Variables& variables) {
  Samples result;
  if (it.samples.empty()) {
    for (const Triple& point : it.points) {
      result.point.push_back(vector_of(point, variables));
      result.displacement.push_back(vector_of(it.exact, at_point(it, variables, result.point.back())));
    }
    return result;
  }
  std::ifstream in(it.samples);
  if (!in) throw Error(it.samples + ": expected a CSV file with the columns level,x,y,z,ux,uy,uz");
  for (std::string line; std::getline(in, line);) {
    std::istringstream fields(line);
    std::string name, field;
    std::getline(fields, name, ',');
    if (name != level) continue;
    std::vector<double> v;
    while (std::getline(fields, field, ',')) v.push_back(evaluate(field, {}));
    if (v.size() != 6) throw Error(it.samples + ": expected 7 columns in \"" + line + "\"");
    result.point.emplace_back(v[0], v[1], v[2]);
    result.displacement.emplace_back(v[3], v[4], v[5]);
  }
  if (result.point.empty()) throw Error(it.samples + ": expected rows of level " + level);
  return result;
}

/// A sample is prescribed where every particle it is interpolated from is, along all axes.
void take_samples(const Samples& samples, Problem& problem) {
  if (samples.point.empty()) return;
  constexpr double most_outside = 0.5;  // cells; facets cut a rounding off
  const Skin all(problem.model, samples.point, most_outside);
  for (std::size_t s = 0; s < all.size(); ++s) {
    bool prescribed = true;
    for (std::size_t v = 0; v < all.particles(s).size(); ++v) {
      if (std::abs(all.weights(s)[v]) > 1e-6 && problem.imposed[all.particles(s)[v]] != 7) prescribed = false;
    }
    if (prescribed) {
      ++problem.prescribed_samples;
      continue;
    }
    problem.sample_point.push_back(samples.point[s]);
    problem.reference.push_back(samples.displacement[s]);
  }
  if (problem.sample_point.empty()) throw Error("every sample point is prescribed; nothing is left to compare");
  problem.samples.emplace(problem.model, problem.sample_point, most_outside);
}

std::array<std::optional<double>, 3> known_part(const Triple& texts, const Variables& variables) {
  std::array<std::optional<double>, 3> value;
  for (int axis = 0; axis < 3; ++axis) {
    if (texts[axis] != "-") value[axis] = evaluate(texts[axis], variables);
  }
  return value;
}

void add_expected_forces(const ReferenceCase& it, const Variables& variables, Problem& problem) {
  for (const ReferenceCase::OnGroup& row : it.reactions) {
    problem.reactions.push_back({problem.model.group(row.group), known_part(row.value, variables), false});
  }
  for (const ReferenceCase::OnGroup& row : it.torques) {
    problem.reactions.push_back({problem.model.group(row.group), known_part(row.value, variables), true});
  }
  for (const ReferenceCase::OnGroup& row : it.pushes) {
    problem.pushes.push_back({row.group, known_part(row.value, variables)});
  }
}

}  // namespace

void Problem::load(Scene& scene) const {
  scene.gravity(gravity);
  for (const Load& load : loads) scene.add(load);
  for (const NamedTool& it : tools) scene.add_tool(it.name, it.tool);
}

Scene Problem::scene(const Model& same_body) const {
  Scene result(same_body);
  load(result);
  return result.copy();
}

bool Problem::has_forces() const {
  return gravity != Vec3::Zero() ||
         std::ranges::any_of(loads, [](const Load& load) { return load.type != LoadType::translation; });
}

Problem make_problem(const ReferenceCase& it, const std::string& level, int n) {
  const Variables variables = it.variables(level, n);
  Problem problem;
  problem.model = make_body(it, variables);
  set_material(problem.model, {evaluate(it.material[0], variables), evaluate(it.material[1], variables),
                               evaluate(it.material[2], variables)});
  problem.imposed.assign(problem.model.rest.size(), 0);
  problem.displacement.assign(problem.model.rest.size(), Vec3::Zero());
  add_loads(it, variables, problem);
  for (int axis = 0; axis < 3; ++axis) spread_harmonically(problem, axis);
  take_samples(samples_of(it, level, variables), problem);
  add_expected_forces(it, variables, problem);
  problem.floor = evaluate(it.floor, variables);
  problem.force_floor = evaluate(it.force_floor, variables);
  return problem;
}

}  // namespace phymul::bench
