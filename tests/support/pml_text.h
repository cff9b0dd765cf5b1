// SPDX-License-Identifier: MIT
//
// Small PML texts for tests, one element a line so that line numbers can be told.
#pragma once

#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <sstream>
#include <string>
#include <vector>

#include "message_of.h"
#include "print.h"

namespace phymul {

inline const std::string test_data = PHYMUL_TEST_DATA, sample_data = PHYMUL_SAMPLE_DATA;  // folders

/// Corners of a unit tetrahedron in mm, on lines 4 to 7 of the file.
inline const std::vector<std::string> tetrahedron_atoms = {
    R"(<atom><atomProperties index="0" x="0" y="0" z="0"/></atom>)",
    R"(<atom><atomProperties index="1" x="1" y="0" z="0"/></atom>)",
    R"(<atom><atomProperties index="2" x="0" y="1" z="0"/></atom>)",
    R"(<atom><atomProperties index="3" x="0" y="0" z="1"/></atom>)"};

/// A cell on one line.
inline std::string cell_text(const std::string& type, const std::vector<int>& atoms, const std::string& more = "",
                             const std::string& children = "") {
  std::string text = "<cell><cellProperties type=\"" + type + "\" " + more + "/>" + children;
  for (const int atom : atoms) text += "<atomRef index=\"" + std::to_string(atom) + "\"/>";
  return text + "</cell>";
}

inline const std::string tetrahedron_cell = cell_text("TETRAHEDRON", {0, 1, 2, 3});

/// Lines 1 to 3, the atoms from line 4, three lines, then the lines of the structural component "Elements".
inline std::string pml_text(const std::vector<std::string>& atoms, const std::vector<std::string>& elements,
                            const std::string& after = "", const std::string& root = "") {
  std::string text = "<physicalModel name=\"t\" " + root + ">\n<atoms>\n<structuralComponent name=\"list\">\n";
  for (const std::string& atom : atoms) text += atom + "\n";
  text += "</structuralComponent></atoms>\n<exclusiveComponents><multiComponent name=\"Exclusive Components\">\n";
  text += "<structuralComponent name=\"Elements\">\n";
  for (const std::string& element : elements) text += element + "\n";
  return text + "</structuralComponent>\n</multiComponent></exclusiveComponents>\n" + after + "</physicalModel>\n";
}

/// The same with the cells of a component "Neighborhoods" instead.
inline std::string with_neighbourhoods(const std::vector<std::string>& cells, const std::string& attributes = "") {
  std::string text = pml_text(tetrahedron_atoms, cells);
  const std::string name = "name=\"Elements\"";
  return text.replace(text.find(name), name.size(), "name=\"Neighborhoods\" " + attributes);
}

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << "no \"" << from << "\" in the text";
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

inline std::string written(const Model& model, const PmlOptions& options = {}) {
  std::ostringstream out;
  write_pml(model, out, options);
  return out.str();
}

inline Model reread(const Model& model, const PmlOptions& options = {}) {
  return read_pml_text(written(model, options), "again.pml", options);
}

inline bool has_note(const std::vector<std::string>& notes, const std::string& part) {
  for (const std::string& note : notes) {
    if (note.find(part) != std::string::npos) return true;
  }
  return false;
}

}  // namespace phymul
