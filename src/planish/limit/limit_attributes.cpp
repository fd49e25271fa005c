#include "planish/limit/limit_attributes.h"

#include "planish/core/parallel.h"
#include "planish/limit/field_at.h"

namespace planish {

std::vector<float> attribute_at(const LimitSurface& surface, std::size_t index,
                                std::span<const SurfaceParameter> places) {
  constexpr std::size_t kGrain = 1024;
  const MeshTopology& topology = surface.topology();
  const PolygonMesh& mesh = surface.surface().mesh();
  const VertexAttribute& given = mesh.attributes[index];
  VertexAttribute made = attribute_of_size(given.name, given.width, places.size());
  for (const NumberRun& run : runs_of(mesh.attributes, index)) {
    const ChartField<glm::dvec4>& field = surface.surface().number_field(run.four);
    parallel_for(places.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      FieldAt<glm::dvec4> value(surface, field);
      for (std::size_t i = begin; i < end; ++i) {
        const CornerParameter at = corner_parameter(topology, places[i]);
        made.set_run(i, run, glm::vec4(value(at.corner, {at.u, at.v})));
      }
    });
  }
  return std::move(made.values);
}

}  // namespace planish
