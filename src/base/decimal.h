// SPDX-License-Identifier: MIT
//
// Decimal numbers in text, the same in every locale: strict parsing, shortest writing, and change of unit by powers of
// ten without rounding twice.
#pragma once

#include <phymul/types.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace phymul {

/// Without blanks, tabs and line ends on both sides.
std::string_view trim(std::string_view text);

/// The number that the whole of the text spells; blanks around it and a leading plus are allowed. None where anything
/// is left over, or where it is not finite or beyond the range of the type; too small for a double: 0.
std::optional<double> parse_decimal(std::string_view text);
std::optional<std::int64_t> parse_integer(std::string_view text);

/// Whether a number that is out of the range of doubles, as spelt there, is too small for them: it is 0 then.
bool underflows(std::string_view number);

/// Appends the shortest text that parse_decimal reads back as the same number.
void append_decimal(std::string& out, double value);
std::string to_decimal(double value);

/// A unit of a file: SI value = number in the file * factor. Where the factor is a power of ten the exponent of the
/// text is shifted instead, so that 12.5 mm is the double next to 0.0125 and every double can be written exactly (a
/// product of doubles misses some).
class DecimalUnit {
 public:
  explicit DecimalUnit(double factor);

  /// SI value of a number in the file; none as for parse_decimal.
  std::optional<double> parse(std::string_view text) const;

  /// Appends the number of a SI value. Read back equal for powers of ten, else within two units in the last place.
  void append(std::string& out, double value) const;

 private:
  std::optional<double> parse_shifted(std::string_view text) const;
  void append_shifted(std::string& out, double value) const;

  double factor_;
  std::optional<int> exponent_;  // factor_ = 10^exponent_
};

/// std::from_chars, also where the standard library has it for integers alone (libc++ before version 20).
template <class Number>
std::from_chars_result number_from_chars(const char* begin, const char* end, Number& value) {
  if constexpr (requires { std::from_chars(begin, end, value); }) {
    return std::from_chars(begin, end, value);
  } else {
    // What strtod would take and from_chars does not: leading blanks, a plus sign, hexadecimal digits.
    const std::size_t sign = begin != end && *begin == '-';
    const std::string_view digits(begin + sign, static_cast<std::size_t>(end - begin) - sign);
    if (digits.empty() || std::string_view("0123456789.iInN").find(digits[0]) == std::string_view::npos) {
      return {begin, std::errc::invalid_argument};
    }
    if (digits.size() > 1 && digits[0] == '0' && (digits[1] == 'x' || digits[1] == 'X')) {
      value = sign ? -0.0 : 0.0;
      return {begin + sign + 1, std::errc{}};
    }
    const std::string text(begin, end);
    char* rest = nullptr;
    errno = 0;
    const double read = std::strtod(text.c_str(), &rest);
    const char* const after = begin + (rest - text.c_str());
    if (after == begin) return {begin, std::errc::invalid_argument};
    if (errno == ERANGE && (read == 0.0 || std::isinf(read))) return {after, std::errc::result_out_of_range};
    value = read;
    return {after, std::errc{}};
  }
}

/// Six digits at most.
inline std::string length_text(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", x);
  return text;
}

/// "(0.01, 0.02, 0.03) m".
inline std::string place_text(const Vec3& x) {
  char text[96];
  std::snprintf(text, sizeof text, "(%.6g, %.6g, %.6g) m", x.x(), x.y(), x.z());
  return text;
}

}  // namespace phymul
