// SPDX-License-Identifier: MIT
//
// Files of labelled images, byte by byte.
#pragma once

#include <gtest/gtest.h>
#include <phymul/label_file.h>
#include <zlib.h>

#include <cstring>
#include <string>
#include <vector>

#include "support/message_of.h"
#include "support/text_file.h"

namespace phymul::test {

template <class Number>
std::string bytes_of(const std::vector<Number>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number)};
}

/// As gzip writes it.
inline std::string zipped(const std::string& bytes) {
  const TextFile file("zipped/a.gz", "");
  const gzFile out = gzopen(file.path().c_str(), "wb");
  gzwrite(out, bytes.data(), static_cast<unsigned>(bytes.size()));
  gzclose(out);
  return text_of(file.path());
}

/// 4 x 3 x 2 labels, each once.
inline std::vector<std::int16_t> counted() {
  std::vector<std::int16_t> labels(24);
  for (int i = 0; i < 24; ++i) labels[i] = static_cast<std::int16_t>(i);
  return labels;
}

/// The file of a NIfTI-1 image: a header of 348 bytes, 4 that say that no extension follows, the voxels.
class Nifti {
 public:
  Nifti() {
    set<std::int32_t>(0, 348);
    dimensions({3, 4, 3, 2, 1, 1, 1, 1});
    set<std::int16_t>(70, 4);  // datatype: int16
    set<std::int16_t>(72, 16);
    for (const int axis : {0, 1, 2, 3, 4}) set(76 + 4 * axis, 1.0f);  // pixdim
    set(108, 352.0f);                                                 // vox_offset
    set<char>(123, 2);                                                // mm
    std::memcpy(&header_[344], "n+1", 4);
  }
  void dimensions(const std::vector<std::int16_t>& dim) {
    for (std::size_t k = 0; k < dim.size(); ++k) set(40 + 2 * k, dim[k]);
  }
  template <class Number>
  void set(std::size_t at, Number value) {
    std::memcpy(&header_[at], &value, sizeof value);
  }
  void sform(const std::vector<float>& rows) {
    set<std::int16_t>(254, 1);
    for (std::size_t k = 0; k < rows.size(); ++k) set(280 + 4 * k, rows[k]);
  }
  std::string voxels = bytes_of(counted());
  std::string bytes() const { return header_ + voxels; }

 private:
  std::string header_ = std::string(352, '\0');
};

inline std::string reading_labels(const std::string& name, const std::string& bytes) {
  const TextFile file(name, bytes);
  return message_of([&] { read_labels(file.path()); });
}

inline LabelImage read_back(const std::string& name, const std::string& bytes) {
  const TextFile file(name, bytes);
  return read_labels(file.path());
}

inline void expect_counted(const LabelImage& image) {
  EXPECT_EQ(image.size, (std::array<Index, 3>{4, 3, 2}));
  ASSERT_EQ(image.label.size(), 24u);
  for (int i = 0; i < 24; ++i) EXPECT_EQ(image.label[i], i);
}

inline void expect_frame(const LabelImage& image, const Vec3& origin, const std::array<Vec3, 3>& step) {
  EXPECT_LT((image.origin - origin).norm(), 1e-8) << image.origin.transpose();
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LT((image.step[axis] - step[axis]).norm(), 1e-8) << image.step[axis].transpose();
  }
}

/// Whether this build reads the format: without the library the Error says so.
inline bool reads(const std::string& name) {
  return reading_labels(name, "").find("phymul was built without") == std::string::npos;
}

#define PHYMUL_SKIP_UNLESS_READ(name) \
  if (!reads(name)) GTEST_SKIP() << reading_labels(name, "")

inline std::string nrrd(const std::string& fields, const std::string& voxels = bytes_of(counted())) {
  return "NRRD0004\n" + fields + "\n" + voxels;
}

inline const std::string plain = "type: short\ndimension: 3\nsizes: 4 3 2\nendian: little\n";
inline const std::string raw = "encoding: raw\n";
inline const std::string directions = "space directions: (1,0,0) (0,2,0) (0,0,3)\nspace origin: (10,20,30)\n";

}  // namespace phymul::test
