// SPDX-License-Identifier: MIT
//
// Reading words and numbers out of an untrusted file held in memory, text or binary, with the place in every error.
#pragma once

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>

#include <phymul/types.h>

namespace phymul {

enum class NumberType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

/// Bytes of one number of that type in a binary file.
std::size_t size_of(NumberType type);

/// For reading bytes. Throws Error, with the system's reason, for a folder and what cannot be opened.
std::ifstream open_file(const std::string& path);

/// Also of a pipe or a device. Throws Error when it cannot be read or has more than max_bytes.
std::string read_whole_file(const std::string& path, std::size_t max_bytes);

/// `"..."` with what could upset a terminal or is overlong taken out: for citing file contents in messages.
std::string cited(std::string_view text);

/// A cursor over bytes that it does not own. Numbers come as white-space separated words or as binary, by mode; the
/// same parser then serves both kinds of file. Nothing is read past the end: a short file is an Error.
class ByteSource {
 public:
  /// `source` is the file name; `first_line` the line of the file where the bytes begin.
  ByteSource(std::string source, std::string_view bytes, std::size_t first_line = 1);

  /// For bytes that were decoded from somewhere else: errors name that place instead of a line or byte.
  static ByteSource decoded(std::string place, std::string_view bytes, bool swap);

  void use_text() { binary_ = false; }
  void use_binary(bool swap);  ///< swap: the file's byte order is not this machine's
  bool is_binary() const { return binary_; }

  std::size_t position() const { return position_; }
  void seek(std::size_t position);
  std::size_t remaining() const { return bytes_.size() - position_; }

  std::string_view line();  ///< up to the next end of line, which is passed over; without trailing white space
  std::string_view word();  ///< the next white-space separated word; empty at the end
  void expect_word(std::string_view expected);
  void expect_line_end(const char* after);  ///< of text: only white space comes before it
  bool skip_past(std::string_view text);  ///< to right after its next occurrence; false (and unmoved) if there is none

  /// The next number; `what` says in a message what it should be ("a node tag").
  std::int64_t integer(NumberType type, const char* what);
  double real(NumberType type, const char* what);  ///< refuses infinities and NaN
  Vec3 point(NumberType type);                     ///< three coordinates

  /// The next number as a count of things of at least `bytes_each` bytes: an Error when the rest of the file is too
  /// short for them, so that a damaged count allocates nothing.
  std::size_t count(NumberType type, std::size_t bytes_each, const char* what);

  /// Least bytes of a number here: its size in binary, a digit and a separator in text.
  std::size_t least_bytes(NumberType type) const { return binary_ ? size_of(type) : 2; }

  /// Skips `n` numbers. Throws when the file ends before.
  void skip_numbers(std::size_t n, NumberType type);

  std::size_t line_number() const;  ///< of what was read last; 0 in binary and decoded bytes
  std::string where() const;        ///< "file:line" or "file: byte N" of what was read last
  [[noreturn]] void fail(const std::string& problem) const;

 private:
  template <class T>
  T take(const char* what);
  std::string_view number_word(const char* what);
  [[noreturn]] void fail_short(const char* what) const;

  std::string source_;
  std::string_view bytes_;
  std::size_t position_ = 0;
  std::size_t mark_ = 0;  // where the word or number read last begins
  std::size_t first_line_ = 1;
  bool binary_ = false;
  bool swap_ = false;
  bool decoded_ = false;
};

}  // namespace phymul
