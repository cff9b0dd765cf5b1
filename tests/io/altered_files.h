// SPDX-License-Identifier: MIT
//
// Files that differ from a valid one in a known way, and what may come of reading them: never another body.
#pragma once

#include <gtest/gtest.h>
#include <phymul/error.h>

#include <chrono>
#include <cstring>
#include <functional>
#include <initializer_list>
#include <random>
#include <regex>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#ifdef __linux__
#include <sys/resource.h>

#include <fstream>
#endif

#include "support/sanitized.h"

namespace phymul::test {

/// What must come of it. `either`: what the valid file gives, or an Error. `any`: something valid, or an Error.
enum class Must { be_same, fail, either, any };

/// While it lives, the process may take `more` bytes of address space beyond what it has. Not where it cannot be asked.
class MemoryLimit {
 public:
#ifdef __linux__
  explicit MemoryLimit(rlim_t more) {
    if (sanitized) return;
    getrlimit(RLIMIT_AS, &before_);
    rlim_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const rlimit limit{4096 * pages + more, before_.rlim_max};
    if (pages > 0) setrlimit(RLIMIT_AS, &limit);
  }
  ~MemoryLimit() {
    if (!sanitized) setrlimit(RLIMIT_AS, &before_);
  }

 private:
  rlimit before_{};
#else
  explicit MemoryLimit(unsigned long) {}
#endif
};

/// Alters one valid file and holds what comes of each.
class AlteredFiles {
 public:
  /// Reads bytes as a file of that name; throws Error; gives all that was read, as a text.
  using Read = std::function<std::string(const std::string& name, const std::string& bytes)>;

  AlteredFiles(std::string name, std::string bytes, Read read)
      : name_(std::move(name)), bytes_(std::move(bytes)), read_(std::move(read)), valid_(read_(name_, bytes_)) {}

  void hold(const std::string& what, const std::string& bytes, Must must) {
    SCOPED_TRACE(name_ + ": " + what);
    testing::Test::RecordProperty(name_, ++held_);
    const auto start = std::chrono::steady_clock::now();
    std::string got, message;
    try {
      const MemoryLimit limit(512 << 20);
      got = read_(name_, bytes);
    } catch (const Error& error) {  // and nothing else
      message = error.what();
      EXPECT_NE(error.file().find(name_), std::string::npos) << message;
      EXPECT_NE(error.code(), ErrorCode::out_of_memory) << message;
    } catch (const std::exception& other) {
      ADD_FAILURE() << "not an Error: " << other.what();
    }
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
    const bool is_read = message.empty(), is_same = is_read && got == valid_;
    const bool holds =
        must == Must::any || (must == Must::fail ? !is_read : is_same || (must == Must::either && !is_read));
    EXPECT_TRUE(holds) << (is_read ? is_same ? "read as the valid one" : "read as " + got : message);
  }

  /// A row has a mark (= ! ~ ?: the values of Must), a text of the file and, after each " | ", what replaces its first
  /// occurrence: \\n is a line end, _ alone nothing. Three blanks end a row, too.
  void alter(const std::string& table) {
    std::istringstream rows(std::regex_replace(table, std::regex("   (?=[=!~?] )"), "\n"));
    for (std::string row; std::getline(rows, row);) {
      if (row.empty()) continue;
      const Must must = static_cast<Must>(std::string("=!~?").find(row[0]));
      row = std::regex_replace(row.substr(2), std::regex("\\\\n"), "\n");
      const std::size_t bar = row.find(" | "), found = bytes_.find(row.substr(0, bar));
      ASSERT_NE(found, std::string::npos) << name_ << " has no " << row;
      for (std::size_t at = bar; at != std::string::npos;) {
        const std::size_t next = row.find(" | ", at + 3);
        const std::string into = row.substr(at + 3, next - at - 3);
        hold(row.substr(0, bar) + " -> " + into, std::string(bytes_).replace(found, bar, into == "_" ? "" : into),
             must);
        at = next;
      }
    }
  }

  /// With each of these numbers at the byte `at`.
  template <class Number>
  void put(std::size_t at, std::initializer_list<Number> numbers, Must must) {
    for (const Number number : numbers) {
      std::string other = bytes_;
      std::memcpy(&other[at], &number, sizeof number);
      hold(std::to_string(number) + " at byte " + std::to_string(at), other, must);
    }
  }

  /// Cut at so many places, and with so many single bits changed, from the byte `from` up to `to`.
  void damage(int cuts, int flips, Must cut = Must::either, Must flipped = Must::any, std::size_t from = 0,
              std::size_t to = std::string::npos) {
    for (std::size_t k = 0; k < std::size_t(cuts); ++k) {
      const std::size_t length = bytes_.size() * k / std::size_t(cuts);
      hold("its first " + std::to_string(length) + " bytes", bytes_.substr(0, length), cut);
    }
    std::mt19937 random(7);
    for (int k = 0; k < flips; ++k) {
      const std::size_t at = from + random() % (std::min(to, bytes_.size()) - from), bit = random() % 8;
      std::string other = bytes_;
      other[at] = static_cast<char>(other[at] ^ (1 << bit));
      hold("bit " + std::to_string(bit) + " of byte " + std::to_string(at), other, flipped);
    }
  }

  /// The same of a text, which may have other line ends.
  void damage_text(int cuts, int flips) {
    hold("CRLF", std::regex_replace(bytes_, std::regex("\n"), "\r\n"), Must::be_same);
    damage(cuts, flips);
  }

  /// As editors and broken transfers do: at up to `places`, from the byte `from` on, a line is missing, there twice, or
  /// without its last word, has one more, or another first one.
  void damage_lines(std::size_t places, Must must = Must::either, std::size_t from = 0) {
    std::vector<std::pair<std::size_t, std::size_t>> lines;  // where they begin and end
    for (std::size_t at = from, end = 0; at < bytes_.size(); at = end + 1) {
      end = std::min(bytes_.find('\n', at), bytes_.size());
      if (end > at) lines.emplace_back(at, end);
    }
    const std::size_t stride = std::max<std::size_t>(lines.size() / places, 1);
    for (std::size_t k = 0; k < lines.size(); k += stride) {
      const auto& [at, end] = lines[k];
      const std::string line = bytes_.substr(at, end - at), shown = " of line " + std::to_string(k) + ": " + line;
      const auto with = [&](const std::string& what, const std::string& other) {
        hold(what + shown, std::string(bytes_).replace(at, line.size(), other), must);
      };
      hold("none" + shown, std::string(bytes_).erase(at, line.size() + 1), must);
      with("two", line + '\n' + line);
      with("last word", line.substr(0, line.find_last_of(" \t", line.size() - 2) + 1));
      with("one more word", line + " 7");
      with("first word", 'x' + line.substr(std::min(line.find_first_of(" \t", 1), line.size())));
    }
  }

  /// The same of bytes: at each place one is missing, or there twice.
  void damage_bytes(std::size_t places, Must must = Must::either, std::size_t from = 0) {
    for (std::size_t k = 0; k < places; ++k) {
      const std::size_t at = from + (bytes_.size() - from) * k / places;
      const std::string place = " byte " + std::to_string(at);
      hold("no" + place, std::string(bytes_).erase(at, 1), must);
      hold("twice" + place, std::string(bytes_).insert(at, 1, bytes_[at]), must);
    }
  }

  const std::string& bytes() const { return bytes_; }

 private:
  std::string name_, bytes_;
  Read read_;
  std::string valid_;
  int held_ = 0;  // files, which --gtest_output=json tells of each name
};

}  // namespace phymul::test
