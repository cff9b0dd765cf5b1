// SPDX-License-Identifier: MIT
#include "label_field.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/decimal.h"
#include "filling.h"
#include "interior.h"

namespace phymul {
namespace {

std::string size_text(const std::array<Index, 3>& size) {
  return std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " + std::to_string(size[2]);
}

void require_size(const LabelImage& image) {
  std::uint64_t voxels = 1;
  for (const Index n : image.size) {
    // The product of three counts below 2^21 fits in 64 bits.
    if (n < 1 || n >= 1 << 21) {
      refuse_body("expected an image of at least 1 x 1 x 1 voxels, each side below 2^21, got " + size_text(image.size));
    }
    voxels *= static_cast<std::uint64_t>(n);
  }
  if (voxels == image.label.size()) return;
  refuse_body("expected " + std::to_string(voxels) + " labels for an image of " + size_text(image.size) +
              " voxels, got " + std::to_string(image.label.size()) + " (LabelImage::label)");
}

/// Of the four voxels whose splines reach a place `t` voxels behind the second of them, 0 <= t < 1.
std::array<double, 4> spline_weights(double t) {
  const double u = 1.0 - t, tt = t * t, uu = u * u;
  return {uu * u / 6.0, 2.0 / 3.0 - 0.5 * tt * (2.0 - t), 2.0 / 3.0 - 0.5 * uu * (2.0 - u), tt * t / 6.0};
}

}  // namespace

double RegionShares::of(int region) const {
  for (int k = 0; k < count; ++k) {
    if (entry[k].region == region) return entry[k].share;
  }
  return 0.0;
}

int RegionShares::largest() const {
  int best = -1;
  for (int k = 0; k < count; ++k) {
    if (best < 0 || entry[k].share > entry[best].share ||
        (entry[k].share == entry[best].share && entry[k].region < entry[best].region)) {
      best = k;
    }
  }
  return best < 0 ? -1 : entry[best].region;
}

LabelField::LabelField(const LabelImage& image, const std::vector<LabelRegion>& asked) : image_(image) {
  require_size(image);
  set_frame();
  const std::vector<LabelRegion> regions = named_regions(asked);
  sort_labels(regions);
  measure_voxels(regions);
}

void LabelField::set_frame() {
  const auto& [a, b, c] = image_.step;
  if (!a.allFinite() || !b.allFinite() || !c.allFinite() || !image_.origin.allFinite()) {
    refuse_body("expected a finite frame of the image, got one that is not (LabelImage::origin, LabelImage::step)");
  }
  const double volume = a.dot(b.cross(c));
  if (!(std::abs(volume) > 1e-6 * a.norm() * b.norm() * c.norm())) {
    refuse_body("expected steps of the image along three directions, got " + place_text(a) + ", " + place_text(b) +
                " and " + place_text(c) + ", which lie in one plane (LabelImage::step)");
  }
  row_ = {b.cross(c) / volume, c.cross(a) / volume, a.cross(b) / volume};
  voxel_ = 1.0 / std::max({row_[0].norm(), row_[1].norm(), row_[2].norm()});
}

/// Those that were asked for, or all labels of the image but 0.
std::vector<LabelRegion> LabelField::named_regions(const std::vector<LabelRegion>& asked) const {
  if (!asked.empty()) return asked;
  std::vector<char> there(1 << 16, 0);
  for (const std::uint16_t label : image_.label) there[label] = 1;
  std::vector<LabelRegion> regions;
  for (std::size_t label = 1; label < there.size(); ++label) {
    if (!there[label]) continue;
    const auto own = static_cast<std::uint16_t>(label);
    const auto named = image_.names.find(own);
    const bool has_name = named != image_.names.end() && !named->second.empty();
    regions.push_back({own, has_name ? named->second : "label " + std::to_string(label)});
  }
  if (regions.empty()) refuse_body("expected an image with labels above 0, got one with label 0 alone");
  return regions;
}

void LabelField::sort_labels(const std::vector<LabelRegion>& regions) {
  region_of_.assign(1 << 16, -1);
  for (const auto& [label, name] : regions) {
    if (label == 0) refuse_body("expected labels above 0 for regions, got 0 (\"" + name + "\"), where nothing is");
    if (name.empty()) refuse_body("expected a name for the region of label " + std::to_string(label));
    if (name == "surface") {
      refuse_body("expected another name than \"surface\" for a region: it is the group of the particles there");
    }
    if (region_of_[label] >= 0) {
      refuse_body("expected each label once, got label " + std::to_string(label) + " for \"" +
                  names_[region_of_[label]] + "\" and for \"" + name + "\"");
    }
    const auto known = std::ranges::find(names_, name);
    region_of_[label] = static_cast<std::int32_t>(known - names_.begin());
    if (known == names_.end()) names_.push_back(name);
  }
}

void LabelField::measure_voxels(const std::vector<LabelRegion>& regions) {
  std::vector<std::int64_t> count(1 << 16, 0);
  std::array<Index, 3> first = image_.size, last{-1, -1, -1};
  std::size_t voxel = 0;
  for (Index k = 0; k < image_.size[2]; ++k) {
    for (Index j = 0; j < image_.size[1]; ++j) {
      for (Index i = 0; i < image_.size[0]; ++i, ++voxel) {
        const std::uint16_t label = image_.label[voxel];
        if (region_of_[label] < 0) continue;
        ++count[label];
        const std::array<Index, 3> at{i, j, k};
        for (int axis = 0; axis < 3; ++axis) {
          first[axis] = std::min(first[axis], at[axis]);
          last[axis] = std::max(last[axis], at[axis]);
        }
      }
    }
  }
  const double voxel_volume = std::abs(image_.step[0].dot(image_.step[1].cross(image_.step[2])));
  volumes_.assign(names_.size(), 0.0);
  for (const auto& [label, name] : regions) {
    if (count[label] == 0) {
      refuse_body("expected label " + std::to_string(label) + " (\"" + name + "\") in the image, but no voxel has it");
    }
    volumes_[region_of_[label]] += voxel_volume * static_cast<double>(count[label]);
  }
  low_ = Vec3::Constant(std::numeric_limits<double>::infinity());
  high_ = -low_;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 x = image_.origin;
    for (int axis = 0; axis < 3; ++axis) {
      // Half a voxel behind its centre; smoothing rounds corners off and moves no face.
      x += (corner >> axis & 1 ? last[axis] + 0.5 : first[axis] - 0.5) * image_.step[axis];
    }
    low_ = low_.cwiseMin(x);
    high_ = high_.cwiseMax(x);
  }
}

RegionShares LabelField::shares(const Vec3& x) const {
  RegionShares shares;
  std::array<std::array<double, 4>, 3> weight;
  std::array<Index, 3> first{};
  for (int axis = 0; axis < 3; ++axis) {
    const double at = row_[axis].dot(x - image_.origin);
    if (!(at > -2.0 && at < image_.size[axis] + 1.0)) return shares;
    const double before = std::floor(at);
    first[axis] = static_cast<Index>(before) - 1;
    weight[axis] = spline_weights(at - before);
  }
  for (int c = 0; c < 4; ++c) {
    const Index k = first[2] + c;
    if (k < 0 || k >= image_.size[2]) continue;
    for (int b = 0; b < 4; ++b) {
      const Index j = first[1] + b;
      if (j < 0 || j >= image_.size[1]) continue;
      const double of_row = weight[2][c] * weight[1][b];
      const std::size_t row = (static_cast<std::size_t>(k) * image_.size[1] + j) * image_.size[0];
      for (int a = 0; a < 4; ++a) {
        const Index i = first[0] + a;
        if (i < 0 || i >= image_.size[0]) continue;
        const int region = region_of_[image_.label[row + i]];
        if (region < 0) continue;
        const double share = of_row * weight[0][a];
        int own = 0;
        while (own < shares.count && shares.entry[own].region != region) ++own;
        if (own == shares.count) shares.entry[shares.count++] = {region, 0.0};
        shares.entry[own].share += share;
        shares.all += share;
      }
    }
  }
  return shares;
}

double LabelInterior::exit(const Vec3& in, const Vec3& out) const {
  return root_between([&](double share) { return 0.5 - field_.shares(in + share * (out - in)).all; });
}

}  // namespace phymul
