#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/mesh/triangle_edges.h"
#include "planish/mesh/triangles.h"

namespace planish {

/// The triangles around a vertex, counter-clockwise.
struct Fan {
  std::vector<std::int32_t> spokes;  ///< half-edges out of the vertex, one a triangle
  std::vector<std::int32_t> ring;    ///< neighbours; one more than spokes where it is open
  bool closed = true;
};

/// A triangle mesh whose edges can be collapsed and flipped. Stays an oriented manifold of the
/// same topology when can_collapse() and can_flip() are obeyed.
class CollapseMesh {
 public:
  /// The triangles must be an oriented manifold.
  CollapseMesh(std::span<const Triangle> triangles, std::size_t vertex_count);

  [[nodiscard]] std::size_t vertex_count() const { return outgoing_.size(); }
  [[nodiscard]] std::size_t triangle_count() const { return corners_.size() / 3; }
  [[nodiscard]] bool is_used(std::int32_t vertex) const { return outgoing_[vertex] >= 0; }
  [[nodiscard]] bool is_alive(std::int32_t triangle) const { return corners_[3 * triangle] >= 0; }
  [[nodiscard]] bool is_boundary(std::int32_t vertex) const {
    return twins_[outgoing_[vertex]] < 0;
  }
  [[nodiscard]] std::int32_t valence(std::int32_t vertex) const { return valences_[vertex]; }
  [[nodiscard]] std::int32_t start(std::int32_t half_edge) const { return corners_[half_edge]; }
  [[nodiscard]] std::int32_t end(std::int32_t half_edge) const {
    return corners_[next_half_edge(half_edge)];
  }
  [[nodiscard]] std::int32_t twin(std::int32_t half_edge) const { return twins_[half_edge]; }
  [[nodiscard]] Triangle triangle(std::int32_t index) const {
    return {corners_[3 * index], corners_[3 * index + 1], corners_[3 * index + 2]};
  }

  /// Fills `fan`; its vectors are used again.
  void get_fan(std::int32_t vertex, Fan& fan) const;
  /// Calls visit(neighbour) for every neighbour of a vertex.
  template <class Visit>
  void for_each_neighbour(std::int32_t vertex, const Visit& visit) const {
    const std::int32_t first = outgoing_[vertex];
    std::int32_t h = first;
    do {
      visit(end(h));
      const std::int32_t before = previous_half_edge(h);
      h = twins_[before];
      if (h < 0) visit(start(before));
    } while (h >= 0 && h != first);
  }

  /// Whether collapsing the vertex of `fan` into its ring's entry `target` keeps the topology (the
  /// link condition) and leaves no vertex next to them below valence 3, inside, or 2, on the
  /// boundary.
  [[nodiscard]] bool can_collapse(std::int32_t vertex, const Fan& fan, std::size_t target);
  /// Moves all triangles of the vertex to ring[target] and drops the one or two between them.
  void collapse(std::int32_t vertex, const Fan& fan, std::size_t target);

  /// Whether the edge is inside and its flipped self does not exist yet.
  [[nodiscard]] bool can_flip(std::int32_t half_edge);
  /// Turns the edge inside its two triangles, which keep their indices: the half-edge's triangle
  /// becomes (c, d, b) and its twin's (d, c, a) for an edge a b with opposite corners c and d.
  void flip(std::int32_t half_edge);

 private:
  void set_outgoing(std::int32_t vertex, std::int32_t half_edge);
  void glue(std::int32_t a, std::int32_t b);
  [[nodiscard]] bool are_neighbours(std::int32_t a, std::int32_t b) const;

  std::vector<std::int32_t> corners_;   // vertex that a half-edge starts at; -1: removed
  std::vector<std::int32_t> twins_;     // -1 on the boundary
  std::vector<std::int32_t> outgoing_;  // of a vertex, the first of an open fan; -1: unused
  std::vector<std::int32_t> valences_;  // edges at a vertex
  std::vector<std::uint32_t> marks_;    // for can_collapse
  std::uint32_t mark_ = 0;
};

}  // namespace planish
