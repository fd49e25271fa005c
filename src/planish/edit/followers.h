#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/refine/refine_mesh.h"

namespace planish {

/// The vertices that refine_mesh() added: each keeps its way from the place that its weights give
/// it among the given ones, wherever these go.
class Followers {
 public:
  Followers() = default;
  /// `positions`: of the mesh that was fitted; the last are those of `added`.
  Followers(std::span<const AddedVertex> added, std::span<const glm::dvec3> positions);

  /// The vertices before them.
  [[nodiscard]] std::int32_t leader_count(std::size_t vertex_count) const {
    return static_cast<std::int32_t>(vertex_count - added_.size());
  }
  /// Adds to moves of given vertices those of all that follow them. `positions`: of all vertices
  /// before the moves.
  void follow(std::span<const glm::dvec3> positions, std::vector<std::int32_t>& vertices,
              std::vector<glm::dvec3>& to) const;
  [[nodiscard]] bool empty() const { return added_.empty(); }

 private:
  std::vector<AddedVertex> added_;
  std::vector<glm::dvec3> offsets_;            // from the mean of its three
  std::vector<std::int32_t> starts_, led_by_;  // of each given vertex, whom it leads
};

}  // namespace planish
