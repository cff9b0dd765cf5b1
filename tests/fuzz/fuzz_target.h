// SPDX-License-Identifier: MIT
//
// What every fuzz target does with any bytes: it reads them as one kind of input and checks what must hold whatever
// they are. A target returns, or throws Violation; anything else (another exception, a finding of a sanitizer, too much
// time or memory) is a fault of the library.
#pragma once

#include <phymul/phymul.h>

#include <array>
#include <stdexcept>
#include <string>
#include <string_view>

namespace phymul::fuzz {

using Target = void(std::string_view bytes);

// Files in memory. Their errors name file and place; what is read is valid, and comes back from our own writers.
Target pml, lml, gmsh, vtk, vtu;
// Files with checksums, which the targets correct first: damage beyond them is what is looked for. `recording` is
// replayed on a small body, with few steps.
Target state, recording;
// Files read by other libraries, as far as our own code goes on from there.
Target nifti, nrrd;
// Bytes as numbers: a surface and a labelled image to be filled; a model to be checked and simulated.
Target surface, labels, model;

struct NamedTarget {
  const char* name;  ///< also that of its folder in corpus/, if it has one
  Target* run;
  const char* ending = "";  ///< of the files in tests/data that are its inputs too; empty: none
};
inline constexpr std::array<NamedTarget, 12> all_targets{{{"pml", pml, ".pml"},
                                                          {"lml", lml},
                                                          {"gmsh", gmsh, ".msh"},
                                                          {"vtk", vtk, ".vtk"},
                                                          {"vtu", vtu, ".vtu"},
                                                          {"state", state},
                                                          {"recording", recording},
                                                          {"nifti", nifti},
                                                          {"nrrd", nrrd},
                                                          {"surface", surface},
                                                          {"labels", labels},
                                                          {"model", model}}};

/// Not an Error, so that no target takes it for a refusal.
struct Violation : std::logic_error {
  using std::logic_error::logic_error;
};

inline void require(bool holds, const std::string& what) {
  if (!holds) throw Violation(what);
}

/// Whether read() accepts its input. If it refuses, its Error must say why.
template <class Read>
bool accepts(Read read) {
  try {
    read();
    return true;
  } catch (const Error& error) {
    require(!std::string(error.what()).empty(), "an Error says nothing");
    return false;
  }
}

/// The same for a file: the Error must name it, at the beginning of its text and in file().
template <class Read>
bool accepts_file(const std::string& file, Read read) {
  try {
    read();
    return true;
  } catch (const Error& error) {
    require(std::string(error.what()).starts_with(file + ":"), std::string("not about the file: ") + error.what());
    require(error.file() == file, "another file, \"" + error.file() + "\": " + error.what());
    return false;
  }
}

/// What every model from a file is: valid, and the same when written as PML and read again, unless a name has a
/// character that XML cannot hold.
void check_model(const Model& model);

/// A file of this process, with these bytes.
std::string file_with(std::string_view bytes, const std::string& ending);

/// Numbers out of bytes; zeros where they end.
class Numbers {
 public:
  explicit Numbers(std::string_view bytes) : bytes_(bytes) {}

  bool empty() const { return bytes_.empty(); }
  unsigned byte() {
    if (bytes_.empty()) return 0;
    const auto value = static_cast<unsigned char>(bytes_.front());
    bytes_.remove_prefix(1);
    return value;
  }
  int below(int end) { return static_cast<int>(byte()) % end; }
  int between(int low, int high) { return low + below(high - low + 1); }
  /// Mostly from -1 to 1 in steps of 1 / 32, so that places coincide and lie in planes; sometimes anything.
  double real();
  Vec3 point() {
    const double x = real(), y = real();
    return {x, y, real()};
  }
  std::string_view rest() const { return bytes_; }

 private:
  std::string_view bytes_;
};

}  // namespace phymul::fuzz
