#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "planish/analytic/analytic_surface.h"
#include "planish/brep/brep.h"
#include "planish/core/callbacks.h"
#include "planish/mesh/mesh_topology.h"

namespace planish {

/// A mesh whose faces may lie on planes, cylinders, cones, spheres and tori.
struct AnalyticMesh {
  const MeshTopology& topology;
  std::span<const glm::dvec3> positions;  ///< in model coordinates
  std::span<const char> is_sharp;         ///< one per edge
  std::span<const std::int32_t> groups;   ///< one per face, or none
  double diagonal = 1;
};

struct AnalyticFaces {
  /// The faces, with edges and vertices and without shells; places are nowhere.
  Brep brep;
  std::vector<std::int32_t> face_of;  ///< by face of the mesh; -1: its part is freeform
  std::array<std::int64_t, kAnalyticKinds> faces_by_kind{};
  std::vector<double> radii;                   ///< distinct ones, ascending, in model units
  double largest_distance = 0;                 ///< of vertices from their surfaces, in model units
  std::int64_t parts = 0, freeform_parts = 0;  ///< of faces that are joined by edges
  std::string first_reason;                    ///< why the first freeform one is
};

/// Faces of each part of the mesh that planes, cylinders, cones, spheres and tori make up whole,
/// within `tolerance` of the diagonal. Edges are lines, circles, ellipses and splines on both
/// surfaces; what closes around an axis has a seam. Throws Error{Cancelled}.
[[nodiscard]] AnalyticFaces make_analytic_faces(const AnalyticMesh& mesh, double tolerance,
                                                const Callbacks& callbacks = {});

/// Both kinds of parts together: of the freeform faces those of parts that are analytic are left
/// out. `analytic_at`: by vertex of the topology that these were made of, an analytic face of its
/// part; -1: its part is freeform. Shells are found anew; `points`: of those vertices.
[[nodiscard]] Brep joined_parts(const Brep& freeform, const AnalyticFaces& analytic,
                                const MeshTopology& topology, std::span<const glm::dvec3> points,
                                std::span<const std::int32_t> analytic_at);

}  // namespace planish
