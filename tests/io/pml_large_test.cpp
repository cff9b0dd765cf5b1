// SPDX-License-Identifier: MIT
//
// A large body reads in time and in memory that grow with its size only. PHYMUL_LARGE_ATOMS sets the size (1000000 for
// the figures of the documentation); the bounds go with it.
#include <gtest/gtest.h>
#include <phymul/pml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iostream>
#include <limits>
#include <optional>
#include <string>

#include "support/text_file.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || !defined(NDEBUG)
constexpr bool measured_build = false;  // slow and large by design
#else
constexpr bool measured_build = true;
#endif

namespace phymul {
namespace {

constexpr double seconds_per_atom = 10e-6;  // of processor time
constexpr double most_growth = 2.0;         // of it, for eight times the atoms; a quadratic reader has 8
constexpr double bytes_per_atom = 2048;     // at the peak, text and tree included

/// A line of /proc/self/status in bytes; none where the system has no such file.
std::optional<double> memory_figure(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kibibytes = 0;
    if (word == name + ":" && status >> kibibytes) return kibibytes * 1024;
  }
  return std::nullopt;
}

/// Lets VmHWM start anew. False where the system cannot.
bool reset_peak() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
  std::ofstream clear("/proc/self/clear_refs");
  clear << "5" << std::flush;
  return clear.good();
}

/// A cubic lattice of n^3 atoms with the neighbourhood of each, in the layout of the usual writers.
void write_lattice(const std::string& path, int n) {
  std::ofstream out(path);
  const auto index = [n](int i, int j, int k) { return (k * n + j) * n + i; };
  out << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<physicalModel name=\"lattice\">\n<atoms>\n"
         "<structuralComponent name=\"element list\">\n";
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        out << "<atom><atomProperties index=\"" << index(i, j, k) << "\" x=\"" << 0.125 * i << "\" y=\"" << 0.125 * j
            << "\" z=\"" << 0.125 * k << "\" mass=\"0.001\"/></atom>\n";
      }
    }
  }
  out << "</structuralComponent>\n</atoms>\n<exclusiveComponents>\n<multiComponent name=\"Exclusive Components\">\n"
         "<structuralComponent name=\"Neighborhoods\" stiffness=\"1\">\n";
  constexpr std::array<std::array<int, 3>, 6> steps = {
      {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}};
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        out << "<cell><cellProperties index=\"" << index(i, j, k) << "\" type=\"POLY_VERTEX\" name=\"Atom #"
            << index(i, j, k) << "\"/><nrOfStructures value=\"6\"/>";
        for (const auto& [a, b, c] : steps) {
          if (std::min({i + a, j + b, k + c}) < 0 || std::max({i + a, j + b, k + c}) >= n) continue;
          out << "<atomRef index=\"" << index(i + a, j + b, k + c) << "\"/>";
        }
        out << "</cell>\n";
      }
    }
  }
  out << "</structuralComponent>\n</multiComponent>\n</exclusiveComponents>\n</physicalModel>\n";
}

/// Processor time, s.
double seconds_to_read(const std::string& path) {
  const std::clock_t start = std::clock();
  (void)read_pml(path);
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

TEST(PmlLarge, TimeAndMemoryGrowWithTheSizeOnly) {
  const char* const wanted = std::getenv("PHYMUL_LARGE_ATOMS");
  const int n = static_cast<int>(std::ceil(std::cbrt(wanted != nullptr ? std::atof(wanted) : 1e5)));
  const Index atoms = n * n * n;
  const TextFile file("large.pml", ""), file_of_eighth("eighth.pml", "");
  const std::string& path = file.path();
  write_lattice(path, n);
  const bool peak_known = reset_peak();
  const std::optional<double> before = memory_figure("VmRSS");
  const std::clock_t start = std::clock();
  const Model model = read_pml(path);
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  const std::optional<double> peak = memory_figure("VmHWM");

  ASSERT_EQ(model.particle_count(), atoms);
  EXPECT_EQ(model.neighbours.entry.size(), static_cast<std::size_t>(6) * n * n * (n - 1));
  EXPECT_EQ(model.rest.back(), Vec3::Constant(0.125e-3 * (n - 1)));
  if (!measured_build) GTEST_SKIP() << "time and memory are not those of a release build";
  std::cout << atoms << " atoms: " << seconds << " s\n";
  const std::string& eighth = file_of_eighth.path();
  write_lattice(eighth, n / 2);
  const int eighth_atoms = (n / 2) * (n / 2) * (n / 2);
  // Processor time, too, is longer beside other work: the ratio is that of one pair of readings in a few.
  double growth = std::numeric_limits<double>::infinity();
  for (int pair = 0; pair < 5 && growth >= most_growth; ++pair) {
    const double of_eighth = seconds_to_read(eighth) / eighth_atoms;
    growth = std::min(growth, (pair == 0 ? seconds : seconds_to_read(path)) / atoms / of_eighth);
  }
  EXPECT_LT(growth, most_growth);
  if (wanted != nullptr) {  // by hand, on a quiet machine
    EXPECT_LT(seconds, seconds_per_atom * atoms);
  }
  if (!peak_known || !before || !peak) GTEST_SKIP() << "this system does not tell a process its peak memory";
  std::cout << (*peak - *before) / atoms << " bytes per atom at the peak\n";
  EXPECT_LT(*peak - *before, bytes_per_atom * atoms);
}

}  // namespace
}  // namespace phymul
