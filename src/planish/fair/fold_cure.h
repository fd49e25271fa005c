#pragma once

#include <atomic>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <span>
#include <vector>

#include "planish/fair/fair_net.h"
#include "planish/fair/fair_topology.h"

namespace planish {

/// Limit normals of a net of level 1 at the places where they depend on the fewest control points;
/// of any length, zero where there is none. `offsets`: the state relative to the given points.
struct NetSamples {
  /// All that a step asks of a polygon besides the own point: its mean and first Fourier pair.
  struct PolygonSums {
    glm::dvec3 mean, even, odd;
  };

  const FairTopology& topology;
  std::span<const glm::dvec3> given, offsets;
  std::vector<PolygonSums> of_large_faces{};  ///< by FairTopology::large_faces

  /// Before least_cosine_around() where there are large faces, whenever offsets have changed.
  void sum_large_faces();

  [[nodiscard]] glm::dvec3 point(std::int32_t corner) const {
    return given[topology.corner_vertices[corner]] + offsets[corner];
  }
  [[nodiscard]] glm::dvec3 at_edge(const FairTopology::Edge& edge) const;
  [[nodiscard]] glm::dvec3 at_face(std::int32_t face) const;
  /// Around the vertex must be a polygon.
  [[nodiscard]] glm::dvec3 at_vertex(std::int32_t vertex) const;
  /// The least cosine between the normals of the faces around a vertex with a polygon and the
  /// limit normals at the places that the next step adds between it and them: at its control
  /// points, on the sides of its polygon, and on those of the faces' polygons that begin or end at
  /// it. 1 where there are none, beside sharp edges.
  [[nodiscard]] double least_cosine_around(std::int32_t vertex,
                                           std::span<const glm::dvec3> face_normals) const;
};

/// Sets a vertex's flag, from several threads: whoever sets, sets the same.
inline void flag(std::span<std::uint8_t> flags, std::int32_t vertex) {
  std::atomic_ref(flags[vertex]).store(1, std::memory_order_relaxed);
}

/// Between a normal of any length and a unit vector; -1 where the normal is zero.
[[nodiscard]] double cosine_of(const glm::dvec3& normal, const glm::dvec3& reference);

/// Elements whose level-1 limit normal is turned away from the mesh's.
struct FoldCount {
  std::int64_t edges = 0, faces = 0;
  std::int32_t rounds = 0;  ///< that changed something before
};

/// Halves the polygons of control points around the vertices of folded edges and faces, about the
/// vertex, so that interpolation is untouched; at most three rounds. At an edge whose own geometry
/// folds no size helps, so that more rounds do not.
/// `offsets`: the state of level 1 relative to the given points, changed in place; `face_normals`:
/// unit, one per face. `halvings`, one per vertex, is increased by what was done. Returns what is
/// still folded. `halo`: where the mesh is a part; counts are those of all.
FoldCount repair_folds(const FairTopology& topology, std::span<const glm::dvec3> given,
                       std::span<const glm::dvec3> face_normals, std::span<glm::dvec3> offsets,
                       std::span<std::uint8_t> halvings, FairHalo* halo = nullptr);

[[nodiscard]] inline FoldCount sum_of_parts(FairHalo* halo, const FoldCount& count) {
  return {sum_of_parts(halo, count.edges), sum_of_parts(halo, count.faces), count.rounds};
}

/// The halving alone, as an earlier repair decided it.
void halve_polygons(const FairTopology& topology, std::span<const std::uint8_t> halvings,
                    std::span<glm::dvec3> offsets);

/// Counts what is folded and changes nothing.
[[nodiscard]] FoldCount count_folds(const FairTopology& topology, std::span<const glm::dvec3> given,
                                    std::span<const glm::dvec3> face_normals,
                                    std::span<const glm::dvec3> offsets);

/// The ellipse of evenly spread points around a smooth or dart vertex whose sides cross all edges
/// best. A few steps make such an ellipse of any polygon; where a hub's edges crowd, that of the
/// perpendicular polygon may run along edges that leave its plane, or backwards (README.md). Chosen
/// once and kept (FairDecisions::ellipses): point i lies at (x cos + y sin, z cos + w sin) of its
/// angle 2 pi i / n, along ring_direction() and left of it, the farthest point at distance 1.
/// `plane`: the unit normal that the polygon has; `face_normals` are unit. All zero where no
/// ellipse in that plane crosses all edges the right way.
[[nodiscard]] glm::vec4 hub_ellipse(const FairTopology& topology, std::span<const glm::dvec3> given,
                                    std::span<const glm::dvec3> face_normals, std::int32_t vertex,
                                    const glm::dvec3& plane);

/// Whether there is one.
[[nodiscard]] inline bool is_ellipse(const glm::vec4& ellipse) {
  return ellipse != glm::vec4(0.0F);
}

/// Chooses the ellipses of flagged vertices and others of their faces, where the cure changed them
/// and they have none yet; 1 per vertex that has got one.
[[nodiscard]] std::vector<std::uint8_t> choose_ellipses(const FairTopology& topology,
                                                        std::span<const glm::dvec3> given,
                                                        std::span<const std::uint8_t> flagged,
                                                        FairDecisions& decisions);

/// Writes the polygon's control points relative to the vertex, the farthest at `size`.
void build_hub_ellipse(const FairTopology& topology, std::span<const glm::dvec3> given,
                       std::int32_t vertex, const glm::dvec3& plane, const glm::vec4& ellipse,
                       double size, std::span<glm::dvec3> offsets);

/// How often a vertex is cured at most: its polygon is then a 256th of what fits beside its faces.
/// With smaller ones no measured mesh folded less, and close to them the surface is smooth in name
/// only.
inline constexpr int kMostCures = 5;

/// What the cure works on. `face_normals` and `normals`, one per vertex, are unit; `offsets`: the
/// state of level 1 relative to the given points, changed in place.
struct CureInput {
  const FairTopology& topology;
  std::span<const glm::dvec3> given, face_normals, normals;
  std::span<glm::dvec3> offsets;
  /// Per vertex where not empty: what stands in for the perpendicular polygon (fold_cure.h).
  std::span<const glm::vec4> ellipses{};
  FairHalo* halo = nullptr;  ///< where the mesh is a part; counts are those of all
};

/// After the last repair: cures folds at edges, faces and vertices that no halving cures. Vertices
/// at a limit normal that is turned too far from a face that it belongs to get perpendicular
/// polygons (perpendicular_polygon.h), and where that does not do a quarter of them, in at most
/// three rounds. Smooth and dart vertices only. `cures`, one per vertex, is increased by the rounds
/// that changed it; `leans` (fair_topology.h) are chosen where the first one does. Returns what is
/// still turned over by more than a right angle from one of its faces.
FoldCount cure_folds(const CureInput& input, std::span<std::uint8_t> cures,
                     std::span<glm::vec2> leans);

/// The same polygons, as an earlier cure decided them; leans that are wanted and were not chosen
/// then are now.
FoldCount repeat_cure(const CureInput& input, std::span<const std::uint8_t> cures,
                      std::span<glm::vec2> leans);

/// Nets of one mesh whose decisions differ in those of the cure alone (cures, leans, ellipses): all
/// that comes before it is made once, with the first. Made in fair_net.cpp.
class CuredNets {
 public:
  /// As for fair_net(); callbacks and decisions come with each net. The mesh, `subdivision`,
  /// `given` and the halo outlive this.
  CuredNets(const PolygonMesh& mesh, const Subdivision& subdivision,
            std::span<const glm::dvec3> given, const FairOptions& options);
  ~CuredNets();

  /// The bits of fair_net() with these decisions; also throws as that does.
  [[nodiscard]] FairNet net(const FairDecisions& decisions, const Callbacks& callbacks = {});

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace planish
