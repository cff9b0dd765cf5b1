// SPDX-License-Identifier: MIT
//
// Where methods stop being stable, as CSV files for the charts: the step limit, predicted and found, over what may
// lower it (--limits); what becomes of a body that starts broken (--recovery); how fast reactions that have no energy
// grow (--rates).
#include <cmath>
#include <cstdio>

#include "arguments.h"
#include "csv_row.h"
#include "stability/stability_methods.h"
#include "support/failure_states.h"
#include "support/mechanics.h"

namespace {

using namespace phymul;
using namespace phymul::bench;
using namespace phymul::test;

constexpr double side = 0.04;  // m

double grown(const Model& model, Solver& solver, int steps, double dt) {
  State start = rest_state(model);
  start.position = random_positions(model, 1e-7, 1);
  solver.reset(start);
  if (!solver.step(steps, dt).ok()) return std::numeric_limits<double>::infinity();
  return displacement_norms(model, solver.read()).max / mean_spacing(model);
}

struct Limit {
  double predicted = 0.0;  // s
  double found = 0.0;      // s; NaN where the body grows at any step
};

/// By bisection to 4e-4: at a step beyond the limit by that, noise grows by e to the twentieth in the steps taken.
Limit step_limit(const Model& model, const TopologyOptions& topology, double damping_factor) {
  const Scene scene(model);
  SolverOptions options;
  options.on_unstable = UnstableStep::allow;
  options.max_displacement_per_step = std::numeric_limits<double>::infinity();
  options.damping.factor = damping_factor;
  const auto solver = make_solver("reference", model, scene, topology, options);
  Limit limit{solver->stable_step(), std::numeric_limits<double>::quiet_NaN()};
  constexpr int steps = 500;
  constexpr double much = 1e-5;  // of a spacing, a hundred times the start
  double low = 0.75, high = 1.25;
  if (grown(model, *solver, 2 * steps, 0.5 * limit.predicted) > much) return limit;
  for (int k = 0; k < 10; ++k) {
    const double middle = 0.5 * (low + high);
    (grown(model, *solver, steps, middle * limit.predicted) > much ? high : low) = middle;
  }
  limit.found = 0.5 * (low + high) * limit.predicted;
  return limit;
}

class Limits {
 public:
  Limits(const std::string& path, const Arguments& arguments)
      : file_(path, {"question", "method", "value", "predicted", "found", "unit"}),
        cells_(std::max(2, static_cast<int>(arguments.number("cells")) / 2)),
        factors_(arguments.numbers("factors")),
        ratios_(arguments.numbers("ratios")),
        valences_(arguments.numbers("valences")) {}

  void all(const Method& method) {
    const Model plain = tissue_cube(method, side, cells_);
    for (const double d : factors_) row("damping", method, d, plain, d);
    for (const double ratio : ratios_) {
      row("stiffness", method, ratio, stiffer_half(method, ratio), 1.0);
      Model model = plain;
      for (std::size_t i = 0; i < model.mass.size(); i += 2) model.mass[i] *= ratio;
      row("mass", method, ratio, model, 1.0);
    }
    if (method.material) return;  // whose forces come from its cells
    for (const double valence : valences_) {
      Method other = method;
      other.valence = static_cast<int>(valence);
      row("valence", other, valence, tissue_cube(other, side, cells_), 1.0);
    }
  }

 private:
  /// Half of the cube by x, E or k times the ratio, mass as it was.
  Model stiffer_half(const Method& method, double ratio) const {
    Model model = tissue_cube(method, side, cells_);
    std::vector<Index> half;
    for (Index i = 0; i < model.particle_count(); ++i) {
      if (model.rest[i].x() > side / 2) half.push_back(i);
    }
    if (!method.material) {
      for (const Index i : half) model.stiffness[i] *= ratio;
      return model;
    }
    Component stiff;
    stiff.name = "stiff";
    stiff.exclusive = false;
    for (std::size_t c = 0; c < model.cells.size(); ++c) {
      double x = 0.0;
      for (const Index p : model.cells[c].particles) x += model.rest[p].x();
      if (is_volume(model.cells[c].type) && x / static_cast<double>(model.cells[c].particles.size()) > side / 2) {
        stiff.cell_refs.push_back(static_cast<Index>(c));
      }
    }
    model.components.push_back(stiff);
    Material tissue = soft_tissue(method.poisson);
    tissue.young *= ratio;
    set_material(model, tissue, "stiff");
    return model;
  }

  void row(const char* question, const Method& method, double value, const Model& model, double damping) {
    const Limit limit = step_limit(model, method.options, damping);
    const double unit = mean_spacing(model) * std::sqrt(soft_tissue().density / soft_tissue().young);
    file_.row({question, method.name, field(value), field(limit.predicted), field(limit.found), field(unit)});
    std::printf("%-10s %-24s %-8g predicted %.5g s, found over it %.4f\n", question, method.name.c_str(), value,
                limit.predicted, limit.found / limit.predicted);
    std::fflush(stdout);
  }

  CsvFile file_;
  int cells_;
  std::vector<double> factors_, ratios_, valences_;
};

const char* verdict(const RestResult& rest, double distance) {
  if (!rest.report.ok()) return "ran away";
  if (distance < 0.01) return "returned";
  if (!rest.converged()) return "moves";
  if (rest.collapsed >= 0) return "rests collapsed";
  return rest.folded >= 0 ? "rests folded" : "rests elsewhere";
}

void write_recovery(const std::string& path, const std::vector<std::string>& backends, int cells, int steps,
                    double share) {
  CsvFile file(path, {"method", "backend", "device", "state", "step_share", "verdict", "distance", "steps", "message"});
  std::vector<FailureState> states = failure_states();
  states.push_back({"point, exact", [](VecList& x, double length, double, std::mt19937&) { flatten(x, length, 3); }});
  for (const Method& method : stability_methods()) {
    const Model model = tissue_cube(method, side, cells);
    const Scene scene(model);
    SolverOptions options;
    options.damping.factor = 0.99;
    for (const std::string& backend : backends) {
      const auto solver = make_solver(backend, model, scene, method.options, options);
      int returned = 0;
      std::string others;
      for (const FailureState& failure : states) {
        std::mt19937 bits(5);
        State state = rest_state(model);
        failure.apply(state.position, side, side / cells, bits);
        solver->reset(state);
        const RestResult rest = solver->run_to_rest(steps, share * solver->stable_step());
        const double distance = distance_from_rest_shape(model, solver->read().position);
        const std::string how = verdict(rest, distance);
        returned += how == "returned";
        if (how != "returned") others += std::string(others.empty() ? "" : "; ") + failure.name + ": " + how;
        file.row({method.name, backend, solver->device(), failure.name, field(share), how, field(distance),
                  std::to_string(rest.report.steps), rest.message()});
      }
      std::printf("%-24s %-10s %2d of %zu; %s\n", method.name.c_str(), backend.c_str(), returned, states.size(),
                  others.c_str());
      std::fflush(stdout);
    }
  }
}

void write_rates(const std::string& path, int most_particles) {
  CsvFile file(path, {"reaction", "body", "particles", "predicted", "measured", "frequency", "highest"});
  for (const auto& [name, reaction] : {std::pair{"full", Reaction::full}, std::pair{"shared", Reaction::shared},
                                       std::pair{"barycentric", Reaction::barycentric}}) {
    for (const Body& body : bodies()) {
      if (body.model.particle_count() > most_particles) continue;
      TopologyOptions options;
      options.reaction = reaction;
      options.on_sparse = SparseParticle::springs;
      const GrowthRate rate =
          growth_rate(body.model, std::make_shared<const TopologyTextures>(build_topology(body.model, options)));
      file.row({name, body.name, std::to_string(body.model.particle_count()), field(rate.predicted),
                field(rate.measured), field(rate.frequency), field(rate.highest)});
      std::printf("%-12s %-12s grows by %.3e omega_max, measured over predicted %.4f, swings at %.3f omega_max\n", name,
                  body.name.c_str(), rate.predicted / rate.highest, rate.measured / rate.predicted,
                  rate.frequency / rate.highest);
      std::fflush(stdout);
    }
  }
}

}  // namespace

int main(int argc, char** argv) try {
  const KnownArguments known{{"limits", ""},
                             {"recovery", ""},
                             {"rates", ""},
                             {"backends", "cpu"},
                             {"cells", "4"},
                             {"factors", "1,0.99,0.9,0.5,0"},
                             {"ratios", "1,1e1,1e2,1e3,1e4,1e6"},
                             {"valences", "6,14,18,26"},
                             {"steps", "12000"},
                             {"step-share", "0.5"},
                             {"most-particles", "300"}};
  if (prints_usage(argc, argv, "stability_atlas",
                   "Where methods stop being stable. limits, recovery, rates: CSV files to write, those that are\n"
                   "given. cells: along a cube's side; steps, step-share (of the limit): of a recovery;\n"
                   "most-particles: of bodies whose growth is measured.",
                   known)) {
    return 0;
  }
  const Arguments arguments(argc, argv, known);
  const int cells = static_cast<int>(arguments.number("cells"));
  if (!arguments.text("rates").empty()) {
    write_rates(arguments.text("rates"), static_cast<int>(arguments.number("most-particles")));
  }
  if (!arguments.text("limits").empty()) {
    Limits limits(arguments.text("limits"), arguments);
    for (const Method& method : stability_methods()) limits.all(method);
  }
  if (!arguments.text("recovery").empty()) {
    write_recovery(arguments.text("recovery"), arguments.list("backends"), cells,
                   static_cast<int>(arguments.number("steps")), arguments.number("step-share"));
  }
} catch (const phymul::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
