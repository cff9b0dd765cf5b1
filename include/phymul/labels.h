// SPDX-License-Identifier: MIT
//
// Bodies of several regions from a labelled image, as segmentation gives it.
#pragma once

#include <phymul/body.h>

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace phymul {

/// An image whose voxels say what is there. Read by read_labels (label_file.h) or filled by hand.
struct LabelImage {
  std::array<Index, 3> size{};       ///< voxels along i, j and k
  std::vector<std::uint16_t> label;  ///< [size[0] * size[1] * size[2]], i fastest, then j; 0: nothing is there

  /// The frame: the centre of voxel (i, j, k) is at origin + i * step[0] + j * step[1] + k * step[2]. The steps may
  /// have any length and direction, and be left-handed, but must not lie in one plane.
  Vec3 origin{0, 0, 0};                                                            ///< m
  std::array<Vec3, 3> step{Vec3(1e-3, 0, 0), Vec3(0, 1e-3, 0), Vec3(0, 0, 1e-3)};  ///< m

  std::map<std::uint16_t, std::string> names;  ///< of labels; one without is named "label 7"
  std::vector<std::string> notes;              ///< what reading found, one sentence each
};

struct LabelRegion {
  std::uint16_t label = 0;  ///< > 0
  std::string name{};       ///< labels with one name are one region
};

struct LabelBodyOptions {
  double spacing = 0.0;                ///< m, > 0: mean distance between neighbours inside the body
  std::vector<LabelRegion> regions{};  ///< what to fill; empty: every label but 0, by its name or as "label 7"
  double most_volume_error = 0.05;     ///< as in BodyOptions, of all regions together
  Index most_particles = 1'000'000;    ///< as in BodyOptions
  SpacingField spacing_at{};           ///< as in BodyOptions
};

/// Fills the regions with tetrahedra as make_body() does for a Solid (body.h). Each region is a group of cells, so that
/// set_material(model, material, name) gives a material to exactly its cells; Model::group(name) has their particles.
/// Particles between two regions are in both groups.
///
/// The labels are smoothed by a cubic B-spline (M. Unser, A. Aldroubi, M. Eden, "B-spline signal processing", IEEE
/// Trans. Signal Process. 41, 1993): at each place every label has a weight from 0 to 1. The body is where the
/// weights of all regions sum to more than 0.5; its surface is then moved until the volume is that of their voxels. A
/// cell belongs to the region of largest weight at its centre. Particles near the boundary between two regions move
/// onto it, and edges that still cross it are cut there, where all cells keep dihedral angles between 15 and 155
/// degrees, or as good as before, and heights above 0.15 of the lattice's edge. A sheet of one voxel is smoothed to 0.7
/// voxels; a line of one voxel is lost. With LabelBodyOptions::spacing_at the lattice's edge is the local one.
///
/// Model::notes has the notes of the image and names the regions that have no cell: they are thinner than the spacing.
/// BodyReport::regions compares volumes. Throws Error as make_body() does for a Solid; for an image whose sizes do not
/// fit or whose frame is singular; for a label that is 0, that no voxel has or that is given twice; for an empty name,
/// and for "surface", which is taken.
Model make_body(const LabelImage& image, const LabelBodyOptions& options, BodyReport* report = nullptr);

}  // namespace phymul
