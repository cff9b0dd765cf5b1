// SPDX-License-Identifier: MIT
#include "expression.h"

#include <muParser.h>
#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace phymul::bench {
namespace {

/// Expressions are compiled once: maps of bodies are evaluated at every particle.
struct Compiled {
  mu::Parser parser;
  Variables values;  // which the parser reads

  Compiled(std::string_view text, const Variables& variables) : values(variables) {
    parser.DefineInfixOprt("!", [](double x) { return x == 0.0 ? 1.0 : 0.0; });
    const auto choose = [](double condition, double a, double b) { return condition != 0.0 ? a : b; };
    parser.DefineFun("if", static_cast<double (*)(double, double, double)>(choose));
    parser.ClearConst();
    parser.DefineConst("pi", std::numbers::pi);
    for (auto& [name, value] : values) parser.DefineVar(name, &value);
    parser.SetExpr(std::string(text));
  }
  Compiled(const Compiled&) = delete;
  Compiled& operator=(const Compiled&) = delete;
};

[[noreturn]] void fail(std::string_view text, const std::string& what) {
  throw Error("expression \"" + std::string(text) + "\": " + what);
}

}  // namespace

double evaluate(std::string_view text, const Variables& variables) try {
  thread_local std::map<std::string, Compiled, std::less<>> known;
  constexpr auto name = &Variables::value_type::first;
  auto at = known.find(text);
  if (at != known.end() && !std::ranges::equal(at->second.values, variables, {}, name, name)) {
    known.erase(at);
    at = known.end();
  }
  if (at == known.end()) {
    at = known.try_emplace(std::string(text), text, variables).first;
  } else {
    auto given = variables.begin();
    for (auto& [key, value] : at->second.values) value = (given++)->second;
  }
  const double value = at->second.parser.Eval();
  if (!std::isfinite(value)) fail(text, "the value is not finite");
  return value;
} catch (const mu::Parser::exception_type& error) {
  fail(text, error.GetMsg());
}

}  // namespace phymul::bench
