#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <queue>
#include <span>
#include <utility>
#include <vector>

#include "planish/mesh/mesh_topology.h"

namespace planish {

/// Faces around others, as far as sharp edges let them go. All spans and the topology must outlive
/// it; `is_sharp`: one per edge.
class FacePatches {
 public:
  FacePatches(std::span<const glm::dvec3> positions, const MeshTopology& topology,
              std::span<const char> is_sharp)
      : positions_(positions),
        topology_(topology),
        is_sharp_(is_sharp),
        seen_(static_cast<std::size_t>(topology.face_count()), 0),
        vertex_seen_(static_cast<std::size_t>(topology.vertex_count()), 0) {}

  /// Calls use(face) for each face across a smooth edge.
  template <class Use>
  void each_neighbour(std::int32_t face, const Use& use) const {
    for (std::int32_t i = 0; i < topology_.face_size(face); ++i) {
      const std::int32_t corner = topology_.first_corner(face) + i, twin = topology_.twin(corner);
      if (twin >= 0 && is_sharp_[topology_.edge_of(corner)] == 0) use(topology_.face_of(twin));
    }
  }

  [[nodiscard]] glm::dvec3 centre(std::int32_t face) const {
    glm::dvec3 sum(0.0);
    for (const std::int32_t v : topology_.face(face)) sum += positions_[v];
    return sum / static_cast<double>(topology_.face_size(face));
  }

  /// Up to `count` faces for which may(face) holds, the nearest first.
  template <class May>
  [[nodiscard]] std::vector<std::int32_t> around(std::int32_t seed, std::size_t count,
                                                 const May& may) {
    ++round_;
    using Entry = std::pair<double, std::int32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    const glm::dvec3 middle = centre(seed);
    queue.emplace(0.0, seed);
    seen_[seed] = round_;
    std::vector<std::int32_t> faces;
    while (!queue.empty() && faces.size() < count) {
      const std::int32_t face = queue.top().second;
      queue.pop();
      faces.push_back(face);
      each_neighbour(face, [&](std::int32_t next) {
        if (seen_[next] == round_ || !may(next)) return;
        seen_[next] = round_;
        queue.emplace(glm::length(centre(next) - middle), next);
      });
    }
    return faces;
  }

  /// Places of their vertices, each once.
  [[nodiscard]] std::vector<glm::dvec3> points_of(std::span<const std::int32_t> faces) {
    ++vertex_round_;
    std::vector<glm::dvec3> points;
    for (const std::int32_t f : faces) {
      for (const std::int32_t v : topology_.face(f)) {
        if (vertex_seen_[v] == vertex_round_) continue;
        vertex_seen_[v] = vertex_round_;
        points.push_back(positions_[v]);
      }
    }
    return points;
  }

 private:
  std::span<const glm::dvec3> positions_;
  const MeshTopology& topology_;
  std::span<const char> is_sharp_;
  std::vector<std::int32_t> seen_, vertex_seen_;
  std::int32_t round_ = 0, vertex_round_ = 0;
};

}  // namespace planish
