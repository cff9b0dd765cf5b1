// SPDX-License-Identifier: MIT
//
// What a wrong file says: each message with its file and line, and what the readers of the field let pass.
#include <phymul/pml.h>

#include <chrono>
#include <filesystem>
#include <fstream>

#include "support/pml_text.h"

namespace phymul {
namespace {

/// Message of reading a text.
std::string refusal(const std::string& text, const PmlOptions& options = {}) {
  return message_of([&] { read_pml_text(text, "t.pml", options); });
}

/// The tetrahedron with another second atom, which stands on line 5.
std::string with_atom(const std::string& properties) {
  std::vector<std::string> atoms = tetrahedron_atoms;
  atoms[1] = "<atom><atomProperties " + properties + "/></atom>";
  return pml_text(atoms, {tetrahedron_cell});
}

/// The tetrahedron with one more element on line 12, after its cell on line 11.
std::string with_element(const std::string& element) {
  return pml_text(tetrahedron_atoms, {tetrahedron_cell, element});
}

TEST(PmlErrors, TheTextTheyStartFromIsRight) {
  EXPECT_EQ(refusal(with_atom("index=\"1\" x=\"1\" y=\"0\" z=\"0\"")), "(no error)");
  EXPECT_EQ(refusal(with_element("<atomRef index=\"3\"/>")), "(no error)");
}

TEST(PmlErrors, Coordinates) {
  EXPECT_EQ(refusal(with_atom("index=\"1\" y=\"0\" z=\"0\"")),
            "t.pml:5: expected attribute \"x\" in <atomProperties>, got none");
  EXPECT_EQ(refusal(with_atom("index=\"1\" x=\"1\" y=\"0\"")),
            "t.pml:5: expected attribute \"z\" in <atomProperties>, got none");
  for (const char* const wrong : {"1,5", "abc", "", "1.5mm", "nan", "inf", "1e999", "0x1"}) {
    EXPECT_EQ(refusal(with_atom("index=\"1\" x=\"" + std::string(wrong) + "\" y=\"0\" z=\"0\"")),
              "t.pml:5: expected a finite number with a decimal point in x, got \"" + std::string(wrong) + "\"");
  }
}

TEST(PmlErrors, AtomIndex) {
  EXPECT_EQ(refusal(with_atom("x=\"1\" y=\"0\" z=\"0\"")),
            "t.pml:5: expected attribute \"index\" in <atomProperties>, got none");
  for (const char* const wrong : {"-5", "2147483648", "99999999999999999999", "1.0", "one", ""}) {
    EXPECT_EQ(refusal(with_atom("index=\"" + std::string(wrong) + "\" x=\"1\" y=\"0\" z=\"0\"")),
              "t.pml:5: expected a whole number from 0 to 2147483647 in index of <atomProperties>, got \"" +
                  std::string(wrong) + "\"");
  }
  EXPECT_EQ(refusal(with_atom("index=\"3\" x=\"1\" y=\"0\" z=\"0\"")),
            "t.pml:7: expected each atom index once, got 3 again; it is first on line 5");
}

TEST(PmlErrors, MassAndStiffness) {
  EXPECT_EQ(refusal(with_atom("index=\"1\" x=\"1\" y=\"0\" z=\"0\" mass=\"0\"")),
            "t.pml:5: expected a mass above 0, got \"0\"");
  EXPECT_EQ(refusal(with_atom("index=\"1\" x=\"1\" y=\"0\" z=\"0\" stiffness=\"-1\"")),
            "t.pml:5: expected a stiffness of 0 or more, got \"-1\"");
  EXPECT_EQ(refusal(with_atom("index=\"1\" x=\"1\" y=\"0\" z=\"0\" mass=\"heavy\"")),
            "t.pml:5: expected a finite number with a decimal point in mass, got \"heavy\"");
  EXPECT_EQ(refusal(with_neighbourhoods({}, "stiffness=\"soft\"")),
            "t.pml:10: expected a finite number with a decimal point in stiffness, got \"soft\"");
}

TEST(PmlErrors, References) {
  EXPECT_EQ(refusal(with_element(cell_text("LINE", {0, 9}))),
            "t.pml:12: expected the index of an atom, got 9, which no atom has; add the atom or remove the <atomRef>");
  EXPECT_EQ(refusal(with_element("<atomRef index=\"4\"/>")),
            "t.pml:12: expected the index of an atom, got 4, which no atom has; add the atom or remove the <atomRef>");
  EXPECT_EQ(refusal(with_element("<atomRef/>")), "t.pml:12: expected attribute \"index\" in <atomRef>, got none");
  EXPECT_EQ(refusal(with_element("<atomRef index=\"-1\"/>")),
            "t.pml:12: expected a whole number from 0 to 2147483647 in index of <atomRef>, got \"-1\"");
  EXPECT_EQ(refusal(with_element("<cellRef index=\"77\"/>")),
            "t.pml:12: expected the index of a cell, got 77, which no cell has; add the cell or remove the <cellRef>");
}

TEST(PmlErrors, Cells) {
  EXPECT_EQ(refusal(with_element(cell_text("HEXAHEDRON", {0, 1, 2, 3}))),
            "t.pml:12: expected 8 <atomRef> in a cell of type HEXAHEDRON, got 4");
  EXPECT_EQ(refusal(with_element(cell_text("TRIANGLE", {0, 1, 2, 3}))),
            "t.pml:12: expected 3 <atomRef> in a cell of type TRIANGLE, got 4");
  EXPECT_EQ(refusal(with_element(cell_text("CUBE", {0}))),
            "t.pml:12: expected a cell type (ATOM, LINE, TRIANGLE, QUAD, TETRAHEDRON, WEDGE, PYRAMID, HEXAHEDRON, "
            "POLY_LINE, POLY_VERTEX), got \"CUBE\"");
  EXPECT_EQ(refusal(with_element("<cell/>")), "t.pml:12: expected <cellProperties> in <cell>, got none");
  EXPECT_EQ(refusal(with_element("<cell><cellProperties/></cell>")),
            "t.pml:12: expected attribute \"type\" in <cellProperties>, got none");
  EXPECT_EQ(refusal(with_element(cell_text("LINE", {0, 1}, "a=\"1\" a=\"2\""))),
            "t.pml:12: expected each attribute once in <cellProperties>, got \"a\" twice");
}

TEST(PmlErrors, Materials) {
  EXPECT_TRUE(
      says(refusal(with_element(cell_text("TETRAHEDRON", {0, 1, 2, 3}, "young=\"1\" poisson=\"0.5\" density=\"1\""))),
           "t.pml:12: material: expected Poisson's ratio above -1 and below 1/2, got 0.5"));
  EXPECT_EQ(refusal(with_element(cell_text("TETRAHEDRON", {0, 1, 2, 3}, "young=\"x\" poisson=\"0.4\" density=\"1\""))),
            "t.pml:12: expected a finite number with a decimal point in young, got \"x\"");
}

TEST(PmlErrors, Neighbourhoods) {
  const auto named = [](const std::string& name, const std::string& type = "POLY_VERTEX") {
    return with_neighbourhoods(
        {cell_text("POLY_VERTEX", {1, 2, 3}, "name=\"Atom #0\""), cell_text(type, {0, 2}, "name=\"" + name + "\"")});
  };
  EXPECT_EQ(refusal(named("Atom #1")), "(no error)");
  for (const char* const wrong : {"Atom #9", "Atom #", "Atom #-1", "Atom #1x"}) {
    EXPECT_EQ(refusal(named(wrong)),
              "t.pml:12: expected a neighbourhood named \"Atom #\" and the index of an atom, got \"" +
                  std::string(wrong) + "\", which names no atom");
  }
  EXPECT_EQ(refusal(named("Atom #0")),
            "t.pml:12: expected one neighbourhood for each atom, got another for atom 0; the first is on line 11");
  EXPECT_EQ(refusal(named("Atom #1", "POLY_LINE")),
            "t.pml:12: expected a neighbourhood of type POLY_VERTEX, got POLY_LINE");
  EXPECT_EQ(refusal(pml_text(tetrahedron_atoms, {tetrahedron_cell},
                             "<informativeComponents><multiComponent>\n<structuralComponent name=\"Neighborhoods\"/>\n"
                             "<structuralComponent name=\"Neighborhoods\"/></multiComponent></informativeComponents>")),
            "t.pml:16: expected one component \"Neighborhoods\", got a second one; the first is on line 15; put their "
            "cells together");
}

TEST(PmlErrors, Structure) {
  EXPECT_EQ(refusal("<loads/>"), "t.pml:1: expected <physicalModel>, got <loads>; read loads with read_lml");
  EXPECT_EQ(refusal("\n<physicalModel/>"), "t.pml:2: expected <atoms> in <physicalModel>, got none");
  EXPECT_EQ(refusal("<physicalModel>\n<atoms/></physicalModel>"),
            "t.pml:2: expected at least one <atom> in <atoms>, got none");
  EXPECT_EQ(refusal("<physicalModel>\n<atoms/>\n<atoms/></physicalModel>"),
            "t.pml:3: expected one <atoms>, got a second one; the first is on line 2");
  EXPECT_EQ(refusal(with_element("") + "<a/>"), "t.pml:16: expected one root element, got a second one, <a>");
  EXPECT_EQ(refusal(pml_text(tetrahedron_atoms, {}, "", "dimension=\"4\"")),
            "t.pml:1: expected dimension 2 or 3, got \"4\"");
  EXPECT_EQ(refusal(pml_text(tetrahedron_atoms, {}, "", "dimension=\"2\"")),
            "t.pml:7: expected z = 0 in a file of dimension 2, got \"1\"");
  EXPECT_TRUE(
      says(refusal(with_element(cell_text("LINE", {0, 1}, "phymul=\"row=3\""))), "expected the row=N of every cell"));
  for (const char* const mark : {"share=1.5", "share=x", "cut=", "cut=1,,2"}) {
    EXPECT_NE(refusal(with_element(cell_text("TETRAHEDRON", {0, 1, 2, 3}, "phymul=\"" + std::string(mark) + "\""))), "")
        << mark;
  }
  EXPECT_TRUE(says(refusal(with_element(cell_text("LINE", {0, 1}, "phymul=\"cut=1,2\""))), "expected a cut only of"));
  EXPECT_TRUE(says(refusal(with_element(cell_text("TETRAHEDRON", {0, 1, 2, 3}, "phymul=\"cut=1,2,3\""))),
                   "got 3 numbers of a cell of type TETRAHEDRON"));
  EXPECT_TRUE(says(refusal(with_element(cell_text("LINE", {0, 1}, "phymul=\"rows\""))),
                   "t.pml:12: expected attribute \"phymul\""));
}

TEST(PmlErrors, NotXml) {
  const std::string text = with_element("");
  for (std::size_t length = 0; length + 2 < text.size(); length += 7) {
    const std::string message = refusal(text.substr(0, length));
    EXPECT_EQ(message.rfind("t.pml:", 0), 0u) << "cut after " << length << " bytes: " << message;
  }
  EXPECT_EQ(refusal(""),
            "t.pml:1: expected well-formed XML, got \"No document element found\"; is the file damaged or cut short?");
  EXPECT_EQ(refusal("<physicalModel>\n<atoms>\n</physicalModel>"),
            "t.pml:3: expected well-formed XML, got \"Start-end tags mismatch\"; is the file damaged or cut short?");
  EXPECT_EQ(refusal(std::string("<physicalModel>\n\0</physicalModel>", 33)),
            "t.pml:2: expected XML in UTF-8, got a zero byte; binary files and UTF-16 are not read");
}

TEST(PmlErrors, EntityBomb) {
  std::string bomb = "<?xml version=\"1.0\"?>\n<!DOCTYPE physicalModel [\n<!ENTITY a \"aaaaaaaaaa\">\n";
  for (char name = 'b'; name <= 'k'; ++name) {
    bomb += std::string("<!ENTITY ") + name + " \"";
    for (int i = 0; i < 10; ++i) bomb += std::string("&") + static_cast<char>(name - 1) + ';';
    bomb += "\">\n";
  }
  EXPECT_EQ(refusal(bomb + "]>\n" + replaced(with_element(""), "name=\"t\"", "name=\"&k;\"")),
            "t.pml:2: expected a file without entity declarations, got a DOCTYPE with <!ENTITY; write the text itself "
            "where &name; stands");
  EXPECT_EQ(refusal("<!DOCTYPE physicalModel SYSTEM \"physicalmodel.dtd\">\n" + with_element("")), "(no error)");
}

TEST(PmlErrors, OfManyAttributesTheRepeatedOneIsNamed) {
  std::string attributes;
  for (int k = 0; k < 50'000; ++k) attributes += " a" + std::to_string(k) + "=''";
  const auto start = std::chrono::steady_clock::now();
  EXPECT_TRUE(refuses([&] { read_pml_text("<physicalModel" + attributes + " a7=''/>", "t.pml"); },
                      "expected each attribute once in <physicalModel>, got \"a7\" twice"));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2));  // each with each: 10 s
}

TEST(PmlErrors, ReferencesToControlCharacters) {
  for (const char* const wrong : {"&#0;", "&#1;", "&#x1F;", "&#0011;", "&#4294967297;", "&#x110000;", "&#xD800;"}) {
    EXPECT_TRUE(refuses([&] { read_pml_text(std::string("<physicalModel\nname='a") + wrong + "b'/>", "t.pml"); },
                        "t.pml:2: expected references to characters of text, got \"" + std::string(wrong) + '"'));
  }
  for (const char* const right : {"&#9;", "&#xA;", "&#13;", "&#228;", "&#;", "&#1"}) {
    EXPECT_FALSE(refuses([&] { read_pml_text(std::string("<physicalModel name='a") + right + "b'/>", "t.pml"); },
                         "characters of text"))
        << right;
  }
  for (const char* const mark : {"<!--", "<![CDATA[", "<?"}) {  // a value, whatever it looks like
    EXPECT_TRUE(
        refuses([&] { read_pml_text(std::string("<physicalModel nbA='") + mark + "' name='a&#0;b'/>", "t.pml"); },
                "characters of text"));
  }
  for (const char* const text : {"<!-- &#0; -->", "<?note &#0; ?>", "<![CDATA[&#0;]]>", "<!-- &#0;", "<"}) {
    EXPECT_FALSE(refuses([&] { read_pml_text(std::string("<physicalModel>") + text + "</physicalModel>", "t.pml"); },
                         "characters of text"))
        << text;
  }
}

TEST(PmlErrors, DeepNesting) {
  std::string deep = pml_text(tetrahedron_atoms, {}, "<informativeComponents>\n");
  deep = deep.substr(0, deep.rfind("</physicalModel>"));
  const std::size_t depth = 500'000;
  for (std::size_t i = 0; i < depth; ++i) deep += "<multiComponent>";
  for (std::size_t i = 0; i < depth; ++i) deep += "</multiComponent>";
  EXPECT_EQ(refusal(deep + "</informativeComponents></physicalModel>"),
            "t.pml:14: expected elements nested at most 256 deep, got more");
}

TEST(PmlErrors, Files) {
  const std::string folder = testing::TempDir();
  const std::string missing = folder + "/phymul_no_such_file.pml";
  EXPECT_EQ(message_of([&] { read_pml(missing); }),
            missing + ": cannot be opened (No such file or directory); check the name and the right to read it");
  EXPECT_EQ(message_of([&] { read_pml(folder); }), folder + ": expected a file, got a folder");
  const std::string path = folder + "/phymul_limit.pml";
  std::ofstream(path, std::ios::binary) << with_element("");
  PmlOptions options{.max_bytes = 100};
  EXPECT_EQ(message_of([&] { read_pml(path, options); }),
            path + ": expected at most 100 bytes, got more; raise max_bytes if the file is meant");
  options.max_bytes = with_element("").size();
  EXPECT_EQ(read_pml(path, options).particle_count(), 4);
  std::filesystem::remove(path);
  if (std::filesystem::exists("/dev/zero")) {
    options.max_bytes = 1 << 20;
    EXPECT_TRUE(refuses([&] { read_pml("/dev/zero", options); }, "expected at most 1048576 bytes"));
  }
}

TEST(PmlErrors, Options) {
  PmlOptions options{.default_mass = 0};
  EXPECT_EQ(refusal(with_element(""), options), "PmlOptions: expected a positive default_mass in kg, got 0");
  options = {};
  options.length_unit = -1;
  EXPECT_EQ(refusal(with_element(""), options), "PmlOptions: expected a positive length_unit in metres, got -1");
  options = {};
  options.default_stiffness = -1;
  EXPECT_EQ(refusal(with_element(""), options), "PmlOptions: expected a default_stiffness of 0 N/m or more, got -1");
}

}  // namespace
}  // namespace phymul
