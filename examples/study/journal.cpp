// SPDX-License-Identifier: MIT
#include "journal.h"

#include <fcntl.h>
#include <phymul/error.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "checksum.h"

namespace {

constexpr std::size_t digits = 8;  // of a checksum

std::string hexadecimal(std::uint32_t value) {
  char text[digits + 1];
  std::snprintf(text, sizeof text, "%08x", value);
  return text;
}

std::string header_of(std::uint32_t fingerprint) {
  return "phymul-study results 1 " + hexadecimal(fingerprint);
}

std::string sealed(const std::string& text) {
  Checksum sum;
  sum.add(text);
  return hexadecimal(sum.value()) + ' ' + text + '\n';
}

/// None for a line whose checksum is another.
std::optional<std::string> unsealed(std::string_view line) {
  if (line.size() <= digits || line[digits] != ' ') return std::nullopt;
  std::string text(line.substr(digits + 1));
  if (sealed(text).substr(0, digits) != line.substr(0, digits)) return std::nullopt;
  return text;
}

void append_number(std::string& text, double value) {
  char number[40];
  std::snprintf(number, sizeof number, " %a", value);
  text += number;
}

}  // namespace

std::string result_text(const std::vector<double>& values, const SceneResult& result) {
  std::string text = (result.failure.empty() ? "ok " : "failed ") + std::to_string(values.size());
  for (const double value : values) append_number(text, value);
  for (const double value : result.values) append_number(text, value);
  return result.failure.empty() ? text : text + ' ' + result.failure;
}

bool read_result(const std::string& text, std::vector<double>& values, SceneResult& result) {
  std::istringstream in(text);
  std::string word;
  std::size_t count = 0;
  if (!(in >> word >> count) || (word != "ok" && word != "failed") || count > text.size()) return false;
  const bool failed = word == "failed";
  const auto number = [&] { return std::strtod(word.c_str(), nullptr); };
  while (values.size() < count && in >> word) values.push_back(number());
  if (values.size() < count) return false;
  if (failed) {
    std::getline(in >> std::ws, result.failure);
    return !result.failure.empty();
  }
  while (in >> word) result.values.push_back(number());
  return true;
}

namespace {

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw phymul::Error(phymul::ErrorCode::file_access, path + ": " + what, path);
}

}  // namespace

StudyJournal::StudyJournal(const std::string& path, std::uint32_t fingerprint) : path_(path) {
  file_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file_ < 0) fail(path, std::string("expected a file that can be written: ") + std::strerror(errno));
  try {
    struct stat about {};
    if (::fstat(file_, &about) != 0 || !S_ISREG(about.st_mode)) fail(path, "expected an ordinary file");
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
      if (errno == EWOULDBLOCK) fail(path, "another process works on this study; wait for its end, or end it");
      notes_.push_back(path + ": this file system has no locks; see to it that one process alone writes the file");
    }
    read(fingerprint);
  } catch (...) {
    ::close(file_);
    throw;
  }
}

StudyJournal::~StudyJournal() {
  ::close(file_);
}

void StudyJournal::read(std::uint32_t fingerprint) {
  std::ifstream in(path_, std::ios::binary);
  const std::string all(std::istreambuf_iterator<char>(in), {});
  if (in.bad()) fail(path_, "expected a file that can be read");
  const std::string_view text = all;
  std::size_t whole = text.rfind('\n');
  whole = whole == std::string_view::npos ? 0 : whole + 1;
  int line = 0;
  for (std::size_t from = 0; from < whole;) {
    const std::size_t end = text.find('\n', from);
    const std::optional<std::string> content = unsealed(text.substr(from, end - from));
    const std::string place = path_ + ':' + std::to_string(++line);
    from = end + 1;
    if (line == 1) {
      if (content && *content == header_of(fingerprint)) continue;
      const bool other = content && content->starts_with("phymul-study results ");
      throw phymul::Error(phymul::ErrorCode::file_format,
                          place + (other ? ": these are results of another study, of other files or of another "
                                           "version; give another --out, or remove this file"
                                         : ": expected results of phymul-study; give another --out"),
                          path_, 1);
    }
    std::vector<double> values;
    SceneResult result;
    if (content && read_result(*content, values, result)) {
      results_.insert_or_assign(std::move(values), std::move(result));
    } else {
      notes_.push_back(place + ": this line is damaged; its scene is done again");
    }
  }
  if (whole < text.size()) {
    if (line == 0 && !sealed(header_of(fingerprint)).starts_with(text)) {
      fail(path_, "expected results of phymul-study; give another --out");
    }
    notes_.push_back(path_ + ':' + std::to_string(line + 1) + ": this line is torn; its scene is done again");
    if (::ftruncate(file_, static_cast<off_t>(whole)) != 0) fail(path_, "the torn end cannot be cut off");
  }
  if (line == 0) write(sealed(header_of(fingerprint)));
}

void StudyJournal::write(const std::string& line) {
  for (std::size_t from = 0; from < line.size();) {
    const ssize_t wrote = ::write(file_, line.data() + from, line.size() - from);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote <= 0) fail(path_, std::string("the results cannot be written: ") + std::strerror(errno));
    from += static_cast<std::size_t>(wrote);
  }
  if (::fsync(file_) != 0 && errno != EINVAL && errno != EROFS) {
    fail(path_, std::string("the results do not reach the disk: ") + std::strerror(errno));
  }
}

const SceneResult* StudyJournal::find(const std::vector<double>& values) const {
  const auto at = results_.find(values);
  return at == results_.end() ? nullptr : &at->second;
}

const SceneResult& StudyJournal::add(const std::vector<double>& values, SceneResult result) {
  write(sealed(result_text(values, result)));
  return results_.insert_or_assign(values, std::move(result)).first->second;
}
