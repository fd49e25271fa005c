#include "planish/mesh/cone_apexes.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/core/parallel.h"
#include "planish/mesh/angle_between.h"

namespace planish {
namespace {

constexpr std::size_t kVertexGrain = 1024;
// Of the faces from the axis: below it a smooth tip is as likely.
constexpr double kLeastAngle = 35 * std::numbers::pi / 180;
// From face to face: beyond it they are those of a pyramid.
constexpr double kLargestTurn = 30 * std::numbers::pi / 180;
// With these two no fewer faces go around.
constexpr std::size_t kFewestFaces = 7;
// How far a face behind may be from the axis.
constexpr double kGoesOn = 1.5;

class ApexLook {
 public:
  ApexLook(const MeshTopology& topology, std::span<const glm::dvec3> normals,
           std::span<const std::uint8_t> is_sharp)
      : topology_(topology), normals_(normals), is_sharp_(is_sharp) {}

  [[nodiscard]] bool is_apex(std::int32_t vertex) const {
    const auto corners = topology_.corners_at(vertex);
    if (corners.size() < kFewestFaces || topology_.is_boundary_vertex(vertex)) return false;
    glm::dvec3 axis(0.0);
    for (const std::int32_t corner : corners) {
      const glm::dvec3& normal = normal_at(corner);
      const double length = glm::length(normal);
      if (length == 0 || is_sharp_[topology_.edge_of(corner)] != 0) return false;
      axis += normal / length;
    }
    return goes_once_around(corners, axis) && goes_on_behind(corners, axis);
  }

 private:
  [[nodiscard]] const glm::dvec3& normal_at(std::int32_t corner) const {
    return normals_[topology_.face_of(corner)];
  }

  // One way all along: counter-clockwise at tips, the other way where they point into the shape.
  [[nodiscard]] bool goes_once_around(std::span<const std::int32_t> corners,
                                      const glm::dvec3& axis) const {
    double around = 0, all = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const glm::dvec3& a = normal_at(corners[i]);
      const glm::dvec3& b = normal_at(corners[(i + 1) % corners.size()]);
      if (angle_between(a, axis) < kLeastAngle || angle_between(a, b) > kLargestTurn) return false;
      const glm::dvec3 flat_a = glm::cross(axis, a), flat_b = glm::cross(axis, b);
      const double turn = angle_between(flat_a, flat_b);
      all += turn;
      around += glm::dot(glm::cross(flat_a, flat_b), axis) < 0 ? -turn : turn;
    }
    constexpr double kRounding = 1e-6;
    return std::abs(std::abs(around) - 2 * std::numbers::pi) < kRounding &&
           all < 2 * std::numbers::pi + kRounding;
  }

  [[nodiscard]] bool goes_on_behind(std::span<const std::int32_t> corners,
                                    const glm::dvec3& axis) const {
    for (const std::int32_t corner : corners) {
      const double most = kGoesOn * angle_between(normal_at(corner), axis);
      const std::int32_t last = topology_.prev(corner);
      for (std::int32_t c = topology_.next(corner); c != last; c = topology_.next(c)) {
        const std::int32_t twin = topology_.twin(c);
        if (twin < 0 || is_sharp_[topology_.edge_of(c)] != 0) continue;
        if (angle_between(normal_at(twin), axis) > most) return false;
      }
    }
    return true;
  }

  const MeshTopology& topology_;
  std::span<const glm::dvec3> normals_;
  std::span<const std::uint8_t> is_sharp_;
};

}  // namespace

std::vector<std::int32_t> cone_apexes(const MeshTopology& topology,
                                      std::span<const glm::dvec3> face_normals,
                                      std::span<const std::uint8_t> is_sharp) {
  const ApexLook look(topology, face_normals, is_sharp);
  std::vector<std::uint8_t> is_apex(static_cast<std::size_t>(topology.vertex_count()), 0);
  parallel_each(is_apex.size(), kVertexGrain,
                [&](std::int32_t v) { is_apex[v] = look.is_apex(v); });
  std::vector<std::int32_t> apexes;
  for (std::int32_t v = 0; v < topology.vertex_count(); ++v)
    if (is_apex[v] != 0) apexes.push_back(v);
  return apexes;
}

}  // namespace planish
