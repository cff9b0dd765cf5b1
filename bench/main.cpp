// SPDX-License-Identifier: MIT
//
// phymul_bench: Google Benchmark's options hold, and --fail-on-error, which makes a bench that could not run a failure.
#include <benchmark/benchmark.h>
#include <phymul/phymul.h>

#include <string_view>

#include "usage.h"

namespace {

/// Google Benchmark 1.9 has another name for the mark than 1.7.
template <class Run>
bool could_not_run(const Run& run) {
  if constexpr (requires { run.error_occurred; }) {
    return run.error_occurred;
  } else {
    return run.skipped != decltype(run.skipped){};
  }
}

/// What Google Benchmark's own reporter prints, and a memory of errors.
class WatchfulReporter : public benchmark::ConsoleReporter {
 public:
  using benchmark::ConsoleReporter::ConsoleReporter;

  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) failed_ = failed_ || could_not_run(run);
    ConsoleReporter::ReportRuns(runs);
  }
  bool failed() const { return failed_; }

 private:
  bool failed_ = false;
};

/// Takes an option out of the arguments; true when it was there.
bool take_option(int& argc, char** argv, std::string_view option) {
  for (int i = 1; i < argc; ++i) {
    if (option == argv[i]) {
      for (int k = i; k < argc; ++k) argv[k] = argv[k + 1];  // the closing null pointer too
      --argc;
      return true;
    }
  }
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  // Google Benchmark goes on with its own options, and ends the program.
  phymul::bench::prints_usage(argc, argv, "phymul_bench [--fail-on-error: a bench that could not run is a failure]");
  const bool fail_on_error = take_option(argc, argv, "--fail-on-error");
  benchmark::AddCustomContext("phymul", PHYMUL_VERSION);
  benchmark::AddCustomContext("phymul build", PHYMUL_BENCH_BUILD);
  benchmark::AddCustomContext("compiler", __VERSION__);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;

  if (!fail_on_error) {
    benchmark::RunSpecifiedBenchmarks();
    return 0;
  }
  WatchfulReporter reporter;
  const std::size_t count = benchmark::RunSpecifiedBenchmarks(&reporter);
  return count == 0 || reporter.failed() ? 1 : 0;
}
