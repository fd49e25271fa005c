#include "planish/files/ply/ply_header.h"

#include <algorithm>
#include <array>
#include <utility>

#include "planish/core/number_text.h"
#include "planish/files/shared/text_lines.h"

namespace planish {
namespace {

constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypes = {{
    {"char", PlyType::Int8},
    {"uchar", PlyType::UInt8},
    {"short", PlyType::Int16},
    {"ushort", PlyType::UInt16},
    {"int", PlyType::Int32},
    {"uint", PlyType::UInt32},
    {"float", PlyType::Float32},
    {"double", PlyType::Float64},
    {"int8", PlyType::Int8},
    {"uint8", PlyType::UInt8},
    {"int16", PlyType::Int16},
    {"uint16", PlyType::UInt16},
    {"int32", PlyType::Int32},
    {"uint32", PlyType::UInt32},
    {"float32", PlyType::Float32},
    {"float64", PlyType::Float64},
}};

PlyType read_type(std::string_view word, const TextLines& lines) {
  const auto found = std::ranges::find(kTypes, word, &std::pair<std::string_view, PlyType>::first);
  if (found == kTypes.end()) lines.fail("unknown type " + quote(word));
  return found->second;
}

PlyFormat read_format(Words words, const TextLines& lines) {
  const std::string_view format = words.next();
  const std::string_view version = words.next();
  if (version != "1.0") lines.fail("PLY version " + quote(version) + " is not 1.0");
  if (format == "ascii") return PlyFormat::Text;
  if (format == "binary_little_endian") return PlyFormat::LittleEndian;
  if (format == "binary_big_endian") return PlyFormat::BigEndian;
  lines.fail("unknown format " + quote(format));
}

PlyElement read_element(Words words, const TextLines& lines) {
  PlyElement element{.name = std::string(words.next())};
  const std::string_view count = words.next();
  if (!parse_integer(count, element.count) || element.count < 0)
    lines.fail("element count " + quote(count) + " is no integer from 0");
  return element;
}

PlyProperty read_property(Words words, const TextLines& lines) {
  PlyProperty property{};
  std::string_view word = words.next();
  if (word == "list") {
    property.count_type = read_type(words.next(), lines);
    if (*property.count_type == PlyType::Float32 || *property.count_type == PlyType::Float64)
      lines.fail("a list cannot be counted by a floating-point number");
    word = words.next();
  }
  property.type = read_type(word, lines);
  property.name = words.next();
  if (property.name.empty()) lines.fail("property without a name");
  return property;
}

// Of two properties of one name nobody could say which counts.
void add_property(Words words, const TextLines& lines, PlyElement& element) {
  PlyProperty property = read_property(words, lines);
  if (std::ranges::find(element.properties, property.name, &PlyProperty::name) !=
      element.properties.end())
    lines.fail("element " + quote(element.name) + " has two properties " + quote(property.name) +
               "; rename one");
  element.properties.push_back(std::move(property));
}

// A line that may be a misspelt element or property, on which the places of all values depend,
// cannot be passed over.
void pass_over(Words words, std::string_view keyword, const TextLines& lines, PlyHeader& header) {
  const std::string what = "unknown keyword " + quote(keyword);
  std::array<std::string_view, 5> rest;
  std::size_t count = 0;
  for (std::string_view word = words.next(); !word.empty(); word = words.next())
    rest[std::min(count++, rest.size() - 1)] = word;
  std::int64_t ignored = 0;
  const bool may_be_element = count == 2 && parse_integer(rest[1], ignored);
  const bool may_be_property = !header.elements.empty() && (count == 2 || count == 4);
  if (may_be_element || may_be_property) lines.fail(what);
  lines.note(header.unknown, what);
}

}  // namespace

std::size_t byte_count_of(PlyType type) {
  switch (type) {
    case PlyType::Int8:
    case PlyType::UInt8:
      return 1;
    case PlyType::Int16:
    case PlyType::UInt16:
      return 2;
    case PlyType::Int32:
    case PlyType::UInt32:
    case PlyType::Float32:
      return 4;
    case PlyType::Float64:
      return 8;
  }
  return 0;
}

std::size_t PlyElement::least_bytes() const {
  std::size_t bytes = 0;
  for (const PlyProperty& property : properties)
    bytes += byte_count_of(property.count_type.value_or(property.type));
  return bytes;
}

std::optional<std::size_t> PlyElement::fixed_bytes(const PlyProperty* besides) const {
  std::size_t bytes = 0;
  for (const PlyProperty& property : properties) {
    if (&property == besides) continue;
    if (property.count_type) return std::nullopt;
    bytes += byte_count_of(property.type);
  }
  return bytes;
}

PlyHeader read_ply_header(const FileBytes& file) {
  TextLines lines = TextLines::of_header(file);
  PlyHeader header;
  bool has_format = false;
  const bool has_line = lines.next();
  Words first(lines.line());
  if (!has_line || first.next() != "ply" || !first.next().empty())
    lines.fail(quote(lines.line()) + " stands in the place of `ply`");
  while (lines.next()) {
    Words words(lines.line());
    const std::string_view keyword = words.next();
    if (keyword == "end_header") {
      if (!has_format) lines.fail("the header names no format");
      header.byte_count = file.bytes.size() - lines.bytes_left();
      header.line_count = lines.number();
      return header;
    }
    if (keyword == "format") {
      header.format = read_format(words, lines);
      has_format = true;
    } else if (keyword == "element") {
      header.elements.push_back(read_element(words, lines));
    } else if (keyword == "property") {
      if (header.elements.empty()) lines.fail("property before the first element");
      add_property(words, lines, header.elements.back());
    } else if (keyword == "comment") {
      const std::size_t begin = words.rest().find_first_not_of(' ');
      header.comments.emplace_back(begin == std::string_view::npos ? ""
                                                                   : words.rest().substr(begin));
    } else if (!keyword.empty() && keyword != "obj_info") {
      pass_over(words, keyword, lines, header);
    }
  }
  lines.fail("the file ends inside the header");
}

}  // namespace planish
