// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/label_file.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <new>
#include <string_view>

#include "base/byte_source.h"
#include "base/decimal.h"
#include "base/files.h"
#include "voxels.h"

namespace phymul {
namespace {

constexpr std::uint64_t most_bytes = std::uint64_t{1} << 31;

}  // namespace

NumberType integer_type(const std::string& path, std::span<const IntegerCode> known, int code, const char* name) {
  const auto found = std::ranges::find(known, code, &IntegerCode::code);
  if (found != known.end()) return found->type;
  fail_format(
      path, 0,
      std::string("expected integers as labels, got ") + name + "; save it anew as an image of 8 or 16 bit integers");
}

std::size_t voxel_count(const std::string& path, const std::vector<std::int64_t>& sizes, NumberType type) {
  std::string text;
  std::uint64_t count = 1;
  bool fits = true;
  for (const std::int64_t size : sizes) {
    text += (text.empty() ? "" : " x ") + std::to_string(size);
    fits = fits && size >= 1 && size <= std::numeric_limits<Index>::max() &&
           static_cast<std::uint64_t>(size) <= most_bytes / count;
    if (fits) count *= static_cast<std::uint64_t>(size);
  }
  if (!fits || count > most_bytes / size_of(type)) {
    fail_format(path, 0,
                "expected at least one voxel along each axis and 2^31 bytes in all at most, got " + text +
                    " voxels of " + std::to_string(size_of(type)) + " bytes");
  }
  return static_cast<std::size_t>(count);
}

void fail_missing_voxels(const std::string& path, std::size_t count, NumberType type) {
  fail_format(path, 0,
              "expected " + std::to_string(count) + " voxels of " + std::to_string(size_of(type)) +
                  " bytes, but the file of " + std::to_string(std::filesystem::file_size(path)) + " bytes ends before");
}

void require_whole_voxels(const std::string& path, std::uint64_t more, NumberType type) {
  if (more % size_of(type) == 0) return;
  fail_format(path, 0,
              "expected whole voxels of " + std::to_string(size_of(type)) + " bytes, got " + std::to_string(more) +
                  " bytes behind those that the header announces; the file is damaged");
}

void require_voxel_bytes(const std::string& path, std::size_t count, NumberType type) {
  constexpr std::uint64_t most = 1032;  // that deflate makes of a byte
  if (count * size_of(type) / most > std::filesystem::file_size(path)) fail_missing_voxels(path, count, type);
}

std::vector<std::uint16_t> labels_of(const std::string& path, ByteSource& in, std::size_t count, NumberType type) {
  const std::int64_t most = size_of(type) == 1 ? 255 : 65535;
  std::vector<std::uint16_t> labels(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::int64_t label = in.integer(type, "labels");
    labels[i] = static_cast<std::uint16_t>(label);
    if (label >= 0 && label <= most) continue;
    fail_format(path, 0,
                "expected labels from 0 to " + std::to_string(most) + ", got " + std::to_string(label) + " in voxel " +
                    std::to_string(i));
  }
  return labels;
}

void require_frame(const std::string& path, const LabelImage& image) {
  const auto& [a, b, c] = image.step;
  const double lengths = a.norm() * b.norm() * c.norm();
  if (image.origin.allFinite() && std::isfinite(lengths) && std::abs(a.dot(b.cross(c))) > 1e-6 * lengths) return;
  fail_format(path, 0,
              "expected a frame with voxels along three directions, got steps of " + place_text(a) + ", " +
                  place_text(b) + " and " + place_text(c) + " from " + place_text(image.origin));
}

void fail_without(const std::string& path, const std::string& what, const std::string& package) {
  throw Error(ErrorCode::not_supported,
              path + ": phymul was built without " + what + ", which reads this format; install it (Debian: " +
                  package + ") and build phymul again, or fill a LabelImage from a reader of your own",
              path);
}

LabelImage read_labels(const std::string& path, const LabelFileOptions& options) {
  const std::string name = lower_case(path);
  const auto ends_in = [&](std::string_view ending) { return std::string_view(name).ends_with(ending); };
  const bool is_nifti = ends_in(".nii") || ends_in(".nii.gz"), is_nrrd = ends_in(".nrrd") || ends_in(".nhdr");
  if (!is_nifti && !is_nrrd) {
    fail_format(path, 0, "expected a labelled image in a .nii, .nii.gz, .nrrd or .nhdr file");
  }
  open_file(path);  // or a reason is told
  try {
    LabelImage image = is_nifti ? read_nifti(path, options) : read_nrrd(path);
    require_frame(path, image);
    return image;
  } catch (const std::bad_alloc&) {
    fail_memory(path);
  }
}

}  // namespace phymul
