// SPDX-License-Identifier: MIT
#include "voxels.h"

#ifdef PHYMUL_HAS_NIFTI
#include <nifti1_io.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>

#include "base/decimal.h"
#include "base/files.h"

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

using Frame = Eigen::Matrix<double, 3, 4>;  // m: steps along i, j and k, and the centre of the first voxel

Frame frame_of(const mat44& frame, double unit) {
  using Rows = Eigen::Matrix<float, 4, 4, Eigen::RowMajor>;
  return unit * Eigen::Map<const Rows>(&frame.m[0][0]).topRows<3>().cast<double>();
}

/// To which sides of a patient i, j and k run, "RAS".
std::string sides_of(const mat44& frame) {
  std::array<int, 3> way{};  // 1: to the right, 2: to the left, ...
  nifti_mat44_to_orientation(frame, &way[0], &way[1], &way[2]);
  return {"?RLAPSI"[way[0]], "?RLAPSI"[way[1]], "?RLAPSI"[way[2]]};
}

/// Throws Error where one is the mirror image of the other.
void compare_frames(const std::string& path, const nifti_image& file, double unit, LabelImage& image) {
  const Frame sform = frame_of(file.sto_xyz, unit), qform = frame_of(file.qto_xyz, unit);
  double apart = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector4d voxel(0.0, 0.0, 0.0, 1.0);
    for (int axis = 0; axis < 3; ++axis) voxel[axis] = (corner >> axis & 1) * (image.size[axis] - 1);
    apart = std::max(apart, ((sform - qform) * voxel).norm());
  }
  // As much as rounding of a quaternion in single precision may move voxels.
  if (apart <= 0.05 * sform.leftCols<3>().colwise().norm().minCoeff()) return;
  const std::string both = "sform (i, j and k run to " + sides_of(file.sto_xyz) + ") and qform (to " +
                           sides_of(file.qto_xyz) + ") place voxels up to " + length_text(1e3 * apart) + " mm apart",
                    choice = "LabelFileOptions::nifti_frame chooses";
  if (sform.leftCols<3>().determinant() * qform.leftCols<3>().determinant() < 0.0) {
    fail_format(path, 0,
                "expected frames that agree, but " + both + " and mirror left and right, or another pair of " +
                    "sides; " + choice + ", or store the right one as both");
  }
  image.notes.push_back(path + ": " + both + "; the sform is used, " + choice);
}

/// Of a frame by pixdim and quatern: nifticlib takes 1 for what is 0 or no number, and turns what is no turn.
void require_turn(const std::string& path, const nifti_1_header& header) {
  for (const int axis : {1, 2, 3}) {
    if (const float size = header.pixdim[axis]; !(size > 0.0f && std::isfinite(size))) {
      fail_format(path, 0, "expected sizes of voxels above 0, got " + to_decimal(size) + " (pixdim)");
    }
  }
  const double squares = Vec3(header.quatern_b, header.quatern_c, header.quatern_d).squaredNorm();
  const bool is_placed = Vec3(header.qoffset_x, header.qoffset_y, header.qoffset_z).allFinite();
  if (header.qform_code <= 0 || (is_placed && squares <= 1.0 + 1e-4)) return;
  fail_format(path, 0,
              "expected a qform of a unit quaternion and a finite offset, got b^2 + c^2 + d^2 = " +
                  to_decimal(squares) + (is_placed ? "" : " and an offset that is not"));
}

void set_frame(const std::string& path, const nifti_image& file, double unit, NiftiFrame asked, LabelImage& image) {
  const bool has_sform = file.sform_code > 0, has_qform = file.qform_code > 0;
  if (asked == NiftiFrame::sform && !has_sform) fail_format(path, 0, "expected an sform, got none (sform_code 0)");
  if (asked == NiftiFrame::qform && !has_qform) fail_format(path, 0, "expected a qform, got none (qform_code 0)");
  if (asked == NiftiFrame::either && has_sform && has_qform) compare_frames(path, file, unit, image);
  if (!has_sform && !has_qform) {
    image.notes.push_back(path + ": says nothing about its frame; taken to begin at 0, along x, y and z");
  }
  const Frame frame = frame_of(has_sform && asked != NiftiFrame::qform ? file.sto_xyz : file.qto_xyz, unit);
  for (int axis = 0; axis < 3; ++axis) image.step[axis] = frame.col(axis);
  image.origin = frame.col(3);
}

NumberType type_of(const std::string& path, const nifti_1_header& header) {
  const NumberType type = integer_type(path, integers, header.datatype, nifti_datatype_string(header.datatype));
  if (std::isfinite(header.scl_slope) && header.scl_slope != 0.0f &&
      !(header.scl_slope == 1.0f && header.scl_inter == 0.0f)) {
    fail_format(path, 0,
                "expected labels as they are, got values to be scaled by " + to_decimal(header.scl_slope) +
                    " and shifted by " + to_decimal(header.scl_inter) + " (scl_slope, scl_inter)");
  }
  if (header.bitpix != 0 && header.bitpix != static_cast<int>(8 * size_of(type))) {
    fail_format(path, 0,
                std::string("expected voxels of ") + std::to_string(8 * size_of(type)) + " bits, as type " +
                    nifti_datatype_string(header.datatype) + " has them, got bitpix " + std::to_string(header.bitpix) +
                    "; the header is damaged");
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
  const std::size_t bytes = count * size_of(type);
  require_voxel_bytes(path, count, type);
  const float offset = header.vox_offset;
  if (!(offset >= 348.0f && offset < 0x1p30f)) {
    fail_format(path, 0, "expected voxels behind the header of 348 bytes, got vox_offset " + to_decimal(offset));
  }
  std::vector<char> voxels(bytes);
  znzFile file = znzopen(path.c_str(), "rb", nifti_is_gzfile(path.c_str()));
  if (!file) fail_access(path, "the file cannot be opened");
  const bool is_whole =
      znzseek(file, static_cast<long>(offset), SEEK_SET) >= 0 && znzread(voxels.data(), 1, bytes, file) == bytes;
  // zlib compares the checksum where it comes to the end, and says only when closed that the end is cut off. More
  // voxels are no fault.
  std::array<char, 4096> rest{};
  std::size_t read = rest.size(), more = 0;
  for (; read == rest.size(); more += read) read = znzread(rest.data(), 1, rest.size(), file);
  const bool is_sound = znzclose(file) == 0 && read < rest.size();
  if (is_whole && !is_sound)
    fail_format(path, 0, "expected compressed voxels of another checksum; the file is damaged");
  if (!is_whole) fail_missing_voxels(path, count, type);
  require_whole_voxels(path, more, type);
  ByteSource in(path, {voxels.data(), voxels.size()});
  in.use_binary(is_swapped);
  return labels_of(path, in, count, type);
}

bool is_nifti_2(const std::string& path) {
  char start[7] = {};
  znzFile file = znzopen(path.c_str(), "rb", nifti_is_gzfile(path.c_str()));
  if (file) znzread(start, 1, sizeof start, file), znzclose(file);
  return start[4] == 'n' && start[6] == '2';
}

}  // namespace

LabelImage read_nifti(const std::string& path, const LabelFileOptions& options) {
  nifti_set_debug_level(0);  // it would print to stderr
  int is_swapped = 0;
  const std::unique_ptr<nifti_1_header, void (*)(void*)> header(nifti_read_header(path.c_str(), &is_swapped, 0),
                                                                std::free);
  if (!header || !nifti_hdr_looks_good(header.get()) || !NIFTI_ONEFILE(*header)) {
    fail_format(path, 0,
                std::string("expected a header of NIfTI-1 with its voxels in the same file (magic \"n+1\"), got ") +
                    (is_nifti_2(path) ? "one of NIfTI-2; save it as NIfTI-1" : "another"));
  }
  const NumberType type = type_of(path, *header);
  const std::vector<std::int64_t> sizes = sizes_of(path, *header);
  const std::size_t count = voxel_count(path, sizes, type);

  const std::unique_ptr<nifti_image, void (*)(nifti_image*)> file(nifti_convert_nhdr2nim(*header, path.c_str()),
                                                                  nifti_image_free);
  if (!file) fail_format(path, 0, "expected a header that makes an image of NIfTI-1");
  if (header->sform_code <= 0 || options.nifti_frame == NiftiFrame::qform) require_turn(path, *header);
  LabelImage image;
  image.size = {static_cast<Index>(sizes[0]), static_cast<Index>(sizes[1]), static_cast<Index>(sizes[2])};
  set_frame(path, *file, unit_of(path, file->xyz_units), options.nifti_frame, image);
  image.label = read_voxels(path, *header, is_swapped != 0, count, type);
  return image;
}

}  // namespace phymul

#else

namespace phymul {

LabelImage read_nifti(const std::string& path, const LabelFileOptions&) {
  fail_without(path, "nifticlib", "libnifti-dev");
}

}  // namespace phymul

#endif
