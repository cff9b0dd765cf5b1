// SPDX-License-Identifier: MIT
#include "voxels.h"

#ifdef PHYMUL_HAS_NIFTI
#include <nifti1_io.h>

#include <cmath>
#include <cstdlib>
#include <memory>

#include "base/decimal.h"
#include "base/file_error.h"

namespace phymul {
namespace {

constexpr IntegerCode integers[] = {
    {DT_INT8, NumberType::int8},     {DT_UINT8, NumberType::uint8},   {DT_INT16, NumberType::int16},
    {DT_UINT16, NumberType::uint16}, {DT_INT32, NumberType::int32},   {DT_UINT32, NumberType::uint32},
    {DT_INT64, NumberType::int64},   {DT_UINT64, NumberType::uint64},
};

/// Metres.
double unit_of(const std::string& path, int xyz_units) {
  if (xyz_units == NIFTI_UNITS_METER) return 1.0;
  if (xyz_units == NIFTI_UNITS_MM || xyz_units == NIFTI_UNITS_UNKNOWN) return 1e-3;
  if (xyz_units == NIFTI_UNITS_MICRON) return 1e-6;
  fail_format(
      path, 0,
      "expected lengths in metres, millimetres or micrometres (xyzt_units), got unit " + std::to_string(xyz_units));
}

void set_frame(const nifti_image& file, double unit, LabelImage& image) {
  const mat44& frame = file.sform_code > 0 ? file.sto_xyz : file.qto_xyz;
  for (int row = 0; row < 3; ++row) {
    for (int axis = 0; axis < 3; ++axis) image.step[axis][row] = unit * frame.m[row][axis];
    image.origin[row] = unit * frame.m[row][3];
  }
}

NumberType type_of(const std::string& path, const nifti_1_header& header) {
  const NumberType type = integer_type(path, integers, header.datatype, nifti_datatype_string(header.datatype));
  if (std::isfinite(header.scl_slope) && header.scl_slope != 0.0f &&
      !(header.scl_slope == 1.0f && header.scl_inter == 0.0f)) {
    fail_format(path, 0,
                "expected labels as they are, got values to be scaled by " + to_decimal(header.scl_slope) +
                    " and shifted by " + to_decimal(header.scl_inter) + " (scl_slope, scl_inter)");
  }
  return type;
}

std::vector<std::int64_t> sizes_of(const std::string& path, const nifti_1_header& header) {
  std::vector<std::int64_t> sizes(header.dim + 1, header.dim + 1 + header.dim[0]);
  while (sizes.size() > 3 && sizes.back() == 1) sizes.pop_back();
  if (sizes.size() == 3) return sizes;
  fail_format(
      path, 0,
      "expected an image of three dimensions, got " + std::to_string(sizes.size()) + "; save one label image of it");
}

/// Not by nifti_image_load, which fills up with zeros what a file lacks.
std::vector<std::uint16_t> read_voxels(const std::string& path, const nifti_1_header& header, bool is_swapped,
                                       std::size_t count, NumberType type) {
  const std::size_t each = size_of(type), bytes = count * each;
  require_voxel_bytes(path, count, type, most_inflation);
  const float offset = header.vox_offset;
  if (!(offset >= 348.0f && offset < 0x1p30f)) {
    fail_format(path, 0, "expected voxels behind the header of 348 bytes, got vox_offset " + to_decimal(offset));
  }
  std::vector<char> voxels(bytes);
  znzFile file = znzopen(path.c_str(), "rb", nifti_is_gzfile(path.c_str()));
  if (!file) fail_access(path, "the file cannot be opened");
  const bool is_whole =
      znzseek(file, static_cast<long>(offset), SEEK_SET) >= 0 && znzread(voxels.data(), 1, bytes, file) == bytes;
  znzclose(file);
  if (!is_whole) fail_missing_voxels(path, count, type);
  if (is_swapped && each > 1) nifti_swap_Nbytes(count, static_cast<int>(each), voxels.data());
  return labels_of(path, voxels.data(), count, type);
}

}  // namespace

LabelImage read_nifti(const std::string& path) {
  nifti_set_debug_level(0);  // it would print to stderr
  int is_swapped = 0;
  const std::unique_ptr<nifti_1_header, void (*)(void*)> header(nifti_read_header(path.c_str(), &is_swapped, 0),
                                                                std::free);
  if (!header || !nifti_hdr_looks_good(header.get()) || !NIFTI_ONEFILE(*header)) {
    fail_format(path, 0, "expected a header of NIfTI-1 with its voxels in the same file (magic \"n+1\"), got another");
  }
  const NumberType type = type_of(path, *header);
  const std::vector<std::int64_t> sizes = sizes_of(path, *header);
  const std::size_t count = voxel_count(path, sizes, type);

  const std::unique_ptr<nifti_image, void (*)(nifti_image*)> file(nifti_convert_nhdr2nim(*header, path.c_str()),
                                                                  nifti_image_free);
  if (!file) fail_format(path, 0, "expected a header that makes an image of NIfTI-1");
  LabelImage image;
  image.size = {static_cast<Index>(sizes[0]), static_cast<Index>(sizes[1]), static_cast<Index>(sizes[2])};
  set_frame(*file, unit_of(path, file->xyz_units), image);
  if (file->sform_code <= 0 && file->qform_code <= 0) {
    image.notes.push_back(path + ": says nothing about its frame; taken to begin at 0, along x, y and z");
  }
  image.label = read_voxels(path, *header, is_swapped != 0, count, type);
  return image;
}

}  // namespace phymul

#else

namespace phymul {

LabelImage read_nifti(const std::string& path) {
  fail_without(path, "nifticlib", "libnifti-dev");
}

}  // namespace phymul

#endif
