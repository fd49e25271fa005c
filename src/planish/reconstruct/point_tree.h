#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace planish {

struct Neighbour {
  double squared_distance;
  std::int32_t index;
};

/// Finds nearest points (k-d tree, split at medians). Copies the points; queries may run in
/// parallel.
class PointTree {
 public:
  explicit PointTree(std::span<const glm::dvec3> points);

  /// Fills `nearest` with the points nearest to `query`, nearest first, a point at `query` itself
  /// included. Returns how many there are, nearest.size() unless the cloud is smaller.
  std::size_t find_nearest(const glm::dvec3& query, std::span<Neighbour> nearest) const;

 private:
  struct Search;
  void build(std::int32_t begin, std::int32_t end);
  void search(std::int32_t begin, std::int32_t end, Search& state) const;

  std::vector<std::int32_t> indices_;  // in tree order: a node's point stands in its middle
  std::vector<glm::dvec3> points_;     // in tree order
  std::vector<std::uint8_t> axes_;     // of the split at each middle
};

}  // namespace planish
