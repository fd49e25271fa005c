#include "planish/job/page/page_order.h"

#include <algorithm>
#include <array>
#include <bit>
#include <unordered_map>

#include "planish/core/assert.h"
#include "planish/mesh/hole_flags.h"

namespace planish {
namespace {

std::uint64_t edge_hash(std::int32_t a, std::int32_t b) {
  const auto low = static_cast<std::uint64_t>(std::min(a, b));
  // The constants are those of the splitmix64 generator.
  std::uint64_t hash = static_cast<std::uint64_t>(std::max(a, b)) << 32 | low;
  hash = (hash ^ hash >> 30) * 0xbf58476d1ce4e5b9u;
  hash = (hash ^ hash >> 27) * 0x94d049bb133111ebu;
  return hash ^ hash >> 31;
}

// Level 0: given vertices keep their numbers, a vertex's further rows follow as copies.
void start(PageOrder& order, const LevelFaces& faces, const SurfaceMesh& surface,
           const PolygonMesh& mesh) {
  const auto given = static_cast<std::int32_t>(surface.base_vertices.size());
  for (std::int32_t v = 0; v < given; ++v) order.rows.push_back(v);
  order.sources = surface.base_vertices;
  order.faces.offsets = faces.offsets;
  const std::vector<std::uint8_t> is_hole = hole_flags(mesh);
  std::vector<std::int32_t> corners;  // the mesh's vertices of the faces that are seen
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (is_hole[f] != 0) continue;
    corners.insert(corners.end(), mesh.face(f).begin(), mesh.face(f).end());
  }
  PLANISH_ASSERT(corners.size() == faces.vertices.size());
  std::unordered_map<std::int32_t, std::int32_t> copy_of_row;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::int32_t row = faces.vertices[i];
    std::int32_t vertex = row;
    if (row >= given) {
      const auto next = static_cast<std::int32_t>(order.rows.size());
      const auto [found, fresh] = copy_of_row.try_emplace(row, next);
      if (fresh) {
        order.rows.push_back(row);
        order.sources.push_back(corners[i]);
      }
      vertex = found->second;
    }
    order.faces.vertices.push_back(vertex);
  }
  order.counts.push_back(order.rows.size());
}

// One split: `faces` in page vertices becomes the next level's.
class Splitter {
 public:
  Splitter(PageOrder& order, const LevelFaces& faces, const LevelFaces& fine)
      : order_(order),
        faces_(faces),
        fine_(fine),
        edges_(std::bit_ceil(faces.vertices.size() + 1), -1) {}

  LevelFaces run() {
    if (!order_.triangles) add_middles();
    LevelFaces next;
    next.offsets = fine_.offsets;
    next.vertices.resize(fine_.vertices.size());
    std::size_t child = 0;
    for (std::size_t f = 0; f < faces_.face_count(); ++f) {
      const std::size_t n = faces_.face(f).size();
      connect(f, child, next);
      child += order_.triangles ? 4 : n;
    }
    order_.counts.push_back(order_.rows.size());
    return next;
  }

 private:
  std::int32_t add_vertex(std::int32_t row, std::span<const std::int32_t> parents) {
    PageSplit& split = order_.splits.back();
    split.parents.insert(split.parents.end(), parents.begin(), parents.end());
    split.parent_offsets.push_back(static_cast<std::int32_t>(split.parents.size()));
    order_.rows.push_back(row);
    return static_cast<std::int32_t>(order_.rows.size()) - 1;
  }

  void add_middles() {
    std::size_t child = 0;
    for (std::size_t f = 0; f < faces_.face_count(); ++f) {
      const auto face = faces_.face(f);
      const auto corners = fine_.face(child);
      (void)add_vertex(corners[child_corners(face.size(), 4, 0).middle], face);
      child += face.size();
    }
  }

  // Whether a new vertex is that of the edge between two.
  [[nodiscard]] bool halves(std::int32_t vertex, std::int32_t a, std::int32_t b) const {
    const PageSplit& split = order_.splits.back();
    const auto first = static_cast<std::size_t>(
        split.parent_offsets[static_cast<std::size_t>(vertex) - order_.counts.back()]);
    const std::int32_t p = split.parents[first], q = split.parents[first + 1];
    return (p == a && q == b) || (p == b && q == a);
  }

  // The vertex of the edge that begins at a corner.
  std::int32_t edge_vertex(std::size_t corner, std::int32_t a, std::int32_t b, std::int32_t row) {
    const std::size_t mask = edges_.size() - 1;
    std::size_t slot = edge_hash(a, b) & mask;
    while (edges_[slot] >= 0 && !halves(edges_[slot], a, b)) slot = (slot + 1) & mask;
    const std::int32_t found = edges_[slot];
    if (found >= 0 && order_.rows[found] == row) return found;
    const std::int32_t vertex = add_vertex(row, std::array{a, b});
    if (found < 0) {
      edges_[slot] = vertex;
    } else {
      order_.splits.back().cuts.push_back(static_cast<std::int32_t>(corner));
    }
    return vertex;
  }

  void connect(std::size_t f, std::size_t child, LevelFaces& next) {
    const auto face = faces_.face(f);
    const std::size_t n = face.size();
    edge_of_corner_.resize(n);
    for (std::size_t k = 0; k < n; ++k) {
      const auto corners = fine_.face(child + k);
      const ChildCorners at = child_corners(n, corners.size(), static_cast<int>(k));
      edge_of_corner_[k] =
          edge_vertex(faces_.offsets[f] + k, face[k], face[(k + 1) % n], corners[at.edge]);
    }
    const auto first_middle = static_cast<std::int32_t>(order_.counts.back());
    for (std::size_t k = 0; k < n; ++k) {
      const std::int32_t offset = fine_.offsets[child + k];
      const int m = order_.triangles ? 3 : 4;
      const ChildCorners at = child_corners(n, static_cast<std::size_t>(m), static_cast<int>(k));
      next.vertices[offset + at.corner] = face[k];
      next.vertices[offset + at.edge] = edge_of_corner_[k];
      next.vertices[offset + (at.corner + m - 1) % m] = edge_of_corner_[(k + n - 1) % n];
      if (at.middle >= 0)
        next.vertices[offset + at.middle] = first_middle + static_cast<std::int32_t>(f);
    }
    if (!order_.triangles) return;
    // The child in the middle has the edges' points, wherever its first corner lies.
    const auto middle = fine_.face(child + 3);
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t e = 0; e < 3; ++e) {
        if (order_.rows[edge_of_corner_[e]] == middle[k])
          next.vertices[fine_.offsets[child + 3] + k] = edge_of_corner_[e];
      }
    }
  }

  PageOrder& order_;
  const LevelFaces& faces_;
  const LevelFaces& fine_;
  // By hash of the ends, the next free place: the first vertex of each edge; -1: none. There are no
  // more edges than corners.
  std::vector<std::int32_t> edges_;
  std::vector<std::int32_t> edge_of_corner_;  // of the face at hand
};

}  // namespace

PageOrder page_order(const SurfaceMesh& surface, const PolygonMesh& mesh) {
  const std::vector<LevelFaces> levels = level_faces(surface, mesh);
  PageOrder order;
  order.triangles = surface.is_triangles();
  start(order, levels[0], surface, mesh);
  LevelFaces faces = order.faces;
  for (std::size_t l = 1; l < levels.size(); ++l) {
    order.splits.emplace_back();
    LevelFaces next = Splitter(order, faces, levels[l]).run();
    for (std::size_t i = 0; i < next.vertices.size(); ++i)
      PLANISH_ASSERT(order.rows[next.vertices[i]] == levels[l].vertices[i]);
    faces = std::move(next);
  }
  return order;
}

PageOrder texture_order(const SurfaceMesh& surface, const PolygonMesh& mesh) {
  SurfaceMesh charts;
  charts.level = surface.level;
  charts.face_offsets = surface.face_offsets;
  charts.face_vertices = surface.face_uvs;
  return page_order(charts, mesh);
}

}  // namespace planish
