// SPDX-License-Identifier: MIT
//
// The file of results: scenes that are done, in the order in which they were. A line is on the disk before the next one
// begins, so that a process killed at any time costs what it was working on, and the file goes on where it ended.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "scene.h"

/// A result and the values it belongs to, in one line: "ok" or "failed", number of parameters, their values, then the
/// result's values or the reason of the failure. Numbers as C's %a, exact to the bit.
std::string result_text(const std::vector<double>& values, const SceneResult& result);

/// False for a text that is no result. `values` and `result` must be empty.
bool read_result(const std::string& text, std::vector<double>& values, SceneResult& result);

/// One process at a time may have the file open. A line is the CRC-32 of its text in eight hexadecimal digits, a blank
/// and the text: result_text(), and in the first line the fingerprint of the study.
class StudyJournal {
 public:
  /// Opens or makes the file and takes what is in it. A torn end is cut off, and a line whose checksum is wrong is left
  /// out; notes() says so. Throws phymul::Error if another process has it open, if it is of a study with another
  /// fingerprint, or if it cannot be written.
  StudyJournal(const std::string& path, std::uint32_t fingerprint);
  ~StudyJournal();
  StudyJournal(const StudyJournal&) = delete;
  StudyJournal& operator=(const StudyJournal&) = delete;

  /// Null: not done yet.
  const SceneResult* find(const std::vector<double>& values) const;

  /// Writes a result and waits until it is on the disk. Throws phymul::Error if it cannot be.
  const SceneResult& add(const std::vector<double>& values, SceneResult result);

  std::size_t size() const { return results_.size(); }
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  void read(std::uint32_t fingerprint);
  void write(const std::string& line);

  std::string path_;
  int file_ = -1;
  std::map<std::vector<double>, SceneResult> results_;
  std::vector<std::string> notes_;
};
