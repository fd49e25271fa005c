#include "planish/files/gltf/gltf_checks.h"

#include <span>

#include "planish/core/first_where.h"
#include "planish/core/formatted.h"
#include "planish/files/shared/finite_numbers.h"
#include "planish/files/shared/writable.h"
#include "planish/mesh/mesh_arrays.h"

namespace planish {
namespace {

void require_faces(const SurfaceMesh& surface, const GltfOptions& options) {
  require_a_face(surface.face_count(), options);
  constexpr std::int32_t kLeastCorners = 3;
  require_sound_indices({.vertex_count = surface.positions.size(),
                         .face_offsets = surface.face_offsets,
                         .face_vertices = surface.face_vertices,
                         .uv_count = surface.uvs.size(),
                         .face_uvs = surface.face_uvs,
                         .color_count = surface.colors.size(),
                         .group_count = surface.groups.size(),
                         .face_groups = surface.face_groups},
                        options.name, ErrorCode::InvalidArgument, kLeastCorners);
}

constexpr std::int64_t kCheckedRows = std::int64_t{1} << 13;

// Calls require(range) on all threads; of several that throw the first one's error is thrown.
template <class Require>
void require_pieces(const std::vector<RowRange>& pieces, const Require& require) {
  const std::size_t wrong = first_where(pieces.size(), [&](std::size_t i) {
    try {
      require(pieces[i]);
      return false;
    } catch (const Error& error) {
      if (error.code() != ErrorCode::InvalidArgument) throw;
      return true;
    }
  });
  if (wrong < pieces.size()) require(pieces[wrong]);
}

void require_attributes(const SurfaceMesh& surface, const GltfOptions& options) {
  const std::span<const std::int32_t> face_uvs = surface.face_uvs;
  const std::size_t bare =
      first_where(face_uvs.size(), [&](std::size_t i) { return face_uvs[i] < 0; });
  if (bare < face_uvs.size())
    refuse_to_write(
        options,
        formatted("corner {} has no texture coordinate; glTF needs one for every corner or none",
                  bare),
        static_cast<std::int64_t>(bare));
}

}  // namespace

void refuse_to_write(const GltfOptions& options, const std::string& what, std::int64_t element) {
  throw Error(ErrorCode::InvalidArgument, options.name + ": " + what, element);
}

void require_a_face(std::int64_t face_count, const GltfOptions& options) {
  if (face_count < 1) refuse_to_write(options, "the surface has no face; glTF needs one");
}

void require_numbers(const SurfaceBlocks& surface, const GltfOptions& options) {
  const SurfaceInfo& info = surface.info();
  require_field_sizes(options.fields, info.row_count, options.name);
  for (const NamedField& field : options.fields)
    require_finite(field.values, 0, formatted("{} of vertex", field.name), options.name,
                   static_cast<std::size_t>(field.width));
  for (const GltfAttribute& attribute : options.attributes)
    for (const std::span<const float> values : {attribute.values, attribute.further_values})
      require_finite(values, 0, formatted("{} of number", attribute.name), options.name,
                     static_cast<std::size_t>(attribute.width));
  for (const std::span<const glm::dvec2> set : options.further_uvs)
    require_finite(set, 0, "further texture coordinate", options.name);
  require_pieces(ranges_of(info.uv_count, kCheckedRows), [&](RowRange range) {
    RawVector<glm::dvec2> uvs(static_cast<std::size_t>(range.count));
    surface.uvs(range, uvs);
    for (std::size_t i = 0; i < uvs.size(); ++i)
      if (!is_finite(stored_uv(uvs[i])))
        refuse_not_finite(options.name, "texture coordinate",
                          range.first + static_cast<std::int64_t>(i), stored_uv(uvs[i]));
  });
  if (!info.has_colors) return;
  require_pieces(sorted(surface.row_blocks(kCheckedRows)), [&](RowRange range) {
    RawVector<glm::vec4> colors(static_cast<std::size_t>(range.count));
    RowTarget target;
    target.colors = colors;
    (void)surface.rows(range, target);
    require_finite(std::span<const glm::vec4>(colors), range.first, "the colour of vertex",
                   options.name);
  });
}

void require_writable(const SurfaceMesh& surface, const GltfOptions& options) {
  if (surface.normals.size() != surface.positions.size()) {
    refuse_to_write(options, formatted("{} normals for {} positions", surface.normals.size(),
                                       surface.positions.size()));
  }
  require_faces(surface, options);
  require_attributes(surface, options);
}

}  // namespace planish
