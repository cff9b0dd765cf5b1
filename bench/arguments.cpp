// SPDX-License-Identifier: MIT
#include "arguments.h"

#include <phymul/error.h>

#include <algorithm>
#include <sstream>

#include "expression.h"
#include "usage.h"

namespace phymul::bench {

bool prints_usage(int argc, char** argv, const std::string& program, const std::string& about,
                  const KnownArguments& known) {
  std::string usage = program + " [--name value] ...\n" + about + "\nNames, and what holds where one is not given:\n";
  for (const auto& [name, value] : known) usage += "  --" + name + (value.empty() ? "" : ' ' + value) + '\n';
  usage.pop_back();  // puts() ends the line
  return prints_usage(argc, argv, usage.c_str());
}

Arguments::Arguments(int argc, char** argv, KnownArguments known) : values_(std::move(known)) {
  std::string names;
  for (const auto& [name, value] : values_) names += " --" + name + " (" + value + ")";
  for (int k = 1; k < argc; k += 2) {
    const std::string name = std::string(argv[k]).rfind("--", 0) == 0 ? argv[k] + 2 : "";
    if (!values_.contains(name) || k + 1 == argc) {
      throw Error("expected pairs of a name and a value, got \"" + std::string(argv[k]) + "\"; known:" + names);
    }
    values_[name] = argv[k + 1];
  }
}

double Arguments::number(const std::string& name) const {
  return evaluate(text(name), {});
}

std::vector<std::string> Arguments::list(const std::string& name) const {
  std::istringstream in(text(name));
  std::vector<std::string> entries;
  for (std::string entry; std::getline(in, entry, ',');) entries.push_back(entry);
  return entries;
}

std::vector<std::string> Arguments::chosen(const std::string& name, const std::vector<std::string>& of) const {
  std::vector<std::string> entries = list(name);
  for (const std::string& entry : entries) {
    if (std::ranges::find(of, entry) != of.end()) continue;
    std::string text = "--" + name + ": expected";
    for (const std::string& known : of) text += ' ' + known;
    throw Error(text + ", got \"" + entry + '"');
  }
  return entries;
}

std::vector<double> Arguments::numbers(const std::string& name) const {
  std::vector<double> values;
  for (const std::string& entry : list(name)) values.push_back(evaluate(entry, {}));
  return values;
}

}  // namespace phymul::bench
