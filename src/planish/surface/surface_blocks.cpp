#include "planish/surface/surface_blocks.h"

#include <algorithm>
#include <mutex>
#include <string>

#include "planish/core/counted.h"
#include "planish/mesh/quad_cut.h"
#include "planish/surface/piece_loop.h"

namespace planish {

namespace {

// Rows and faces of a piece: those of several tiles, still within a core's cache.
constexpr std::int64_t kPieceRows = 1 << 14;

// Also of faces whose rows are made along.
constexpr std::int64_t kPieceFaces = 1 << 13;

template <class T>
std::span<T> part_of(RawVector<T>& values, std::int64_t first, std::int64_t count) {
  return std::span(values).subspan(static_cast<std::size_t>(first),
                                   static_cast<std::size_t>(count));
}

}  // namespace

void SurfaceBlocks::cuts(RowRange faces, std::span<std::uint8_t> from_1) const {
  RawVector<glm::dvec3> positions(static_cast<std::size_t>(4 * faces.count));
  RawVector<glm::vec3> normals(positions.size());
  corners(faces, positions, normals);
  for (std::size_t f = 0; f < from_1.size(); ++f) {
    const glm::dvec3* p = positions.data() + 4 * f;
    from_1[f] = is_cut_from_1(p[0], p[1], p[2], p[3]) ? 1 : 0;
  }
}

// By runs of rows that follow one another.
DegenerateRows SurfaceBlocks::rows_at(std::span<const std::int32_t> rows,
                                      const RowTarget& target) const {
  DegenerateRows found;
  for (std::size_t i = 0; i < rows.size();) {
    std::size_t count = 1;
    while (i + count < rows.size() && rows[i + count] == rows[i + count - 1] + 1) ++count;
    RowTarget run;
    run.origin = target.origin;
    const auto take = [&](const auto& all, auto& part) {
      if (!all.empty()) part = all.subspan(i, count);
    };
    take(target.positions, run.positions);
    take(target.stored, run.stored);
    take(target.normals, run.normals);
    take(target.colors, run.colors);
    found.add(this->rows({rows[i], static_cast<std::int64_t>(count)}, run));
    i += count;
  }
  return found;
}

std::vector<RowRange> ranges_of(std::int64_t count, std::int64_t size) {
  std::vector<RowRange> ranges;
  for (std::int64_t first = 0; first < count; first += size) {
    ranges.push_back({first, std::min(size, count - first)});
  }
  return ranges;
}

std::vector<RowRange> sorted(std::vector<RowRange> ranges) {
  std::sort(ranges.begin(), ranges.end(),
            [](const RowRange& a, const RowRange& b) { return a.first < b.first; });
  return ranges;
}

void warn_of(const DegenerateRows& rows, const Callbacks& callbacks) {
  if (rows.count == 0) return;
  callbacks.warn(
      {"degenerate-normals",
       counted(rows.count, "vertex") +
           (rows.count == 1 ? " has parallel tangents; its normal is that of the facets"
                            : " have parallel tangents; their normals are those of the facets"),
       rows.count, rows.first});
}

DegenerateRows make_all_rows(const SurfaceBlocks& blocks, const RowTarget& all,
                             const Callbacks& callbacks) {
  DegenerateRows degenerate;
  std::mutex mutex;
  const auto add = [&](const DegenerateRows& found) {
    if (found.count == 0) return;
    const std::lock_guard lock(mutex);
    degenerate.add(found);
  };
  const bool by_faces = blocks.makes_face_rows() && all.stored.empty() && all.colors.empty();
  const RowRange along = by_faces ? blocks.rows_of_faces() : RowRange{0, 0};
  if (by_faces) {
    for_pieces(ranges_of(blocks.info().face_count, kPieceFaces), callbacks, 0, 0.75,
               [&](RowRange faces) { add(blocks.face_rows(faces, all)); });
  }
  std::vector<RowRange> pieces = blocks.row_blocks(kPieceRows);
  std::erase_if(pieces, [&](const RowRange& piece) {
    return piece.first >= along.first && piece.first + piece.count <= along.first + along.count;
  });
  for_pieces(pieces, callbacks, by_faces ? 0.75 : 0, 0.8, [&](RowRange rows) {
    RowTarget target = all;
    const auto take = [&](auto& values) {
      if (!values.empty())
        values = values.subspan(static_cast<std::size_t>(rows.first),
                                static_cast<std::size_t>(rows.count));
    };
    take(target.positions);
    take(target.stored);
    take(target.normals);
    take(target.colors);
    add(blocks.rows(rows, target));
  });
  return degenerate;
}

VertexAttribute all_rows(const SurfaceBlocks& blocks, std::size_t attribute) {
  const auto& info = blocks.info().attributes[attribute];
  const int width = info.width;
  VertexAttribute made =
      attribute_of_size(info.name, width, static_cast<std::size_t>(blocks.info().row_count));
  const std::vector<RowRange> ranges = ranges_of(blocks.info().row_count, kPieceRows);
  parallel_each(ranges.size(), 1, [&](std::size_t i) {
    blocks.attribute(attribute, ranges[i],
                     std::span(made.values)
                         .subspan(static_cast<std::size_t>(width * ranges[i].first),
                                  static_cast<std::size_t>(width * ranges[i].count)));
  });
  return made;
}

SurfaceMesh collect(const SurfaceBlocks& blocks, const Callbacks& callbacks) {
  const HostScope host(callbacks);
  const SurfaceInfo& info = blocks.info();
  SurfaceMesh surface;
  surface.level = info.level;
  surface.base_vertices = info.base_vertices;
  surface.groups = info.groups;
  surface.face_offsets = info.face_offsets;
  const auto row_count = static_cast<std::size_t>(info.row_count);
  surface.positions.resize(row_count);
  surface.normals.resize(row_count);
  if (info.has_colors) surface.colors.resize(row_count);
  RowTarget all;
  all.positions = surface.positions;
  all.normals = surface.normals;
  all.colors = surface.colors;
  const DegenerateRows degenerate = make_all_rows(blocks, all, callbacks);
  for (std::size_t k = 0; k < info.attributes.size(); ++k)
    surface.attributes.push_back(all_rows(blocks, k));

  surface.face_vertices.resize(static_cast<std::size_t>(info.corner_count));
  if (info.uv_count > 0) surface.face_uvs.resize(surface.face_vertices.size());
  if (info.has_groups) surface.face_groups.resize(static_cast<std::size_t>(info.face_count));
  for_pieces(ranges_of(info.face_count, kPieceRows), callbacks, 0.8, 1, [&](RowRange faces) {
    const std::int64_t first = info.first_corner(faces.first);
    const std::int64_t count = info.first_corner(faces.first + faces.count) - first;
    blocks.face_vertices(faces, part_of(surface.face_vertices, first, count));
    if (info.uv_count > 0) blocks.face_uvs(faces, part_of(surface.face_uvs, first, count));
    if (info.has_groups) {
      blocks.face_groups(faces, part_of(surface.face_groups, faces.first, faces.count));
    }
  });
  surface.uvs.resize(static_cast<std::size_t>(info.uv_count));
  for_pieces(ranges_of(info.uv_count, kPieceRows), {}, 0, 0,
             [&](RowRange uvs) { blocks.uvs(uvs, part_of(surface.uvs, uvs.first, uvs.count)); });
  warn_of(degenerate, callbacks);
  callbacks.report("evaluate", 1);
  return surface;
}

}  // namespace planish
