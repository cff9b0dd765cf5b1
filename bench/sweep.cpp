// SPDX-License-Identifier: MIT
//
// sweep --out FILE [--sizes a,b] [--variants a,b] [--backends a,b] [--repeats N] [--sample SECONDS] [--cap SECONDS]
// [--quick 1]: how fast bodies of 4 to 16,777,216 particles step, for every model and backend, as CSV. Each body is
// measured in a process of its own, whose memory is given back, and whose end for lack of it is a row and no more. What
// would not fit the memory that is free, or the time a body has (--cap), is left out, and its row says so and why.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>

#include "arguments.h"
#include "csv_row.h"
#include "machine.h"
#include "stopwatch.h"
#include "sweep_measure.h"

namespace {

using namespace phymul;
using namespace phymul::bench;

constexpr double memory_share = 0.85;  // of what is available, that a body may take

const std::vector<std::string> columns{"variant",
                                       "bases",
                                       "particles",
                                       "base_count",
                                       "backend",
                                       "threads",
                                       "device",
                                       "software",
                                       "status",
                                       "repeats",
                                       "s_per_step",
                                       "s_least",
                                       "s_greatest",
                                       "cpu_s_per_step",
                                       "cpu_s_least",
                                       "cpu_s_greatest",
                                       "device_s_per_step",
                                       "particle_steps_per_s",
                                       "bases_per_s",
                                       "multiply_share",
                                       "operation_share",
                                       "load"};

std::vector<std::string> fields_of(const SweepRow& row) {
  // One thread's by processor time: other work on the machine does not count.
  const double n = row.particles, seconds = row.threads == 1 ? row.processor_seconds_a_step : row.seconds_a_step;
  const double rate = n / seconds;
  return {row.variant,
          row.bases,
          std::to_string(row.particles),
          field(row.base_count),
          row.backend,
          std::to_string(row.threads),
          row.device,
          is_software(row.device) ? "yes" : "no",
          row.status,
          std::to_string(row.repeats),
          field(row.seconds_a_step),
          field(row.least),
          field(row.greatest),
          field(row.processor_seconds_a_step),
          field(row.processor_least),
          field(row.processor_greatest),
          field(row.device_seconds_a_step),
          field(rate),
          field(rate / n * row.base_count),
          field(row.multiply_share),
          field(row.operation_share),
          row.load};
}

double available_bytes() {
  std::ifstream info("/proc/meminfo");
  for (std::string name; info >> name;) {
    double kilobytes = 0.0;
    if (name == "MemAvailable:" && info >> kilobytes) return 1024.0 * kilobytes;
    info.ignore(256, '\n');
  }
  return std::numeric_limits<double>::infinity();
}

std::string gigabytes(double bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g GB", 1e-9 * bytes);
  return text;
}

/// What bodies of a variant took, from which those of the next size are foreseen: everything grows with the particles.
struct Experience {
  int particles = 0;
  double bytes = 0.0, seconds = 0.0;           // peak, and wall time, of the process
  std::map<std::string, double> step_seconds;  // by backend
};

class Sweep {
 public:
  Sweep(const Arguments& arguments, SweepLimits limits)
      : limits_(std::move(limits)), csv_(arguments.text("out"), columns) {}

  void run(const SweepVariant& variant, int size) {
    const std::string reason = why_not(variant, size);
    if (!reason.empty()) return leave_out(variant, size, reason);
    const Stopwatch watch;
    int ends[2];
    if (pipe(ends) != 0) throw Error("sweep: no pipe");
    std::fflush(nullptr);
    const pid_t child = fork();
    if (child < 0) throw Error("sweep: no process");
    if (child == 0) measure_in_child(variant, size, ends);
    close(ends[1]);
    read_rows(variant, size, ends[0]);
    int status = 0;
    rusage used{};
    wait4(child, &status, 0, &used);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
      leave_out(variant, size,
                WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM
                    ? "stopped: took longer than it may"
                    : "failed: the process ended early, for lack of memory or by a fault");
    }
    Experience& known = known_[variant.name];
    known.particles = size;
    known.bytes = 1024.0 * static_cast<double>(used.ru_maxrss);
    known.seconds = watch.seconds();
    std::printf("%-20s %9d particles: %6.1f s, %s\n", variant.name.c_str(), size, known.seconds,
                gigabytes(known.bytes).c_str());
    std::fflush(stdout);
  }

 private:
  std::string why_not(const SweepVariant& variant, int size) {
    const auto found = known_.find(variant.name);
    if (found == known_.end()) return {};
    const double times = static_cast<double>(size) / found->second.particles;
    const double bytes = found->second.bytes * times, available = available_bytes();
    if (found->second.particles >= 4096 && bytes > memory_share * available) {
      return "left out: would need about " + gigabytes(bytes) + " of memory, " + gigabytes(available) + " are free";
    }
    // A process of seconds was mostly repeats; a long one was mostly the making of tables.
    const double seconds = (found->second.seconds - 20.0) * times;
    if (found->second.particles >= 4096 && seconds > limits_.seconds_a_body) {
      return "left out: would take about " + std::to_string(static_cast<int>(seconds)) + " s, more than the cap of " +
             std::to_string(static_cast<int>(limits_.seconds_a_body)) + " s";
    }
    return {};
  }

  [[noreturn]] void measure_in_child(const SweepVariant& variant, int size, const int* ends) {
    close(ends[0]);
    alarm(static_cast<unsigned>(2.0 * limits_.seconds_a_body) + 30);
    SweepLimits limits = limits_;
    const Experience& known = known_[variant.name];
    limits.expected = [&](const std::string& backend) {
      const auto found = known.step_seconds.find(backend);
      // Below, a step of a device is its launching, which does not grow.
      const double times = known.particles < 4096 ? 1.0 : static_cast<double>(size) / known.particles;
      return found == known.step_seconds.end() ? 0.0 : found->second * times;
    };
    int code = 0;
    try {
      measure_body(variant, size, limits, [&](const SweepRow& row) {
        std::string line;
        for (const std::string& text : fields_of(row)) line += text + '\t';
        std::ranges::replace(line, '\n', ' ');
        line += '\n';
        if (write(ends[1], line.data(), line.size()) < 0) _exit(1);
      });
    } catch (const std::exception& error) {
      std::fprintf(stderr, "sweep: %s, %d particles: %s\n", variant.name.c_str(), size, error.what());
      code = 1;
    }
    _exit(code);
  }

  void read_rows(const SweepVariant& variant, int size, int end) {
    std::FILE* file = fdopen(end, "r");
    std::string line;
    for (int c = std::fgetc(file); c != EOF; c = std::fgetc(file)) {
      if (c != '\n') {
        line += static_cast<char>(c);
        continue;
      }
      std::vector<std::string> fields;
      std::istringstream in(line);
      for (std::string text; std::getline(in, text, '\t');) fields.push_back(text);
      csv_.row(fields);
      remember(variant, size, fields);
      line.clear();
    }
    std::fclose(file);
  }

  /// The slowest of a backend's rows, which is what its time is foreseen by; one that failed or was left out stays so.
  void remember(const SweepVariant& variant, int size, const std::vector<std::string>& fields) {
    Experience& known = known_[variant.name];
    const std::string& backend = fields[4];
    const double scale = known.particles >= 4096 ? static_cast<double>(size) / known.particles : 1.0;
    if (!fields[10].empty()) {
      known.step_seconds[backend] = std::atof(fields[10].c_str());
    } else {
      known.step_seconds[backend] *= scale;
    }
  }

  void leave_out(const SweepVariant& variant, int size, const std::string& reason) {
    SweepRow row;
    row.variant = variant.name;
    row.bases = variant.bases;
    row.particles = size;
    row.status = reason;
    row.load = load_before();
    csv_.row(fields_of(row));
    std::printf("%-20s %9d particles: %s\n", variant.name.c_str(), size, reason.c_str());
  }

  SweepLimits limits_;
  CsvFile csv_;
  std::map<std::string, Experience> known_;
};

bool wanted(const std::vector<std::string>& list, const std::string& name) {
  return list.empty() || std::ranges::find(list, name) != list.end();
}

void run(const Arguments& arguments) {
  const bool quick = arguments.number("quick") > 0.0;
  SweepLimits limits;
  limits.repeats = static_cast<int>(arguments.number("repeats"));
  limits.sample_seconds = quick ? 0.003 : arguments.number("sample");
  limits.seconds_a_body = arguments.number("cap");
  limits.backends = arguments.list("backends");
  if (limits.backends.empty()) limits.backends = backend_names();
  if (limits.repeats < 5) throw Error("sweep: expected --repeats of 5 or more: a median of fewer says little");
  std::vector<double> sizes = arguments.numbers("sizes");
  if (sizes.empty()) sizes.assign(sweep_sizes().begin(), sweep_sizes().end());
  if (quick) std::erase_if(sizes, [](double size) { return size > 512; });
  Sweep sweep(arguments, limits);
  std::vector<std::string> names;
  for (const SweepVariant& variant : sweep_variants()) names.push_back(variant.name);
  const std::vector<std::string> chosen = arguments.chosen("variants", names);
  for (const SweepVariant& variant : sweep_variants()) {
    if (!wanted(chosen, variant.name)) continue;
    for (const double size : sizes) {
      if (has_body(variant, static_cast<int>(size))) sweep.run(variant, static_cast<int>(size));
    }
  }
}

}  // namespace

int main(int argc, char** argv) try {
  const KnownArguments known{{"out", "sweep.csv"}, {"sizes", ""},      {"variants", ""}, {"backends", ""},
                             {"repeats", "7"},     {"sample", "0.05"}, {"cap", "120"},   {"quick", "0"}};
  if (prints_usage(argc, argv, "sweep",
                   "How fast bodies of 4 to 16,777,216 particles step, for every model and backend. Lists are\n"
                   "separated by commas. sample: seconds of a measurement; cap: seconds for a body; quick 1: at most\n"
                   "512 particles.",
                   known)) {
    return 0;
  }
  run(Arguments(argc, argv, known));
} catch (const phymul::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
