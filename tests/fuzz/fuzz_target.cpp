// SPDX-License-Identifier: MIT
#include "fuzz_target.h"

#include <phymul/pml.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

namespace phymul::fuzz {

namespace {

bool has_plain_materials(const Model& model) {
  const bool in_cells = std::ranges::any_of(model.cells, [](const Cell& cell) { return cell.material >= 0; });
  return in_cells && std::ranges::all_of(model.materials, [](const Material& m) {
           return m == Material{.young = m.young, .poisson = m.poisson, .density = m.density};
         });
}

}  // namespace

void check_model(const Model& model) {
  try {
    validate(model);
  } catch (const Error& error) {
    throw Violation(std::string("accepted, but not valid: ") + error.what());
  }
  // PML has materials in cells only, and none of fibres and dissipation.
  if (!model.materials.empty() && !has_plain_materials(model)) return;
  std::ostringstream out;
  if (!accepts([&] { write_pml(model, out); })) return;
  try {
    require(read_pml_text(out.str(), "again.pml") == model, "another model after writing and reading:\n" + out.str());
  } catch (const Error& error) {
    throw Violation(std::string("written, but not read: ") + error.what() + '\n' + out.str());
  }
}

std::string file_with(std::string_view bytes, const std::string& ending) {
  const std::string name = "phymul_fuzz_" + std::to_string(getpid()) + ending;
  const std::string path = (std::filesystem::temp_directory_path() / name).string();
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return path;
}

double Numbers::real() {
  constexpr std::array<double, 12> special{0.0,
                                           -0.0,
                                           1e-3,
                                           1e3,
                                           1e-300,
                                           1e300,
                                           -1e300,
                                           5e-324,
                                           1.7976931348623157e308,
                                           std::numeric_limits<double>::infinity(),
                                           -std::numeric_limits<double>::infinity(),
                                           std::numeric_limits<double>::quiet_NaN()};
  const unsigned first = byte();
  if (first >= 256 - special.size()) return special[first - (256 - special.size())];
  if (first >= 240) {  // any bits
    std::uint64_t bits = 0;
    for (int k = 0; k < 8; ++k) bits = bits << 8 | byte();
    return std::bit_cast<double>(bits);
  }
  return (static_cast<double>(first % 65) - 32.0) / 32.0;
}

}  // namespace phymul::fuzz
