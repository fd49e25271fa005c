#include "planish/job/output_bytes.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <string>
#include <vector>

namespace planish {
namespace {

// What keeps a corner's vertex apart from others at the same vertex of the mesh.
struct CornerKey {
  std::int32_t sector, group, uv;
  friend auto operator<=>(const CornerKey&, const CornerKey&) = default;
};

class CopyCounter {
 public:
  CopyCounter(const PolygonMesh& mesh, const PreparedMesh& prepared)
      : mesh_(mesh), prepared_(prepared), topology_(*prepared.topology), is_sharp_(sharp_edges()) {}

  void count(WrittenShape& shape) {
    for (std::int32_t v = 0; v < topology_.vertex_count(); ++v) count_vertex(v, shape);
    for (std::int32_t e = 0; e < topology_.edge_count(); ++e) {
      const std::int32_t corner = topology_.corner_of(e), other = topology_.twin(corner);
      if (other < 0) continue;
      const bool has_seam =
          uv(corner) != uv(topology_.next(other)) || uv(topology_.next(corner)) != uv(other);
      if (is_sharp(e)) {
        ++shape.rows.edges;
      } else if (has_seam || group(corner) != group(other)) {
        ++shape.gltf_vertices.edges;
      }
    }
  }

 private:
  // By edge; empty where none is.
  [[nodiscard]] std::vector<bool> sharp_edges() const {
    std::vector<bool> sharp;
    for (const CreaseEdge& crease : mesh_.creases) {
      if (!std::isinf(crease.sharpness) && crease.sharpness < kInfiniteSharpness) continue;
      const std::int32_t v0 = used(crease.v0), v1 = used(crease.v1);
      const std::int32_t edge = v0 < 0 || v1 < 0 ? -1 : topology_.find_edge(v0, v1);
      if (edge < 0 || topology_.is_boundary_edge(edge)) continue;
      sharp.resize(static_cast<std::size_t>(topology_.edge_count()));
      sharp[edge] = true;
    }
    return sharp;
  }
  // The topology's number of a vertex, -1: no face names it.
  [[nodiscard]] std::int32_t used(std::int32_t vertex) const {
    const auto found = std::ranges::lower_bound(prepared_.vertices, vertex);
    return found == prepared_.vertices.end() || *found != vertex
               ? -1
               : static_cast<std::int32_t>(found - prepared_.vertices.begin());
  }
  [[nodiscard]] bool is_sharp(std::int32_t edge) const {
    return !is_sharp_.empty() && is_sharp_[edge];
  }
  [[nodiscard]] std::int32_t uv(std::int32_t corner) const {
    return mesh_.face_uvs.empty() ? -1 : mesh_.face_uvs[corner];
  }
  [[nodiscard]] std::int32_t group(std::int32_t corner) const {
    return mesh_.face_groups.empty() ? 0 : mesh_.face_groups[topology_.face_of(corner)];
  }

  void count_vertex(std::int32_t vertex, WrittenShape& shape) {
    const auto corners = topology_.corners_at(vertex);
    keys_.clear();
    std::int32_t sector = 0;
    for (const std::int32_t corner : corners) {
      keys_.push_back({sector, group(corner), uv(corner)});
      // To the next corner the way leads across the trailing edge.
      if (is_sharp(topology_.edge_of(topology_.prev(corner)))) ++sector;
    }
    // Round a vertex the last sector goes on in the first.
    if (sector > 0 && !topology_.is_boundary_vertex(vertex)) {
      for (CornerKey& key : keys_)
        if (key.sector == sector) key.sector = 0;
      --sector;
    }
    std::ranges::sort(keys_);
    keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
    shape.rows.vertices += sector;
    shape.gltf_vertices.vertices +=
        std::max<std::int64_t>(std::ssize(keys_), 1) - 1 - std::int64_t{sector};
  }

  const PolygonMesh& mesh_;
  const PreparedMesh& prepared_;
  const MeshTopology& topology_;
  std::vector<bool> is_sharp_;
  std::vector<CornerKey> keys_;  // of the vertex at hand
};

struct Counts {
  std::uint64_t rows, faces, corners, fields;
  bool has_normals;
};

Counts counts_of(const WrittenShape& shape, const WrittenLevel& level, const PlannedOutput& output,
                 const Settings& settings) {
  const auto faces = static_cast<std::uint64_t>(level.counts.faces);
  const bool is_surface = output.kind == OutputKind::Surface;
  const FieldChoice& fields = settings.attributes;
  return {.rows = static_cast<std::uint64_t>(written_vertices(shape, level, output.kind)),
          .faces = faces,
          .corners = level.level == 0 ? static_cast<std::uint64_t>(shape.corner_count)
                                      : (level.is_triangles ? 3 : 4) * faces,
          .fields = is_surface ? static_cast<std::uint64_t>(fields.error) + fields.deviation +
                                     fields.fold + (fields.curvature ? 2 : 0) + shape.property_count
                               : 0,
          .has_normals = is_surface};
}

std::uint64_t gltf_bytes(const WrittenShape& shape, const WrittenLevel& level, const Counts& counts,
                         GltfCompression compression) {
  const std::uint64_t vertices =
      counts.rows + static_cast<std::uint64_t>(shape.gltf_vertices.at(level.level));
  const auto primitives = static_cast<std::uint64_t>(std::max<std::int64_t>(shape.group_count, 1));
  // Two bytes an index while that reaches.
  const std::uint64_t index = vertices / primitives < 65535 ? 2 : 4;
  const std::uint64_t document = 1500 + 1100 * (primitives - 1) + 3 * shape.name_bytes +
                                 160 * counts.fields +
                                 (compression == GltfCompression::None ? 0 : 800 * primitives);
  const std::uint64_t numbers =
      vertices * (24 + (shape.has_uvs ? 8 : 0) + (shape.has_colors ? 16 : 0) + 4 * counts.fields) +
      index * 3 * (counts.corners - 2 * counts.faces);
  // The most that surfaces of known meshes came out at: 0.94, and 0.20 to 0.40, at level 0 to 0.48.
  const double share = compression == GltfCompression::None       ? 1
                       : compression == GltfCompression::Quantize ? 0.95
                       : level.level == 0                         ? 0.5
                                                                  : 0.42;
  return document + static_cast<std::uint64_t>(share * static_cast<double>(numbers));
}

std::uint64_t ply_bytes(const WrittenShape& shape, const WrittenLevel& level,
                        const Counts& counts) {
  const bool is_long = level.level == 0 && shape.largest_face > 255;
  // Of vertices, or lists of faces.
  const bool has_long_lists = level.level == 0 && 2 * shape.largest_face > 255;
  const std::uint64_t uv_bytes = !shape.has_uvs ? 0
                                 : shape.has_uv_seams
                                     ? 8 * counts.corners + (has_long_lists ? 4 : 1) * counts.faces
                                     : 8 * counts.rows;
  return 250 + (counts.has_normals ? 60 : 300) + (shape.has_colors ? 80 : 0) + 25 * counts.fields +
         (shape.has_uvs ? 40 : 0) + uv_bytes +
         counts.rows *
             (24 + (counts.has_normals ? 12 : 0) + (shape.has_colors ? 4 : 0) + 4 * counts.fields) +
         (is_long ? 4 : 1) * counts.faces + 4 * counts.corners;
}

}  // namespace

WrittenShape written_shape(const PolygonMesh& mesh, const PreparedMesh& prepared) {
  const MeshTopology& topology = *prepared.topology;
  WrittenShape shape;
  shape.has_uvs = !mesh.face_uvs.empty();
  shape.has_colors = !mesh.colors.empty();
  std::vector<std::int32_t> uv_of(mesh.positions.size(), -1);
  for (std::size_t c = 0; c < mesh.face_uvs.size(); ++c) {
    const std::int32_t uv = mesh.face_uvs[c];
    std::int32_t& known = uv_of[mesh.face_vertices[c]];
    shape.has_uv_seams = shape.has_uv_seams || uv < 0 || (known >= 0 && known != uv);
    known = uv;
  }
  shape.corner_count = topology.corner_count();
  for (std::int32_t f = 0; f < topology.face_count(); ++f)
    shape.largest_face =
        std::max(shape.largest_face, static_cast<std::size_t>(topology.face_size(f)));
  if (!mesh.face_groups.empty()) shape.group_count = std::ssize(mesh.groups);
  for (const FaceGroup& group : mesh.groups)
    shape.name_bytes += group.name.size() + group.material.size();
  CopyCounter(mesh, prepared).count(shape);
  return shape;
}

std::int64_t written_vertices(const WrittenShape& shape, const WrittenLevel& level,
                              OutputKind kind) {
  return level.counts.vertices + (kind == OutputKind::Surface ? shape.rows.at(level.level) : 0);
}

std::optional<std::uint64_t> output_bytes(const WrittenShape& shape, const WrittenLevel& level,
                                          const PlannedOutput& output, const Settings& settings) {
  const Counts counts = counts_of(shape, level, output, settings);
  switch (output.format) {
    case FileFormat::Glb:
    case FileFormat::Gltf:
      return gltf_bytes(shape, level, counts, settings.compression);
    case FileFormat::Ply:
      return ply_bytes(shape, level, counts);
    case FileFormat::Stl:
      return 84 + 50 * (counts.corners - 2 * counts.faces);
    default:
      return std::nullopt;
  }
}

}  // namespace planish
