// SPDX-License-Identifier: MIT
#pragma once

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string>
#include <string_view>
#include <system_error>

namespace phymul {

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

}  // namespace phymul
