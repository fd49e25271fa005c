#include "planish/backend/initial_residual.h"

#include "planish/core/parallel.h"

namespace planish {
namespace {

// A sum of points about its first one, and the sum of its weights.
struct SumAbout {
  glm::dvec3 origin{0.0}, sum{0.0};
  double weight = 0;

  // Of (from - point) over its points.
  [[nodiscard]] glm::dvec3 way_from(const glm::dvec3& from) const {
    return weight * (from - origin) - sum;
  }
};

SumAbout sum_about(const StencilView<double>& sums, std::size_t row,
                   std::span<const glm::dvec3> points) {
  const auto first = static_cast<std::size_t>(sums.offsets[row]);
  SumAbout result{points[sums.indices[first]]};
  for (std::size_t k = first; k < first + static_cast<std::size_t>(sums.sizes[row]); ++k) {
    result.sum += sums.weights[k] * (points[sums.indices[k]] - result.origin);
    result.weight += sums.weights[k];
  }
  return result;
}

}  // namespace

RawVector<glm::dvec3> initial_residual(const SummedView& masks, std::span<const glm::dvec3> given) {
  const StencilView<double>& rows = masks.rows;
  RawVector<SumAbout> sums(static_cast<std::size_t>(masks.sum_count()));
  parallel_each(sums.size(), 1, [&](std::size_t s) { sums[s] = sum_about(masks.sums, s, given); });
  RawVector<glm::dvec3> residual(given.size());
  parallel_each(given.size(), [&](std::size_t i) {
    glm::dvec3 sum(0.0);
    for (std::int32_t k = rows.offsets[i]; k < rows.offsets[i] + rows.sizes[i]; ++k) {
      const auto source = static_cast<std::size_t>(rows.indices[k]);
      sum += rows.weights[k] * (source < given.size()
                                    ? given[i] - given[source]
                                    : sums[source - given.size()].way_from(given[i]));
    }
    residual[i] = sum;
  });
  return residual;
}

RawVector<glm::dvec3> sums_of(const SummedView& table, std::span<const glm::dvec3> points) {
  const StencilView<double>& sums = table.sums;
  RawVector<glm::dvec3> result(static_cast<std::size_t>(table.sum_count()));
  parallel_each(result.size(), 1, [&](std::size_t row) {
    glm::dvec3 sum(0.0);
    for (std::int32_t k = sums.offsets[row]; k < sums.offsets[row] + sums.sizes[row]; ++k)
      sum += sums.weights[k] * points[sums.indices[k]];
    result[row] = sum;
  });
  return result;
}

}  // namespace planish
