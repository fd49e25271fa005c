#pragma once

#include <glm/vec4.hpp>
#include <vector>

#include "planish/distributed/mesh_part.h"
#include "planish/distributed/sub_mesh.h"

namespace planish {

/// The colours of a slice's vertices, sent to where these stand along the curve; takes them.
[[nodiscard]] std::vector<glm::vec4> colors_along_curve(const Ranks& ranks,
                                                        SliceAttributes& attributes,
                                                        const CurveOrder& order);

/// Fetches what rides on a part and is kept elsewhere: the ghosts' colours, the values of texture
/// coordinates, whose numbers the part has; takes the slice's.
void fetch_attributes(const Ranks& ranks, SliceAttributes& attributes, MeshPart& part);

/// Gives a sub mesh the attributes of its vertices, corners and faces. Texture coordinates are
/// numbered in the order of the file, as rows of them are.
void add_attributes(const MeshPart& part, SubMesh& sub);

}  // namespace planish
