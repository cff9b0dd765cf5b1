// SPDX-License-Identifier: MIT
//
// A labelled image as smooth functions of the place: the share of each region, by cubic B-splines (M. Unser,
// A. Aldroubi, M. Eden, "B-spline signal processing", IEEE Trans. Signal Process. 41, 1993). The shares of all regions
// and of what is in none add up to 1.
#pragma once

#include <phymul/labels.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "interior.h"

namespace phymul {

/// Shares of the regions at one place.
struct RegionShares {
  struct Entry {
    int region;
    double share;
  };
  std::array<Entry, 64> entry;  // no more voxels reach a place
  int count = 0;
  double all = 0.0;  ///< of all regions

  double of(int region) const;
  int largest() const;  ///< region; the one that comes first in the options where shares are equal; -1: none is near
};

class LabelField {
 public:
  /// Keeps a reference to the image. Throws Error for what labels.h names.
  LabelField(const LabelImage& image, const std::vector<LabelRegion>& asked);

  const std::vector<std::string>& names() const { return names_; }  ///< of regions
  const std::vector<double>& volumes() const { return volumes_; }   ///< m^3, of the voxels of each region
  const Vec3& low() const { return low_; }                          ///< m, of a box around all regions
  const Vec3& high() const { return high_; }                        ///< m
  double voxel() const { return voxel_; }                           ///< m, the least distance between layers of voxels

  RegionShares shares(const Vec3& x) const;

 private:
  std::vector<LabelRegion> named_regions(const std::vector<LabelRegion>& asked) const;
  void set_frame();
  void sort_labels(const std::vector<LabelRegion>& regions);
  void measure_voxels(const std::vector<LabelRegion>& regions);

  const LabelImage& image_;
  std::array<Vec3, 3> row_;              // of the inverse frame: index k of a place is row_[k] . (x - origin)
  std::vector<std::string> names_;       // [regions]
  std::vector<double> volumes_;          // [regions]
  std::vector<std::int32_t> region_of_;  // [2^16] of a label; -1: none
  Vec3 low_, high_;
  double voxel_ = 0.0;
};

/// Where the regions have more than half.
class LabelInterior : public PlaceInterior {
 public:
  explicit LabelInterior(const LabelField& field) : field_(field) {}
  double exit(const Vec3& in, const Vec3& out) const override;

 private:
  bool contains(const Vec3& x) const override { return field_.shares(x).all > 0.5; }
  const LabelField& field_;
};

}  // namespace phymul
