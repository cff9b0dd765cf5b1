// SPDX-License-Identifier: MIT
//
// compare [--runs N] [--time real_time|cpu_time] [--fail-above RATIO] A B [arguments of both]: two builds of one bench
// of Google Benchmark, run in turns, so that what else the machine does hurts both alike. Prints, for each benchmark,
// the time of A and the ratio of B's to A's: median, least and greatest over the runs. Below 1: B is faster. With
// --fail-above it ends with 3 where a median is above it and no run was below 1.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "usage.h"

namespace {

struct Options {
  int runs = 5;
  std::string column = "real_time";
  double fail_above = 0.0;  // 0: never
  std::string programs[2];
  std::string arguments;
};

std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

Options read_options(int argc, char** argv) {
  Options options;
  int i = 1;
  for (; i + 1 < argc && std::string(argv[i]).starts_with("--"); i += 2) {
    const std::string name = argv[i], value = argv[i + 1];
    if (name == "--runs") {
      options.runs = std::atoi(value.c_str());
    } else if (name == "--time" && (value == "real_time" || value == "cpu_time")) {
      options.column = value;
    } else if (name == "--fail-above") {
      options.fail_above = std::atof(value.c_str());
    } else {
      throw std::runtime_error("expected --runs N, --time real_time|cpu_time or --fail-above RATIO, got " + name + " " +
                               value);
    }
  }
  if (argc - i < 2 || options.runs < 1) {
    throw std::runtime_error("expected [--runs N >= 1] and the paths of two builds of one bench");
  }
  for (std::string& program : options.programs) program = argv[i++];
  for (; i < argc; ++i) options.arguments += " " + quoted(argv[i]);
  return options;
}

/// Fields of a line of CSV; quotes inside quotes do not come up.
std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  bool in_quotes = false;
  for (const char c : line) {
    if (c == '"') {
      in_quotes = !in_quotes;
    } else if (c == ',' && !in_quotes) {
      fields.emplace_back();
    } else if (c != '\n' && c != '\r') {
      fields.back() += c;
    }
  }
  return fields;
}

std::string output_of(const std::string& command) {
  std::FILE* pipe = popen(command.c_str(), "r");
  if (!pipe) throw std::runtime_error(command + ": could not be started");
  std::string text;
  char buffer[4096];
  while (const std::size_t count = std::fread(buffer, 1, sizeof buffer, pipe)) text.append(buffer, count);
  if (pclose(pipe) != 0) throw std::runtime_error(command + ": failed");
  return text;
}

double seconds_in(const std::string& unit) {
  return unit == "ns" ? 1e-9 : unit == "us" ? 1e-6 : unit == "ms" ? 1e-3 : 1.0;
}

/// Seconds by name, of the rows that are runs and no aggregates.
std::map<std::string, double> times_of(const Options& options, const std::string& program) {
  const std::string command = quoted(program) + options.arguments + " --benchmark_format=csv 2>/dev/null";
  std::istringstream lines(output_of(command));
  std::map<std::string, double> times;
  std::size_t column = 0, unit = 0;
  for (std::string line; std::getline(lines, line);) {
    const std::vector<std::string> fields = fields_of(line);
    if (fields[0] == "name") {
      column = static_cast<std::size_t>(std::ranges::find(fields, options.column) - fields.begin());
      unit = static_cast<std::size_t>(std::ranges::find(fields, "time_unit") - fields.begin());
    } else if (column > 0 && fields.size() > std::max(column, unit) && !fields[column].empty()) {
      times[fields[0]] = std::atof(fields[column].c_str()) * seconds_in(fields[unit]);
    }
  }
  if (times.empty()) throw std::runtime_error(command + ": expected a benchmark at least, got none");
  return times;
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

struct Compared {
  std::vector<double> seconds, ratios;  // of A; of B to A in one run
};

std::map<std::string, Compared> measured(const Options& options) {
  std::map<std::string, Compared> all;
  for (int run = 0; run < options.runs; ++run) {
    std::map<std::string, double> times[2];
    const int first = run % 2;  // who goes first changes, so that neither always finds the machine warmed up
    for (const int which : {first, 1 - first}) times[which] = times_of(options, options.programs[which]);
    for (const auto& [name, seconds] : times[0]) {
      if (!times[1].contains(name)) throw std::runtime_error(options.programs[1] + ": has no benchmark " + name);
      all[name].seconds.push_back(seconds);
      all[name].ratios.push_back(times[1][name] / seconds);
    }
  }
  return all;
}

}  // namespace

int main(int argc, char** argv) try {
  if (phymul::bench::prints_usage(
          argc, argv,
          "compare [--runs N] [--time real_time|cpu_time] [--fail-above RATIO] A B [arguments of both]\n"
          "Runs two builds of one bench of Google Benchmark in turns and prints the ratio of B's times to A's:\n"
          "below 1, B is faster. Ends with 3 where a median is above RATIO and no run was below 1.")) {
    return 0;
  }
  const Options options = read_options(argc, argv);
  std::printf("A: %s\nB: %s\n%d runs of each, in turns; B : A of %s\n\n%-60s %12s %8s %8s %8s\n",
              options.programs[0].c_str(), options.programs[1].c_str(), options.runs, options.column.c_str(), "",
              "A, us", "median", "least", "greatest");
  bool failed = false;
  for (const auto& [name, compared] : measured(options)) {
    const auto [least, greatest] = std::ranges::minmax(compared.ratios);
    const double middle = median(compared.ratios);
    std::printf("%-60s %12.4g %8.3f %8.3f %8.3f\n", name.c_str(), 1e6 * median(compared.seconds), middle, least,
                greatest);
    failed = failed || (options.fail_above > 0.0 && middle > options.fail_above && least > 1.0);
  }
  return failed ? 3 : 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "compare: %s\n", error.what());
  return 1;
}
