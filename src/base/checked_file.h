// SPDX-License-Identifier: MIT
//
// Binary files that a damaged byte does not get through: a magic word of eight letters, the version (u32), then
// sections of a tag of four letters (u32), the payload's bytes (u64), the payload, and the CRC-32 of all that from the
// tag on (u32); the last section is "end ", empty. Little-endian.
#pragma once

#include <phymul/types.h>

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace phymul {

/// Puts numbers one after another.
class ByteWriter {
 public:
  void u8(std::uint8_t value) { bytes_.push_back(static_cast<char>(value)); }
  void u32(std::uint32_t value) { put(value, 4); }
  void u64(std::uint64_t value) { put(value, 8); }
  void index(Index value) { u32(static_cast<std::uint32_t>(value)); }
  void real(double value);  ///< its bits
  void vector(const Vec3& v);
  void vectors(const VecList& list);             ///< without a count
  void text(std::string_view text);              ///< u32 length, bytes
  void indices(const std::vector<Index>& list);  ///< u64 count, values
  void raw(std::string_view bytes) { bytes_.append(bytes); }
  const std::string& bytes() const { return bytes_; }

  // What ByteReader has under the same names: one function then says what a thing is made of, for writing and reading.
  void field(bool value, const char*) { u8(value ? 1 : 0); }
  void field(Index value, const char*) { index(value); }
  void field(std::uint64_t value, const char*) { u64(value); }
  void field(double value, const char*) { real(value); }
  void field(const Vec3& value, const char*) { vector(value); }
  void field(const std::string& value, const char*) { text(value); }
  void field(const std::vector<Index>& value, const char*) { indices(value); }
  template <class List, class Each>
  void list(const List& items, std::size_t, const char*, const Each& each) {
    u64(items.size());
    for (const auto& item : items) each(item);
  }

 private:
  void put(std::uint64_t value, int count);
  std::string bytes_;
};

/// Takes them back. Every failure is an Error with the file, the byte, what was expected and what came.
class ByteReader {
 public:
  ByteReader(std::string file, std::string_view bytes, std::size_t first_byte = 0);

  std::uint8_t u8(const char* what);
  std::uint32_t u32(const char* what);
  std::uint64_t u64(const char* what);
  Index index(const char* what) { return static_cast<Index>(u32(what)); }
  double real(const char* what);  ///< any bits
  Vec3 vector(const char* what);
  VecList vectors(std::size_t count, const char* what);
  std::string text(const char* what);
  std::vector<Index> indices(const char* what);
  /// A count of things of at least so many bytes each: an Error when the rest is too short for them, so that a damaged
  /// one allocates nothing.
  std::size_t count(std::size_t bytes_each, const char* what);
  std::string_view raw(std::size_t count, const char* what);

  void field(bool& value, const char* what);  ///< refuses all but 0 and 1
  void field(Index& value, const char* what) { value = index(what); }
  void field(std::uint64_t& value, const char* what) { value = u64(what); }
  void field(double& value, const char* what) { value = real(what); }
  void field(Vec3& value, const char* what) { value = vector(what); }
  void field(std::string& value, const char* what) { value = text(what); }
  void field(std::vector<Index>& value, const char* what) { value = indices(what); }
  /// A count as above, then each item by each(item).
  template <class List, class Each>
  void list(List& items, std::size_t bytes_each, const char* what, const Each& each) {
    items.resize(count(bytes_each, what));
    for (auto& item : items) each(item);
  }

  ByteReader nested(const char* what);  ///< of a text's bytes

  std::size_t remaining() const { return bytes_.size() - position_; }
  void expect_end(const char* what) const;  ///< throws where bytes are left over
  /// Throws "file: byte N: expected ..., got ...; ..." about what was read last.
  [[noreturn]] void fail(const std::string& problem) const;

 private:
  std::uint64_t take(int count, const char* what);

  std::string file_;
  std::string_view bytes_;
  std::size_t first_byte_, position_ = 0, mark_ = 0;
};

/// CRC-32 of zlib.
std::uint32_t checksum(std::string_view bytes);

struct FileSection {
  std::string tag;           ///< four letters
  std::string_view payload;  ///< of the bytes given to read_sections
  std::size_t first_byte = 0;
};

struct FileKind {
  const char* magic;      ///< eight letters
  std::uint32_t version;  ///< that is written, and the only one read
  const char* name;       ///< "a state file"
};

class SectionWriter {
 public:
  explicit SectionWriter(const FileKind& kind);
  void add(std::string_view tag, const ByteWriter& payload);
  std::string finish();  ///< the whole file

 private:
  ByteWriter bytes_;
  std::string file_;
};

/// Sections but for the last; throws Error unless magic, version and checksums are right, the tags are these and
/// nothing is missing or left over.
std::vector<FileSection> read_sections(const std::string& file, std::string_view bytes, const FileKind& kind,
                                       std::initializer_list<std::string_view> tags);

}  // namespace phymul
