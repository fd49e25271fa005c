#include "planish/backend/initial_residual.h"

#include "planish/core/parallel.h"

namespace planish {

RawVector<glm::dvec3> initial_residual(const StencilView<double>& masks,
                                       std::span<const glm::dvec3> given) {
  RawVector<glm::dvec3> residual(given.size());
  parallel_each(given.size(), [&](std::size_t i) {
    glm::dvec3 sum(0.0);
    for (std::int32_t k = masks.offsets[i]; k < masks.offsets[i] + masks.sizes[i]; ++k) {
      sum += masks.weights[k] * (given[i] - given[masks.indices[k]]);
    }
    residual[i] = sum;
  });
  return residual;
}

}  // namespace planish
