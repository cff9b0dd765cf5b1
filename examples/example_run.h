// SPDX-License-Identifier: MIT
//
// What the examples with tools share: a command line of --out DIR and --quick, curves in CSV files, checked steps.
#pragma once

#include <phymul/simulation.h>

#include <cstdio>
#include <functional>
#include <initializer_list>
#include <memory>
#include <string>

struct ExampleOptions {
  std::string out = ".";  ///< folder; made where it is not there
  bool quick = false;     ///< coarser bodies and faster tools, for tests: a second or two

  std::string file(const std::string& name) const { return out + '/' + name; }
};

/// Reads the command line, runs, and says what went wrong: main()'s exit code. `about`: what --help says of the
/// example.
int run_example(int argc, char** argv, const char* about, const std::function<void(const ExampleOptions&)>& run);

/// Throws phymul::Error with the sentence unless it holds: an example's own test.
void require(bool holds, const std::string& sentence);

std::string text(const char* format, double a, double b = 0.0, double c = 0.0);

/// Advances a simulation, and says the time reached every three seconds; throws phymul::Error if that fails. Returns
/// the time reached, s.
double advance(phymul::Simulation& sim, double seconds);

/// Where a point of the body at rest is now: the mean of particles near it, moved with them. Chosen once.
class BodyPoint {
 public:
  BodyPoint(const phymul::Model& model, const phymul::Vec3& rest);
  phymul::Vec3 now(const phymul::State& state) const;
  const phymul::Vec3& rest() const { return rest_; }

 private:
  phymul::Vec3 rest_;
  std::vector<phymul::Index> particles_;
  std::vector<double> weights_;  // sum 1
  std::vector<phymul::Vec3> place_;
};

/// A CSV file: the names of the columns, then rows. Throws Error where one cannot be written.
class Curve {
 public:
  Curve(const std::string& path, const std::string& columns);
  void add(std::initializer_list<double> row);
  void add(const std::string& name, std::initializer_list<double> row);

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string path_;
  std::unique_ptr<std::FILE, Close> file_;
};
