// SPDX-License-Identifier: MIT
#include "checked_file.h"

#include <phymul/error.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstdio>
#include <limits>

#include "byte_source.h"
#include "files.h"

namespace phymul {
namespace {

constexpr const char* end_tag = "end ";

std::string hexadecimal(std::uint32_t value) {
  char text[16];
  std::snprintf(text, sizeof text, "0x%08x", value);
  return text;
}

std::uint32_t crc(std::uint32_t start, std::string_view bytes) {
  // zlib counts in 32 bits.
  auto sum = static_cast<uLong>(start);
  for (std::size_t done = 0; done < bytes.size();) {
    const std::size_t some = std::min<std::size_t>(bytes.size() - done, 1u << 30);
    sum = crc32(sum, reinterpret_cast<const Bytef*>(bytes.data() + done), static_cast<uInt>(some));
    done += some;
  }
  return static_cast<std::uint32_t>(sum);
}

}  // namespace

std::uint32_t checksum(std::string_view bytes) {
  return crc(0, bytes);
}

void ByteWriter::put(std::uint64_t value, int count) {
  for (int k = 0; k < count; ++k) bytes_.push_back(static_cast<char>(value >> 8 * k & 0xff));
}

void ByteWriter::real(double value) {
  u64(std::bit_cast<std::uint64_t>(value));
}

void ByteWriter::vector(const Vec3& v) {
  for (int a = 0; a < 3; ++a) real(v[a]);
}

void ByteWriter::vectors(const VecList& list) {
  bytes_.reserve(bytes_.size() + 24 * list.size());
  for (const Vec3& v : list) vector(v);
}

void ByteWriter::text(std::string_view text) {
  if (text.size() > std::numeric_limits<std::uint32_t>::max()) {
    throw Error(ErrorCode::not_supported,
                "expected less than 4 GiB in one part of a file, got " + std::to_string(text.size()) + " bytes");
  }
  u32(static_cast<std::uint32_t>(text.size()));
  bytes_.append(text);
}

void ByteWriter::indices(const std::vector<Index>& list) {
  u64(list.size());
  for (const Index i : list) index(i);
}

ByteReader::ByteReader(std::string file, std::string_view bytes, std::size_t first_byte)
    : file_(std::move(file)), bytes_(bytes), first_byte_(first_byte) {}

void ByteReader::fail(const std::string& problem) const {
  fail_format(file_, 0, "byte " + std::to_string(first_byte_ + mark_) + ": " + problem);
}

ByteReader ByteReader::nested(const char* what) {
  const std::uint32_t size = u32(what);
  return {file_, raw(size, what), first_byte_ + position_ - size};
}

std::string_view ByteReader::raw(std::size_t count, const char* what) {
  mark_ = position_;
  if (count > remaining()) {
    fail(std::string("expected ") + what + " (" + std::to_string(count) + " bytes), got the end after " +
         std::to_string(remaining()) + "; the file was cut short: take another copy, or write it anew");
  }
  position_ += count;
  return bytes_.substr(mark_, count);
}

std::uint64_t ByteReader::take(int count, const char* what) {
  const std::string_view bytes = raw(static_cast<std::size_t>(count), what);
  std::uint64_t value = 0;
  for (int k = 0; k < count; ++k) value |= std::uint64_t{static_cast<unsigned char>(bytes[k])} << 8 * k;
  return value;
}

std::uint8_t ByteReader::u8(const char* what) {
  return static_cast<std::uint8_t>(take(1, what));
}
std::uint32_t ByteReader::u32(const char* what) {
  return static_cast<std::uint32_t>(take(4, what));
}
std::uint64_t ByteReader::u64(const char* what) {
  return take(8, what);
}
double ByteReader::real(const char* what) {
  return std::bit_cast<double>(u64(what));
}

Vec3 ByteReader::vector(const char* what) {
  Vec3 v;
  for (int a = 0; a < 3; ++a) v[a] = real(what);
  return v;
}

std::size_t ByteReader::count(std::size_t bytes_each, const char* what) {
  const std::uint64_t value = u64(what);
  if (value > remaining() / bytes_each) {
    fail(std::string("expected ") + what + " that fits into the " + std::to_string(remaining()) +
         " bytes after it, got " + std::to_string(value) + "; the file is damaged: take another copy");
  }
  return static_cast<std::size_t>(value);
}

VecList ByteReader::vectors(std::size_t count, const char* what) {
  ByteReader part(file_, raw(24 * count, what), first_byte_ + position_ - 24 * count);
  VecList list(count);
  for (Vec3& v : list) v = part.vector(what);
  return list;
}

std::string ByteReader::text(const char* what) {
  return std::string(raw(u32(what), what));
}

std::vector<Index> ByteReader::indices(const char* what) {
  std::vector<Index> list(count(4, what));
  for (Index& i : list) i = index(what);
  return list;
}

void ByteReader::field(bool& value, const char* what) {
  const std::uint8_t byte = u8(what);
  if (byte > 1) {
    fail(std::string("expected ") + what + " (0 or 1), got " + std::to_string(byte) + "; the file is damaged");
  }
  value = byte == 1;
}

void ByteReader::expect_end(const char* what) const {
  if (remaining() == 0) return;
  fail_format(file_, 0,
              "byte " + std::to_string(first_byte_ + position_) + ": expected the end of " + what + ", got " +
                  std::to_string(remaining()) + " bytes more; the file is damaged: take another copy");
}

SectionWriter::SectionWriter(const FileKind& kind) {
  file_ = kind.magic;
  ByteWriter version;
  version.u32(kind.version);
  file_ += version.bytes();
}

void SectionWriter::add(std::string_view tag, const ByteWriter& payload) {
  ByteWriter length, sum;
  length.u64(payload.bytes().size());
  const std::size_t start = file_.size();
  file_.append(tag).append(length.bytes()).append(payload.bytes());
  sum.u32(checksum(std::string_view(file_).substr(start)));
  file_ += sum.bytes();
}

std::string SectionWriter::finish() {
  add(end_tag, {});
  return std::move(file_);
}

std::vector<FileSection> read_sections(const std::string& file, std::string_view bytes, const FileKind& kind,
                                       std::initializer_list<std::string_view> tags) {
  ByteReader in(file, bytes);
  const std::string_view magic = in.raw(8, "the magic word");
  if (magic != kind.magic) {
    in.fail(std::string("expected ") + kind.name + ", which begins with \"" + kind.magic + "\", got " + cited(magic) +
            "; give a file of that kind");
  }
  const std::uint32_t version = in.u32("the version");
  if (version != kind.version) {
    in.fail("expected version " + std::to_string(kind.version) + " of " + kind.name + ", got " +
            std::to_string(version) + "; read it with the version of phymul that wrote it");
  }
  std::vector<FileSection> sections;
  for (;;) {
    const std::size_t start = bytes.size() - in.remaining();
    const std::string tag(in.raw(4, "a section's tag"));
    const std::size_t length = in.count(1, "a section's length");
    const std::string_view payload = in.raw(length, "a section");
    const std::uint32_t expected = checksum(bytes.substr(start, 12 + length));
    const std::uint32_t got = in.u32("a checksum");
    if (got != expected) {
      in.fail("expected the checksum " + hexadecimal(expected) + " of section " + cited(tag) + " from byte " +
              std::to_string(start) + ", got " + hexadecimal(got) + "; the file is damaged: take another copy");
    }
    if (tag == end_tag) break;
    sections.push_back({tag, payload, start + 12});
  }
  in.expect_end(kind.name);
  if (!std::ranges::equal(sections, tags, {}, &FileSection::tag)) {
    std::string expected;
    for (const std::string_view tag : tags) expected += (expected.empty() ? "" : ", ") + cited(tag);
    fail_format(file, 0,
                "expected the sections " + expected + ", got " + std::to_string(sections.size()) +
                    " others; the file was written by something else");
  }
  return sections;
}

}  // namespace phymul
