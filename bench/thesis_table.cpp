// SPDX-License-Identifier: MIT
//
// thesis_table [--seconds S] [--backends a,b] [--largest N] [--csv FILE]: time of 1 to 5890 steps for every backend of
// this build and bodies of 4 to 262,144 particles, as table 3.1 of the 2007 thesis has it for one body. Markdown goes
// to the standard output. A row is cut where S seconds (default 10) would not do for it.
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <sstream>

#include "machine.h"
#include "stopwatch.h"
#include "usage.h"

namespace {

constexpr int step_counts[] = {1, 10, 100, 1000, 5890};
constexpr double spacing = 0.0025;  // m, of the lattices
constexpr double stretch = 1.05;    // of the start along z: a body at rest would have nothing to compute but zeros
constexpr double step_share = 0.2;  // of the stable step at rest
constexpr double damping = 0.99;
constexpr int repeats = 5;

/// What is computed: the thesis' own model in its stable form, and what a body without a material takes by default.
struct Law {
  const char* name;
  phymul::TopologyOptions options;
};
const Law laws[] = {
    {"near the thesis: reaction shared, bases above the threshold", {.reaction = phymul::Reaction::shared}},
    {"default: reaction conservative, bases above the threshold", {}},
};

struct Options {
  double seconds = 10.0;  // for a row
  std::vector<std::string> backends = phymul::backend_names();
  int largest = 262144;
  std::string csv;
};

struct Body {
  std::string name;
  int side = 0;  // particles along a side of a lattice; 0: none
};
const Body bodies[] = {
    {"tetrahedron", 0}, {"cylinder", 0}, {"lattice 16^3", 16}, {"lattice 32^3", 32}, {"lattice 64^3", 64}};

phymul::Model lattice(int side) {
  const double length = (side - 1) * spacing;
  return phymul::make_block({length, length, length}, side - 1, side - 1, side - 1, 6);
}

phymul::Model model_of(const Body& body) {
  if (body.side > 0) return lattice(body.side);
  return body.name == "tetrahedron" ? phymul::make_tetrahedron(0.01) : phymul::make_cylinder(0.010, 0.040, 3, 8, 11);
}

using Tables = std::shared_ptr<const phymul::TopologyTextures>;

/// One estimate for all lattices, from the 10^3 one, which takes seconds where the largest would take many minutes. The
/// largest eigenvalues of 10^3, 16^3 and 24^3 lie within 0.6 % of each other, and steps are a fifth of the limit.
phymul::Spectrum spectrum_of(const Body& body, const Tables& tables, const Law& law) {
  if (body.side == 0) return estimate_spectrum(*tables, tables->rest);
  const phymul::TopologyTextures small = build_topology(lattice(10), law.options);
  return estimate_spectrum(small, small.rest);
}

struct Cell {
  std::optional<double> seconds;  // none: not run
  double predicted = 0.0;         // s
  int repeats = 0;
};

struct Row {
  std::string backend, device;
  double first_call = 0.0;  // s: making the solver, and its first step
  std::vector<Cell> cells;  // for each of step_counts
};

class Runner {
 public:
  Runner(const Options& options, const std::string& backend, const Tables& tables, const phymul::Scene& scene,
         const phymul::Spectrum& spectrum)
      : options_(options), start_(phymul::rest_state(scene.model())) {
    for (phymul::Vec3& x : start_.position) x.z() *= stretch;
    phymul::SolverOptions solver_options;
    solver_options.damping.factor = damping;
    solver_options.spectrum = spectrum;
    const Stopwatch watch;
    solver_ = phymul::make_solver(backend, tables, scene, solver_options);
    dt_ = step_share * solver_->stable_step();
    time_of(1);
    row_ = {backend, solver_->device(), watch.seconds(), {}};
  }

  Row run() {
    double per_step = time_of(1);
    double left = options_.seconds;
    for (const int count : step_counts) {
      Cell cell;
      cell.predicted = per_step * count;
      if (cell.predicted <= left) {
        std::vector<double> times;
        do {
          times.push_back(time_of(count));
          left -= times.back();
        } while (static_cast<int>(times.size()) < repeats && times.back() <= 0.2 * left);
        std::sort(times.begin(), times.end());
        cell.seconds = times[times.size() / 2];
        cell.repeats = static_cast<int>(times.size());
        per_step = *cell.seconds / count;
      }
      row_.cells.push_back(cell);
    }
    return row_;
  }

 private:
  /// Steps and the positions read back once, as otherwise a device might not have begun yet.
  double time_of(int count) {
    solver_->reset(start_);
    solver_->read(end_);
    const Stopwatch watch;
    const phymul::StepReport report = solver_->step(count, dt_);
    solver_->read(end_);
    const double seconds = watch.seconds();
    if (!report.ok()) throw phymul::Error("thesis_table: " + report.message());
    return seconds;
  }

  const Options& options_;
  phymul::State start_, end_;
  std::unique_ptr<phymul::Solver> solver_;
  double dt_ = 0.0;
  Row row_;
};

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, value < 0.0995 ? "%.2g" : "%.3g", value);
  return text;
}

/// Milliseconds in a table's cell.
std::string text_of(const Cell& cell) {
  if (cell.seconds) return number(1e3 * *cell.seconds);
  return "not run: would take about " + number(cell.predicted) + " s";
}

void print_row(const phymul::TopologyTextures& tables, const Row& row) {
  std::printf("| %d | %d | %s%s | %s |", tables.particle_count, tables.base_count, row.backend.c_str(),
              is_software(row.device) ? " (software)" : "", number(1e3 * row.first_call).c_str());
  double per_step = 0.0;
  for (std::size_t k = 0; k < row.cells.size(); ++k) {
    std::printf(" %s |", text_of(row.cells[k]).c_str());
    if (row.cells[k].seconds) per_step = *row.cells[k].seconds / step_counts[k];
  }
  std::printf(" %s |\n", number(1e6 * per_step).c_str());
  std::fflush(stdout);
}

void write_csv_rows(std::ofstream& csv, const Law& law, const Body& body, const phymul::TopologyTextures& tables,
                    const Row& row) {
  for (std::size_t k = 0; k < row.cells.size(); ++k) {
    const Cell& cell = row.cells[k];
    csv << '"' << law.name << "\",\"" << body.name << "\"," << tables.particle_count << ',' << tables.base_count << ','
        << row.backend << ",\"" << row.device << "\"," << (is_software(row.device) ? "yes" : "no") << ','
        << row.first_call << ',' << step_counts[k] << ',';
    if (cell.seconds) csv << *cell.seconds << ',' << 1e6 * *cell.seconds / step_counts[k];
    if (!cell.seconds) csv << ',';
    csv << ',' << cell.repeats << ',' << (cell.seconds ? "" : std::to_string(cell.predicted)) << '\n';
  }
}

void print_head(const Law& law) {
  std::printf("\n## %s\n\n| particles | bases | backend | first call, ms |", law.name);
  for (const int count : step_counts) std::printf(" %d step%s, ms |", count, count == 1 ? "" : "s");
  std::printf(" us a step |\n|--:|--:|:--|--:|");
  for (std::size_t k = 0; k < std::size(step_counts); ++k) std::printf("--:|");
  std::printf("--:|\n");
}

void run_body(const Options& options, const Law& law, const Body& body, std::ofstream& csv) {
  const phymul::Model model = model_of(body);
  if (model.particle_count() > options.largest) return;
  const phymul::Scene scene(model);
  const Tables tables = std::make_shared<const phymul::TopologyTextures>(build_topology(model, law.options));
  const phymul::Spectrum spectrum = spectrum_of(body, tables, law);
  for (const std::string& backend : options.backends) {
    std::string reason = phymul::why_unavailable(backend);
    try {
      if (reason.empty()) {
        const Row row = Runner(options, backend, tables, scene, spectrum).run();
        print_row(*tables, row);
        if (csv.is_open()) write_csv_rows(csv, law, body, *tables, row);
        continue;
      }
    } catch (const phymul::Error& error) {  // a body that is too large for the device
      reason = error.what();
    }
    std::printf("| %d | %d | %s | not run: %s |\n", tables->particle_count, tables->base_count, backend.c_str(),
                reason.c_str());
  }
  if (body.name == "cylinder") {
    std::printf("| 275 | | thesis 2007, GPU | | | | | | | 314 |\n| 275 | | thesis 2007, CPU | | | | | | | 270 |\n");
  }
}

void print_machine(const Options& options) {
  std::printf("# Steps by backend and size\n\n");
  for (const auto& [what, value] : machine_facts()) std::printf("- %s: %s\n", what.c_str(), value.c_str());
  const phymul::Model model = phymul::make_tetrahedron(0.01);
  const phymul::Scene scene(model);
  for (const std::string& backend : options.backends) {
    const std::string reason = phymul::why_unavailable(backend);
    const std::string device = reason.empty() ? phymul::make_solver(backend, model, scene)->device() : reason;
    std::printf("- backend %s: %s%s\n", backend.c_str(), device.c_str(),
                is_software(device) ? " (software: no GPU's figure)" : "");
  }
  std::printf(
      "\nEach time is that of one call of `step`, and of reading the positions once at its end, median of up to %d;\n"
      "the body starts stretched by %.0f %%, free, no loads, damping d = %.2f, a step of %.1f of the limit (of\n"
      "lattices: that of the 10^3 one). The first call makes the solver (tables uploaded, shaders compiled) and\n"
      "takes its first step; the tables themselves and the stable step are made before, once for all backends.\n"
      "Microseconds a step are those of the longest run. A row has %.0f s.\n\n"
      "The thesis' own figures, from its table 3.1, are those of 275 particles in 2007.\n",
      repeats, 100.0 * (stretch - 1.0), damping, step_share, options.seconds);
}

Options read_options(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; i += 2) {
    const std::string name = argv[i];
    if (i + 1 >= argc) throw phymul::Error("thesis_table: expected a value after " + name);
    const std::string value = argv[i + 1];
    if (name == "--seconds") {
      options.seconds = std::atof(value.c_str());
    } else if (name == "--largest") {
      options.largest = std::atoi(value.c_str());
    } else if (name == "--csv") {
      options.csv = value;
    } else if (name == "--backends") {
      options.backends.clear();
      std::istringstream list(value);
      for (std::string backend; std::getline(list, backend, ',');) options.backends.push_back(backend);
    } else {
      throw phymul::Error("thesis_table: expected --seconds, --backends, --largest or --csv, got " + name);
    }
  }
  return options;
}

}  // namespace

int main(int argc, char** argv) try {
  if (phymul::bench::prints_usage(
          argc, argv,
          "thesis_table [--seconds of a row] [--backends a,b,...] [--largest number of particles] [--csv file]\n"
          "Times of 1 to 5890 steps for every backend and bodies of 4 to 262,144 particles, as the thesis of 2007 has "
          "them.")) {
    return 0;
  }
  const Options options = read_options(argc, argv);
  std::ofstream csv;
  if (!options.csv.empty()) {
    csv.open(options.csv);
    csv << "law,body,particles,bases,backend,device,software,first_call_s,steps,seconds,us_per_step,repeats,"
           "predicted_s_where_not_run\n";
  }
  print_machine(options);
  for (const Law& law : laws) {
    print_head(law);
    for (const Body& body : bodies) run_body(options, law, body, csv);
  }
  if (csv.is_open() && !csv.flush()) throw phymul::Error(options.csv + ": could not be written");
} catch (const phymul::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
