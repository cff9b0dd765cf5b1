// SPDX-License-Identifier: MIT
#include "voxels.h"

#ifdef PHYMUL_HAS_TEEM
#include <teem/nrrd.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <mutex>
#include <optional>

#include "base/byte_source.h"
#include "base/decimal.h"
#include "base/file_error.h"

namespace phymul {
namespace {

using File = std::unique_ptr<Nrrd, Nrrd* (*)(Nrrd*)>;

constexpr IntegerCode integers[] = {
    {nrrdTypeChar, NumberType::int8},     {nrrdTypeUChar, NumberType::uint8},   {nrrdTypeShort, NumberType::int16},
    {nrrdTypeUShort, NumberType::uint16}, {nrrdTypeInt, NumberType::int32},     {nrrdTypeUInt, NumberType::uint32},
    {nrrdTypeLLong, NumberType::int64},   {nrrdTypeULLong, NumberType::uint64},
};

/// Characters of a path, and of a line of the header that is neither a key/value pair nor a comment. teem puts these
/// into its messages, whose buffer 1,000 of them overflow.
constexpr std::size_t longest_text = 512;

bool names_a_list(std::string_view line) {
  std::string field(line.substr(0, line.find(':')));
  std::ranges::transform(field, field.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return field.find("file") != std::string::npos && line.find("LIST") != std::string_view::npos;
}

/// `lists`: a name of a file, whatever is in it.
void require_line(const std::string& path, std::size_t number, std::string_view line, bool lists) {
  if (line.find('\0') != std::string_view::npos) {
    fail_format(path, number, "expected text in the header, got a byte of 0");
  }
  if (!lists && (line.starts_with('#') || line.find(":=") < line.find(": "))) return;
  if (line.size() > longest_text) {
    fail_format(path, number,
                "expected lines of at most " + std::to_string(longest_text) + " characters in the header, got " +
                    std::to_string(line.size()));
  }
  // teem gives numbered names of files to sprintf as they are.
  if (line.find('%') != std::string_view::npos) {
    fail_format(path, number,
                "expected a header without \"%\", as in numbered names of files; put the voxels into one");
  }
}

/// What teem must not see. It would also read other formats, by their first bytes. It ends a line at a lone carriage
/// return too, and does not end a list of files at an empty line.
void require_header(const std::string& path) {
  if (path.size() > longest_text) {
    fail_access(path, "expected a path of at most " + std::to_string(longest_text) + " characters for NRRD");
  }
  std::ifstream file = open_file(path);
  bool lists = false;
  std::string text;
  for (std::size_t number = 1; std::getline(file, text); ++number) {
    if (number == 1 && !text.starts_with("NRRD")) {
      fail_format(path, 1, "expected an image in NRRD, which begins with NRRD, got other bytes");
    }
    if (!lists && (text.empty() || text == "\r")) return;
    for (std::string_view rest = text; !rest.empty();) {
      const std::string_view line = rest.substr(0, rest.find('\r'));
      rest.remove_prefix(std::min(rest.size(), line.size() + 1));
      require_line(path, number, line, lists);
      lists = lists || names_a_list(line);
    }
  }
}

using Reading = std::unique_ptr<NrrdIoState, NrrdIoState* (*)(NrrdIoState*)>;

Reading make_reading() {
  Reading io(nrrdIoStateNew(), nrrdIoStateNix);
  if (!io) throw std::bad_alloc();
  return io;
}

/// The header alone, or all.
File load(const std::string& path, NrrdIoState* io, bool header_alone) {
  File file(nrrdNew(), nrrdNuke);
  if (!file) throw std::bad_alloc();
  nrrdIoStateSet(io, nrrdIoStateSkipData, header_alone ? AIR_TRUE : AIR_FALSE);
  if (nrrdLoad(file.get(), path.c_str(), io) == 0) return file;
  std::unique_ptr<char, void (*)(void*)> reasons(biffGetDone(NRRD), std::free);
  std::string last = reasons ? reasons.get() : "";
  // One reason a line, the innermost last.
  last = std::string(trim(last));
  last = std::string(trim(std::string_view(last).substr(last.rfind('\n') + 1)));
  fail_format(path, 0, "expected an image in NRRD, which teem cannot read: " + last);
}

/// Metres.
double unit_of(const std::string& path, const Nrrd& file) {
  std::optional<std::string> unit;
  for (int axis = 0; axis < 3; ++axis) {
    const char* own = file.spaceDim > 0 ? file.spaceUnits[axis] : file.axis[axis].units;
    const std::string text = own ? own : "";
    if (unit && *unit != text)
      fail_format(path, 0, "expected one unit of length, got \"" + *unit + "\" and \"" + text + "\"");
    unit = text;
  }
  if (unit->empty() || *unit == "mm" || *unit == "millimeter" || *unit == "millimetre") return 1e-3;
  if (*unit == "m" || *unit == "meter" || *unit == "metre") return 1.0;
  if (*unit == "cm") return 1e-2;
  if (*unit == "um" || *unit == "micron" || *unit == "\xc2\xb5m") return 1e-6;
  fail_format(path, 0, "expected a length in m, cm, mm or um, got \"" + *unit + "\"");
}

/// Signs that turn a place of the file's space into one of RAS.
Vec3 turn_to_ras(const std::string& path, int space, LabelImage& image) {
  if (space == nrrdSpaceLeftAnteriorSuperior) return {-1, 1, 1};
  if (space == nrrdSpaceLeftPosteriorSuperior) return {-1, -1, 1};
  if (space != nrrdSpaceRightAnteriorSuperior) {
    image.notes.push_back(path + ": does not say what its axes are to a patient (space); taken for RAS");
  }
  return {1, 1, 1};
}

void set_frame(const std::string& path, const Nrrd& file, LabelImage& image) {
  const double unit = unit_of(path, file);
  if (file.spaceDim == 0) {
    for (int axis = 0; axis < 3; ++axis) {
      const double length = std::isfinite(file.axis[axis].spacing) ? file.axis[axis].spacing : 1.0;
      image.step[axis] = unit * length * Vec3::Unit(axis);
    }
    image.notes.push_back(path + ": says nothing about its frame; taken to begin at 0, along x, y and z");
    return;
  }
  if (file.spaceDim != 3) {
    fail_format(path, 0, "expected a space of three dimensions, got " + std::to_string(file.spaceDim));
  }
  const Vec3 turn = unit * turn_to_ras(path, file.space, image);
  for (int row = 0; row < 3; ++row) {
    for (int axis = 0; axis < 3; ++axis) image.step[axis][row] = turn[row] * file.axis[axis].spaceDirection[row];
    const double origin = file.spaceOrigin[row];
    image.origin[row] = std::isfinite(origin) ? turn[row] * origin : 0.0;
  }
}

/// 3D Slicer's keys.
void set_names(const Nrrd& file, LabelImage& image) {
  const auto value = [&](const std::string& key) {
    std::unique_ptr<char, void (*)(void*)> text(nrrdKeyValueGet(&file, key.c_str()), std::free);
    return std::string(text ? text.get() : "");
  };
  for (int segment = 0;; ++segment) {
    const std::string key = "Segment" + std::to_string(segment) + "_";
    const std::string name = value(key + "Name");
    if (name.empty()) return;
    const std::optional<std::int64_t> label = parse_integer(value(key + "LabelValue"));
    if (label && *label > 0 && *label <= 65535) image.names[static_cast<std::uint16_t>(*label)] = name;
  }
}

}  // namespace

LabelImage read_nrrd(const std::string& path) {
  static std::mutex one_at_a_time;  // teem collects its reasons in one place
  const std::scoped_lock lock(one_at_a_time);
  require_header(path);
  const Reading of_header = make_reading();
  const File header = load(path, of_header.get(), true);
  if (header->dim != 3) {
    fail_format(path, 0,
                "expected an image of three dimensions, got " + std::to_string(header->dim) +
                    "; save one label image of it (3D Slicer: export the segments to a label map)");
  }
  const NumberType type = integer_type(path, integers, header->type, airEnumStr(nrrdType, header->type));
  std::vector<std::int64_t> sizes;
  for (int axis = 0; axis < 3; ++axis) sizes.push_back(static_cast<std::int64_t>(header->axis[axis].size));
  const std::size_t count = voxel_count(path, sizes, type);
  const bool elsewhere = of_header->dataFNFormat != nullptr || of_header->dataFNArr->len > 0;
  // bzip2 makes gigabytes of some hundred bytes.
  if (!elsewhere && of_header->encoding != nrrdEncodingBzip2) require_voxel_bytes(path, count, type, most_inflation);

  const File file = load(path, make_reading().get(), false);
  LabelImage image;
  image.size = {static_cast<Index>(sizes[0]), static_cast<Index>(sizes[1]), static_cast<Index>(sizes[2])};
  image.label = labels_of(path, file->data, count, type);
  set_frame(path, *file, image);
  set_names(*file, image);
  return image;
}

}  // namespace phymul

#else

namespace phymul {

LabelImage read_nrrd(const std::string& path) {
  fail_without(path, "teem", "libteem-dev");
}

}  // namespace phymul

#endif
