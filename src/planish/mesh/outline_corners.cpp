#include "planish/mesh/outline_corners.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <unordered_map>

#include "planish/core/work.h"
#include "planish/mesh/angle_between.h"
#include "planish/mesh/area_vector.h"

namespace planish {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
// A boundary goes on straight where it turns by less, along the surface: so rough ground has
// straight rims.
constexpr double kOnwardDegrees = 30;
// So large a part of a loop's vertices that are no corners turns by less along the surface.
constexpr double kQuietDegrees = 15, kQuietPart = 0.75;

// A loop of hardly more vertices than corners is round, unless it has at most those of a rectangle.
constexpr std::size_t kFewCorners = 4;

struct Turns {
  double in_space = 0, along_surface = 0;  // degrees
  bool is_outward = false;                 // the faces reach round by less than half a turn
};

// Turns of a boundary at the vertex between two of its edges.
class BoundaryTurns {
 public:
  BoundaryTurns(const PolygonMesh& mesh, const MeshTopology& topology)
      : mesh_(mesh), topology_(topology) {}

  [[nodiscard]] Turns at(std::int32_t before, std::int32_t vertex, std::int32_t behind) {
    const glm::dvec3 in = mesh_.positions[vertex] - mesh_.positions[before];
    const glm::dvec3 out = mesh_.positions[behind] - mesh_.positions[vertex];
    double reach = 0;
    for (const std::int32_t corner : topology_.corners_at(vertex)) reach += angle_of(corner);
    return {angle_between(in, out) * kDegrees, std::abs(180 - reach * kDegrees),
            reach < std::numbers::pi};
  }

 private:
  // 0 to a whole turn: beyond half of one where the face turns inward.
  [[nodiscard]] double angle_of(std::int32_t corner) {
    const std::int32_t vertex = topology_.vertex_of(corner);
    const glm::dvec3 at = mesh_.positions[vertex];
    const glm::dvec3 to = mesh_.positions[topology_.vertex_of(topology_.next(corner))] - at;
    const glm::dvec3 from = mesh_.positions[topology_.vertex_of(topology_.prev(corner))] - at;
    const glm::dvec3 across = glm::cross(to, from);
    const double angle = angle_between(to, from);
    if (topology_.face_size(topology_.face_of(corner)) == 3) return angle;
    const glm::dvec3 area = area_of(topology_.face_of(corner));
    return glm::dot(across, area) < 0 ? 2 * std::numbers::pi - angle : angle;
  }

  // Of a face whose corners may all lie at a boundary and ask it, once.
  [[nodiscard]] glm::dvec3 area_of(std::int32_t face) {
    const auto [at, is_new] = areas_.try_emplace(face);
    if (is_new) {
      count_work(Work::Pairs, topology_.face_size(face));
      at->second = area_vector(mesh_.positions, topology_.face(face));
    }
    return at->second;
  }

  const PolygonMesh& mesh_;
  const MeshTopology& topology_;
  std::unordered_map<std::int32_t, glm::dvec3> areas_;
};

// Adds the corners of a loop, given by its vertices and their turns, if they are clear.
void add_clear(const std::vector<std::int32_t>& loop, const std::vector<Turns>& turns,
               double corner_degrees, std::vector<std::int32_t>& corners) {
  const std::size_t count = loop.size();
  const auto turns_far = [&](std::size_t i) {
    return turns[i].in_space > corner_degrees && turns[i].along_surface > corner_degrees;
  };
  const auto goes_on = [&](std::size_t i) {
    return turns[i].along_surface < kOnwardDegrees || turns_far(i);
  };
  const std::size_t first = corners.size();
  std::size_t quiet = 0, inward = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (turns_far(i) && goes_on((i + count - 1) % count) && goes_on((i + 1) % count)) {
      corners.push_back(loop[i]);
      inward += turns[i].is_outward ? 0 : 1;
    } else if (turns[i].along_surface < kQuietDegrees) {
      ++quiet;
    }
  }
  const std::size_t found = corners.size() - first;
  const bool is_few = found <= kFewCorners && inward == 0;  // none of a missing face's
  if ((2 * found > count && !is_few) ||
      static_cast<double>(quiet) < kQuietPart * static_cast<double>(count - found))
    corners.resize(first);
}

}  // namespace

std::vector<std::int32_t> outline_corners(const PolygonMesh& mesh, const MeshTopology& topology,
                                          double corner_degrees) {
  BoundaryTurns turns_of(mesh, topology);
  std::vector<std::int32_t> corners, loop;
  std::vector<Turns> turns;
  std::vector<std::uint8_t> seen(static_cast<std::size_t>(topology.vertex_count()), 0);
  // The boundary edge that leaves a boundary vertex is the leading one of its first corner.
  const auto behind = [&](std::int32_t vertex) {
    return topology.vertex_of(topology.next(topology.corners_at(vertex).front()));
  };
  for (std::int32_t v = 0; v < topology.vertex_count(); ++v) {
    if (seen[v] != 0 || !topology.is_boundary_vertex(v)) continue;
    loop.clear();
    for (std::int32_t at = v; seen[at] == 0; at = behind(at)) {
      seen[at] = 1;
      loop.push_back(at);
    }
    turns.resize(loop.size());
    for (std::size_t i = 0; i < loop.size(); ++i)
      turns[i] = turns_of.at(loop[(i + loop.size() - 1) % loop.size()], loop[i],
                             loop[(i + 1) % loop.size()]);
    add_clear(loop, turns, corner_degrees, corners);
  }
  std::ranges::sort(corners);
  return corners;
}

}  // namespace planish
