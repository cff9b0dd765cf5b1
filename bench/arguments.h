// SPDX-License-Identifier: MIT
//
// "--name value" arguments of the chart programs.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace phymul::bench {

/// Names of a program's arguments, and what stands where one is not given.
using KnownArguments = std::map<std::string, std::string>;

/// Where an argument asks for help, prints how to call `program`, `about` and the names, and says true.
bool prints_usage(int argc, char** argv, const std::string& program, const std::string& about,
                  const KnownArguments& known);

class Arguments {
 public:
  /// Throws Error for an argument that is none of the known ones.
  Arguments(int argc, char** argv, KnownArguments known);

  const std::string& text(const std::string& name) const { return values_.at(name); }
  double number(const std::string& name) const;
  std::vector<std::string> list(const std::string& name) const;  ///< separated by commas; empty: no entry
  /// list() of some of these. Throws Error for another entry.
  std::vector<std::string> chosen(const std::string& name, const std::vector<std::string>& of) const;
  std::vector<double> numbers(const std::string& name) const;

 private:
  KnownArguments values_;
};

}  // namespace phymul::bench
