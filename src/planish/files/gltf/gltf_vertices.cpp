#include "planish/files/gltf/gltf_vertices.h"

#include <algorithm>
#include <functional>
#include <span>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/files/writers.h"
#include "planish/mesh/sound_topology.h"
#include "planish/patches/seam_vertices.h"

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

namespace {

constexpr std::int64_t kSeamFaces = 1 << 14;

// write(range of faces, span of their corners' values), on all threads.
template <class Write>
RawVector<std::int32_t> of_all_corners(const SurfaceInfo& info, const Write& write) {
  RawVector<std::int32_t> values(static_cast<std::size_t>(info.corner_count));
  const std::vector<RowRange> pieces = ranges_of(info.face_count, kSeamFaces);
  parallel_each(pieces.size(), 1, [&](std::size_t i) {
    const std::int64_t first = info.first_corner(pieces[i].first);
    const std::int64_t last = info.first_corner(pieces[i].first + pieces[i].count);
    write(pieces[i], std::span(values).subspan(static_cast<std::size_t>(first),
                                               static_cast<std::size_t>(last - first)));
  });
  return values;
}

RawVector<std::int32_t> rows_of_corners(const SurfaceBlocks& surface) {
  return of_all_corners(surface.info(), [&](RowRange faces, std::span<std::int32_t> rows) {
    surface.face_vertices(faces, rows);
  });
}

RawVector<std::int32_t> uvs_of_corners(const SurfaceBlocks& surface) {
  return of_all_corners(surface.info(), [&](RowRange faces, std::span<std::int32_t> uvs) {
    surface.face_uvs(faces, uvs);
  });
}

// Vertices at seams, which the file has behind the others.
class SeamSplitter {
 public:
  explicit SeamSplitter(GltfVertices& vertices) : vertices_(vertices), seams_(vertices.uvs) {}

  // The vertex of a corner; `first` is that of its row.
  std::int64_t operator()(std::int64_t first, std::int32_t row, std::int32_t uv) {
    const std::int64_t vertex = seams_.of_corner(first, row, uv);
    if (vertex == vertices_.count()) vertices_.rows.push_back(row);
    return vertex;
  }
  void next_primitive() { seams_.next_primitive(); }

 private:
  GltfVertices& vertices_;
  SeamVertices seams_;
};

// Rows and texture coordinates at the corners of some faces.
struct SeamPiece {
  RawVector<std::int32_t> rows, uvs;
};

void split_seams(const SurfaceBlocks& surface, GltfVertices& vertices) {
  const SurfaceInfo& info = surface.info();
  vertices.uvs.assign(static_cast<std::size_t>(vertices.kept_rows), -1);
  SeamSplitter split(vertices);
  const std::vector<RowRange> pieces = ranges_of(info.face_count, kSeamFaces);
  in_order<SeamPiece>(
      pieces,
      [&](RowRange faces, SeamPiece& piece) {
        const auto count = static_cast<std::size_t>(info.first_corner(faces.first + faces.count) -
                                                    info.first_corner(faces.first));
        piece.rows.resize(count), piece.uvs.resize(count);
        surface.face_vertices(faces, piece.rows);
        surface.face_uvs(faces, piece.uvs);
      },
      [&](RowRange faces, const SeamPiece& piece) {
        const std::int64_t first = info.first_corner(faces.first);
        for (std::size_t c = 0; c < piece.rows.size(); ++c) {
          const std::int32_t row = piece.rows[c];
          const std::int64_t vertex = split(row, row, piece.uvs[c]);
          if (vertex != row)
            vertices.seams.push_back(
                {first + static_cast<std::int64_t>(c), static_cast<std::int32_t>(vertex)});
        }
      });
}

// Calls visit(corner) for every corner of a part.
template <class Visit>
void for_each_corner(const SurfaceInfo& info, const GltfPart& part, const Visit& visit) {
  for (const RowRange& run : part.faces) {
    const auto end = static_cast<std::size_t>(info.first_corner(run.first + run.count));
    for (auto c = static_cast<std::size_t>(info.first_corner(run.first)); c < end; ++c) visit(c);
  }
}

// Numbers the vertices of each part by itself.
void part_vertices(const SurfaceBlocks& surface, GltfVertices& vertices) {
  const SurfaceInfo& info = surface.info();
  vertices.corners = rows_of_corners(surface);
  RawVector<std::int32_t> uvs;
  if (info.uv_count > 0) uvs = uvs_of_corners(surface);
  std::vector<std::int64_t> vertex_of(static_cast<std::size_t>(info.row_count));
  SeamSplitter split(vertices);
  for (GltfPart& part : vertices.parts) {
    part.first_vertex = vertices.count();
    std::vector<std::int32_t> rows;
    for_each_corner(info, part, [&](std::size_t c) { rows.push_back(vertices.corners[c]); });
    std::ranges::sort(rows);
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    for (const std::int32_t row : rows) {
      vertex_of[row] = vertices.count();
      vertices.rows.push_back(row);
    }
    if (!uvs.empty()) vertices.uvs.resize(vertices.rows.size(), -1);
    for_each_corner(info, part, [&](std::size_t c) {
      const std::int32_t row = vertices.corners[c];
      std::int64_t vertex = vertex_of[row];
      if (!uvs.empty()) vertex = split(vertex, row, uvs[c]);
      vertices.corners[c] = static_cast<std::int32_t>(vertex - part.first_vertex);
    });
    part.vertex_count = vertices.count() - part.first_vertex;
    split.next_primitive();
  }
}

// Faces without texture coordinates come with zeros.
void count_uv_sets(const SurfaceBlocks& surface, const GltfOptions& options,
                   GltfVertices& vertices) {
  if (!options.uv_sets.empty()) {
    for (GltfPart& part : vertices.parts) part.uv_sets = options.uv_sets[std::max(part.group, 0)];
    return;
  }
  std::vector<glm::dvec2> values(static_cast<std::size_t>(surface.info().uv_count));
  surface.uvs({0, surface.info().uv_count}, values);
  for (GltfPart& part : vertices.parts) {
    const auto uvs = std::span(vertices.uvs)
                         .subspan(static_cast<std::size_t>(part.first_vertex),
                                  static_cast<std::size_t>(part.vertex_count));
    const bool has_uvs = std::ranges::any_of(
        uvs, [&](std::int32_t uv) { return uv >= 0 && values[uv] != glm::dvec2(0.0); });
    part.uv_sets = has_uvs ? 1 + static_cast<int>(options.further_uvs.size()) : 0;
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

GltfVertices gltf_vertices(const SurfaceBlocks& surface, const GltfOptions& options) {
  const SurfaceInfo& info = surface.info();
  GltfVertices vertices;
  if (info.has_groups) {
    sort_by_group(surface, vertices);
  } else {
    const auto faces = static_cast<std::uint64_t>(info.face_count);
    vertices.parts = {{.face_count = faces,
                       .triangle_count = static_cast<std::uint64_t>(info.corner_count) - 2 * faces,
                       .faces = {{0, info.face_count}}}};
  }
  if (vertices.parts.size() > 1) {
    part_vertices(surface, vertices);
  } else {
    vertices.kept_rows = info.row_count;
    if (info.uv_count > 0) split_seams(surface, vertices);
    for (GltfPart& part : vertices.parts) part.vertex_count = vertices.count();
  }
  if (info.uv_count > 0) count_uv_sets(surface, options, vertices);
  return vertices;
}

std::vector<CopiedRow> copied_rows(const GltfVertices& vertices) {
  std::vector<CopiedRow> copied(vertices.rows.size());
  for (std::size_t i = 0; i < copied.size(); ++i)
    copied[i] = {vertices.rows[i], vertices.kept_rows + static_cast<std::int64_t>(i)};
  std::ranges::sort(copied, std::less<>());
  return copied;
}

std::span<const CopiedRow> copies_in(std::span<const CopiedRow> copied, RowRange range) {
  const auto at = [&](std::int64_t row) {
    return std::ranges::lower_bound(copied, row, std::less<>(), &CopiedRow::row);
  };
  return {at(range.first), at(range.first + range.count)};
}

}  // namespace planish
