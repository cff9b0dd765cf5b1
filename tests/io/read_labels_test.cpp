// SPDX-License-Identifier: MIT
//
// Labelled images from files written here, byte by byte: labels, frames and units come back, and what is wrong is said
// by file.
#include <gtest/gtest.h>
#include <phymul/label_file.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <random>
#include <vector>

#include "label_files.h"

namespace phymul::test {
namespace {

TEST(ReadLabels, Nifti) {
  PHYMUL_SKIP_UNLESS_READ("a.nii");
  Nifti file;
  file.sform({0.5f, 0.1f, 0, -10, 0, 0.75f, 0, 20, 0, 0, 2.0f, 30});
  const std::array<Vec3, 3> step{Vec3(0.5e-3, 0, 0), Vec3(0.1e-3, 0.75e-3, 0), Vec3(0, 0, 2e-3)};
  for (const bool is_zipped : {false, true}) {
    const LabelImage image = is_zipped ? read_back("a.nii.gz", zipped(file.bytes())) : read_back("a.NII", file.bytes());
    expect_counted(image);
    expect_frame(image, {-0.01, 0.02, 0.03}, step);
    EXPECT_TRUE(image.notes.empty());
  }
  file.set<char>(123, 3);  // micrometres
  expect_frame(read_back("a.nii", file.bytes()), {-1e-5, 2e-5, 3e-5}, {1e-3 * step[0], 1e-3 * step[1], 1e-3 * step[2]});
  file.set<char>(123, 0);  // no unit: millimetres
  expect_frame(read_back("a.nii", file.bytes()), {-0.01, 0.02, 0.03}, step);
  file.dimensions({4, 4, 3, 2, 1});
  expect_counted(read_back("a.nii", file.bytes()));
}

TEST(ReadLabels, NiftiByQuaternionOrSizesAlone) {
  PHYMUL_SKIP_UNLESS_READ("a.nii");
  Nifti file;
  for (const int axis : {0, 1, 2}) file.set(80 + 4 * axis, 1.0f + static_cast<float>(axis));
  LabelImage image = read_back("a.nii", file.bytes());
  expect_counted(image);
  expect_frame(image, {0, 0, 0}, {Vec3(1e-3, 0, 0), Vec3(0, 2e-3, 0), Vec3(0, 0, 3e-3)});
  ASSERT_EQ(image.notes.size(), 1u);
  EXPECT_TRUE(says(image.notes[0], "says nothing about its frame"));
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.8, Vec3(1, -2, 0.5).normalized()));
  file.set<std::int16_t>(252, 1);
  file.set(76, -1.0f);  // qfac: the third axis the other way
  file.set(256, static_cast<float>(turn.x()));
  file.set(260, static_cast<float>(turn.y()));
  file.set(264, static_cast<float>(turn.z()));
  file.set(268, 5.0f);
  image = read_back("a.nii", file.bytes());
  expect_frame(image, {0.005, 0, 0}, {turn * Vec3(1e-3, 0, 0), turn * Vec3(0, 2e-3, 0), turn * Vec3(0, 0, -3e-3)});
  EXPECT_TRUE(image.notes.empty());
}

/// Of a machine with the other order of bytes.
TEST(ReadLabels, NiftiTheOtherWayRound) {
  PHYMUL_SKIP_UNLESS_READ("a.nii");
  Nifti file;
  file.sform({0.5f, 0, 0, -10, 0, 0.75f, 0, 20, 0, 0, 2.0f, 30});
  const auto turn = [&](std::string& bytes, std::size_t from, std::size_t each, std::size_t count) {
    for (std::size_t k = 0; k < count; ++k) std::reverse(&bytes[from + each * k], &bytes[from + each * k] + each);
  };
  std::string bytes = file.bytes();
  turn(bytes, 0, 4, 1);
  turn(bytes, 40, 2, 8);
  turn(bytes, 68, 2, 4);
  turn(bytes, 76, 4, 11);
  turn(bytes, 252, 2, 2);
  turn(bytes, 256, 4, 18);
  turn(bytes, 352, 2, 24);
  const LabelImage image = read_back("a.nii", bytes);
  expect_counted(image);
  expect_frame(image, {-0.01, 0.02, 0.03}, {Vec3(0.5e-3, 0, 0), Vec3(0, 0.75e-3, 0), Vec3(0, 0, 2e-3)});
}

TEST(ReadLabels, NiftiTypes) {
  PHYMUL_SKIP_UNLESS_READ("a.nii");
  Nifti file;
  const auto put = [&](std::int16_t type, std::int16_t bits, const auto& numbers) {
    file.set(70, type);
    file.set(72, bits);
    file.voxels = bytes_of(numbers);
  };
  put(2, 8, std::vector<std::uint8_t>(24, 200));
  EXPECT_EQ(read_back("a.nii", file.bytes()).label, std::vector<std::uint16_t>(24, 200));
  put(512, 16, std::vector<std::uint16_t>(24, 65535));
  EXPECT_EQ(read_back("a.nii", file.bytes()).label, std::vector<std::uint16_t>(24, 65535));
  put(1024, 64, std::vector<std::int64_t>(24, 7));
  EXPECT_EQ(read_back("a.nii", file.bytes()).label, std::vector<std::uint16_t>(24, 7));
  put(8, 32, std::vector<std::int32_t>(24, 65536));
  EXPECT_TRUE(says(reading_labels("a.nii", file.bytes()), "expected labels from 0 to 65535, got 65536 in voxel 0"));
  put(4, 16, std::vector<std::int16_t>(24, -1));
  EXPECT_TRUE(says(reading_labels("a.nii", file.bytes()), "expected labels from 0 to 65535, got -1 in voxel 0"));
  put(16, 32, std::vector<float>(24, 1.0f));
  EXPECT_TRUE(says(reading_labels("a.nii", file.bytes()), "expected integers as labels, got FLOAT32"));
}

TEST(ReadLabels, RefusesBadNifti) {
  PHYMUL_SKIP_UNLESS_READ("a.nii");
  const auto changed = [](auto change, const std::string& name = "bad.nii") {
    Nifti file;
    change(file);
    return reading_labels(name, file.bytes());
  };
  EXPECT_TRUE(says(reading_labels("bad.nii", "nothing of it"), "bad.nii: expected a header of NIfTI-1"));
  const std::string second = bytes_of(std::vector<std::int32_t>{540}) + "n+2" + std::string(600, '\0');
  EXPECT_TRUE(says(reading_labels("bad.nii.gz", zipped(second)), "got one of NIfTI-2; save it as NIfTI-1"));
  EXPECT_TRUE(
      says(changed([](Nifti& f) { f.voxels.resize(20); }), "expected 24 voxels of 2 bytes, but the file of 372"));
  EXPECT_TRUE(says(changed([](Nifti& f) { f.dimensions({4, 4, 3, 2, 5}); }), "of three dimensions, got 4"));
  EXPECT_TRUE(says(changed([](Nifti& f) { f.dimensions({2, 6, 4, 1}); }), "of three dimensions, got 2"));
  EXPECT_TRUE(says(changed([](Nifti& f) { f.dimensions({3, 30000, 30000, 30000}); }), "2^31 bytes in all at most"));
  EXPECT_TRUE(says(changed([](Nifti& f) { f.dimensions({3, 1000, 1000, 1000}); }), "ends before"));
  EXPECT_TRUE(says(changed([](Nifti& f) { f.dimensions({3, 4, -3, 2}); }), "bad.nii: expected"));
  EXPECT_TRUE(says(changed([](Nifti& f) { f.set(112, 2.0f); }), "got values to be scaled by 2"));
  EXPECT_TRUE(says(changed([](Nifti& f) { f.set(108, -4.0f); }), "got vox_offset -4"));
  EXPECT_TRUE(says(changed([](Nifti& f) { f.set<char>(345, 'i'); }), "with its voxels in the same file"));
  EXPECT_TRUE(says(changed([](Nifti& f) { f.set<char>(123, 5); }), "got unit 5"));
  EXPECT_TRUE(says(changed([](Nifti& f) { f.sform({1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0}); }), "expected a frame"));
  EXPECT_TRUE(says(changed([](Nifti& f) { f.sform({1, 0, 0, NAN, 0, 1, 0, 0, 0, 0, 1, 0}); }), "expected a frame"));
  // Of frames by sizes or a quaternion, not by an sform.
  for (const float size : {0.0f, -2.0f, NAN}) {
    EXPECT_TRUE(says(changed([&](Nifti& f) { f.set(84, size); }), "bad.nii: expected sizes of voxels above 0, got"));
    EXPECT_EQ(changed([&](Nifti& f) { f.set(84, size), f.sform({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}); }), "(no error)");
  }
  for (const float b : {3.0f, NAN}) {
    EXPECT_TRUE(says(changed([&](Nifti& f) { f.set<std::int16_t>(252, 1), f.set(256, b); }), "a unit quaternion and"));
  }
  EXPECT_TRUE(says(changed([](Nifti& f) { f.set<std::int16_t>(252, 1), f.set(268, NAN); }), "an offset that is not"));
  std::string half = zipped(Nifti().bytes());
  EXPECT_EQ(reading_labels("a.nii.gz", half), "(no error)");
  half.resize(half.size() / 2);
  EXPECT_TRUE(says(reading_labels("half.nii.gz", half), "half.nii.gz: expected"));
}

/// Cut at every byte: an Error, or what was read is whole.
TEST(ReadLabels, NiftiCutAnywhere) {
  PHYMUL_SKIP_UNLESS_READ("a.nii");
  const std::string whole = Nifti().bytes();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_TRUE(says(reading_labels("cut.nii", whole.substr(0, size)), "cut.nii: ")) << size;
  }
}

TEST(ReadLabels, Nrrd) {
  PHYMUL_SKIP_UNLESS_READ("a.nrrd");
  const std::array<Vec3, 3> step{Vec3(1e-3, 0, 0), Vec3(0, 2e-3, 0), Vec3(0, 0, 3e-3)};
  LabelImage image = read_back("a.nrrd", nrrd(plain + "space: right-anterior-superior\n" + directions + raw));
  expect_counted(image);
  expect_frame(image, {0.01, 0.02, 0.03}, step);
  EXPECT_TRUE(image.notes.empty());
  // What 3D Slicer and ITK write.
  image = read_back("a.nrrd", nrrd(plain + "space: left-posterior-superior\n" + directions + "encoding: gzip\n" +
                                       "Segment0_Name:=liver\nSegment0_LabelValue:=3\n",
                                   zipped(bytes_of(counted()))));
  expect_counted(image);
  expect_frame(image, {-0.01, -0.02, 0.03}, {-step[0], -step[1], step[2]});
  EXPECT_EQ(image.names, (std::map<std::uint16_t, std::string>{{3, "liver"}}));
  image = read_back("a.nrrd", nrrd(plain + "space: LAS\nspace units: \"m\" \"m\" \"m\"\n" + directions + raw));
  expect_frame(image, {-10, 20, 30}, {-1e3 * step[0], 1e3 * step[1], 1e3 * step[2]});
  image = read_back("a.nrrd", nrrd(plain + "spacings: 1 2 3\n" + raw));
  expect_frame(image, {0, 0, 0}, step);
  ASSERT_EQ(image.notes.size(), 1u);
  EXPECT_TRUE(says(image.notes[0], "says nothing about its frame"));
  image = read_back("a.nrrd", nrrd(plain + "space dimension: 3\n" + directions + raw));
  EXPECT_TRUE(says(image.notes.at(0), "taken for RAS"));
  // A name less between two, and no origin.
  const std::string nowhere = directions.substr(0, directions.find("space origin"));
  image = read_back("a.nrrd", nrrd(plain + "space: RAS\n" + nowhere + raw +
                                   "Segment0_Name:=liver\nSegment0_LabelValue:=3\n"
                                   "Segment12_Name:=tumour\nSegment12_LabelValue:=4\n"));
  EXPECT_EQ(image.names, (std::map<std::uint16_t, std::string>{{3, "liver"}, {4, "tumour"}}));
  ASSERT_EQ(image.notes.size(), 1u);
  EXPECT_TRUE(says(image.notes[0], "taken to begin at 0"));
}

TEST(ReadLabels, NrrdWithItsVoxelsInAnotherFile) {
  PHYMUL_SKIP_UNLESS_READ("a.nhdr");
  const TextFile header("a.nhdr", "NRRD0004\n" + plain + "spacings: 1 1 1\n" + raw + "data file: a.raw\n");
  EXPECT_TRUE(refuses([&] { read_labels(header.path()); }, "a.nhdr: expected an image in NRRD"));
  std::ofstream(std::filesystem::path(header.path()).parent_path() / "a.raw", std::ios::binary) << bytes_of(counted());
  expect_counted(read_labels(header.path()));
}

TEST(ReadLabels, RefusesBadNrrd) {
  PHYMUL_SKIP_UNLESS_READ("a.nrrd");
  const std::string end = "spacings: 1 1 1\n" + raw;
  const auto with = [&](const std::string& fields, const std::string& voxels = bytes_of(counted())) {
    return reading_labels("bad.nrrd", nrrd(fields + raw, voxels));
  };
  EXPECT_TRUE(says(reading_labels("bad.nrrd", "nothing of it"), "bad.nrrd:1: expected an image in NRRD"));
  EXPECT_TRUE(says(reading_labels("bad.nrrd", "P5\n2 2\n255\n...."), "bad.nrrd:1: expected an image in NRRD"));
  const std::string endless(2000, 'x');
  for (const std::string& line : {endless, "space: " + endless, "space: " + endless + ":=a", endless + ": a:=b"}) {
    EXPECT_TRUE(
        says(reading_labels("bad.nrrd", nrrd(plain + line + "\n" + raw)), "bad.nrrd:6: expected lines of at most 512"));
  }
  // teem ends lines at a carriage return, and takes what follows LIST for names of files.
  for (const std::string& line : {"a:=b\rspace: " + endless, "data file: LIST\na:=" + endless,
                                  "Data File: LIST\n\n#" + endless, "\r\r\n" + endless}) {
    EXPECT_TRUE(says(reading_labels("bad.nrrd", nrrd(plain + line + "\n" + raw)), "expected lines of at most 512"));
  }
  EXPECT_TRUE(says(reading_labels("bad.nrrd", nrrd(plain + endless + std::string(1, '\0') + ":=x\n" + raw)),
                   "bad.nrrd:6: expected text in the header"));
  EXPECT_TRUE(says(reading_labels("bad.nrrd", nrrd(plain + "data file: x%400d.raw 1 2 1 2\n" + raw)),
                   "bad.nrrd:6: expected a header without \"%\""));
  const TextFile image("a.nrrd", nrrd(plain + raw));
  std::string deep = image.path().substr(0, image.path().rfind('/') + 1);
  for (int k = 0; k < 300; ++k) deep += "./";
  deep += "a.nrrd";
  EXPECT_TRUE(refuses([&] { read_labels(deep); }, "expected a path of at most 512"));
  EXPECT_EQ(reading_labels("a.nrrd", nrrd(plain + "spacings: 1 2 3\n#" + endless + "\n" + raw)), "(no error)");
  EXPECT_EQ(reading_labels("a.nrrd", nrrd(plain + "spacings: 1 2 3\nnote:=" + endless + ": " + endless + "\n" + raw)),
            "(no error)");
  EXPECT_TRUE(says(with(plain, "short"), "bad.nrrd: expected an image in NRRD"));
  EXPECT_TRUE(says(with("type: uchar\ndimension: 3\nsizes: 1 1 999999999\nspacings: 1 1 1\n", "short"), "ends before"));
#ifndef __SANITIZE_ADDRESS__  // teem loses its buffers there
  EXPECT_TRUE(
      says(reading_labels("bad.nrrd", nrrd(plain + "encoding: gzip\n", zipped(bytes_of(counted())).substr(0, 30))),
           "bad.nrrd: expected an image in NRRD"));
#endif
  EXPECT_TRUE(says(with("type: float\ndimension: 3\nsizes: 3 2 2\nendian: little\n"), "as labels, got float"));
  EXPECT_TRUE(says(with("type: short\ndimension: 4\nsizes: 2 2 3 2\nendian: little\n"),
                   "of three dimensions, or a fourth of kind"));
  EXPECT_TRUE(says(with("type: short\ndimension: 3\nsizes: 99999 99999 99999\nendian: little\n"), "2^31 bytes"));
  EXPECT_TRUE(says(with(plain + "space: RAS\nspace directions: (1,0,0) (0,1,0) (1,1,0)\n"), "expected a frame"));
  EXPECT_TRUE(
      says(with(plain + "space: RAS\nspace directions: none (0,2,0) (0,0,3)\n"), "of all three axes or of none"));
  EXPECT_TRUE(says(with(plain + "spacings: nan 2 2\n"), "spacings of all three axes or of none"));
  for (const std::string kind : {"vector", "list", "time"}) {
    EXPECT_TRUE(
        says(with(plain + "kinds: " + kind + " domain space\n"), "three axes of space, got one of kind " + kind));
  }
  const std::string four = "type: uchar\ndimension: 3\nsizes: 1 1 4\nencoding: ascii\n";
  for (const auto& [voxels, text] : {std::pair{"1, 2,3 255\n", "(no error)"},
                                     {"1 301 2 3", "from 0 to 255, got 301 in voxel 1"},
                                     {"1 -2 2 3", "got -2 in voxel 1"},
                                     {"1 1.9 2 3", "bad.nrrd:7: expected labels (a whole number), got \"1.9\""},
                                     {"1 2 3", "got the end of the file"},
                                     {"1 2 3 4 5", "expected 4 voxels, got more"}}) {
    EXPECT_TRUE(says(reading_labels("bad.nrrd", nrrd(four, voxels)), text));
  }
  EXPECT_TRUE(says(with(plain + "space: RAS\nspace units: \"s\" \"s\" \"s\"\n" + directions), "got \"s\""));
  EXPECT_TRUE(says(with(plain, bytes_of(std::vector<std::int16_t>(24, -5))), "got -5 in voxel 0"));
}

/// Bytes changed at random: an Error that names the file, or an image.
TEST(ReadLabels, DamagedFiles) {
  std::mt19937 random(1);
  const auto damaged = [&](const std::string& name, std::string bytes, std::size_t header) {
    for (int byte = 0; byte < 3; ++byte) bytes[random() % header] = static_cast<char>(random() % 256);
    const std::string message = reading_labels(name, bytes);
    EXPECT_TRUE(message == "(no error)" || message.find(name) != std::string::npos) << message;
  };
  const std::string text = nrrd(plain + "space: LPS\n" + directions + raw);
  for (int turn = 0; turn < 400; ++turn) {
    damaged("damaged.nii", Nifti().bytes(), 352);
    damaged("damaged.nrrd", text, text.size() - 48);
  }
}

TEST(ReadLabels, RefusesOtherFiles) {
  EXPECT_TRUE(
      says(reading_labels("a.png", "x"), "a.png: expected a labelled image in a .nii, .nii.gz, .nrrd or .nhdr file"));
  EXPECT_TRUE(refuses([] { read_labels("/nowhere/a.nii"); }, "/nowhere/a.nii: cannot be opened ("));
}

// Labelled images that say where they are in two ways, in several units, and in layers.

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
                    "space directions: none (1,0,0) (0,2,0) (0,0,3)\nspace origin: (0,0,0)\n" +
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
