// SPDX-License-Identifier: MIT
//
// Arithmetic of case files: numbers, names, + - * / ^, comparisons and && || ! (1 for true), parentheses, and
// sin cos tan asin acos atan2 sqrt exp log abs min max if(condition, a, b), by muParser. `pi` is known.
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace phymul::bench {

using Variables = std::map<std::string, double, std::less<>>;

/// Throws Error, quoting the text, for what is no expression, an unknown name, or a value that is not finite.
double evaluate(std::string_view text, const Variables& variables);

}  // namespace phymul::bench
