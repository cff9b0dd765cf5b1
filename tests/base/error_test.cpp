// SPDX-License-Identifier: MIT
//
// Codes, files and lines of errors; the text has its tests where it is made.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <fstream>
#include <functional>
#include <limits>
#include <type_traits>

namespace phymul {
namespace {

// Exceptions are copied while they fly.
static_assert(std::is_nothrow_copy_constructible_v<Error> && std::is_nothrow_copy_assignable_v<Error>);

Error error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error;
  }
  return Error("(no error)");
}

std::string file_with(const std::string& name, const std::string& text) {
  std::string path = testing::TempDir() + "/phymul_error_" + name;
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

void expect_error(const Error& error, ErrorCode code, const std::string& file, int line) {
  EXPECT_EQ(error.code(), code) << error.what();
  EXPECT_EQ(error.file(), file) << error.what();
  EXPECT_EQ(error.line(), line) << error.what();
}

TEST(Error, HasAGeneralCodeAndNoFileByDefault) {
  expect_error(Error("text"), ErrorCode::invalid_argument, "", 0);
  EXPECT_STREQ(Error(ErrorCode::device, "lost").what(), "lost");
}

TEST(Error, FilesThatCannotBeReadOrWritten) {
  const std::string nowhere = testing::TempDir() + "/phymul_no_folder/x";
  expect_error(error_of([&] { read_pml(nowhere); }), ErrorCode::file_access, nowhere, 0);
  expect_error(error_of([&] { read_mesh(nowhere); }), ErrorCode::file_access, nowhere, 0);
  expect_error(error_of([&] { read_state(nowhere); }), ErrorCode::file_access, nowhere, 0);
  expect_error(error_of([&] { save_state(Snapshot{}, nowhere); }), ErrorCode::file_access, nowhere, 0);
  const std::string large = file_with("large.pml", "<physicalModel/>");
  expect_error(error_of([&] { read_pml(large, {.max_bytes = 3}); }), ErrorCode::file_access, large, 0);
}

TEST(Error, FilesWithAFaultNameItsLine) {
  const std::string pml = file_with("fault.pml", "<physicalModel>\n<atoms>\n</atoms>\n</physicalModel>\n");
  expect_error(error_of([&] { read_pml(pml); }), ErrorCode::file_format, pml, 2);
  const std::string xml = file_with("xml.pml", "<physicalModel>\n");
  EXPECT_EQ(error_of([&] { read_pml(xml); }).code(), ErrorCode::file_format);
  const Model model = make_block({1, 1, 1}, 1, 1, 1);
  const std::string lml = file_with("fault.lml", "<loads>\n<load type=\"Gust\"/>\n</loads>\n");
  expect_error(error_of([&] { read_lml(lml, model); }), ErrorCode::file_format, lml, 2);
  const std::string msh = file_with("fault.msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\nx\n");
  expect_error(error_of([&] { read_mesh(msh); }), ErrorCode::file_format, msh, 5);
  const std::string vtu = file_with("fault.vtu", "<VTKFile>\n<UnstructuredGrid\n");
  EXPECT_EQ(error_of([&] { read_mesh(vtu); }).file(), vtu);
  const std::string other = file_with("other.mesh", "solid\n");
  expect_error(error_of([&] { read_mesh(other); }), ErrorCode::file_format, other, 1);
  const std::string recording = file_with("fault.rec", "phymulSt");
  expect_error(error_of([&] { read_recording(recording); }), ErrorCode::file_format, recording, 0);
}

TEST(Error, NamesModelsAndBackends) {
  const Model model = make_block({1, 1, 1}, 1, 1, 1);
  Scene scene(model);
  expect_error(error_of([&] { scene.fix("nose"); }), ErrorCode::unknown_name, "", 0);
  expect_error(error_of([&] { scene.tool("nose"); }), ErrorCode::unknown_name, "", 0);
  expect_error(error_of([&] { make_solver("cuda", model, scene); }), ErrorCode::unknown_name, "", 0);
  expect_error(error_of([&] { scene.gravity(Vec3(std::numeric_limits<double>::infinity(), 0, 0)); }),
               ErrorCode::invalid_argument, "", 0);
  Model broken = model;
  broken.mass.pop_back();
  expect_error(error_of([&] { validate(broken); }), ErrorCode::invalid_model, "", 0);
}

}  // namespace
}  // namespace phymul
