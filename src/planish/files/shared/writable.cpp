#include "planish/files/shared/writable.h"

#include "planish/core/error.h"
#include "planish/mesh/mesh_arrays.h"

namespace planish {

void require_field_sizes(std::span<const NamedField> fields, std::int64_t row_count,
                         const std::string& name) {
  for (const NamedField& field : fields)
    if (field.values.size() != static_cast<std::size_t>(field.width * row_count))
      throw Error(ErrorCode::InvalidArgument,
                  formatted("{}: {} values of {} for {} positions", name, field.values.size(),
                            field.name, row_count));
}

void require_writable(const PolygonView& view, const std::string& name) {
  constexpr std::int32_t kLeastCorners = 3;
  require_sound_indices({.vertex_count = view.positions.size(),
                         .face_offsets = view.face_offsets,
                         .face_vertices = view.face_vertices,
                         .uv_count = view.uvs.size(),
                         .face_uvs = view.face_uvs,
                         .color_count = view.colors.size(),
                         .group_count = view.groups.size(),
                         .face_groups = view.face_groups,
                         .hole_faces = view.hole_faces,
                         .creases = view.creases,
                         .corners = view.corners},
                        name, ErrorCode::InvalidArgument, kLeastCorners);
  if (!view.normals.empty() && view.normals.size() != view.positions.size())
    throw Error(ErrorCode::InvalidArgument, formatted("{}: {} normals for {} positions", name,
                                                      view.normals.size(), view.positions.size()));
  require_field_sizes(view.fields, static_cast<std::int64_t>(view.positions.size()), name);
}

}  // namespace planish
