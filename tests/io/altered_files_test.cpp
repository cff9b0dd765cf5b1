// SPDX-License-Identifier: MIT
//
// Labelled images, states and recordings that were altered, in the ways of altered_meshes_test.cpp.
#include <phymul/recording.h>
#include <phymul/shapes.h>
#include <phymul/simulation.h>
#include <phymul/state_file.h>

#include <limits>
#include <sstream>

#include "altered_files.h"
#include "base/checked_file.h"
#include "label_files.h"
#include "session/snapshot_bytes.h"

namespace phymul::test {
namespace {

std::string read_altered_labels(const std::string& name, const std::string& bytes) {
  const LabelImage image = read_back(name, bytes);
  EXPECT_EQ(image.label.size(), std::size_t(image.size[0]) * std::size_t(image.size[1]) * std::size_t(image.size[2]));
  std::ostringstream out;
  out << image.size[0] << ' ' << image.size[1] << ' ' << image.size[2] << " from " << image.origin.transpose() << " by";
  for (const Vec3& step : image.step) out << ' ' << step.transpose();
  for (const std::uint16_t label : image.label) out << ' ' << label;
  return out.str();
}

TEST(AlteredLabels, Nifti) {
  PHYMUL_SKIP_UNLESS_READ("a.nii");
  constexpr float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  Nifti framed;
  framed.sform({1, 0, 0, 5, 0, 2, 0, 6, 0, 0, 3, 7});
  AlteredFiles file("a.nii", Nifti().bytes(), read_altered_labels);
  std::string swapped = file.bytes();
  for (const auto& [at, size, count] :
       {std::array<std::size_t, 3>{0, 4, 1}, {40, 2, 8}, {70, 2, 2}, {76, 4, 9}, {352, 2, 24}}) {
    for (std::size_t k = 0; k < count; ++k) {
      const auto first = swapped.begin() + static_cast<std::ptrdiff_t>(at + k * size);
      std::reverse(first, first + static_cast<std::ptrdiff_t>(size));
    }
  }
  file.hold("the other byte order", swapped, Must::be_same);
  file.put<std::int32_t>(0, {540, 0, -1}, Must::either);
  file.put<std::int16_t>(40, {0, -3, 2, 8, 32767}, Must::fail);  // dimensions
  file.put<std::int16_t>(40, {4}, Must::be_same);
  file.put<std::int16_t>(42, {0, -4, 5, 32767}, Must::fail);
  file.put<std::int16_t>(70, {0, 1, 2, 8, 16, 64, 128, 256, 1024, 4096}, Must::fail);  // types not of 16 bits
  file.put<std::int16_t>(70, {512}, Must::be_same);
  file.put<float>(80, {0.0f, nan, infinity}, Must::any);                                  // widths of voxels
  file.put<float>(108, {0.0f, -1.0f, nan, infinity, 1e30f, 354.0f, 400.0f}, Must::fail);  // where the voxels begin
  file.put<float>(112, {2.0f}, Must::fail);                                               // a scale
  file.put<char>(345, {'i', '-'}, Must::fail);
  file.damage(12, 20, Must::fail);
  file.damage_bytes(150);
  AlteredFiles("b.nii", framed.bytes(), read_altered_labels).put<float>(280, {0.0f, nan, infinity}, Must::fail);
  Nifti large;  // enough that zlib could stop before the checksum
  large.dimensions({3, 64, 32, 20, 1, 1, 1, 1});
  std::vector<std::int16_t> noise(64 * 32 * 20);
  std::mt19937 random(3);
  for (std::int16_t& label : noise) label = static_cast<std::int16_t>(random() % 8);
  large.voxels = bytes_of(noise);
  for (const std::string& bytes : {framed.bytes(), large.bytes()}) {
    AlteredFiles zip("a.nii.gz", zipped(bytes), read_altered_labels);
    zip.damage(15, 40, Must::either, Must::either, 10);
    zip.damage_bytes(60, Must::either, 10);
  }
}

TEST(AlteredLabels, Nrrd) {
  PHYMUL_SKIP_UNLESS_READ("a.nrrd");
  AlteredFiles file("a.nrrd", nrrd(plain + raw + "spacings: 1 2 3\n"), read_altered_labels);
  file.alter(R"(
= type: short | # labels\ntype: short | type: int16   ~ NRRD0004 | NRRD0001   ! NRRD0004 | NRRD0009 | NRRX0004
! type: short | type: int | type: float | type: long long int | type: short\ntype: int   ! type: short\n | _
! dimension: 3 | dimension: 2 | dimension: 4 | dimension: 0   ! dimension: 3\n | _
! sizes: 4 | sizes: 5 | sizes: 0 | sizes: -4 | sizes: 4000000000   ! sizes: 4 3 2 | sizes: 4 3 | sizes: 4 3 2 1
! endian: little\n | _   ! endian: little | endian: middle
! encoding: raw | encoding: gzip | encoding: text | encoding: hex   ! encoding: raw\n | _
! spacings: 1 2 3 | spacings: 0 2 3 | spacings: 1 inf 3 | spacings: 1 2 | spacings: a b c)");
  file.hold("a voxel too many", file.bytes() + std::string(2, '\0'), Must::either);
  file.damage(12, 20, Must::fail);
  file.damage_bytes(150, Must::either, file.bytes().find("\n\n"));
  AlteredFiles zip("b.nrrd", nrrd(plain + "encoding: gzip\n", zipped(bytes_of(counted()))), read_altered_labels);
  zip.damage(12, 60, Must::either, Must::either, zip.bytes().find("\n\n") + 12);
  zip.damage_bytes(40);
}

TEST(AlteredStates, FilesAndRecordings) {
  Simulation sim(make_block({0.02, 0.02, 0.02}, 1, 1, 1));
  sim.record();
  sim.advance(0.01);
  const TextFile state("a.state", ""), recording("a.rec", "");
  sim.save(state.path());
  save_recording(sim.recording(), recording.path());
  const auto text_of_snapshot = [](const Snapshot& snapshot) {
    ByteWriter out;
    put_snapshot(out, snapshot);
    return out.bytes();
  };
  const std::string state_bytes = text_of(state.path()), recording_bytes = text_of(recording.path());
  AlteredFiles one("a.state", state_bytes, [&](const std::string& name, const std::string& bytes) {
    const TextFile file(name, bytes);
    return text_of_snapshot(read_state(file.path()));
  });
  AlteredFiles two("a.rec", recording_bytes, [&](const std::string& name, const std::string& bytes) {
    const TextFile file(name, bytes);
    const Recording read = read_recording(file.path());
    return text_of_snapshot(read.start) + read.scene + std::to_string(read.inputs.size());
  });
  for (AlteredFiles* file : {&one, &two}) {
    file->damage(15, 30, Must::fail, Must::fail);
    file->damage_bytes(230, Must::fail);
    file->hold("twice", file->bytes() + file->bytes(), Must::fail);
    file->hold("a byte more", file->bytes() + 'x', Must::fail);
  }
}

}  // namespace
}  // namespace phymul::test
