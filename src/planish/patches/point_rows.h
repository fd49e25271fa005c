#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "planish/core/raw_vector.h"

namespace planish {

/// Limit points of vertices, faces and edges that patches make along, in any order: their rows,
/// positions in model coordinates and normals.
class PointRows {
 public:
  /// Drops all and takes room for so many.
  void reset(std::size_t capacity) {
    rows_.resize(capacity);
    positions_.resize(capacity);
    normals_.resize(capacity);
    count_ = 0;
  }
  /// There must be room. A point without values gets them later.
  void add(std::int32_t row) { rows_[count_++] = row; }
  void add(std::int32_t row, const double* position, const float* normal) {
    rows_[count_] = row;
    positions_[count_] = {position[0], position[1], position[2]};
    normals_[count_++] = {normal[0], normal[1], normal[2]};
  }

  [[nodiscard]] std::size_t size() const { return count_; }
  [[nodiscard]] std::span<const std::int32_t> rows() const { return {rows_.data(), count_}; }
  [[nodiscard]] std::span<glm::dvec3> positions() { return {positions_.data(), count_}; }
  [[nodiscard]] std::span<glm::vec3> normals() { return {normals_.data(), count_}; }

 private:
  RawVector<std::int32_t> rows_;
  RawVector<glm::dvec3> positions_;
  RawVector<glm::vec3> normals_;
  std::size_t count_ = 0;
};

}  // namespace planish
