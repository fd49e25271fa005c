#include "planish/limit/adaptive_blocks.h"

#include <algorithm>
#include <vector>

#include "planish/core/stop.h"
#include "planish/limit/bilinear_at.h"
#include "planish/limit/field_at.h"
#include "planish/surface/doo_sabin_blocks.h"

namespace planish {
namespace {

std::span<const AdaptivePlace> part_of(const RawVector<AdaptivePlace>& places, RowRange range) {
  return std::span(places).subspan(static_cast<std::size_t>(range.first),
                                   static_cast<std::size_t>(range.count));
}

}  // namespace

bool AdaptiveBlocks::uvs_of(std::span<const glm::dvec2> given, RowRange uvs,
                            std::span<glm::dvec2> values) const {
  field_at(lies_on_, lies_on_.surface().uv_field_of(given), part_of(adaptive_.uv_places, uvs),
           [&](std::size_t i, const glm::dvec2& uv) { values[i] = uv; });
  // Those of the mesh come first, also where no corner names them.
  const auto own = static_cast<std::int64_t>(given.size());
  for (std::int64_t row = uvs.first; row < std::min(uvs.first + uvs.count, own); ++row)
    values[row - uvs.first] = given[row];
  return true;
}

bool AdaptiveBlocks::rows_of(std::span<const glm::vec4> given, RowRange rows,
                             std::span<glm::vec4> values) const {
  const MeshTopology& topology = lies_on_.topology();
  const auto& vertices = lies_on_.surface().used().vertices;
  const auto at = [&](std::int32_t corner) {
    return glm::dvec4(given[vertices[topology.vertex_of(corner)]]);
  };
  bilinear_at<glm::dvec4>(
      topology, part_of(adaptive_.places, rows), at,
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
