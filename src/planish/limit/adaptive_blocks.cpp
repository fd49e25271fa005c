#include "planish/limit/adaptive_blocks.h"

#include <algorithm>
#include <vector>

#include "planish/core/stop.h"
#include "planish/limit/field_at.h"
#include "planish/surface/doo_sabin_blocks.h"

namespace planish {
namespace {

// Those of the mesh come first, also where no corner names them.
template <class Vector, class Stored>
void write_corner_rows(const LimitSurface& surface, const ChartField<Vector>& field,
                       std::span<const AdaptivePlace> places, std::span<const Stored> given,
                       std::span<Stored> values) {
  field_at(surface, field, places,
           [&](std::size_t i, const Vector& value) { values[i] = Stored(value); });
  std::ranges::copy(given, values.begin());
}

}  // namespace

bool AdaptiveBlocks::uvs_of(std::span<const glm::dvec2> given, std::span<glm::dvec2> values) const {
  write_corner_rows(lies_on_, lies_on_.surface().uv_field_of(given), adaptive_.uv_places, given,
                    values);
  return true;
}

bool AdaptiveBlocks::corners_of(std::span<const glm::vec4> given,
                                std::span<glm::vec4> values) const {
  write_corner_rows(lies_on_, lies_on_.surface().corner_field_of(given), adaptive_.uv_places, given,
                    values);
  return true;
}

bool AdaptiveBlocks::rows_of(std::span<const glm::vec4> given, std::span<glm::vec4> values) const {
  std::vector<glm::vec4> used;
  for (const std::int32_t vertex : lies_on_.surface().used().vertices)
    used.push_back(given[vertex]);
  field_at(lies_on_, lies_on_.surface().vertex_field_of(used), adaptive_.places,
           [&](std::size_t i, const glm::dvec4& value) { values[i] = glm::vec4(value); });
  return true;
}

SurfaceMesh AdaptiveBlocks::rows_on(const LimitSurface& other) const {
  constexpr std::size_t kAtOnce = std::size_t{1} << 14;
  const std::size_t count = adaptive_.places.size();
  SurfaceMesh made;
  made.positions.resize(count);
  made.normals.resize(count);
  std::vector<SurfaceParameter> places;
  std::vector<SurfacePoint> points;
  for (std::size_t first = 0; first < count; first += kAtOnce) {
    check_stop();
    places.clear();
    const std::size_t end = std::min(count, first + kAtOnce);
    for (std::size_t row = first; row < end; ++row) {
      const AdaptivePlace& at = adaptive_.places[row];
      places.push_back(
          surface_parameter(other.topology(), at.corner, share_of_side(at.u), share_of_side(at.v)));
    }
    points.resize(places.size());
    other.evaluate(places, points);
    for (std::size_t row = first; row < end; ++row) {
      made.positions[row] = points[row - first].position;
      made.normals[row] = glm::vec3(points[row - first].normal);
    }
  }
  return made;
}

}  // namespace planish
