#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace planish {

/// Points in the order of a Z-curve (spatial_order.h), so that neighbours in space are neighbours
/// in memory: 12 bytes a point where all coordinates are numbers of single precision, as most files
/// hold them, else 24; and 4 for the order. Places are those given, to the last bit.
class OrderedPoints {
 public:
  explicit OrderedPoints(std::span<const glm::dvec3> points);
  [[nodiscard]] std::size_t size() const { return given_.size(); }
  [[nodiscard]] glm::dvec3 operator[](std::size_t index) const {
    return doubles_.empty() ? glm::dvec3(floats_[index]) : doubles_[index];
  }
  /// The index that a point was given with.
  [[nodiscard]] std::int32_t given(std::size_t index) const { return given_[index]; }
  [[nodiscard]] std::span<const std::int32_t> given() const { return given_; }

  /// Drops the points that are marked, one mark each; the others keep their order.
  void drop(std::span<const std::uint8_t> is_dropped);
  /// Puts every point elsewhere; the order stays.
  void move_to(std::vector<glm::dvec3> places);

 private:
  std::vector<std::int32_t> given_;
  std::vector<glm::vec3> floats_;  // one of both is empty
  std::vector<glm::dvec3> doubles_;
};

/// Drops all but the first given of points at one place; returns how many.
std::int64_t drop_duplicates(OrderedPoints& points);

/// Length of the bounding box' diagonal; 0 for no points.
[[nodiscard]] double diagonal_of(const OrderedPoints& points);

}  // namespace planish
