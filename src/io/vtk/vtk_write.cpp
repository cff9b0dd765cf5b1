// SPDX-License-Identifier: MIT
//
// VTK XML unstructured grids with appended raw data (compact, quick, exact) and the .pvd file that makes a series of
// them. Format: https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
#include <phymul/error.h>
#include <phymul/writer.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <ostream>
#include <set>

#include "base/decimal.h"
#include "base/files.h"
#include "io/xml/xml_writer.h"
#include "vtk_parts.h"

namespace phymul {
namespace {

/// Text as an XML attribute's value. Control characters, which XML 1.0 cannot hold, become '?'.
std::string escaped(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return static_cast<unsigned char>(c) < ' '; }, '?');
  std::string result;
  append_xml_text(result, text);
  return result;
}

/// Collects arrays: an XML element each, and behind all of them the bytes, each array after its size in bytes.
class AppendedArrays {
 public:
  template <class T>
  void add(std::string& xml, const char* type, const std::string& name, int components, const std::vector<T>& values) {
    xml += std::string("        <DataArray type=\"") + type + "\" Name=\"" + escaped(name) +
           "\" NumberOfComponents=\"" + std::to_string(components) + "\" format=\"appended\" offset=\"" +
           std::to_string(bytes_.size()) + "\"/>\n";
    const std::uint64_t size = values.size() * sizeof(T);
    bytes_.append(reinterpret_cast<const char*>(&size), sizeof size);
    bytes_.append(reinterpret_cast<const char*>(values.data()), static_cast<std::size_t>(size));
  }

  void add(std::string& xml, const std::string& name, const VecList& values) {
    std::vector<double> flat;
    flat.reserve(3 * values.size());
    for (const Vec3& value : values) flat.insert(flat.end(), value.data(), value.data() + 3);
    add(xml, "Float64", name, 3, flat);
  }

  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

void require_sizes(const Model& model, const State& state, const std::vector<Field>& fields, const std::string& path) {
  const std::size_t n = model.rest.size();
  const auto require = [&](const std::string& what, std::size_t size) {
    if (size == n) return;
    throw Error(path + ": expected " + what + " of " + std::to_string(n) + " particles, got " + std::to_string(size) +
                "; write the state together with its own model");
  };
  require("positions", state.position.size());
  require("velocities", state.velocity.size());
  std::set<std::string> taken{"displacement", "velocity", "mass"};  // as they are written
  for (const Component& component : model.components) taken.insert(escaped("group:" + component.name));
  for (const Field& field : fields) {
    require("field \"" + field.name + '"', field.values.size());
    if (!field.name.empty() && taken.insert(escaped(field.name)).second) continue;
    throw Error(path + ": expected fields with names of their own, other than \"displacement\", \"velocity\", " +
                "\"mass\" and \"group:\" with a group's, got \"" + field.name + '"');
  }
}

/// Cells of the model but those that are removed, or a vertex per particle where it has none. `count`: of them.
std::string cell_arrays(const Model& model, AppendedArrays& arrays, std::size_t& count) {
  std::vector<std::int32_t> connectivity;
  std::vector<std::int64_t> offsets;
  std::vector<std::uint8_t> types;
  for (const Cell& cell : model.cells) {
    if (cell.share == 0.0) continue;
    const std::vector<Index> particles = vtk_order(cell);
    connectivity.insert(connectivity.end(), particles.begin(), particles.end());
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
    types.push_back(vtk_type(cell.type));
  }
  if (model.cells.empty()) {
    for (Index i = 0; i < model.particle_count(); ++i) {
      connectivity.push_back(i);
      offsets.push_back(i + 1);
      types.push_back(vtk_type(CellType::atom));
    }
  }
  count = types.size();
  std::string xml = "      <Cells>\n";
  arrays.add(xml, "Int32", "connectivity", 1, connectivity);
  arrays.add(xml, "Int64", "offsets", 1, offsets);
  arrays.add(xml, "UInt8", "types", 1, types);
  return xml + "      </Cells>\n";
}

/// One array of 0 and 1 per group name. A group of all particles tells nothing and is left out.
void add_groups(const Model& model, std::string& xml, AppendedArrays& arrays) {
  std::set<std::string> names;
  for (const Component& component : model.components) names.insert(component.name);
  names.erase("");
  for (const std::string& name : names) {
    const std::vector<Index> members = model.group(name);
    if (members.empty() || members.size() == model.rest.size()) continue;
    std::vector<std::uint8_t> inside(model.rest.size(), 0);
    for (const Index i : members) inside[i] = 1;
    arrays.add(xml, "UInt8", "group:" + name, 1, inside);
  }
}

std::string point_arrays(const Model& model, const State& state, const std::vector<Field>& fields,
                         AppendedArrays& arrays) {
  VecList displacement(model.rest.size());
  std::transform(state.position.begin(), state.position.end(), model.rest.begin(), displacement.begin(),
                 [](const Vec3& x, const Vec3& rest) -> Vec3 { return x - rest; });
  std::string xml = "      <PointData Vectors=\"displacement\">\n";
  arrays.add(xml, "displacement", displacement);
  arrays.add(xml, "velocity", state.velocity);
  arrays.add(xml, "Float64", "mass", 1, model.mass);
  for (const Field& field : fields) arrays.add(xml, "Float64", field.name, 1, field.values);
  add_groups(model, xml, arrays);
  xml += "      </PointData>\n      <Points>\n";
  arrays.add(xml, "Points", state.position);
  return xml + "      </Points>\n";
}

}  // namespace

void write_vtu(const Model& model, const State& state, const std::string& path, const std::vector<Field>& fields) {
  require_sizes(model, state, fields, path);
  AppendedArrays arrays;
  const std::string points = point_arrays(model, state, fields, arrays);
  std::size_t cell_count = 0;
  const std::string cells = cell_arrays(model, arrays, cell_count);
  const char* byte_order = std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian";

  // Numbers as strings: a stream would write them in the way of the global locale.
  replace_file(path, [&](std::ostream& out) {
    out << "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"" << byte_order
        << "\" header_type=\"UInt64\">\n  <UnstructuredGrid>\n"
        << "    <FieldData>\n      <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" "
        << "format=\"ascii\">" << to_decimal(state.time) << "</DataArray>\n    </FieldData>\n"
        << "    <Piece NumberOfPoints=\"" << std::to_string(model.rest.size()) << "\" NumberOfCells=\""
        << std::to_string(cell_count) << "\">\n"
        << points << cells << "    </Piece>\n  </UnstructuredGrid>\n  <AppendedData encoding=\"raw\">\n_"
        << arrays.bytes() << "\n  </AppendedData>\n</VTKFile>\n";
  });
}

VtkSeries::VtkSeries(std::string stem) : stem_(std::move(stem)) {}

void VtkSeries::write(const Model& model, const State& state, const std::vector<Field>& fields) {
  char number[32];
  std::snprintf(number, sizeof number, "_%06zu.vtu", frames_.size());
  write_vtu(model, state, stem_ + number, fields);
  // Beside the .pvd file, so that the folder can be moved.
  auto frames = frames_;
  frames.emplace_back(state.time, std::filesystem::path(stem_ + number).filename().string());

  replace_file(stem_ + ".pvd", [&](std::ostream& out) {
    out << "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n  <Collection>\n";
    for (const auto& [time, name] : frames) {
      out << "    <DataSet timestep=\"" << to_decimal(time) << "\" part=\"0\" file=\"" << escaped(name) << "\"/>\n";
    }
    out << "  </Collection>\n</VTKFile>\n";
  });
  frames_ = std::move(frames);
}

}  // namespace phymul
