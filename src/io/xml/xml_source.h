// SPDX-License-Identifier: MIT
//
// An XML file as untrusted input: loaded within a byte limit, parsed in place, every node with its line.
#pragma once

#include <phymul/error.h>
#include <phymul/model.h>

#include <initializer_list>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace pugi {
class xml_document;
class xml_node;
}  // namespace pugi

namespace phymul {

/// The text with bytes that are no UTF-8 as letters of Latin-1; all that are not ASCII if it is Latin-1 throughout.
std::string as_utf8(std::string text, bool is_latin1 = false);

/// Name of an attribute that this element has twice, which the parser lets pass; empty if none.
std::string_view repeated_attribute(pugi::xml_node node);

class XmlSource {
 public:
  /// Parses. `name` stands for the file in messages. Throws Error for text that is no XML document, declares entities
  /// (nothing here needs them, and expanding them is how small files grow huge), nests elements deeper than 256, or
  /// gives an attribute twice, of which the parser takes either.
  /// `instructions`: processing instructions appear in the tree too.
  XmlSource(std::string text, std::string name, bool instructions = false);
  ~XmlSource();
  XmlSource(const XmlSource&) = delete;
  XmlSource& operator=(const XmlSource&) = delete;

  pugi::xml_node root() const;
  const std::string& name() const { return name_; }

  std::size_t line(pugi::xml_node node) const;
  std::string where(pugi::xml_node node) const;  ///< "file:line"
  [[noreturn]] void fail(pugi::xml_node node, const std::string& message) const;

  /// Value of an attribute that must be there.
  std::string_view text(pugi::xml_node node, const char* attribute) const;
  double number(pugi::xml_node node, const char* attribute) const;
  Index index(pugi::xml_node node, const char* attribute) const;

  /// The same from the text of an attribute at hand.
  double number(pugi::xml_node node, const char* attribute, std::string_view value) const;
  Index index(pugi::xml_node node, const char* attribute, std::string_view value) const;

  /// Attributes other than the known ones, in order.
  std::vector<Attribute> other_attributes(pugi::xml_node node, std::initializer_list<std::string_view> known) const;

  /// Remembers that this element is not understood and was passed over: one note for all of its kind.
  void skip(pugi::xml_node node);
  void note(pugi::xml_node node, const std::string& message);

  /// All notes, in the order they came. Call once.
  std::vector<std::string> take_notes();

  /// Gives back the memory of an element's tree.
  void discard(pugi::xml_node node);

  /// A piece of the file for a message: quoted, without control characters, shortened.
  static std::string cite(std::string_view text);

 private:
  std::size_t line_at(std::size_t offset) const;
  void refuse_control_characters() const;
  void parse(bool instructions);
  void refuse_entities() const;
  void check_elements() const;

  struct Skipped {
    std::size_t note = 0;
    std::size_t count = 0;
  };

  std::string name_;
  std::string text_;                   // owned by the parser once parse() has run: cut into names and values in place
  std::vector<std::size_t> line_end_;  // offset of every '\n'
  std::unique_ptr<pugi::xml_document> document_;
  std::vector<std::string> notes_;
  std::size_t notes_left_out_ = 0;
  std::map<std::string, Skipped> skipped_;
};

}  // namespace phymul
