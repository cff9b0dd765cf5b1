// SPDX-License-Identifier: MIT
//
// "--name value" arguments of the chart programs.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace phymul::bench {

class Arguments {
 public:
  /// `known`: names and what stands where one is not given. Throws Error for an argument that is none of them.
  Arguments(int argc, char** argv, std::map<std::string, std::string> known);

  const std::string& text(const std::string& name) const { return values_.at(name); }
  double number(const std::string& name) const;
  std::vector<std::string> list(const std::string& name) const;  ///< separated by commas; empty: no entry
  std::vector<double> numbers(const std::string& name) const;

 private:
  std::map<std::string, std::string> values_;
};

}  // namespace phymul::bench
