#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "planish/distributed/mesh_part.h"
#include "planish/distributed/part_fair.h"
#include "planish/distributed/write_cage.h"
#include "planish/mesh/sharpness.h"

namespace planish {

/// Where the corners of a slice's faces stand among all corners of the file.
struct CornerStarts {
  Layout faces;                      ///< of all slices
  std::vector<std::int64_t> starts;  ///< of each face of this rank's slice
  std::int64_t total = 0;            ///< corners of all ranks
};
/// Throws AgreedError{InvalidArgument} for meshes with holes, whose borders cut polygons of
/// level 1.
[[nodiscard]] CornerStarts corner_starts_of(const Ranks& ranks, const MeshSlice& slice);

/// The cage of a fair surface as it stands in its file, each rank a run of vertices and of faces.
struct FairCage {
  Layout vertices;
  std::vector<glm::dvec3> positions;
  CageFaces faces;
  std::int64_t face_total = 0;
};

/// level_one_mesh() of the whole mesh: each rank makes that of its part, and takes the polygons
/// around its own vertices, faces and edges, which are sent to where they stand in the order of the
/// file. Throws AgreedError{InvalidArgument} for more vertices than a file's indices count.
[[nodiscard]] FairCage make_fair_cage(const Ranks& ranks, const MeshPart& part,
                                      const PartFair& fair, const CornerStarts& corners,
                                      const SharpFeatureOptions& sharp);

}  // namespace planish
