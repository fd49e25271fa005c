#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/doosabin/subdivision.h"
#include "planish/edit/measured_error.h"
#include "planish/edit/sparse_set.h"
#include "planish/fair/fair_net.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// A fair net while given points move: some rings of faces around these make nets of their own,
/// before and after the move, by the decisions of the whole net, and the control points change by
/// the difference. Each polygon keeps its centroid, so that the surface passes through every point
/// to rounding. In coordinates of unit diagonal. Not for several threads at once.
class LocalFair {
 public:
  /// Of a fair fit; `mesh` has no unused vertices, and all of it must outlive this.
  LocalFair(const PolygonMesh& mesh, const Subdivision& subdivision, FairDecisions decisions,
            std::int32_t polish_steps, bool cures_folds, std::vector<glm::dvec3> given);

  /// Vertices to their new points, none twice. Throws Error{Cancelled}, and all is as it was.
  void move(std::span<const std::int32_t> vertices, std::span<const glm::dvec3> points);
  /// Puts points where they are, and nothing more.
  void put(std::span<const std::int32_t> vertices, std::span<const glm::dvec3> points);
  /// After a move: places of the state that change and by how much, and the vertices that they
  /// belong to; or is_whole(), and the state is to be made anew.
  [[nodiscard]] std::span<const std::int32_t> places() const { return places_; }
  [[nodiscard]] std::span<const glm::dvec3> differences() const { return differences_; }
  [[nodiscard]] std::span<const std::int32_t> vertices() const { return changed_; }
  [[nodiscard]] bool is_whole() const { return is_whole_; }
  /// The state of all of the mesh. Throws Error{Cancelled}.
  [[nodiscard]] std::vector<glm::dvec3> whole_state(const Callbacks& callbacks) const;

  [[nodiscard]] std::span<const glm::dvec3> given() const { return given_; }
  [[nodiscard]] const FairDecisions& decisions() const { return decisions_; }
  /// The ways from given points to the surface's, of a state of level 1.
  [[nodiscard]] MeasuredError measured(std::span<const glm::dvec3> state) const;

 private:
  class Part;

  void grow(std::span<const std::int32_t> vertices);

  const PolygonMesh& mesh_;
  const Subdivision& subdivision_;
  FairDecisions decisions_;
  std::int32_t polish_steps_;
  bool cures_folds_;
  std::vector<glm::dvec3> given_;

  SparseSet near_;               // vertices whose faces are the part
  std::size_t inner_count_ = 0;  // those of them whose control points may change
  SparseSet faces_;
  std::vector<std::int32_t> places_, changed_;
  std::vector<glm::dvec3> differences_;
  bool is_whole_ = false;
};

}  // namespace planish
