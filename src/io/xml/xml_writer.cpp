// SPDX-License-Identifier: MIT
#include "xml_writer.h"

#include <algorithm>
#include <ostream>

#include "base/decimal.h"
#include "xml_source.h"

namespace phymul {
namespace {

constexpr std::size_t piece = 1 << 16;  // bytes handed to the stream at once

/// A cautious subset of XML's names; what our readers return always was a name of an XML file, so letters beyond ASCII
/// pass.
bool is_name(std::string_view name) {
  const auto starts = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == ':' ||
           static_cast<unsigned char>(c) >= 0x80;
  };
  return !name.empty() && starts(name.front()) && std::all_of(name.begin(), name.end(), [&](char c) {
    return starts(c) || (c >= '0' && c <= '9') || c == '-' || c == '.';
  });
}

}  // namespace

void append_xml_text(std::string& out, std::string_view text) {
  for (const char c : as_utf8(std::string(text))) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else if (c == '"') {
      out += "&quot;";
    } else if (c == '\n' || c == '\r' || c == '\t') {
      // As references: a reader turns the characters themselves into blanks.
      out.append("&#").append(std::to_string(code)).append(";");
    } else if (code < 0x20) {
      throw Error("expected text that XML can hold, got the control character " + std::to_string(code) + " in \"" +
                  std::string(text.substr(0, 40)) + '"');
    } else {
      out += c;
    }
  }
}

XmlWriter::XmlWriter(std::ostream& out) : out_(out) {
  buffer_.reserve(piece + piece / 4);
  buffer_ += "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
}

void XmlWriter::open(const char* element) {
  end_start_tag();
  buffer_.append("<").append(element);
  open_elements_.append(element).append("/");
  in_start_tag_ = true;
}

void XmlWriter::end_start_tag() {
  if (in_start_tag_) buffer_ += ">\n";
  in_start_tag_ = false;
}

void XmlWriter::attribute(std::string_view name, std::string_view value) {
  if (!is_name(name)) throw Error("expected a name that XML allows for an attribute, got \"" + std::string(name) + '"');
  buffer_.append(" ").append(name).append("=\"");
  append_xml_text(buffer_, value);
  buffer_ += '"';
}

void XmlWriter::attribute(std::string_view name, Index value) {
  raw_attribute(name, std::to_string(value));
}

void XmlWriter::attribute(std::string_view name, std::size_t value) {
  raw_attribute(name, std::to_string(value));
}

void XmlWriter::attribute(std::string_view name, double value) {
  raw_attribute(name, to_decimal(value));
}

void XmlWriter::raw_attribute(std::string_view name, std::string_view value) {
  buffer_.append(" ").append(name).append("=\"").append(value).append("\"");
}

void XmlWriter::text(std::string_view text) {
  if (in_start_tag_) buffer_ += '>';
  in_start_tag_ = false;
  append_xml_text(buffer_, text);
}

void XmlWriter::instruction(const char* content) {
  end_start_tag();
  buffer_.append("<?").append(content).append("?>\n");
}

void XmlWriter::close() {
  open_elements_.pop_back();
  const std::size_t start = open_elements_.rfind('/') + 1;  // npos + 1 == 0
  if (in_start_tag_) {
    buffer_ += "/>\n";
  } else {
    buffer_.append("</").append(open_elements_, start).append(">\n");
  }
  open_elements_.resize(start);
  in_start_tag_ = false;
  if (buffer_.size() >= piece) {
    out_.write(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    buffer_.clear();
  }
}

void XmlWriter::leaf(const char* element, const char* name, std::size_t value) {
  end_start_tag();
  buffer_.append("<").append(element).append(" ").append(name).append("=\"");
  buffer_.append(std::to_string(value)).append("\"/>\n");
}

void XmlWriter::finish() {
  out_.write(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
  buffer_.clear();
  out_.flush();
  if (!out_) throw Error(ErrorCode::file_access, "the output stream failed; is the disk full?");
}

}  // namespace phymul
