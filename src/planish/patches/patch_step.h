#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/doosabin/face_rule.h"
#include "planish/patches/vector_sum.h"

namespace planish {

class PatchRings;

/// Rows of weights that are mostly zeros: how points follow from a patch's control points.
struct PatchRows {
  std::vector<std::int32_t> offsets{0};  ///< row_count + 1
  std::vector<std::int32_t> columns;
  std::vector<double> weights;

  [[nodiscard]] bool empty() const { return columns.empty(); }
  [[nodiscard]] std::size_t row_count() const { return offsets.size() - 1; }
  void end_row() { offsets.push_back(static_cast<std::int32_t>(columns.size())); }
  void add(std::int32_t column, double weight);
  [[nodiscard]] VectorSum combine(std::size_t row, const glm::dvec3* points) const {
    VectorSum sum;
    for (auto i = static_cast<std::size_t>(offsets[row]);
         i < static_cast<std::size_t>(offsets[row + 1]); ++i)
      sum.add(weights[i], points[columns[i]]);
    return sum;
  }
};

/// How the points of a patch's quarter follow from the patch's K. Every point of a ring of n has
/// weights of all n, but they are a few sums of the ring and little more: so large rings have a few
/// entries a row instead of n.
struct PatchStep {
  PatchRows sums;  ///< of the patch's points; none where rings are small
  PatchRows rows;  ///< column K + i is sum i

  /// The quarter's points, of `points` (K).
  void apply(std::span<const glm::dvec3> points, std::vector<glm::dvec3>& result) const;
};

/// The step to quarter 0 to 3 of a patch of `column_count` control points.
[[nodiscard]] PatchStep make_step(const PatchRings& rings, int quarter, const FaceWeights& weights,
                                  std::int32_t column_count);

/// Dense rows over the points that `map` makes, as rows over the `columns` that it takes.
[[nodiscard]] std::vector<double> pulled_back(std::span<const double> rows, const PatchRows& map,
                                              std::size_t columns);
[[nodiscard]] std::vector<double> pulled_back(std::span<const double> rows, const PatchStep& step,
                                              std::size_t columns);

}  // namespace planish
