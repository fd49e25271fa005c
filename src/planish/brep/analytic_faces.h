#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "planish/analytic/analytic_surface.h"
#include "planish/analytic/find_regions.h"
#include "planish/analytic/noisy_regions.h"
#include "planish/analytic/region_borders.h"
#include "planish/analytic/settle_surfaces.h"
#include "planish/brep/brep.h"
#include "planish/brep/free_borders.h"
#include "planish/core/callbacks.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// A mesh whose faces may lie on planes, cylinders, cones, spheres and tori.
struct AnalyticMesh {
  const MeshTopology& topology;
  std::span<const glm::dvec3> positions;  ///< in model coordinates
  std::span<const char> is_sharp;         ///< one per edge
  std::span<const std::int32_t> groups;   ///< one per face, or none
  double diagonal = 1;
  VertexPlaces places = VertexPlaces::OnEdges;
  bool keeps_smooth = true;  ///< what is not sharp is to be smooth: see find_regions()
};

/// What of a mesh lies on surfaces that have a name, part by part: faces that edges join.
struct AnalyticParts {
  Placement placement;                ///< all that follows is in unit coordinates
  std::vector<glm::dvec3> positions;  ///< of the mesh's vertices; of samples, on their borders
  AnalyticRegions regions;
  RegionBorders borders;
  SettledRegions settled;
  FaceComponents parts;
  std::vector<std::vector<std::int32_t>> regions_of;  ///< by part
  std::vector<char> has_free;                         ///< by part: not all its faces are of regions
  std::vector<double> tolerances;  ///< by part: of its vertices, five deviations of noise
};

/// Of vertices from their surfaces where they are not noisy, of the diagonal.
inline constexpr double kExactTolerance = 1.5e-6;

/// Within `tolerance` of the diagonal; empty: within kExactTolerance, or where vertices are noisier
/// than that five deviations of the noise that is measured in each part. Throws Error{Cancelled}.
[[nodiscard]] AnalyticParts find_analytic_parts(const AnalyticMesh& mesh,
                                                std::optional<double> tolerance = {},
                                                const Callbacks& callbacks = {});

struct AnalyticFaces {
  /// The faces, with edges and vertices and without shells; places are nowhere.
  Brep brep;
  std::vector<std::int32_t> face_of;  ///< by face of the mesh: one of its part; -1: it is freeform
  /// By face of FreeformFaces::brep, what it is here; -1: it is not. Empty without these.
  std::vector<std::int32_t> freeform_number;
  std::array<std::int64_t, kAnalyticKinds> faces_by_kind{};
  std::vector<double> radii;    ///< distinct ones, ascending, in model units
  double largest_distance = 0;  ///< of vertices from their surfaces, in model units
  std::int64_t parts = 0;
  std::int64_t mixed_parts = 0;     ///< that have freeform faces beside those on surfaces
  std::int64_t freeform_parts = 0;  ///< that are freeform as a whole
  std::string first_reason;         ///< why the first of these is
};

/// Faces of each part that lies on planes, cylinders, cones, spheres and tori, with freeform faces
/// between where these are given. Edges are lines, circles, ellipses and splines on both surfaces;
/// what closes around an axis has a seam. Freeform faces that end at one on a surface are moved
/// onto it there. Throws Error{Cancelled}.
[[nodiscard]] AnalyticFaces make_analytic_faces(const AnalyticMesh& mesh,
                                                const AnalyticParts& found,
                                                const FreeformFaces* freeform = nullptr,
                                                const Callbacks& callbacks = {});

/// All parts together: of the freeform faces those of other parts are left out. `analytic_at`: by
/// vertex of the topology that these were made of, a face of its part that stands in `analytic`;
/// -1: its part is freeform. Shells are found anew; `points`: of those vertices.
[[nodiscard]] Brep joined_parts(const Brep& freeform, const AnalyticFaces& analytic,
                                const MeshTopology& topology, std::span<const glm::dvec3> points,
                                std::span<const std::int32_t> analytic_at);

}  // namespace planish
