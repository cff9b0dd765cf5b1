// SPDX-License-Identifier: MIT
#include "case_body.h"

#include <phymul/body.h>
#include <phymul/error.h>
#include <phymul/mesh.h>
#include <phymul/shapes.h>

#include <algorithm>
#include <cmath>

namespace phymul::bench {
namespace {

std::vector<double> values(const std::vector<std::string>& texts, const Variables& variables) {
  std::vector<double> result;
  for (const std::string& text : texts) result.push_back(evaluate(text, variables));
  return result;
}

int count(const std::string& text, const Variables& variables) {
  const double value = evaluate(text, variables);
  if (std::abs(value - std::round(value)) > 1e-9) throw Error("cells: expected a whole number, got \"" + text + "\"");
  return static_cast<int>(std::round(value));
}

Model from_file(const ReferenceCase& it, const Variables& variables) {
  std::string path = it.body_args[0];
  if (const std::size_t mark = path.find("{n}"); mark != std::string::npos) {
    path.replace(mark, 3, std::to_string(static_cast<int>(variables.at("n"))));
  }
  MeshOptions options;
  if (it.body_args.size() > 1) options.length_unit = evaluate(it.body_args[1], variables);
  return read_mesh(path, options);
}

void add_place(Variables& variables, const Vec3& point) {
  variables["x"] = point.x();
  variables["y"] = point.y();
  variables["z"] = point.z();
}

/// A box filled by make_body(), finer around the middle of its upper side. The volume asked for is met by moving the
/// surface, which edges that are cut off take part in: the place of the upper side is what a tool is pressed into.
Model filled_box(const Vec3& size, double spacing, double finest, double radius) {
  const Vec3 top(0.5 * size.x(), 0.5 * size.y(), size.z());
  BodyOptions options{.spacing = spacing};
  if (finest < spacing) options.spacing_at = fine_near(top, radius, finest, spacing);
  Model model = phymul::make_body(solid_box(Vec3::Zero(), size), options);
  double sum = 0.0;
  int count = 0;
  for (const Index i : model.group("surface")) {
    if ((model.rest[i] - top).norm() > std::max(radius, spacing)) continue;
    sum += model.rest[i].z() - top.z();
    ++count;
  }
  for (Vec3& x : model.rest) x.z() -= sum / count;
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool is_far : {false, true}) {
      std::vector<Index> side;
      for (const Index i : model.group("surface")) {
        if (std::abs(model.rest[i][axis] - (is_far ? size[axis] : 0.0)) < 0.2 * spacing) side.push_back(i);
      }
      model.add_group(std::string(1, "xyz"[axis]) + (is_far ? "1" : "0"), std::move(side));
    }
  }
  return model;
}

Model built(const ReferenceCase& it, const Variables& variables) {
  if (it.body == "file") return from_file(it, variables);
  const std::vector<double> a = values(it.body_args, variables);
  if (it.body == "filled") {
    if (a.size() != 6) throw Error("body filled: expected 6 numbers, got " + std::to_string(a.size()));
    return filled_box({a[0], a[1], a[2]}, a[3], a[4], a[5]);
  }
  const int nx = count(it.cells[0], variables), ny = count(it.cells[1], variables), nz = count(it.cells[2], variables);
  const auto require = [&](std::size_t least) {
    if (a.size() < least) {
      throw Error("body " + it.body + ": expected " + std::to_string(least) + " numbers, got " +
                  std::to_string(a.size()));
    }
  };
  if (it.body == "block") {
    require(3);
    return make_block({a[0], a[1], a[2]}, nx, ny, nz);
  }
  if (it.body == "tetrahedra") {
    require(4);
    const auto seed = static_cast<std::uint32_t>(a.size() > 4 ? a[4] : 1.0);
    const double least = a.size() > 5 ? a[5] : 0.1;
    return make_tetrahedral_block({a[0], a[1], a[2]}, nx, ny, nz, a[3], seed, least);
  }
  if (it.body == "cylinder") {
    require(2);
    return make_cylinder(a[0], a[1], nx, ny, nz + 1);
  }
  throw Error("body \"" + it.body + "\": expected block, tetrahedra, cylinder, filled or file");
}

}  // namespace

Variables at_point(const ReferenceCase& it, Variables variables, const Vec3& point) {
  add_place(variables, point);
  for (const auto& [name, text] : it.fields) variables[name] = evaluate(text, variables);
  return variables;
}

Vec3 vector_of(const Triple& texts, const Variables& variables) {
  return {evaluate(texts[0], variables), evaluate(texts[1], variables), evaluate(texts[2], variables)};
}

Model make_body(const ReferenceCase& it, const Variables& variables) {
  Model model = built(it, variables);
  if (it.map[0] != "-") {
    Variables here = variables;
    for (Vec3& p : model.rest) {
      add_place(here, p);
      for (int axis = 0; axis < 3; ++axis) p[axis] = evaluate(it.map[axis], here);
    }
  }
  for (const auto& [name, condition] : it.groups) {
    std::vector<Index> members;
    for (Index i = 0; i < model.particle_count(); ++i) {
      if (evaluate(condition, at_point(it, variables, model.rest[i])) != 0.0) members.push_back(i);
    }
    if (members.empty()) throw Error("group " + name + ": no particle meets the condition \"" + condition + "\"");
    model.add_group(name, std::move(members));
  }
  return model;
}

}  // namespace phymul::bench
