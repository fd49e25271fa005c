#include "planish/limit/limit_attributes.h"

#include "planish/core/parallel.h"
#include "planish/patches/patch_attributes.h"

namespace planish {

std::vector<float> attribute_at(const LimitSurface& surface, std::size_t index,
                                std::span<const SurfaceParameter> places) {
  constexpr std::size_t kGrain = 1024;
  const MeshTopology& topology = surface.topology();
  const VertexAttribute& given = surface.surface().mesh().attributes[index];
  VertexAttribute made = attribute_of_size(given.name, given.width, places.size());
  parallel_each(places.size(), kGrain, [&](std::size_t i) {
    const CornerParameter at = corner_parameter(topology, places[i]);
    for (int first = 0; first < given.width; first += 4) {
      const auto square = square_values(topology, at.corner, [&](std::int32_t corner) {
        return glm::dvec4(given.four(static_cast<std::size_t>(topology.vertex_of(corner)), first));
      });
      made.set_four(i, first, glm::vec4(bilinear(square, at.u, at.v)));
    }
  });
  return std::move(made.values);
}

}  // namespace planish
