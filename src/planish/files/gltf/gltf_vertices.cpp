#include "planish/files/gltf/gltf_vertices.h"

#include <unordered_map>

#include "planish/core/parallel.h"

namespace planish {
namespace {

constexpr std::int64_t kSeamFaces = 1 << 14;

// write(range of faces, span of their corners' values), on all threads.
template <class Write>
RawVector<std::int32_t> of_all_corners(const SurfaceInfo& info, const Write& write) {
  RawVector<std::int32_t> values(static_cast<std::size_t>(info.corner_count));
  const std::vector<RowRange> pieces = ranges_of(info.face_count, kSeamFaces);
  parallel_for(pieces.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::int64_t first = info.first_corner(pieces[i].first);
      const std::int64_t last = info.first_corner(pieces[i].first + pieces[i].count);
      write(pieces[i], std::span(values).subspan(static_cast<std::size_t>(first),
                                                 static_cast<std::size_t>(last - first)));
    }
  });
  return values;
}

void split_seams(const SurfaceBlocks& surface, GltfVertices& vertices) {
  const SurfaceInfo& info = surface.info();
  vertices.corners = of_all_corners(info, [&](RowRange faces, std::span<std::int32_t> rows) {
    surface.face_vertices(faces, rows);
  });
  const RawVector<std::int32_t> uvs = of_all_corners(
      info, [&](RowRange faces, std::span<std::int32_t> some) { surface.face_uvs(faces, some); });
  vertices.uvs.assign(static_cast<std::size_t>(info.row_count), -1);
  std::unordered_map<std::uint64_t, std::int32_t> copies;  // by row and texture coordinate
  for (std::size_t corner = 0; corner < uvs.size(); ++corner) {
    std::int32_t& vertex = vertices.corners[corner];
    const std::int32_t row = vertex, uv = uvs[corner];
    if (vertices.uvs[row] < 0) vertices.uvs[row] = uv;
    if (vertices.uvs[row] == uv) continue;
    const std::uint64_t key =
        static_cast<std::uint64_t>(row) << 32 | static_cast<std::uint32_t>(uv);
    const auto next = static_cast<std::int32_t>(vertices.count(surface));
    const auto [entry, is_new] = copies.try_emplace(key, next);
    vertex = entry->second;
    if (!is_new) continue;
    vertices.rows.push_back(row);
    vertices.uvs.push_back(uv);
  }
}

void sort_by_group(const SurfaceBlocks& surface, GltfVertices& vertices) {
  const SurfaceInfo& info = surface.info();
  std::vector<GltfPart> all(info.groups.size());
  std::vector<std::int32_t> groups;
  for (const RowRange& piece : ranges_of(info.face_count, kSeamFaces)) {
    groups.resize(static_cast<std::size_t>(piece.count));
    surface.face_groups(piece, groups);
    for (std::int64_t i = 0; i < piece.count; ++i) {
      GltfPart& part = all[groups[i]];
      const std::int64_t face = piece.first + i;
      ++part.face_count;
      part.triangle_count +=
          static_cast<std::uint64_t>(info.first_corner(face + 1) - info.first_corner(face) - 2);
      if (part.faces.empty() || part.faces.back().first + part.faces.back().count != face) {
        part.faces.push_back({face, 0});
      }
      ++part.faces.back().count;
    }
  }
  for (std::size_t group = 0; group < all.size(); ++group) {
    all[group].group = static_cast<std::int32_t>(group);
    if (all[group].face_count > 0) vertices.parts.push_back(std::move(all[group]));
  }
}

}  // namespace

GltfVertices gltf_vertices(const SurfaceBlocks& surface) {
  const SurfaceInfo& info = surface.info();
  GltfVertices vertices;
  if (info.uv_count > 0) split_seams(surface, vertices);
  if (info.has_groups) {
    sort_by_group(surface, vertices);
  } else {
    const auto faces = static_cast<std::uint64_t>(info.face_count);
    vertices.parts = {{.group = -1,
                       .face_count = faces,
                       .triangle_count = static_cast<std::uint64_t>(info.corner_count) - 2 * faces,
                       .faces = {{0, info.face_count}}}};
  }
  return vertices;
}

}  // namespace planish
