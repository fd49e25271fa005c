#include "planish/files/gltf/gltf_checks.h"

#include <cmath>
#include <span>

#include "planish/core/first_where.h"
#include "planish/core/formatted.h"
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
  const auto require_finite = [&](std::size_t count, const auto& is_wrong,
                                  const std::string& what) {
    const std::size_t wild = first_where(count, is_wrong);
    if (wild < count)
      refuse_to_write(options, formatted("{} {} is not finite in float32", what, wild),
                      static_cast<std::int64_t>(wild));
  };
  require_finite(
      surface.uvs.size(),
      [&](std::size_t i) { return !is_finite(glm::vec3(stored_uv(surface.uvs[i]), 0.0f)); },
      "texture coordinate");
  require_finite(
      surface.colors.size(),
      [&](std::size_t i) {
        const glm::vec4& color = surface.colors[i];
        return !is_finite(glm::vec3(color)) || !std::isfinite(color.a);
      },
      "the colour of vertex");
}

}  // namespace

void refuse_to_write(const GltfOptions& options, const std::string& what, std::int64_t element) {
  throw Error(ErrorCode::InvalidArgument, options.name + ": " + what, element);
}

void require_a_face(std::int64_t face_count, const GltfOptions& options) {
  if (face_count < 1) refuse_to_write(options, "the surface has no face; glTF needs one");
}

void require_fields(std::int64_t row_count, const GltfOptions& options) {
  require_field_sizes(options.fields, row_count, options.name);
  for (const NamedField& field : options.fields) {
    const std::size_t wild = first_where(
        field.values.size(), [&](std::size_t i) { return !std::isfinite(field.values[i]); });
    if (wild < field.values.size())
      refuse_to_write(options,
                      formatted("{} of vertex {} is not finite", field.name,
                                wild / static_cast<std::size_t>(field.width)),
                      static_cast<std::int64_t>(wild) / field.width);
  }
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
