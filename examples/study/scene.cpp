// SPDX-License-Identifier: MIT
#include "scene.h"

#include <phymul/error.h>
#include <phymul/simulation.h>
#include <phymul/skin.h>
#include <phymul/version.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "checksum.h"
#include "expression.h"
#include "run_body.h"

namespace {

using phymul::Vec3;
using phymul::bench::Variables;

Variables variables_of(const Study& study, const std::vector<double>& values) {
  Variables result;
  const std::vector<std::string> names = study.names();
  for (std::size_t k = 0; k < names.size(); ++k) result[names[k]] = values[k];
  return result;
}

std::string with_values(const std::string& word, const Variables& variables) {
  std::string result;
  std::size_t from = 0;
  for (std::size_t open = 0; (open = word.find('{', from)) != std::string::npos;) {
    const std::size_t close = word.find('}', open);
    if (close == std::string::npos) throw phymul::Error("expected } after { in " + word);
    result += word.substr(from, open - from);
    result += shortest_decimal(phymul::bench::evaluate(word.substr(open + 1, close - open - 1), variables));
    from = close + 1;
  }
  return result + word.substr(from);
}

bool same_shape(const RunOptions& a, const RunOptions& b) {
  return a.body == b.body && a.length_unit == b.length_unit && a.spacing == b.spacing && a.fine_balls == b.fine_balls;
}

/// What a load amounts to in the end, from the beginning: a rest shape has no dates.
std::vector<phymul::Load> last_values(const std::vector<phymul::Load>& loads) {
  std::vector<phymul::Load> result = loads;
  for (phymul::Load& load : result) {
    if (!load.events.empty()) load.events = {{0.0, load.events.back().value}};
  }
  return result;
}

void append(std::vector<double>& values, const Vec3& vector) {
  values.insert(values.end(), vector.data(), vector.data() + 3);
}

Vec3 point_of(const StudyTarget& target, const Variables& variables) {
  Vec3 point;
  for (int axis = 0; axis < 3; ++axis) point[axis] = phymul::bench::evaluate(target.point[axis], variables);
  return point;
}

/// Rest place and displacement, m.
std::pair<Vec3, Vec3> centre_of_mass(const phymul::Model& model, const std::string& group,
                                     const phymul::VecList& displacement) {
  Vec3 rest = Vec3::Zero(), moved = Vec3::Zero();
  double mass = 0.0;
  for (const phymul::Index i : model.group(group)) {
    rest += model.mass[i] * model.rest[i];
    moved += model.mass[i] * displacement[i];
    mass += model.mass[i];
  }
  return {rest / mass, moved / mass};
}

}  // namespace

std::vector<std::string> scene_words(const Study& study, const std::vector<double>& values) try {
  const Variables variables = variables_of(study, values);
  std::vector<std::string> words;
  for (const std::string& word : study.words) words.push_back(with_values(word, variables));
  return words;
} catch (const phymul::Error& error) {
  fail_at(study.file, study.words_line, error.what());
}

phymul::Model SceneSolver::dressed(const RunOptions& options) {
  if (!shape_options_ || !same_shape(*shape_options_, options)) {
    if (shape_options_ && shape_options_->body != options.body) {
      throw phymul::Error("expected the same body in all scenes, got " + options.body + " besides " +
                          shape_options_->body);
    }
    shape_options_.reset();
    shape_ = read_shape(options);
    shape_options_ = options;
  }
  phymul::Model model = shape_;
  dress_shape(options, model);
  return cut_along_planes(options, std::move(model));
}

std::vector<double> SceneSolver::solve_or_throw(const std::vector<double>& values, bool only_build) {
  const RunOptions options = run_options_of(scene_words(study_, values));
  if (options.from_file) throw phymul::Error("--from-file: expected a body with a material; a rest shape needs one");
  if (options.tearing) throw phymul::Error("--tear: expected a body whose rest shape is asked for; it tears in time");
  const Variables variables = variables_of(study_, values);

  // "reference": the state stays in double precision, and no choice depends on the machine's speed.
  phymul::SimulationOptions how{.backend = "reference", .topology = options.topology};
  phymul::Simulation sim(dressed(options), how);
  fill_scene(options, sim.model(), sim.scene(), nullptr);
  const std::vector<phymul::Load> loads = last_values(sim.scene().loads());
  for (std::size_t row = 0; row < loads.size(); ++row) sim.scene().replace(row, loads[row]);

  phymul::VecList points;
  for (const StudyTarget& target : study_.targets) {
    if (target.group.empty()) {
      points.push_back(point_of(target, variables));
    } else {
      (void)sim.model().group(target.group);
    }
  }
  const phymul::VecList& measured = study_.measurement.point;
  points.insert(points.end(), measured.begin(), measured.end());
  const phymul::Skin skin(sim.model(), points);
  if (only_build) return {};

  const phymul::StaticResult rest = sim.solve_static({.tolerance = study_.tolerance});
  if (!rest.converged()) throw phymul::Error(rest.message());
  phymul::VecList displacement = sim.state().position;
  for (std::size_t i = 0; i < displacement.size(); ++i) displacement[i] -= sim.model().rest[i];
  const phymul::VecList moved = skin.deform(displacement);

  std::vector<double> result;
  std::size_t point = 0;
  for (const StudyTarget& target : study_.targets) {
    const auto [at, way] = target.group.empty() ? std::pair(points[point], moved[point])
                                                : centre_of_mass(sim.model(), target.group, displacement);
    if (target.group.empty()) ++point;
    append(result, at + way);
    append(result, way);
  }
  for (; point < points.size(); ++point) append(result, moved[point]);
  return result;
}

SceneResult SceneSolver::solve(const std::vector<double>& values) try {
  return {.failure = {}, .values = solve_or_throw(values, false)};
} catch (const phymul::Error& error) {
  if (error.code() == phymul::ErrorCode::out_of_memory || error.code() == phymul::ErrorCode::file_access) throw;
  std::string reason = error.what();  // in one line, as the results are kept
  std::ranges::replace(reason, '\n', ' ');
  return {.failure = std::move(reason), .values = {}};
}

void SceneSolver::try_out(const std::vector<double>& values) try {
  solve_or_throw(values, true);
} catch (const phymul::Error& error) {
  if (!error.file().empty()) throw;
  fail_at(study_.file, study_.words_line, error.what());
}

std::uint32_t study_fingerprint(const Study& study, const std::vector<double>& values) {
  Checksum sum;
  sum.add(PHYMUL_VERSION);
  for (const std::string& word : study.words) sum.add(word);
  for (const std::string& name : study.names()) sum.add(name);
  for (const StudyTarget& target : study.targets) {
    sum.add(target.name);
    sum.add(target.group);
    for (const std::string& text : target.point) sum.add(text);
  }
  for (const Vec3& point : study.measurement.point) {
    for (int axis = 0; axis < 3; ++axis) sum.add(shortest_decimal(point[axis]));
  }
  sum.add(shortest_decimal(study.tolerance));
  const std::vector<std::string> words = scene_words(study, values);
  const RunOptions options = run_options_of(words);
  for (const std::string& path : {options.body, options.loads}) {
    if (path.empty()) continue;
    for (std::size_t k = 0; k < words.size(); ++k) {
      if (words[k] != path || study.words[k] == path) continue;
      fail_at(study.file, study.words_line,
              "expected the same files in all scenes, got " + study.words[k] + "; make a study of each");
    }
    std::ifstream in(path, std::ios::binary);
    sum.add(std::string(std::istreambuf_iterator<char>(in), {}));
  }
  return sum.value();
}
