// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/error.h>
#include <phymul/types.h>

#include <iosfwd>
#include <string>
#include <string_view>

namespace phymul {

/// Appends text as an attribute or element holds it. Throws Error for control characters, which XML cannot hold.
void append_xml_text(std::string& out, std::string_view text);

/// Writes XML to a stream in large pieces, independent of the stream's locale and format flags. Calls follow the
/// document: open, attributes, then text or children, close. Throws Error for what XML cannot hold.
class XmlWriter {
 public:
  /// Writes the declaration.
  explicit XmlWriter(std::ostream& out);

  void open(const char* element);
  void attribute(std::string_view name, std::string_view value);
  void attribute(std::string_view name, Index value);
  void attribute(std::string_view name, std::size_t value);
  void attribute(std::string_view name, double value);
  void raw_attribute(std::string_view name, std::string_view value);  ///< value needs no escaping
  void text(std::string_view text);
  void instruction(const char* content);  ///< a processing instruction, for readers that know it
  void close();

  /// One child element with one index, the shape of most of a file.
  void leaf(const char* element, const char* name, std::size_t value);

  /// Hands everything to the stream. Throws Error when the stream failed.
  void finish();

 private:
  void end_start_tag();

  std::ostream& out_;
  std::string buffer_;
  std::string open_elements_;  // names, each followed by '/'
  bool in_start_tag_ = false;
};

}  // namespace phymul
