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
    } else {
      return std::nullopt;
    }
  }
  return marks;
}

}  // namespace phymul
