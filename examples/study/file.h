// SPDX-License-Identifier: MIT
//
// What phymul-study is asked to do: its file, read. docs/guide/studies.md documents the format.
#pragma once

#include <phymul/types.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

/// Throws phymul::Error that begins with "file:line: ".
[[noreturn]] void fail_at(const std::string& file, int line, const std::string& what);

enum class Spread { list, uniform, normal, lognormal };

/// A name whose value differs between the scenes of a study.
struct StudyParameter {
  std::string name;
  Spread spread = Spread::list;
  std::vector<double> values;  ///< list: each value; uniform: from, to; normal: mean, sd; lognormal: median, factor
  int line = 0;
};

/// A part of the body whose place is asked for: the centre of mass of a group, or a point of the tissue.
struct StudyTarget {
  std::string name;
  std::string group;                   ///< empty: a point
  std::array<std::string, 3> point{};  ///< m, at rest; expressions of the parameters
  int line = 0;
};

/// A value that is sought so that the body moves as it was measured to.
struct StudyUnknown {
  std::string name;
  double guess = 0.0;  ///< > 0
  int line = 0;
};

/// Displacements that were measured at points of the tissue.
struct Measurement {
  phymul::VecList point;         ///< m, at rest
  phymul::VecList displacement;  ///< m
  double deviation = 0.0;        ///< m, standard deviation of the noise of each coordinate
};

struct Study {
  std::string file;                ///< as it was given
  std::vector<std::string> words;  ///< of phymul-run, with {expression} where a parameter acts
  int words_line = 0;              ///< of the last line of words
  std::vector<StudyParameter> parameters;
  int samples = 0;  ///< of the parameters that are not lists
  std::uint64_t seed = 1;
  int samples_line = 0;
  std::vector<StudyTarget> targets;
  std::vector<StudyUnknown> unknowns;
  Measurement measurement;
  std::string measured_file;  ///< as the study names it; empty: nothing was measured
  double tolerance = 1e-8;    ///< StaticOptions::tolerance
  bool has_tolerance = false;

  bool identifies() const { return !unknowns.empty(); }
  std::vector<std::string> names() const;  ///< of parameters, then of unknowns
};

/// Reads the study and the measurement it names, relative to its folder. `with_displacements`: false where only the
/// points of the measurement are needed. Throws phymul::Error as "file:line: ...".
Study read_study(const std::string& path, bool with_displacements = true);
