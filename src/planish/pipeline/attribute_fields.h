#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/surface/surface_blocks.h"
#include "planish/surface/vertex_fields.h"

namespace planish {

/// Rows of a surface for which attributes are made at once.
inline constexpr std::int64_t kAttributeRows = std::int64_t{1} << 14;

/// Numbers that vertices of the given mesh have, `width` of 1 to 4 each, at all rows of the surface
/// of its fit, as colours have them. The surface has to know its mesh (see
/// SurfaceBlocks::rows_of()).
[[nodiscard]] std::vector<float> rows_of_vertices(std::span<const float> given, int width,
                                                  const FittedMesh& fitted,
                                                  const SurfaceBlocks& surface);

/// The attributes of a surface as further fields of its files, those of more than four numbers as
/// one field a number, `name_0` and so on; what is returned holds their values and must outlive
/// them. A field of the same name, whatever its case, stays in the place of theirs; that is the
/// warning "left-out-properties". Throws Error{OutOfMemory} before values are made that the machine
/// has no memory for.
[[nodiscard]] std::vector<VertexAttribute> add_attributes(const SurfaceBlocks& surface,
                                                          std::vector<NamedField>& fields,
                                                          const Callbacks& callbacks);

}  // namespace planish
