// SPDX-License-Identifier: MIT
#include "decimal.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <system_error>

namespace phymul {
namespace {

/// Trimmed and without a leading plus (which from_chars refuses); "+-1" stays wrong.
std::string_view number_text(std::string_view text) {
  text = trim(text);
  if (text.size() > 1 && text[0] == '+' && text[1] != '-' && text[1] != '+') text.remove_prefix(1);
  return text;
}

template <class Number>
std::optional<Number> parse_whole(std::string_view text) {
  Number value{};
  const char* const end = text.data() + text.size();
  const auto [rest, problem] = number_from_chars(text.data(), end, value);
  if (problem == std::errc::result_out_of_range && rest == end && underflows(text)) return Number{};
  if (problem != std::errc{} || rest != end) return std::nullopt;
  return value;
}

}  // namespace

std::string_view trim(std::string_view text) {
  constexpr std::string_view blanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

bool underflows(std::string_view number) {
  const std::size_t mark = std::min(number.find_first_of("eE"), number.size());
  const std::string_view mantissa = number.substr(0, mark), power = number.substr(std::min(mark + 1, number.size()));
  const std::optional<std::int64_t> exponent = parse_integer(power);
  if (!exponent && !power.empty()) return power.starts_with('-');
  const std::size_t point = std::min(mantissa.find('.'), mantissa.size());
  const std::size_t first = std::min(mantissa.find_first_of("123456789"), mantissa.size());
  return exponent.value_or(0) < static_cast<std::int64_t>(first) - static_cast<std::int64_t>(point);
}

std::optional<double> parse_decimal(std::string_view text) {
  const std::optional<double> value = parse_whole<double>(number_text(text));
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<std::int64_t> parse_integer(std::string_view text) {
  return parse_whole<std::int64_t>(number_text(text));
}

void append_decimal(std::string& out, double value) {
  std::array<char, 32> text;
  const auto result = std::to_chars(text.data(), text.data() + text.size(), value);
  out.append(text.data(), result.ptr);
}

std::string to_decimal(double value) {
  std::string text;
  append_decimal(text, value);
  return text;
}

DecimalUnit::DecimalUnit(double factor) : factor_(factor) {
  for (int exponent = -30; exponent <= 30; ++exponent) {
    if (parse_decimal("1e" + std::to_string(exponent)) == factor) exponent_ = exponent;
  }
}

std::optional<double> DecimalUnit::parse(std::string_view text) const {
  if (exponent_ && *exponent_ != 0) return parse_shifted(number_text(text));
  const std::optional<double> number = parse_decimal(text);
  if (!number || !std::isfinite(*number * factor_)) return std::nullopt;
  return *number * factor_;
}

std::optional<double> DecimalUnit::parse_shifted(std::string_view text) const {
  const std::size_t mark = text.find_first_of("eE");
  std::int64_t exponent = *exponent_;
  if (mark != std::string_view::npos) {
    const std::string_view digits = text.substr(mark + 1);
    const std::optional<std::int64_t> own = parse_integer(digits);
    // Blanks inside a number are an error; parse_integer alone would pass them. Exponents beyond `largest` belong to no
    // double; not by std::abs, which the least integer defeats.
    constexpr std::int64_t largest = 1'000'000;
    if (!own || trim(digits) != digits || *own < -largest || *own > largest) return std::nullopt;
    exponent += *own;
  }
  const std::string_view mantissa = text.substr(0, mark);
  std::array<char, 96> buffer;
  constexpr std::size_t exponent_room = 16;
  if (mantissa.size() + exponent_room > buffer.size()) {
    return parse_decimal(std::string(mantissa) + 'e' + std::to_string(exponent));
  }
  mantissa.copy(buffer.data(), mantissa.size());
  buffer[mantissa.size()] = 'e';
  char* const digits = buffer.data() + mantissa.size() + 1;
  const char* const end = std::to_chars(digits, buffer.data() + buffer.size(), exponent).ptr;
  const std::optional<double> value = parse_whole<double>({buffer.data(), end});
  return value && std::isfinite(*value) ? value : std::nullopt;
}

void DecimalUnit::append(std::string& out, double value) const {
  if (exponent_ && *exponent_ != 0) return append_shifted(out, value);
  // The rounded quotient is the double whose product lies nearest to the value: no other comes back better.
  append_decimal(out, value / factor_);
}

void DecimalUnit::append_shifted(std::string& out, double value) const {
  std::array<char, 40> text;
  const auto result = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::scientific);
  std::string_view all(text.data(), static_cast<std::size_t>(result.ptr - text.data()));
  if (all.front() == '-') {
    out += '-';
    all.remove_prefix(1);
  }
  const std::size_t mark = all.find('e');
  std::string digits(all.substr(0, mark));
  if (digits.size() > 1) digits.erase(1, 1);  // the decimal point
  const int exponent = static_cast<int>(parse_integer(all.substr(mark + 1)).value_or(0)) - *exponent_;
  if (value == 0.0) {
    out += '0';
  } else if (exponent < -5 || exponent > 15) {
    out += digits.substr(0, 1);
    if (digits.size() > 1) out.append(".").append(digits, 1);
    out.append("e").append(std::to_string(exponent));
  } else if (exponent < 0) {
    out.append("0.").append(static_cast<std::size_t>(-exponent - 1), '0').append(digits);
  } else {
    const std::size_t whole = static_cast<std::size_t>(exponent) + 1;
    if (digits.size() < whole) digits.append(whole - digits.size(), '0');
    out.append(digits, 0, whole);
    if (digits.size() > whole) out.append(".").append(digits, whole);
  }
}

}  // namespace phymul
