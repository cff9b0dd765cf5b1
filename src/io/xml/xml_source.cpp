// SPDX-License-Identifier: MIT
#include "xml_source.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <limits>
#include <pugixml.hpp>

#include "base/decimal.h"
#include "base/files.h"

namespace phymul {
namespace {

constexpr int max_depth = 256;           // far above any real file: components nest by anatomy, not by data
constexpr std::size_t max_notes = 1000;  // a wrong file may hold a flaw per atom

/// Names in old files are often in Latin-1, and say so. Converted here, not by the parser, whose offsets would then no
/// longer be those of the file.
bool declares_latin1(std::string_view text) {
  std::string head(text.substr(0, text.substr(0, 200).find('>')));
  std::transform(head.begin(), head.end(), head.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : c; });
  return head.find("<?xml") != std::string::npos &&
         (head.find("iso-8859-1") != std::string::npos || head.find("latin1") != std::string::npos);
}

/// Bytes of the character that a text begins with, if it is one of UTF-8 beyond ASCII; else 0.
std::size_t utf8_size(std::string_view text) {
  const auto at = [&](std::size_t k) { return k < text.size() ? static_cast<unsigned char>(text[k]) : 0; };
  const int lead = at(0), second = at(1);
  const std::size_t size = lead < 0xC2 || lead > 0xF4 ? 0 : lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
  for (std::size_t k = 1; k < size; ++k) {
    if ((at(k) & 0xC0) != 0x80) return 0;
  }
  const bool too_long = (lead == 0xE0 && second < 0xA0) || (lead == 0xF0 && second < 0x90);
  const bool no_character = (lead == 0xED && second >= 0xA0) || (lead == 0xF4 && second >= 0x90);
  return too_long || no_character ? 0 : size;
}

}  // namespace

std::string as_utf8(std::string text, bool is_latin1) {
  const auto is_ascii = [](char c) { return static_cast<unsigned char>(c) < 0x80; };
  if (std::ranges::all_of(text, is_ascii)) return text;
  std::string utf8;
  utf8.reserve(text.size() + text.size() / 8);
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::size_t size = is_latin1 ? 0 : utf8_size(std::string_view(text).substr(i));
    if (size > 0) {
      utf8.append(text, i, size);
      i += size - 1;
    } else if (is_ascii(text[i])) {
      utf8 += text[i];
    } else {
      const auto code = static_cast<unsigned char>(text[i]);
      utf8 += static_cast<char>(0xC0 | (code >> 6));
      utf8 += static_cast<char>(0x80 | (code & 0x3F));
    }
  }
  return utf8;
}

std::string_view repeated_attribute(pugi::xml_node node) {
  constexpr std::size_t few = 32;  // of which each is compared with each
  std::size_t count = 0;
  for (const pugi::xml_attribute attribute : node.attributes()) {
    if (++count > few) break;
    if (node.attribute(attribute.name()) != attribute) return attribute.name();  // the first of that name
  }
  if (count <= few) return {};
  std::vector<std::string_view> names;
  for (const pugi::xml_attribute attribute : node.attributes()) names.emplace_back(attribute.name());
  std::ranges::sort(names);
  const auto twice = std::ranges::adjacent_find(names);
  return twice != names.end() ? *twice : std::string_view();
}

XmlSource::XmlSource(std::string text, std::string name, bool instructions)
    : name_(std::move(name)), text_(std::move(text)), document_(std::make_unique<pugi::xml_document>()) {
  const bool is_latin1 = declares_latin1(text_);
  text_ = as_utf8(std::move(text_), is_latin1);
  const auto lines = static_cast<std::size_t>(std::count(text_.begin(), text_.end(), '\n'));
  line_end_.reserve(lines);
  for (std::size_t at = text_.find('\n'); at != std::string::npos; at = text_.find('\n', at + 1)) {
    line_end_.push_back(at);
  }
  const std::size_t zero = text_.find('\0');
  if (zero != std::string::npos) {
    fail_format(name_, line_at(zero), "expected XML in UTF-8, got a zero byte; binary files and UTF-16 are not read");
  }
  refuse_control_characters();
  parse(instructions);
  refuse_entities();
  check_elements();
}

XmlSource::~XmlSource() = default;

void XmlSource::parse(bool instructions) {
  const unsigned flags = pugi::parse_default | pugi::parse_doctype | (instructions ? pugi::parse_pi : 0u);
  const auto result = document_->load_buffer_inplace(text_.data(), text_.size(), flags, pugi::encoding_utf8);
  if (result.status == pugi::status_out_of_memory) fail_memory(name_);
  if (!result) {
    fail_format(name_, line_at(static_cast<std::size_t>(result.offset)),
                std::string("expected well-formed XML, got \"") + result.description() +
                    "\"; is the file damaged or cut short?");
  }
  std::size_t roots = 0;
  for (const pugi::xml_node node : document_->children()) {
    if (node.type() == pugi::node_element && ++roots == 2) {
      fail(node, "expected one root element, got a second one, <" + std::string(node.name()) + '>');
    }
  }
  if (roots == 0) fail_format(name_, 1, "expected an XML document, got no element");
}

/// References to characters that XML does not have: 0 would end a name, and write_pml refuses the others. What looks
/// like one in a comment, CDATA or an instruction is none; what looks like the beginning of these in a value is none,
/// either.
void XmlSource::refuse_control_characters() const {
  if (text_.find("&#") == std::string::npos) return;
  using Marks = std::pair<std::string_view, std::string_view>;
  bool in_tag = false;
  char quote = 0;
  for (std::size_t at = 0; at < text_.size(); ++at) {
    const char c = text_[at];
    if (c == '<' && !in_tag) {
      in_tag = true;
      for (const auto& [begin, end] : {Marks{"<!--", "-->"}, Marks{"<![CDATA[", "]]>"}, Marks{"<?", "?>"}}) {
        if (text_.compare(at, begin.size(), begin) != 0) continue;
        at = std::min(text_.find(end, at + begin.size()), text_.size() - 1);
        in_tag = false;
        break;
      }
    } else if (in_tag && quote == 0) {
      if (c == '"' || c == '\'') quote = c;
      if (c == '>') in_tag = false;
    } else if (c == quote) {
      quote = 0;
    }
    if (text_.compare(at, 2, "&#") != 0) continue;
    const bool hexadecimal = text_.compare(at + 2, 1, "x") == 0;
    const char* const digits = text_.data() + at + (hexadecimal ? 3 : 2);
    std::uint32_t code = 0;
    const auto [end, problem] = std::from_chars(digits, text_.data() + text_.size(), code, hexadecimal ? 16 : 10);
    if (end == digits || end == text_.data() + text_.size() || *end != ';') continue;  // no reference
    const bool is_blank = code == '\t' || code == '\n' || code == '\r';
    const bool is_half = code >= 0xD800 && code < 0xE000;  // of a pair in UTF-16
    if (problem == std::errc() && (code >= 0x20 || is_blank) && code <= 0x10FFFF && !is_half) continue;
    fail_format(name_, line_at(at),
                "expected references to characters of text, got " + cite({text_.data() + at, end + 1}));
  }
}

void XmlSource::refuse_entities() const {
  for (const pugi::xml_node node : document_->children()) {
    if (node.type() == pugi::node_doctype && std::strstr(node.value(), "<!ENTITY") != nullptr) {
      fail_format(name_, line(node),
                  "expected a file without entity declarations, got a DOCTYPE with <!ENTITY; write the text itself "
                  "where &name; stands");
    }
  }
}

void XmlSource::check_elements() const {
  // No recursion: the tree may be as deep as the file is long.
  const pugi::xml_node top = root();
  int depth = 1;
  for (pugi::xml_node node = top; node;) {
    if (depth > max_depth) {
      fail(node, "expected elements nested at most " + std::to_string(max_depth) + " deep, got more");
    }
    const std::string_view twice = repeated_attribute(node);
    if (!twice.empty()) {
      fail(node, "expected each attribute once in <" + std::string(node.name()) + ">, got " + cite(twice) + " twice");
    }
    if (node.first_child()) {
      node = node.first_child();
      ++depth;
      continue;
    }
    while (node != top && !node.next_sibling()) {
      node = node.parent();
      --depth;
    }
    if (node == top) break;
    node = node.next_sibling();
  }
}

pugi::xml_node XmlSource::root() const {
  return document_->document_element();
}

std::size_t XmlSource::line_at(std::size_t offset) const {
  const auto found = std::lower_bound(line_end_.begin(), line_end_.end(), offset);
  return static_cast<std::size_t>(found - line_end_.begin()) + 1;
}

std::size_t XmlSource::line(pugi::xml_node node) const {
  return line_at(static_cast<std::size_t>(std::max<std::ptrdiff_t>(node.offset_debug(), 0)));
}

std::string XmlSource::where(pugi::xml_node node) const {
  return name_ + ':' + std::to_string(line(node));
}

void XmlSource::fail(pugi::xml_node node, const std::string& message) const {
  fail_format(name_, line(node), message);
}

std::string_view XmlSource::text(pugi::xml_node node, const char* attribute) const {
  const pugi::xml_attribute found = node.attribute(attribute);
  if (!found) {
    fail(node, "expected attribute \"" + std::string(attribute) + "\" in <" + node.name() + ">, got none");
  }
  return found.value();
}

double XmlSource::number(pugi::xml_node node, const char* attribute) const {
  return number(node, attribute, text(node, attribute));
}

double XmlSource::number(pugi::xml_node node, const char* attribute, std::string_view value) const {
  const std::optional<double> parsed = parse_decimal(value);
  if (!parsed) {
    fail(node, std::string("expected a finite number with a decimal point in ") + attribute + ", got " + cite(value));
  }
  return *parsed;
}

Index XmlSource::index(pugi::xml_node node, const char* attribute) const {
  return index(node, attribute, text(node, attribute));
}

Index XmlSource::index(pugi::xml_node node, const char* attribute, std::string_view value) const {
  const std::optional<std::int64_t> parsed = parse_integer(value);
  constexpr Index largest = std::numeric_limits<Index>::max();
  if (!parsed || *parsed < 0 || *parsed > largest) {
    fail(node, std::string("expected a whole number from 0 to ") + std::to_string(largest) + " in " + attribute +
                   " of <" + node.name() + ">, got " + cite(value));
  }
  return static_cast<Index>(*parsed);
}

std::vector<Attribute> XmlSource::other_attributes(pugi::xml_node node,
                                                   std::initializer_list<std::string_view> known) const {
  std::vector<Attribute> others;
  for (const pugi::xml_attribute attribute : node.attributes()) {
    const std::string_view name = attribute.name();
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      others.push_back({std::string(name), attribute.value()});
    }
  }
  return others;
}

void XmlSource::skip(pugi::xml_node node) {
  if (node.type() != pugi::node_element) return;  // stray text carries nothing
  const std::string what = '<' + std::string(node.name()) + "> in <" + node.parent().name() + '>';
  if (skipped_.size() >= max_notes && !skipped_.contains(what)) return;
  const auto [entry, is_new] = skipped_.try_emplace(what);
  ++entry->second.count;
  if (!is_new) return;
  entry->second.note = notes_.size();
  notes_.push_back(where(node) + ": unknown element " + what + " was skipped");
}

void XmlSource::note(pugi::xml_node node, const std::string& message) {
  if (notes_.size() < max_notes) {
    notes_.push_back(where(node) + ": " + message);
  } else {
    ++notes_left_out_;
  }
}

std::vector<std::string> XmlSource::take_notes() {
  for (const auto& [what, skipped] : skipped_) {
    if (skipped.count > 1) notes_[skipped.note] += ", and " + std::to_string(skipped.count - 1) + " more of its kind";
  }
  if (notes_left_out_ > 0) notes_.push_back(name_ + ": " + std::to_string(notes_left_out_) + " further notes left out");
  return std::move(notes_);
}

void XmlSource::discard(pugi::xml_node node) {
  node.parent().remove_child(node);
}

std::string XmlSource::cite(std::string_view text) {
  constexpr std::size_t longest = 40;
  std::string cited = "\"";
  for (const char c : text.substr(0, longest)) cited += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? '?' : c;
  return cited + (text.size() > longest ? "...\"" : "\"");
}

}  // namespace phymul
