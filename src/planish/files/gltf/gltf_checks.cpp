#include "planish/files/gltf/gltf_checks.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "planish/core/parallel.h"

namespace planish {
namespace {

constexpr std::size_t kCheckGrain = std::size_t{1} << 13;

// Smallest i with wrong(i), whatever the threads do; count if there is none.
template <class Predicate>
std::size_t first_where(std::size_t count, const Predicate& wrong) {
  const std::size_t block_count = (count + kCheckGrain - 1) / kCheckGrain;
  std::vector<std::size_t> first(block_count, count);
  parallel_for(block_count, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t block = begin; block < end; ++block) {
      const std::size_t stop = std::min(count, (block + 1) * kCheckGrain);
      for (std::size_t i = block * kCheckGrain; i < stop; ++i) {
        if (!wrong(i)) continue;
        first[block] = i;
        break;
      }
    }
  });
  return first.empty() ? count : *std::min_element(first.begin(), first.end());
}

void require_faces(const SurfaceMesh& surface, const GltfOptions& options) {
  const auto& corners = surface.face_vertices;
  if (surface.face_count() < 1) refuse_to_write(options, "the surface has no face; glTF needs one");
  if (surface.face_offsets.empty()) {
    if (corners.size() % 4 != 0)
      refuse_to_write(options, "the number of quad corners is no multiple of 4");
  } else {
    const auto& offsets = surface.face_offsets;
    const auto face_count = static_cast<std::size_t>(surface.face_count());
    const std::size_t small = first_where(face_count, [&](std::size_t f) {
      return offsets[f] < 0 || offsets[f + 1] - 3 < offsets[f];
    });
    if (small < face_count) {
      refuse_to_write(options, "face " + std::to_string(small) + " has fewer than 3 corners",
                      static_cast<std::int64_t>(small));
    }
    if (offsets.front() != 0 || static_cast<std::size_t>(offsets.back()) != corners.size()) {
      refuse_to_write(options, "the face offsets do not span the face corners");
    }
  }
  const auto vertex_count = static_cast<std::int64_t>(surface.positions.size());
  const std::size_t wild = first_where(
      corners.size(), [&](std::size_t i) { return corners[i] < 0 || corners[i] >= vertex_count; });
  if (wild < corners.size()) {
    refuse_to_write(options,
                    "face corner " + std::to_string(wild) + " names vertex " +
                        std::to_string(corners[wild]) + " of " + std::to_string(vertex_count),
                    static_cast<std::int64_t>(wild));
  }
}

void require_attributes(const SurfaceMesh& surface, const GltfOptions& options) {
  const auto require_size = [&](std::size_t size, std::size_t wanted, const std::string& what) {
    if (size != 0 && size != wanted)
      refuse_to_write(options, std::to_string(size) + " " + what + " where " +
                                   std::to_string(wanted) + " are needed");
  };
  require_size(surface.face_uvs.size(), surface.face_vertices.size(), "corners of the texture");
  require_size(surface.colors.size(), surface.positions.size(), "colours");
  require_size(surface.face_groups.size(), static_cast<std::size_t>(surface.face_count()),
               "groups of faces");
  const auto require_indices = [&](std::span<const std::int32_t> indices, std::size_t count,
                                   const std::string& what) {
    const std::size_t wild = first_where(indices.size(), [&](std::size_t i) {
      return indices[i] < 0 || static_cast<std::size_t>(indices[i]) >= count;
    });
    if (wild < indices.size())
      refuse_to_write(options,
                      what + " " + std::to_string(wild) + " has number " +
                          std::to_string(indices[wild]) + " of " + std::to_string(count),
                      static_cast<std::int64_t>(wild));
  };
  require_indices(surface.face_uvs, surface.uvs.size(), "the texture coordinate of corner");
  require_indices(surface.face_groups, surface.groups.size(), "the group of face");
  const auto require_finite = [&](std::size_t count, const auto& is_wrong,
                                  const std::string& what) {
    const std::size_t wild = first_where(count, is_wrong);
    if (wild < count)
      refuse_to_write(options, what + " " + std::to_string(wild) + " is not finite in float32",
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

void require_fields(std::int64_t row_count, const GltfOptions& options) {
  for (const NamedField& field : options.fields) {
    if (field.values.size() != static_cast<std::size_t>(row_count))
      refuse_to_write(options, std::to_string(field.values.size()) + " values of " + field.name +
                                   " for " + std::to_string(row_count) + " positions");
    const std::size_t wild = first_where(
        field.values.size(), [&](std::size_t i) { return !std::isfinite(field.values[i]); });
    if (wild < field.values.size())
      refuse_to_write(options, field.name + " of vertex " + std::to_string(wild) + " is not finite",
                      static_cast<std::int64_t>(wild));
  }
}

void require_writable(const SurfaceMesh& surface, const GltfOptions& options) {
  if (surface.normals.size() != surface.positions.size()) {
    refuse_to_write(options, std::to_string(surface.normals.size()) + " normals for " +
                                 std::to_string(surface.positions.size()) + " positions");
  }
  require_faces(surface, options);
  require_attributes(surface, options);
}

}  // namespace planish
