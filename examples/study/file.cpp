// SPDX-License-Identifier: MIT
#include "file.h"

#include <phymul/error.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <set>
#include <sstream>

#include "expression.h"
#include "measurement.h"
#include "tables.h"

namespace {

using Words = std::vector<std::string>;

/// Separated by blanks; a word in double quotes may have some. A word that begins with # and all after it is a comment.
Words split(const std::string& line) {
  std::istringstream in(line);
  Words words;
  for (std::string word; in >> std::ws && in.peek() != '#' && !in.eof(); words.push_back(word)) {
    if (!(in >> std::quoted(word))) throw phymul::Error("expected a second \" at the end of the word");
  }
  return words;
}

double number(const std::string& text) {
  return phymul::bench::evaluate(text, {});
}

int whole_number(const std::string& text, double least, const std::string& what) {
  const double value = number(text);
  if (value != std::round(value) || value < least || value > 1e9) {
    throw phymul::Error("expected " + what + ", a whole number of " + std::to_string(static_cast<int>(least)) +
                        " to 1e9, got " + text);
  }
  return static_cast<int>(value);
}

void require_count(const Words& words, std::size_t least, std::size_t most, const std::string& usage) {
  if (words.size() > least && words.size() <= most + 1) return;
  throw phymul::Error("expected: " + words[0] + ' ' + usage + "; got " + std::to_string(words.size() - 1) + " words");
}

void require_name(const std::string& name) {
  const auto good = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
  if (std::isdigit(static_cast<unsigned char>(name[0])) == 0 && std::ranges::all_of(name, good)) return;
  throw phymul::Error("expected a name of letters, digits and _, got " + name);
}

StudyParameter read_parameter(const Words& w) {
  const std::string usage = "NAME list|range|uniform|normal|lognormal numbers";
  require_count(w, 3, 100'000, usage);
  StudyParameter it;
  it.name = w[1];
  require_name(it.name);
  for (std::size_t k = 3; k < w.size(); ++k) it.values.push_back(number(w[k]));
  const auto require = [&](bool good, const char* numbers) {
    if (!good) throw phymul::Error("expected: parameter NAME " + w[2] + ' ' + numbers);
  };
  const std::vector<double>& v = it.values;
  if (w[2] == "list") {
    it.spread = Spread::list;
  } else if (w[2] == "range") {
    require(v.size() == 3, "from to count");
    const int count = whole_number(w[5], 2, "the count");
    require(count <= 10'000'000, "from to count, count at most 1e7");
    std::vector<double> values;
    for (int k = 0; k < count; ++k) values.push_back(v[0] + (v[1] - v[0]) * k / (count - 1));
    it.values = values;
  } else if (w[2] == "uniform") {
    require(v.size() == 2 && v[0] < v[1], "from to, from < to");
    it.spread = Spread::uniform;
  } else if (w[2] == "normal") {
    require(v.size() == 2 && v[1] > 0.0, "mean deviation, deviation > 0");
    it.spread = Spread::normal;
  } else if (w[2] == "lognormal") {
    require(v.size() == 2 && v[0] > 0.0 && v[1] > 1.0, "median factor, median > 0, factor > 1");
    it.spread = Spread::lognormal;
  } else {
    throw phymul::Error("expected: parameter " + usage + "; got \"" + w[2] + '"');
  }
  return it;
}

StudyTarget read_target(const Words& w) {
  const std::string usage = "NAME group GROUP, or NAME point x y z";
  require_count(w, 3, 5, usage);
  StudyTarget it;
  it.name = w[1];
  require_name(it.name);
  if (w[2] == "group" && w.size() == 4) {
    it.group = w[3];
  } else if (w[2] == "point" && w.size() == 6) {
    it.point = {w[3], w[4], w[5]};
  } else {
    throw phymul::Error("expected: target " + usage);
  }
  return it;
}

void read_line(const Words& w, int line, Study& study) {
  const std::string& key = w[0];
  if ((key == "samples" && study.samples > 0) || (key == "measured" && !study.measured_file.empty()) ||
      (key == "tolerance" && study.has_tolerance)) {
    throw phymul::Error("expected one line \"" + key + "\", got another");
  }
  if (key == "run") {
    study.words.insert(study.words.end(), w.begin() + 1, w.end());
    study.words_line = line;
  } else if (key == "parameter") {
    study.parameters.push_back(read_parameter(w));
    study.parameters.back().line = line;
  } else if (key == "samples") {
    require_count(w, 1, 3, "COUNT [seed NUMBER]");
    study.samples = whole_number(w[1], 1, "the number of samples");
    if (w.size() > 2) {
      if (w[2] != "seed" || w.size() != 4) throw phymul::Error("expected: samples COUNT [seed NUMBER]");
      study.seed = static_cast<std::uint64_t>(whole_number(w[3], 0, "the seed"));
    }
    study.samples_line = line;
  } else if (key == "target") {
    study.targets.push_back(read_target(w));
    study.targets.back().line = line;
  } else if (key == "unknown") {
    require_count(w, 3, 3, "NAME guess NUMBER");
    require_name(w[1]);
    const double guess = number(w[3]);
    if (w[2] != "guess" || !(guess > 0.0)) throw phymul::Error("expected: unknown NAME guess NUMBER, NUMBER > 0");
    study.unknowns.push_back({w[1], guess, line});
  } else if (key == "measured") {
    require_count(w, 3, 3, "FILE deviation NUMBER");
    const double deviation = number(w[3]);
    if (w[2] != "deviation" || !(deviation > 0.0)) {
      throw phymul::Error("expected: measured FILE deviation NUMBER, m, NUMBER > 0");
    }
    study.measured_file = w[1];
    study.measurement.deviation = deviation;
  } else if (key == "tolerance") {
    require_count(w, 1, 1, "NUMBER");
    study.tolerance = number(w[1]);
    study.has_tolerance = true;
    if (!(study.tolerance > 0.0)) throw phymul::Error("expected: tolerance NUMBER, NUMBER > 0");
  } else {
    throw phymul::Error("unknown key \"" + key +
                        "\"; expected run, parameter, samples, target, unknown, measured or tolerance");
  }
}

void require_complete(const Study& study) {
  const auto fail = [&](int line, const std::string& what) { fail_at(study.file, line, what); };
  if (study.words.empty()) fail(0, "expected a line \"run\" with the body and the options of phymul-run");
  std::set<std::string> names;
  std::istringstream columns(std::string(scene_columns) + ',' + spread_columns);
  for (std::string column; !study.identifies() && std::getline(columns, column, ',');) names.insert(column);
  for (const StudyParameter& it : study.parameters) {
    if (!names.insert(it.name).second) fail(it.line, "the name " + it.name + " is taken; give another");
    if (it.spread != Spread::list && study.samples == 0) {
      fail(it.line, it.name + " is sampled: expected a line \"samples COUNT\"");
    }
    if (study.identifies()) fail(it.line, "a study that seeks unknowns has no parameters; make two studies of it");
  }
  for (const StudyUnknown& it : study.unknowns) {
    if (!names.insert(it.name).second) fail(it.line, "the name " + it.name + " is taken; give another");
  }
  if (study.samples > 0 &&
      std::ranges::none_of(study.parameters, [](const auto& it) { return it.spread != Spread::list; })) {
    fail(study.samples_line, "expected a parameter that is sampled: uniform, normal or lognormal");
  }
  std::set<std::string> targets;
  for (const StudyTarget& it : study.targets) {
    if (!targets.insert(it.name).second) fail(it.line, "the target " + it.name + " is there already");
    for (const char* column : target_columns) {
      const std::string whole = it.name + '_' + column;
      if (names.contains(whole)) fail(it.line, "the column " + whole + " of the target is taken; give another name");
    }
  }
  if (study.identifies() == study.measured_file.empty()) {
    fail(0, study.identifies() ? "expected a line \"measured\": what is to be met?"
                               : "a measurement needs a line \"unknown\": what is sought?");
  }
  if (!study.identifies() && study.targets.empty()) fail(0, "expected a line \"target\": what is asked for?");
}

}  // namespace

void fail_at(const std::string& file, int line, const std::string& what) {
  const std::string place = line > 0 ? file + ':' + std::to_string(line) : file;
  throw phymul::Error(phymul::ErrorCode::file_format, place + ": " + what, file, line);
}

std::vector<std::string> Study::names() const {
  std::vector<std::string> result;
  for (const StudyParameter& it : parameters) result.push_back(it.name);
  for (const StudyUnknown& it : unknowns) result.push_back(it.name);
  return result;
}

Study read_study(const std::string& path, bool with_displacements) {
  std::ifstream in(path);
  if (!in || std::filesystem::is_directory(path)) {
    throw phymul::Error(phymul::ErrorCode::file_access, path + ": expected a study file that can be read", path);
  }
  Study study;
  study.file = path;
  int line = 0;
  for (std::string text; std::getline(in, text);) {
    ++line;
    try {
      if (const Words words = split(text); !words.empty()) read_line(words, line, study);
    } catch (const phymul::Error& error) {
      fail_at(path, line, error.what());
    }
  }
  require_complete(study);
  if (study.identifies()) {
    const auto file = std::filesystem::path(path).parent_path() / study.measured_file;
    const double deviation = study.measurement.deviation;
    study.measurement = read_measurement(file.string(), with_displacements);
    study.measurement.deviation = deviation;
    if (with_displacements && 3 * study.measurement.point.size() < study.unknowns.size()) {
      fail_at(file.string(), 0, "expected at least as many coordinates as there are unknowns");
    }
  }
  return study;
}
