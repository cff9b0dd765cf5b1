// SPDX-License-Identifier: MIT
#include "byte_source.h"

#include <phymul/error.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <new>
#include <optional>
#include <vector>

#include "decimal.h"
#include "files.h"

namespace phymul {
namespace {

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f' || c == '\v';
}

/// from_chars knows no leading plus sign; some writers print one.
std::string_view without_plus(std::string_view word) {
  return word.size() > 1 && word[0] == '+' && word[1] != '-' ? word.substr(1) : word;
}

}  // namespace

std::size_t size_of(NumberType type) {
  constexpr std::array<std::size_t, 10> sizes{1, 1, 2, 2, 4, 4, 8, 8, 4, 8};  // in the order of NumberType
  return sizes[static_cast<std::size_t>(type)];
}

std::ifstream open_file(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) fail_access(path, "expected a file, got a folder");
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    fail_access(path, "cannot be opened" + (errno != 0 ? std::string(" (") + std::strerror(errno) + ')' : "") +
                          "; check the name and the right to read it");
  }
  return in;
}

std::string read_whole_file(const std::string& path, std::size_t max_bytes) try {
  std::ifstream in = open_file(path);
  std::string text;
  std::error_code ignored;
  const std::uintmax_t expected = std::filesystem::file_size(path, ignored);  // of devices and pipes: none, or 0
  if (!ignored) text.reserve(static_cast<std::size_t>(std::min<std::uintmax_t>(expected, max_bytes)));
  std::vector<char> chunk(1 << 16);
  while (in.read(chunk.data(), static_cast<std::streamsize>(chunk.size())), in.gcount() > 0) {
    const auto got = static_cast<std::size_t>(in.gcount());
    if (got > max_bytes - text.size()) {
      fail_access(path, "expected at most " + std::to_string(max_bytes) +
                            " bytes, got more; raise max_bytes if the file is meant");
    }
    text.append(chunk.data(), got);
  }
  if (in.bad()) fail_access(path, "cannot be read to its end");
  return text;
} catch (const std::bad_alloc&) {
  fail_memory(path);
}

std::string cited(std::string_view text) {
  constexpr std::size_t longest = 40;
  std::string out = "\"";
  for (const char c : text.substr(0, longest)) out += c >= ' ' && c <= '~' ? c : '?';
  if (text.size() > longest) out += "...";
  return out + '"';
}

ByteSource::ByteSource(std::string source, std::string_view bytes, std::size_t first_line)
    : source_(std::move(source)), bytes_(bytes), first_line_(first_line) {}

ByteSource ByteSource::decoded(std::string place, std::string_view bytes, bool swap) {
  ByteSource result(std::move(place), bytes);
  result.use_binary(swap);
  result.decoded_ = true;
  return result;
}

void ByteSource::use_binary(bool swap) {
  binary_ = true;
  swap_ = swap;
}

void ByteSource::seek(std::size_t position) {
  mark_ = position_ = std::min(position, bytes_.size());
}

std::string_view ByteSource::line() {
  mark_ = position_;
  const std::size_t end = std::min(bytes_.find('\n', position_), bytes_.size());
  std::string_view text = bytes_.substr(position_, end - position_);
  position_ = std::min(end + 1, bytes_.size());
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

std::string_view ByteSource::word() {
  while (position_ < bytes_.size() && is_space(bytes_[position_])) ++position_;
  mark_ = position_;
  while (position_ < bytes_.size() && !is_space(bytes_[position_])) ++position_;
  return bytes_.substr(mark_, position_ - mark_);
}

void ByteSource::expect_word(std::string_view expected) {
  const std::string_view got = word();
  if (got == expected) return;
  fail("expected " + cited(expected) + ", got " + (got.empty() ? "the end of the file" : cited(got)) +
       "; the counts before it are wrong or the file is damaged: export it again");
}

void ByteSource::expect_line_end(const char* after) {
  const std::string_view rest = line();
  const std::size_t got = rest.find_first_not_of(" \t");
  if (got == std::string_view::npos) return;
  fail(std::string("expected the end of the line after ") + after + ", got " + cited(rest.substr(got)) +
       "; the counts before it are wrong or the file is damaged: export it again");
}

bool ByteSource::skip_past(std::string_view text) {
  const std::size_t found = bytes_.find(text, position_);
  if (found == std::string_view::npos) return false;
  seek(found + text.size());
  return true;
}

std::string_view ByteSource::number_word(const char* what) {
  const std::string_view text = word();
  if (text.empty()) fail_short(what);
  return text;
}

template <class T>
T ByteSource::take(const char* what) {
  mark_ = position_;
  if (remaining() < sizeof(T)) fail_short(what);
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), bytes_.data() + position_, sizeof(T));
  if (swap_) std::reverse(raw.begin(), raw.end());
  position_ += sizeof(T);
  T value;
  std::memcpy(&value, raw.data(), sizeof(T));
  return value;
}

std::int64_t ByteSource::integer(NumberType type, const char* what) {
  if (binary_) {
    if (type == NumberType::int8) return take<std::int8_t>(what);
    if (type == NumberType::uint8) return take<std::uint8_t>(what);
    if (type == NumberType::int16) return take<std::int16_t>(what);
    if (type == NumberType::uint16) return take<std::uint16_t>(what);
    if (type == NumberType::int32) return take<std::int32_t>(what);
    if (type == NumberType::uint32) return take<std::uint32_t>(what);
    if (type == NumberType::int64) return take<std::int64_t>(what);
    if (type == NumberType::uint64) {
      const auto value = take<std::uint64_t>(what);
      if (value <= static_cast<std::uint64_t>(INT64_MAX)) return static_cast<std::int64_t>(value);
      fail(std::string("expected ") + what + ", got " + std::to_string(value) + "; the file is damaged");
    }
    fail(std::string("expected ") + what + " as whole numbers, got an array of reals");
  }
  const std::string_view text = number_word(what);
  const std::optional<std::int64_t> value = parse_integer(text);
  if (!value) {
    fail(std::string("expected ") + what + " (a whole number), got " + cited(text) +
         "; correct it, or export the file again");
  }
  if (type == NumberType::int32 && *value != static_cast<std::int32_t>(*value)) {
    fail(std::string("expected ") + what + " of 32 bits, got " + std::to_string(*value) + "; the file is damaged");
  }
  return *value;
}

double ByteSource::real(NumberType type, const char* what) {
  double value = 0.0;
  if (binary_) {
    if (type == NumberType::float32) {
      value = static_cast<double>(take<float>(what));
    } else if (type == NumberType::float64) {
      value = take<double>(what);
    } else {
      return static_cast<double>(integer(type, what));
    }
  } else {
    const std::string_view text = number_word(what);
    const std::string_view digits = without_plus(text);
    const auto [end, problem] = number_from_chars(digits.data(), digits.data() + digits.size(), value);
    // Underflow is no mistake of the file's: 1e-400 is zero.
    const bool tiny = problem == std::errc::result_out_of_range && underflows(digits);
    if (tiny) value = 0.0;
    if ((problem != std::errc() && !tiny) || end != digits.data() + digits.size()) {
      fail(std::string("expected ") + what + " (a number with a decimal point), got " + cited(text) +
           "; correct it, or export the file again");
    }
  }
  if (!std::isfinite(value)) {
    fail(std::string("expected ") + what + " that is finite, got " + (std::isnan(value) ? "NaN" : "infinity") +
         "; mend the mesh and export it again");
  }
  return value;
}

Vec3 ByteSource::point(NumberType type) {
  Vec3 place;
  for (int axis = 0; axis < 3; ++axis) place[axis] = real(type, "a coordinate");
  return place;
}

std::size_t ByteSource::count(NumberType type, std::size_t bytes_each, const char* what) {
  const std::int64_t n = integer(type, what);
  if (n < 0)
    fail(std::string("expected ") + what + " of at least 0, got " + std::to_string(n) + "; the file is damaged");
  const std::size_t most = remaining() / std::max<std::size_t>(bytes_each, 1);
  if (static_cast<std::uint64_t>(n) > most) {
    fail(std::string("expected ") + what + " that the " + std::to_string(remaining()) +
         " remaining bytes can hold (at most " + std::to_string(most) + "), got " + std::to_string(n) +
         "; the file is cut off or damaged: export it again");
  }
  return static_cast<std::size_t>(n);
}

void ByteSource::skip_numbers(std::size_t n, NumberType type) {
  if (binary_) {
    mark_ = position_;
    if (n > remaining() / size_of(type)) fail_short("more numbers");
    position_ += n * size_of(type);
    return;
  }
  for (std::size_t i = 0; i < n; ++i) number_word("more numbers");
}

std::size_t ByteSource::line_number() const {
  if (decoded_ || binary_) return 0;
  const auto lines = std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(mark_), '\n');
  return first_line_ + static_cast<std::size_t>(lines);
}

std::string ByteSource::where() const {
  if (decoded_) return source_;
  return binary_ ? source_ + ": byte " + std::to_string(mark_) : source_ + ':' + std::to_string(line_number());
}

void ByteSource::fail(const std::string& problem) const {
  // The source of decoded bytes is a place in a file, which the reader of the file knows.
  throw Error(ErrorCode::file_format, where() + ": " + problem, decoded_ ? std::string() : source_,
              static_cast<int>(line_number()));
}

void ByteSource::fail_short(const char* what) const {
  fail(std::string("expected ") + what + ", got the end of the " + (decoded_ ? "array" : "file") +
       "; it is cut off: export it again");
}

}  // namespace phymul
