// SPDX-License-Identifier: MIT
//
// Holds phymul against measurements, published values and closed forms: the figures of docs/measurements/truth.md.
#include <cstdio>

#include "arguments.h"
#include "truth_table.h"

int main(int argc, char** argv) try {
  using namespace phymul::bench;
  const KnownArguments known{{"cases", ""}, {"measured", "bench/reference/measured.csv"}, {"out", "."}, {"quick", "0"}};
  if (prints_usage(
          argc, argv, "truth",
          "Holds phymul against measurements, published values and closed forms. cases: separated by commas, all\n"
          "unless given. quick 1: the coarsest body of each. out: folder for truth.csv and truth_curves.csv.",
          known)) {
    return 0;
  }
  const Arguments arguments(argc, argv, known);
  TruthTable table(arguments.text("measured"), arguments.text("out"));
  std::map<std::string, TruthCase> cases = static_cases();
  cases.insert(solid_cases().begin(), solid_cases().end());
  cases.insert(motion_cases().begin(), motion_cases().end());
  std::vector<std::string> wanted = arguments.list("cases");
  if (wanted.empty()) {
    for (const auto& it : cases) wanted.push_back(it.first);
  }
  for (const std::string& name : wanted) {
    const auto found = cases.find(name);
    if (found == cases.end()) throw phymul::Error("truth: no case is named " + name);
    found->second(table, arguments.number("quick") > 0.0);
  }
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
