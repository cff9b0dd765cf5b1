// SPDX-License-Identifier: MIT
//
// Labelled images that say where they are in two ways, in several units, and in layers.
#include <gtest/gtest.h>

#include "label_files.h"

namespace phymul::test {
namespace {

/// 4 x 3 x 2 voxels of 1 mm, from (-10, 20, 30) mm by the sform, from (-10 + shift, 20, 30) mm by the qform.
Nifti two_frames(float shift = 0.0f) {
  Nifti file;
  file.sform({1, 0, 0, -10, 0, 1, 0, 20, 0, 0, 1, 30});
  file.set<std::int16_t>(252, 1);
  for (int axis = 0; axis < 3; ++axis) file.set(268 + 4 * axis, std::array{shift - 10.0f, 20.0f, 30.0f}[axis]);
  return file;
}

LabelImage read_framed(const Nifti& file, NiftiFrame frame = NiftiFrame::either) {
  const TextFile on_disk("two.nii", file.bytes());
  return read_labels(on_disk.path(), {.nifti_frame = frame});
}

TEST(LabelFrames, SformAndQformThatDisagreeAreNoted) {
  PHYMUL_SKIP_UNLESS_READ("a.nii");
  EXPECT_TRUE(read_framed(two_frames()).notes.empty());
  EXPECT_TRUE(read_framed(two_frames(0.04f)).notes.empty());  // as rounding moves them
  Nifti file = two_frames(7.5f);
  const LabelImage image = read_framed(file), by_qform = read_framed(file, NiftiFrame::qform);
  EXPECT_NEAR(image.origin.x(), -0.01, 1e-8);
  EXPECT_TRUE(says(image.notes.at(0), "two.nii: sform", "qform", "7.5 mm apart", "sform is used", "nifti_frame"));
  EXPECT_NEAR(by_qform.origin.x(), -0.0025, 1e-8);
  EXPECT_TRUE(by_qform.notes.empty());  // the caller knows
  EXPECT_NEAR(read_framed(file, NiftiFrame::sform).origin.x(), -0.01, 1e-8);
  // Half a turn about z: left is right, and no axis is mirrored.
  file = two_frames();
  file.set(264, 1.0f);
  EXPECT_TRUE(says(read_framed(file).notes.at(0), "RAS", "LPS", "7.2111 mm apart"));  // (6, 4, 0) mm
  file.set<std::int16_t>(254, 0);
  EXPECT_TRUE(refuses([&] { read_framed(file, NiftiFrame::sform); }, "expected an sform, got none (sform_code 0)"));
  // Mirrored: refused unless one is chosen.
  file = two_frames();
  file.sform({-1, 0, 0, -10, 0, 1, 0, 20, 0, 0, 1, 30});
  EXPECT_TRUE(refuses([&] { read_framed(file); }, "two.nii: ", "LAS", "RAS", "left and right", "nifti_frame"));
  EXPECT_LT(read_framed(file, NiftiFrame::sform).step[0].x(), 0.0);
  EXPECT_GT(read_framed(file, NiftiFrame::qform).step[0].x(), 0.0);
}

/// Without a space, and in one with directions or with spacings alone.
TEST(LabelFrames, UnitsOfNrrd) {
  PHYMUL_SKIP_UNLESS_READ("a.nrrd");
  const std::string space = "space: RAS\n", spacings = "spacings: 1 1 1\n";
  for (const auto& [length, names] :
       std::map<double, std::vector<std::string>>{{1.0, {"m", "meter", "metre", "meters", "M"}},
                                                  {1e-2, {"cm", "centimeter", "centimetres"}},
                                                  {1e-3, {"", "mm", "millimeter", "Millimetres"}},
                                                  {1e-6, {"um", "micron", "\xc2\xb5m", "\xce\xbcm", "micrometers"}},
                                                  {1e-9, {"nm"}}}) {
    for (const std::string& name : names) {
      const std::string units = "units: \"" + name + "\" \"" + name + "\" \"" + name + "\"\n";
      for (const std::string& fields :
           {spacings + units, space + "space " + units + directions, space + spacings + units}) {
        EXPECT_EQ(read_back("a.nrrd", nrrd(plain + fields + raw)).step[0].x(), length) << fields;
      }
    }
  }
  const LabelImage mixed = read_back("a.nrrd", nrrd(plain + spacings + "units: \"cm\" \"cm\" \"mm\"\n" + raw));
  expect_frame(mixed, {0, 0, 0}, {Vec3(1e-2, 0, 0), Vec3(0, 1e-2, 0), Vec3(0, 0, 1e-3)});
}

/// As 3D Slicer writes segments that overlap: two layers of 4 x 3 x 2 voxels, the axis of the layers first.
TEST(LabelFrames, NrrdInLayers) {
  PHYMUL_SKIP_UNLESS_READ("a.nrrd");
  std::vector<std::uint8_t> voxels(48);
  for (int i = 0; i < 12; ++i) voxels[2 * i] = 1;       // the liver
  voxels[2 * 3 + 1] = voxels[2 * 4 + 1] = 1;            // the tumour: inside of it
  for (int i = 10; i < 24; ++i) voxels[2 * i + 1] = 2;  // the vessel: partly
  const auto file = [&](const std::string& kind) {
    return nrrd("type: uchar\ndimension: 4\nsizes: 2 4 3 2\nkinds: " + kind +
                    " domain domain domain\nspace: RAS\n"
                    "space directions: none (1,0,0) (0,2,0) (0,0,3)\n" +
                    raw +
                    "Segment0_Name:=liver\nSegment0_LabelValue:=1\nSegment0_Layer:=0\n"
                    "Segment1_Name:=tumour\nSegment1_LabelValue:=1\nSegment1_Layer:=1\n"
                    "Segment2_Name:=vessel\nSegment2_LabelValue:=2\nSegment2_Layer:=1\n",
                bytes_of(voxels));
  };
  const LabelImage image = read_back("a.seg.nrrd", file("list"));
  EXPECT_EQ(image.size, (std::array<Index, 3>{4, 3, 2}));
  expect_frame(image, {0, 0, 0}, {Vec3(1e-3, 0, 0), Vec3(0, 2e-3, 0), Vec3(0, 0, 3e-3)});
  EXPECT_EQ(image.names, (std::map<std::uint16_t, std::string>{{1, "liver"}, {2, "tumour"}, {3, "vessel"}}));
  std::vector<std::uint16_t> wanted(24, 3);
  for (int i = 0; i < 12; ++i) wanted[i] = i == 3 || i == 4 ? 2 : 1;
  EXPECT_EQ(image.label, wanted);
  EXPECT_TRUE(says(image.notes.at(0), "numbered anew: 1 (liver), 2 (tumour), 3 (vessel)"));
  EXPECT_TRUE(says(image.notes.at(1), "4 voxels are in more than one segment", "smaller"));
  EXPECT_TRUE(says(reading_labels("a.nrrd", file("time")), "or a fourth of kind \"list\" for layers", "got 4"));
}

}  // namespace
}  // namespace phymul::test
