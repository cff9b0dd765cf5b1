// SPDX-License-Identifier: MIT
//
// Filling a ball's surface of 10,080 triangles with tetrahedra of one spacing and graded ones, and three regions of an
// image of 256^3 voxels, by spacing; items are particles. Binding that surface to the body as a skin; items are points.
#include <benchmark/benchmark.h>
#include <phymul/phymul.h>

#include <cmath>
#include <cstdint>
#include <numbers>

namespace {

phymul::Surface ball(double radius, int around, int rings) {
  phymul::Surface surface;
  surface.vertices = {{0, 0, -radius}, {0, 0, radius}};
  const auto vertex = [&](int ring, int k) { return static_cast<phymul::Index>(2 + ring * around + k % around); };
  for (int ring = 0; ring < rings; ++ring) {
    const double polar = std::numbers::pi * (ring + 1) / (rings + 1);
    for (int k = 0; k < around; ++k) {
      const double turn = 2.0 * std::numbers::pi * k / around;
      surface.vertices.push_back(
          radius * phymul::Vec3(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), -std::cos(polar)));
    }
  }
  for (int k = 0; k < around; ++k) {
    surface.triangles.push_back({0, vertex(0, k + 1), vertex(0, k)});
    surface.triangles.push_back({1, vertex(rings - 1, k), vertex(rings - 1, k + 1)});
    for (int ring = 0; ring + 1 < rings; ++ring) {
      surface.triangles.push_back({vertex(ring, k), vertex(ring, k + 1), vertex(ring + 1, k + 1)});
      surface.triangles.push_back({vertex(ring, k), vertex(ring + 1, k + 1), vertex(ring + 1, k)});
    }
  }
  return surface;
}

void make_body(benchmark::State& run) {
  const phymul::Surface surface = ball(0.05, 72, 70);
  phymul::BodyReport report;
  for (auto _ : run) {
    phymul::make_body(surface, {.spacing = 1e-6 * static_cast<double>(run.range(0))}, &report);
  }
  run.SetItemsProcessed(run.iterations() * report.particles);
  run.counters["triangles"] = static_cast<double>(surface.triangles.size());
  run.counters["particles"] = report.particles;
  run.counters["volume_error"] = report.volume / report.wanted_volume - 1.0;
  run.counters["smallest_angle"] = report.smallest_angle;
}

/// Eight times finer near a place on the surface.
void make_graded_body(benchmark::State& run) {
  const phymul::Surface surface = ball(0.05, 72, 70);
  const double spacing = 1e-6 * static_cast<double>(run.range(0));
  phymul::BodyReport report;
  for (auto _ : run) {
    phymul::make_body(surface,
                      {.spacing = spacing, .spacing_at = phymul::fine_near({0, 0.05, 0}, 0.01, spacing / 8, spacing)},
                      &report);
  }
  run.SetItemsProcessed(run.iterations() * report.particles);
  run.counters["particles"] = report.particles;
  run.counters["smallest_angle"] = report.smallest_angle;
}

void bind_skin(benchmark::State& run) {
  const phymul::Surface surface = ball(0.05, 72, 70);
  const phymul::Model body = phymul::make_body(surface, {.spacing = 1e-6 * static_cast<double>(run.range(0))});
  for (auto _ : run) benchmark::DoNotOptimize(phymul::Skin(body, surface.vertices));
  run.SetItemsProcessed(run.iterations() * static_cast<std::int64_t>(surface.vertices.size()));
  run.counters["particles"] = body.particle_count();
}

/// Voxels of 1 mm: two ellipsoids, and a vessel in one of them.
phymul::LabelImage organs() {
  phymul::LabelImage image;
  image.size = {256, 256, 256};
  image.label.reserve(std::size_t{256} * 256 * 256);
  for (int k = 0; k < 256; ++k) {
    for (int j = 0; j < 256; ++j) {
      for (int i = 0; i < 256; ++i) {
        const double x = i - 78.0, y = j - 128.0, z = k - 128.0;
        const bool first = std::hypot(x / 50, y / 80, z / 70) < 1,
                   second = std::hypot((x - 110) / 60, y / 50, z / 70) < 1;
        const bool vessel = first && std::hypot(x + 10, y - 20) < 8;
        image.label.push_back(vessel ? 3 : first ? 1 : second ? 2 : 0);
      }
    }
  }
  return image;
}

void make_body_of_labels(benchmark::State& run) {
  const phymul::LabelImage image = organs();
  phymul::BodyReport report;
  const phymul::LabelBodyOptions options{.spacing = 1e-6 * static_cast<double>(run.range(0)),
                                         .regions = {{1, "first"}, {2, "second"}, {3, "vessel"}}};
  for (auto _ : run) phymul::make_body(image, options, &report);
  run.SetItemsProcessed(run.iterations() * report.particles);
  run.counters["particles"] = report.particles;
  run.counters["smallest_angle"] = report.smallest_angle;
  for (const phymul::RegionReport& region : report.regions) {
    run.counters[region.name + "_volume_error"] = region.volume / region.wanted_volume - 1.0;
  }
}

BENCHMARK(make_body)->ArgName("spacing_um")->Arg(6050)->Arg(2095)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(make_graded_body)->ArgName("spacing_um")->Arg(14800)->Arg(4600)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(bind_skin)->ArgName("spacing_um")->Arg(6050)->Arg(2095)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(make_body_of_labels)
    ->ArgName("spacing_um")
    ->Arg(6000)
    ->Arg(3000)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
