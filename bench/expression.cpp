// SPDX-License-Identifier: MIT
#include "expression.h"

#include <phymul/error.h>

#include <cctype>
#include <charconv>
#include <cmath>
#include <numbers>
#include <vector>

namespace phymul::bench {
namespace {

/// Recursive descent, evaluated on the way; one function per level of precedence, weakest first.
class Reader {
 public:
  Reader(std::string_view text, const Variables& variables) : text_(text), variables_(variables) {}

  double whole() {
    const double value = disjunction();
    skip_blanks();
    if (at_ < text_.size()) fail("expected an operator");
    if (!std::isfinite(value)) fail("the value is not finite");
    return value;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error("expression \"" + std::string(text_) + "\": " + what + " at column " + std::to_string(at_ + 1));
  }

  void skip_blanks() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
  }

  bool take(std::string_view token) {
    skip_blanks();
    if (text_.substr(at_, token.size()) != token) return false;
    at_ += token.size();
    return true;
  }

  double disjunction() {
    double value = conjunction();
    while (take("||")) {
      const double right = conjunction();
      value = value != 0.0 || right != 0.0;
    }
    return value;
  }

  double conjunction() {
    double value = comparison();
    while (take("&&")) {
      const double right = comparison();
      value = value != 0.0 && right != 0.0;
    }
    return value;
  }

  double comparison() {
    const double left = sum();
    if (take("<=")) return left <= sum();
    if (take(">=")) return left >= sum();
    if (take("==")) return left == sum();
    if (take("!=")) return left != sum();
    if (take("<")) return left < sum();
    if (take(">")) return left > sum();
    return left;
  }

  double sum() {
    double value = product();
    while (true) {
      if (take("+")) {
        value += product();
      } else if (take("-")) {
        value -= product();
      } else {
        return value;
      }
    }
  }

  double product() {
    double value = sign();
    while (true) {
      if (take("*")) {
        value *= sign();
      } else if (take("/")) {
        value /= sign();
      } else {
        return value;
      }
    }
  }

  double sign() {
    if (take("-")) return -sign();
    if (take("+")) return sign();
    skip_blanks();
    if (text_.substr(at_, 2) != "!=" && take("!")) return sign() == 0.0;
    return power();
  }

  double power() {
    const double base = primary();
    return take("^") ? std::pow(base, sign()) : base;
  }

  double primary() {
    skip_blanks();
    if (take("(")) {
      const double value = disjunction();
      if (!take(")")) fail("expected )");
      return value;
    }
    if (at_ < text_.size() && (std::isalpha(static_cast<unsigned char>(text_[at_])) || text_[at_] == '_')) {
      return named();
    }
    double value = 0.0;
    const char* first = text_.data() + at_;
    const auto [end, error] = std::from_chars(first, text_.data() + text_.size(), value);
    if (error != std::errc()) fail("expected a number, a name or (");
    at_ += static_cast<std::size_t>(end - first);
    return value;
  }

  double named() {
    const std::size_t first = at_;
    while (at_ < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[at_])) || text_[at_] == '_')) ++at_;
    const std::string_view name = text_.substr(first, at_ - first);
    if (take("(")) return function(name);
    if (name == "pi") return std::numbers::pi;
    const auto found = variables_.find(name);
    if (found == variables_.end()) {
      std::string known;
      for (const auto& [key, value] : variables_) known += " " + key;
      fail("no name \"" + std::string(name) + "\"; there are: pi" + known);
    }
    return found->second;
  }

  double function(std::string_view name) {
    std::vector<double> a{disjunction()};
    while (take(",")) a.push_back(disjunction());
    if (!take(")")) fail("expected )");
    if (a.size() == 1) {
      if (name == "sin") return std::sin(a[0]);
      if (name == "cos") return std::cos(a[0]);
      if (name == "tan") return std::tan(a[0]);
      if (name == "asin") return std::asin(a[0]);
      if (name == "acos") return std::acos(a[0]);
      if (name == "sqrt") return std::sqrt(a[0]);
      if (name == "exp") return std::exp(a[0]);
      if (name == "log") return std::log(a[0]);
      if (name == "abs") return std::abs(a[0]);
    } else if (a.size() == 2) {
      if (name == "atan2") return std::atan2(a[0], a[1]);
      if (name == "min") return std::min(a[0], a[1]);
      if (name == "max") return std::max(a[0], a[1]);
    } else if (a.size() == 3 && name == "if") {
      return a[0] != 0.0 ? a[1] : a[2];
    }
    fail("no function \"" + std::string(name) + "\" of " + std::to_string(a.size()) + " arguments");
  }

  std::string_view text_;
  const Variables& variables_;
  std::size_t at_ = 0;
};

}  // namespace

double evaluate(std::string_view text, const Variables& variables) {
  return Reader(text, variables).whole();
}

}  // namespace phymul::bench
