// SPDX-License-Identifier: MIT
#include "fuzz_target.h"

#include <phymul/pml.h>
#include <unistd.h>

#include <bit>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

namespace phymul::fuzz {

void check_model(const Model& model) {
  try {
    validate(model);
  } catch (const Error& error) {
    throw Violation(std::string("accepted, but not valid: ") + error.what());
  }
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
