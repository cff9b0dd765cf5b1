// SPDX-License-Identifier: MIT
#include "example_run.h"

#include <phymul/error.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <numeric>

int run_example(int argc, char** argv, const char* about, const std::function<void(const ExampleOptions&)>& run) {
  const std::string name = std::filesystem::path(argv[0]).filename().string();
  try {
    ExampleOptions options;
    for (int k = 1; k < argc; ++k) {
      const std::string word = argv[k];
      if (word == "--quick") {
        options.quick = true;
      } else if (word == "--out" && k + 1 < argc) {
        options.out = argv[++k];
      } else if (word == "--help" || word == "-h") {
        std::printf(
            "%s [--out DIR] [--quick]\n%s\n"
            "DIR: the folder to write to, here by default; --quick: coarser bodies and faster tools.\n",
            name.c_str(), about);
        return 0;
      } else {
        throw phymul::Error("expected [--out DIR] [--quick], got \"" + word + '"');
      }
    }
    std::filesystem::create_directories(options.out);
    run(options);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), error.what());
  }
  return 1;
}

void require(bool holds, const std::string& sentence) {
  if (!holds) throw phymul::Error(sentence);
}

std::string text(const char* format, double a, double b, double c) {
  char buffer[200];
  std::snprintf(buffer, sizeof buffer, format, a, b, c);
  return buffer;
}

double advance(phymul::Simulation& sim, double seconds) {
  static auto next = std::chrono::steady_clock::now() + std::chrono::seconds(3);
  const phymul::StepReport report = sim.advance(seconds);
  if (!report.ok()) throw phymul::Error(report.message());
  if (const auto now = std::chrono::steady_clock::now(); now >= next) {
    std::fprintf(stderr, "t = %.4g s\n", report.time);
    next = now + std::chrono::seconds(3);
  }
  return report.time;
}

BodyPoint::BodyPoint(const phymul::Model& model, const phymul::Vec3& rest) : rest_(rest) {
  constexpr std::size_t count = 8;
  std::vector<phymul::Index> rows(model.rest.size());
  std::iota(rows.begin(), rows.end(), 0);
  const auto distance = [&](phymul::Index i) { return (model.rest[i] - rest).squaredNorm(); };
  std::ranges::partial_sort(rows, rows.begin() + static_cast<std::ptrdiff_t>(std::min(count, rows.size())), {},
                            distance);
  rows.resize(std::min(count, rows.size()));
  const double small = 1e-6 * distance(rows.back());
  double sum = 0.0;
  for (const phymul::Index i : rows) {
    particles_.push_back(i);
    place_.push_back(model.rest[i]);
    weights_.push_back(1.0 / (distance(i) + small));
    sum += weights_.back();
  }
  for (double& weight : weights_) weight /= sum;
}

phymul::Vec3 BodyPoint::now(const phymul::State& state) const {
  phymul::Vec3 moved = phymul::Vec3::Zero();
  for (std::size_t k = 0; k < particles_.size(); ++k) {
    moved += weights_[k] * (state.position[particles_[k]] - place_[k]);
  }
  return rest_ + moved;
}

Curve::Curve(const std::string& path, const std::string& columns) : path_(path), file_(std::fopen(path.c_str(), "w")) {
  if (!file_) throw phymul::Error(phymul::ErrorCode::file_access, path + ": cannot be written");
  std::fprintf(file_.get(), "%s\n", columns.c_str());
}

void Curve::add(std::initializer_list<double> row) {
  const char* before = "";
  for (const double value : row) {
    std::fprintf(file_.get(), "%s%.6g", before, value);
    before = ",";
  }
  std::fputc('\n', file_.get());
  if (std::fflush(file_.get()) == 0 && std::ferror(file_.get()) == 0) return;
  throw phymul::Error(phymul::ErrorCode::file_access, path_ + ": cannot be written to its end; is the disk full?");
}

void Curve::add(const std::string& name, std::initializer_list<double> row) {
  std::fprintf(file_.get(), "%s,", name.c_str());
  add(row);
}
