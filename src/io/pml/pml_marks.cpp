// SPDX-License-Identifier: MIT
#include "pml_marks.h"

#include <limits>

#include "base/decimal.h"

namespace phymul {

std::optional<PmlMarks> parse_pml_marks(std::string_view text) {
  PmlMarks marks;
  for (text = trim(text); !text.empty(); text = trim(text)) {
    const std::string_view word = text.substr(0, text.find(' '));
    text.remove_prefix(word.size());
    if (word == "unnumbered") {
      marks.unnumbered = true;
    } else if (word == "wrapper") {
      marks.wrapper = true;
    } else if (word == "loose") {
      marks.loose = true;
    } else if (word == "unlisted") {
      marks.unlisted = true;
    } else if (word == "unweighed") {
      marks.unweighed = true;
    } else if (word.starts_with("row=")) {
      const std::optional<std::int64_t> row = parse_integer(word.substr(4));
      if (!row || *row < 0 || *row > std::numeric_limits<Index>::max()) return std::nullopt;
      marks.row = static_cast<Index>(*row);
    } else if (word.starts_with("share=")) {
      marks.share = parse_decimal(word.substr(6));
      if (!marks.share || !(*marks.share >= 0.0 && *marks.share <= 1.0)) return std::nullopt;
    } else if (word.starts_with("cut=")) {
      std::vector<double>& cut = marks.cuts.emplace_back();
      std::string_view left = word.substr(4);
      while (true) {
        const std::size_t end = left.find(',');
        const std::optional<double> value = parse_decimal(left.substr(0, end));
        if (!value) return std::nullopt;
        cut.push_back(*value);
        if (end == std::string_view::npos) break;
        left.remove_prefix(end + 1);
      }
    } else {
      return std::nullopt;
    }
  }
  return marks;
}

}  // namespace phymul
