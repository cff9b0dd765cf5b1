// SPDX-License-Identifier: MIT
//
// Bodies of several regions: a labelled image is filled, and its cells are given to regions.
#include <phymul/labels.h>
#include <phymul/surface.h>

#include <algorithm>

#include "base/place_text.h"
#include "filling.h"
#include "label_field.h"
#include "model/cell_geometry.h"
#include "model/group.h"
#include "region_interfaces.h"

namespace phymul {
namespace {

/// [cells] of the region with the largest share at the cell's centre.
std::vector<int> regions_of_cells(const Model& model, const LabelField& field) {
  std::vector<int> regions;
  regions.reserve(model.cells.size());
  int last = 0;  // where no voxel of a region is near, at a body's point, that of the cell before
  for (const Cell& cell : model.cells) {
    const int own = field.shares(cell_centre(cell, model.rest)).largest();
    if (own >= 0) last = own;
    regions.push_back(last);
  }
  return regions;
}

/// Makes the groups, and says what became of each region.
std::vector<RegionReport> add_regions(Model& model, const LabelField& field, double spacing) {
  const std::vector<int> region = regions_of_cells(model, field);
  std::vector<std::vector<Index>> cells(field.names().size());
  for (std::size_t row = 0; row < region.size(); ++row) cells[region[row]].push_back(static_cast<Index>(row));
  std::vector<RegionReport> reports;
  for (std::size_t r = 0; r < cells.size(); ++r) {
    RegionReport& report = reports.emplace_back();
    report.name = field.names()[r];
    report.wanted_volume = field.volumes()[r];
    report.cells = static_cast<Index>(cells[r].size());
    if (cells[r].empty()) {
      model.notes.push_back("make_body: region \"" + report.name + "\" of " + length_text(1e6 * report.wanted_volume) +
                            " ml has no cell and no group: it is thinner than the spacing of " + length_text(spacing) +
                            " m; take a smaller one");
      continue;
    }
    for (const Index row : cells[r]) report.volume += cell_volume(model, model.cells[row]);
    if (model.has_group(report.name)) {
      refuse_body("expected another name than \"" + report.name + "\" for a region: every body has a group of it");
    }
    add_cell_group(model, report.name, std::move(cells[r]));
    report.particles = static_cast<Index>(model.group(report.name).size());
  }
  return reports;
}

/// Calls see(centre) for the voxels of the regions.
void each_voxel(const LabelImage& image, const std::vector<LabelRegion>& regions, const Contains& see) {
  const auto [ni, nj, nk] = image.size;
  for (std::size_t row = 0; row < image.label.size(); ++row) {
    const std::uint16_t own = image.label[row];
    if (regions.empty() ? own == 0 : std::ranges::count(regions, own, &LabelRegion::label) == 0) continue;
    const std::size_t line = row / ni;
    const Vec3 at(static_cast<double>(row % ni), static_cast<double>(line % nj), static_cast<double>(line / nj));
    see(image.origin + at.x() * image.step[0] + at.y() * image.step[1] + at.z() * image.step[2]);
  }
}

}  // namespace

Model make_body(const LabelImage& image, const LabelBodyOptions& options, BodyReport* report) {
  const LabelField field(image, options.regions);
  const BodyOptions filling{options.spacing, options.most_volume_error, options.most_particles, options.spacing_at};
  const CentredLattice lattice = lattice_over(field.low(), field.high(), filling);
  double wanted_volume = 0.0;
  for (const double volume : field.volumes()) wanted_volume += volume;
  BodyReport own;
  Model model = filled_body(
      LabelInterior(field), lattice, [&](bool) { return wanted_volume; }, filling, own,
      [&](Stuffing& body) { meet_interfaces(body, field, lattice.edge); });
  require_volume(own, filling, [&] {
    return lost_parts([&](const Contains& see) { each_voxel(image, options.regions, see); },
                      {model.rest, surface_triangles(model), {}}, filling);
  });
  own.regions = add_regions(model, field, options.spacing);
  model.notes.insert(model.notes.begin(), image.notes.begin(), image.notes.end());
  if (report) *report = std::move(own);
  return model;
}

}  // namespace phymul
