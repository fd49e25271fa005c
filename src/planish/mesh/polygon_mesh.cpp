#include "planish/mesh/polygon_mesh.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/core/vectors.h"
#include "planish/core/words.h"
#include "planish/mesh/check.h"

namespace planish {
namespace {

[[noreturn]] void refuse(const std::string& name, const std::string& what) {
  throw Error(ErrorCode::InvalidArgument, formatted("attribute \"{}\": {}", visible(name), what));
}

bool is_name(const std::string& name) {
  const auto is_of_name = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
  return !name.empty() && std::ranges::all_of(name, is_of_name) &&
         std::isdigit(static_cast<unsigned char>(name[0])) == 0;
}

}  // namespace

VertexAttribute attribute_of_size(const std::string& name, int width, std::size_t count) {
  return {name, std::vector<float>(static_cast<std::size_t>(width) * count), width};
}

std::uint64_t numbers_of(std::span<const VertexAttribute> attributes) {
  std::uint64_t sum = 0;
  for (const VertexAttribute& attribute : attributes)
    sum += static_cast<std::uint64_t>(attribute.width);
  return sum;
}

void VertexAttribute::set_run(std::size_t vertex, const NumberRun& run, const glm::vec4& four) {
  const std::size_t first =
      static_cast<std::size_t>(width) * vertex + static_cast<std::size_t>(run.column);
  for (int k = 0; k < run.count; ++k)
    values[first + static_cast<std::size_t>(k)] = four[run.lane + k];
}

std::vector<NumberRun> runs_of(std::span<const VertexAttribute> attributes, std::size_t index) {
  // Where an attribute would not fit into a four that is begun, the next one begins.
  std::size_t before = 0;
  const auto begin = [&](const VertexAttribute& attribute) {
    if (before % 4 + static_cast<std::size_t>(attribute.width) > 4) before += (4 - before % 4) % 4;
  };
  for (const VertexAttribute& attribute : attributes.first(index)) {
    begin(attribute);
    before += static_cast<std::size_t>(attribute.width);
  }
  begin(attributes[index]);
  const int width = attributes[index].width;
  std::vector<NumberRun> runs;
  for (int column = 0; column < width;) {
    const std::size_t number = before + static_cast<std::size_t>(column);
    const int lane = static_cast<int>(number % 4), count = std::min(4 - lane, width - column);
    runs.push_back({number / 4, lane, column, count});
    column += count;
  }
  return runs;
}

std::vector<glm::vec4> four_of(std::span<const VertexAttribute> attributes, std::size_t four) {
  const std::size_t count = attributes.empty() ? 0 : attributes.front().count();
  std::vector<glm::vec4> values(count, glm::vec4(0.0f));
  for (std::size_t index = 0; index < attributes.size(); ++index) {
    const VertexAttribute& from = attributes[index];
    for (const NumberRun& run : runs_of(attributes, index)) {
      if (run.four != four) continue;
      for (std::size_t v = 0; v < count; ++v)
        for (int k = 0; k < run.count; ++k)
          values[v][run.lane + k] = from.values[static_cast<std::size_t>(from.width) * v +
                                                static_cast<std::size_t>(run.column + k)];
    }
  }
  return values;
}

std::vector<VertexAttribute> attributes_of(std::span<const VertexAttribute> given,
                                           std::span<const std::int32_t> vertices) {
  std::vector<VertexAttribute> result;
  for (const VertexAttribute& from : given) {
    VertexAttribute& to =
        result.emplace_back(attribute_of_size(from.name, from.width, vertices.size()));
    for (std::size_t i = 0; i < vertices.size(); ++i)
      std::copy_n(from.values.begin() + std::ptrdiff_t{from.width} * vertices[i], from.width,
                  to.values.begin() + static_cast<std::ptrdiff_t>(i) * from.width);
  }
  return result;
}

void require_attributes(std::span<const VertexAttribute> attributes) {
  std::set<std::string> names;
  for (const VertexAttribute& attribute : attributes) {
    const std::string& name = attribute.name;
    if (!is_name(name))
      refuse(name, "is no name that files hold; letters, digits and '_' are, no digit first");
    if (!names.insert(lower_case(name)).second)
      refuse(name, "is there twice; names differ by more than case");
    const std::vector<float>& values = attribute.values;
    const std::size_t wild =
        first_where(values.size(), [&](std::size_t i) { return !std::isfinite(values[i]); });
    if (wild < values.size())
      refuse(name,
             formatted("of vertex {} is {}; finite numbers are wanted",
                       wild / static_cast<std::size_t>(attribute.width), shortest(values[wild])));
  }
}

namespace {

struct Box {
  glm::dvec3 low{std::numeric_limits<double>::max()};
  glm::dvec3 high{std::numeric_limits<double>::lowest()};

  void add(const Box& other) {
    low = glm::min(low, other.low);
    high = glm::max(high, other.high);
  }
};

// Pieces in their order: which of two equal zeros is kept does not depend on threads.
template <class PositionOf>
Box box_of(std::size_t count, const PositionOf& position_of) {
  constexpr std::size_t kPiece = 1 << 14;
  std::vector<Box> pieces((count + kPiece - 1) / kPiece);
  parallel_each(pieces.size(), 1, [&](std::size_t p) {
    Box box;
    for (std::size_t i = p * kPiece; i < std::min(count, (p + 1) * kPiece); ++i) {
      const glm::dvec3& position = position_of(i);
      box.add({position, position});
    }
    pieces[p] = box;
  });
  Box whole;
  for (const Box& box : pieces) whole.add(box);
  return whole;
}

Placement placement_of(const Box& box) {
  const glm::dvec3 extent = box.high - box.low;
  // hypot neither overflows nor underflows on the way, as the root of a sum of squares would.
  const double diagonal = portable::hypot(extent.x, extent.y, extent.z);
  return {.centre = 0.5 * box.low + 0.5 * box.high, .diagonal = diagonal > 0 ? diagonal : 1.0};
}

}  // namespace

Placement placement_of(const PolygonMesh& mesh) {
  if (mesh.face_vertices.empty()) return {};
  return placement_of(box_of(mesh.face_vertices.size(), [&](std::size_t c) -> const glm::dvec3& {
    return mesh.positions[mesh.face_vertices[c]];
  }));
}

bool has_extent(const PolygonMesh& mesh) {
  if (mesh.face_vertices.empty()) return false;
  const glm::dvec3& first = mesh.positions[mesh.face_vertices.front()];
  return std::ranges::any_of(mesh.face_vertices,
                             [&](std::int32_t v) { return mesh.positions[v] != first; });
}

Placement placement_of(std::span<const glm::dvec3> positions) {
  if (positions.empty()) return {};
  return placement_of(
      box_of(positions.size(), [&](std::size_t v) -> const glm::dvec3& { return positions[v]; }));
}

double diagonal_of(std::span<const glm::dvec3> points) {
  const auto [low, high] = point_bounds(points);
  return glm::length(high - low);
}

void recentre(PointCloud& cloud) {
  const auto [low, high] = point_bounds(cloud.points);
  const double diagonal = glm::length(high - low);
  if (!(diagonal > 0)) return;
  // A multiple of a power of two above the diagonal: then every difference has fewer bits than
  // the coordinate it came from and is exact.
  const double grain = std::ldexp(1.0, std::ilogb(diagonal) + 1);
  for (int axis = 0; axis < 3; ++axis) {
    const double centre = 0.5 * low[axis] + 0.5 * high[axis];
    if (std::abs(centre) > kFarDiagonals * diagonal)
      cloud.origin[axis] = std::round(centre / grain) * grain;
  }
  if (cloud.origin == glm::dvec3(0.0)) return;
  for (glm::dvec3& point : cloud.points) point -= cloud.origin;
}

PointCloud cloud_of(std::vector<glm::dvec3> positions, std::string_view name) {
  for (std::size_t i = 0; i < positions.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      if (!(std::abs(positions[i][axis]) <= kMaxCoordinate))
        throw Error(ErrorCode::UnreadableInput,
                    formatted("{}: point {} of {}: a coordinate is beyond 1e150", name, i,
                              positions.size()),
                    static_cast<std::int64_t>(i));
  PointCloud cloud{.points = std::move(positions)};
  recentre(cloud);
  return cloud;
}

}  // namespace planish
