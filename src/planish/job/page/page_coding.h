#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "planish/core/json.h"
#include "planish/job/page/page_order.h"

namespace planish {

/// Numbers on their way into a page: whole numbers less what is expected of them, by bytes of equal
/// weight, deflated. Nothing but subtraction and a table is needed to read it, see viewer/data.js.
///
/// A section of `count` vectors of `components` numbers of `width` bytes holds for each component,
/// for each byte from the lowest, that byte of all numbers. A number is the difference from what is
/// expected, zigzagged: 0, -1, 1, -2, ... as 0, 1, 2, 3, ..., modulo 2^(8 width).
class PageCoder {
 public:
  /// Expected is the number before.
  void add_list(const std::string& name, std::span<const std::int32_t> values);
  /// `values`: one vector a vertex, unsigned and below 2^(8 width). Expected is the mean of the
  /// parents, rounded to nearest, halves up; on level 0 the value before. Vertices that `order` has
  /// more of are left out.
  void add_values(const std::string& name, std::span<const std::uint16_t> values, int width,
                  int components, const PageOrder& order);

  /// Where everything lies in the bytes: [{"name", "count", "width", "components", "offset"}, ...].
  [[nodiscard]] const nlohmann::ordered_json& sections() const { return sections_; }
  /// All sections as one raw deflate stream in base64.
  [[nodiscard]] std::string base64() const;

 private:
  void begin(const std::string& name, std::size_t count, int width, int components);
  void put(std::size_t plane, std::size_t count, std::size_t i, int width, std::int64_t difference);

  std::vector<std::uint8_t> bytes_;
  nlohmann::ordered_json sections_ = nlohmann::ordered_json::array();
};

/// Bytes in base64, padded.
[[nodiscard]] std::string base64_text(std::span<const std::uint8_t> bytes);

}  // namespace planish
