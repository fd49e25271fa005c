#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

namespace planish {

/// What the construction of a fair net needs where a mesh is spread over several processes. Each
/// builds the net of its part: the faces around the vertices that it owns and around those faces'
/// vertices. What it finds for others is replaced by what their owners found; all call the same
/// functions in the same order. Without a halo the mesh is in one piece.
class FairHalo {
 public:
  virtual ~FairHalo() = default;

  /// Values of vertices that others own become theirs. One per vertex of the part.
  virtual void exchange_vertices(std::span<double> values) = 0;
  virtual void exchange_vertices(std::span<glm::dvec3> values) = 0;
  virtual void exchange_vertices(std::span<std::uint8_t> values) = 0;
  /// The same of the control points around such vertices; one per corner.
  virtual void exchange_corners(std::span<float> values) = 0;
  /// And of those on curves; the state of level 1. Curve points at the part's rim, where the mesh
  /// goes on, are nobody's.
  virtual void exchange_state(std::span<glm::dvec3> values) = 0;

  /// Sums over the elements that each process owns: the same bits however the mesh is spread.
  [[nodiscard]] virtual double sum_of_vertices(std::span<const double> values) = 0;
  [[nodiscard]] virtual double sum_of_faces(std::span<const double> values) = 0;
  [[nodiscard]] virtual std::int64_t sum(std::int64_t value) = 0;
  [[nodiscard]] virtual double largest(double value) = 0;

  /// One flag per vertex and per face; a face belongs to one process, its edges to that of the face
  /// that they were found in.
  [[nodiscard]] virtual std::span<const std::uint8_t> owned_vertices() const = 0;
  [[nodiscard]] virtual std::span<const std::uint8_t> owned_faces() const = 0;
};

/// Without a halo all is this process's own.
[[nodiscard]] inline bool owns_vertex(const FairHalo* halo, std::int32_t vertex) {
  return halo == nullptr || halo->owned_vertices()[vertex] != 0;
}
[[nodiscard]] inline bool owns_face(const FairHalo* halo, std::int32_t face) {
  return halo == nullptr || halo->owned_faces()[face] != 0;
}
[[nodiscard]] inline std::int64_t sum_of_parts(FairHalo* halo, std::int64_t value) {
  return halo == nullptr ? value : halo->sum(value);
}
[[nodiscard]] inline bool is_in_any_part(FairHalo* halo, bool is_here) {
  return sum_of_parts(halo, is_here ? 1 : 0) > 0;
}

}  // namespace planish
