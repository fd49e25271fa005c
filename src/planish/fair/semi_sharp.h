#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/doosabin/subdivision.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Edges and vertices whose sharpness lies between 0 and kInfiniteSharpness: the surface turns
/// there over a distance, the shorter the sharper they are. Doo-Sabin has no rule for them behind
/// level 1, so that they shape the control points of level 1: those of a fair net in which they are
/// smooth and of one in which they are sharp, and in between. README.md has the rules.
struct SemiSharpTags {
  /// Per edge and per vertex of the mesh how much of the smooth net is left, in (0, 1); 1: no such
  /// tag.
  std::vector<double> of_edge, of_vertex;
};

/// Whether a mesh has such tags.
[[nodiscard]] bool has_semi_sharp(const PolygonMesh& mesh);
/// The mesh with these tags as sharp as can be.
[[nodiscard]] PolygonMesh with_semi_sharp_as_sharp(PolygonMesh mesh);

/// How much of the smooth net a sharpness leaves: 1 at 0, falling to 0 at kInfiniteSharpness.
[[nodiscard]] double smooth_share(float sharpness);

/// Those of a mesh; where an edge is tagged twice the later tag holds. `topology` is its own.
[[nodiscard]] SemiSharpTags semi_sharp_tags(const PolygonMesh& mesh, const MeshTopology& topology);

/// Moves a fair net of the mesh with such tags as smooth towards the one with them as sharp.
/// `smooth` and `sharp` are on one topology; `given`, one per vertex, and both states are in the
/// same coordinates. The surface passes through the given points as it did: every polygon around a
/// smooth vertex keeps its centroid, every curve its points.
void blend_semi_sharp(const Subdivision& smooth, const Subdivision& sharp,
                      const SemiSharpTags& tags, std::span<const glm::dvec3> given,
                      std::span<const glm::dvec3> sharp_state, std::span<glm::dvec3> state);

}  // namespace planish
