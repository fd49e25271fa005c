#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/vec4.hpp>
#include <span>
#include <string>
#include <vector>

namespace planish {

/// What numbers of vertices are called, and how many each has.
struct AttributeName {
  std::string name;
  int width = 1;
};

struct NumberRun;

/// Numbers that each vertex has besides, as PLY's `quality`. On a surface they go smoothly from one
/// vertex to the next and never past the values around (linearly with other schemes than
/// Doo-Sabin); up to four that add up to a constant do so everywhere.
struct VertexAttribute {
  std::string name;  ///< letters, digits and '_', no digit first; no two differ by case alone
  std::vector<float> values;  ///< finite, `width` of each vertex, one vertex after another
  int width = 1;

  [[nodiscard]] std::size_t count() const {
    return width > 0 ? values.size() / static_cast<std::size_t>(width) : 0;
  }
  /// One value a vertex of a run.
  void set_run(std::size_t vertex, const NumberRun& run, const glm::vec4& four);
  /// Up to four numbers of a vertex, from the one of number `first` on; the rest is 0.
  [[nodiscard]] glm::vec4 four(std::size_t vertex, int first) const {
    glm::vec4 result(0.0f);
    for (int k = 0; k < std::min(width - first, 4); ++k)
      result[k] =
          values[static_cast<std::size_t>(width) * vertex + static_cast<std::size_t>(first + k)];
    return result;
  }
  void set_four(std::size_t vertex, int first, const glm::vec4& four) {
    for (int k = 0; k < std::min(width - first, 4); ++k)
      values[static_cast<std::size_t>(width) * vertex + static_cast<std::size_t>(first + k)] =
          four[k];
  }
};

/// Room for the same numbers of so many vertices.
[[nodiscard]] VertexAttribute attribute_of_size(const std::string& name, int width,
                                                std::size_t count);

/// Of each vertex, of all attributes.
[[nodiscard]] std::uint64_t numbers_of(std::span<const VertexAttribute> attributes);

/// Numbers of a vertex that stand together: of the attribute from `column` on, in a four from
/// `lane` on.
struct NumberRun {
  std::size_t four;
  int lane, column, count;
};

/// The numbers of all attributes, one after another, make fours; those of an attribute of up to
/// four stand in one. Where those of one attribute are.
[[nodiscard]] std::vector<NumberRun> runs_of(std::span<const VertexAttribute> attributes,
                                             std::size_t index);

/// That four of every vertex; 0 behind the last number.
[[nodiscard]] std::vector<glm::vec4> four_of(std::span<const VertexAttribute> attributes,
                                             std::size_t four);

/// Attributes of those vertices alone, in their order.
[[nodiscard]] std::vector<VertexAttribute> attributes_of(std::span<const VertexAttribute> given,
                                                         std::span<const std::int32_t> vertices);

/// Throws Error{InvalidArgument} for a name that files cannot hold or that is there twice, and for
/// the first value that is not finite.
void require_attributes(std::span<const VertexAttribute> attributes);

}  // namespace planish
