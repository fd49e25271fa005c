#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "planish/files/shared/text_lines.h"

namespace planish {

enum class PlyType { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float32, Float64 };
[[nodiscard]] std::size_t byte_count_of(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type;
  std::optional<PlyType> count_type;  ///< of a list
};

struct PlyElement {
  std::string name;
  std::int64_t count = 0;
  std::vector<PlyProperty> properties;

  /// The fewest bytes of one entry in a binary file: every list is empty.
  [[nodiscard]] std::size_t least_bytes() const;
  /// The bytes of every entry in a binary file but those of one list; nothing where it has another.
  [[nodiscard]] std::optional<std::size_t> fixed_bytes(const PlyProperty* besides = nullptr) const;
};

enum class PlyFormat { Text, LittleEndian, BigEndian };

struct PlyHeader {
  PlyFormat format = PlyFormat::Text;
  std::vector<PlyElement> elements;
  std::vector<std::string> comments;  ///< without the word `comment`
  LineNote unknown;                   ///< lines of unknown words that are passed over
  std::size_t byte_count = 0;         ///< of the header
  std::int64_t line_count = 0;
};

/// Throws Error{UnreadableInput} `name:line: what`.
[[nodiscard]] PlyHeader read_ply_header(const FileBytes& file);

}  // namespace planish
