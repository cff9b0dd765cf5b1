// SPDX-License-Identifier: MIT
//
// Decimal numbers in text, the same in every locale: strict parsing, shortest writing, and change of unit by powers of
// ten without rounding twice.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

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

}  // namespace phymul
