#include "planish/surface/level_faces.h"

#include <opensubdiv/far/primvarRefiner.h>

#include <utility>
#include <vector>

#include "planish/core/guards.h"
#include "planish/mesh/mesh_parts.h"

namespace planish {

namespace Far = OpenSubdiv::Far;

namespace {

// A primvar of OpenSubdiv's protocol.
template <class Vector>
struct Primvar {
  Vector value{0.0};
  void Clear() { value = Vector(0.0); }
#pragma GCC diagnostic push
#if defined(__GNUC__) && !defined(__clang__)
  // GCC 14 does not see that OpenSubdiv's masks of an edge set both weights.
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
  void AddWithWeight(const Primvar& other, float weight) {
    value += static_cast<double>(weight) * other.value;
  }
#pragma GCC diagnostic pop
};

void carry_uvs(const PolygonMesh& mesh, const Far::TopologyRefiner& topology,
               SurfaceMesh& surface) {
  std::vector<Primvar<glm::dvec2>> values(mesh.uvs.size() + 1);
  for (std::size_t i = 0; i < mesh.uvs.size(); ++i) values[i].value = mesh.uvs[i];
  const OpenSubdiv::Far::PrimvarRefinerReal<float> refiner(topology);
  for (int l = 1; l <= surface.level; ++l) {
    std::vector<Primvar<glm::dvec2>> finer(
        static_cast<std::size_t>(topology.GetLevel(l).GetNumFVarValues()));
    refiner.InterpolateFaceVarying(l, values, finer);
    values = std::move(finer);
  }
  surface.uvs.reserve(values.size());
  for (const auto& primvar : values) surface.uvs.push_back(primvar.value);

  const auto& level = topology.GetLevel(surface.level);
  surface.face_uvs.reserve(surface.face_vertices.size());
  for (int f = 0; f < level.GetNumFaces(); ++f) {
    const auto corners = level.GetFaceFVarValues(f);
    for (int i = 0; i < corners.size(); ++i) surface.face_uvs.push_back(corners[i]);
  }
}

// of(vertex) of all vertices of the mesh, four numbers each, linearly: put(row, value).
template <class Of, class Put>
void carry_linear(const PolygonMesh& mesh, const Far::TopologyRefiner& topology,
                  const SectorRows& rows, int level, const Of& of, const Put& put) {
  std::vector<Primvar<glm::dvec4>> values(mesh.positions.size());
  for (std::size_t i = 0; i < values.size(); ++i) values[i].value = glm::dvec4(of(i));
  const OpenSubdiv::Far::PrimvarRefinerReal<float> refiner(topology);
  for (int l = 1; l <= level; ++l) {
    std::vector<Primvar<glm::dvec4>> finer(
        static_cast<std::size_t>(topology.GetLevel(l).GetNumVertices()));
    refiner.InterpolateVarying(l, values, finer);
    values = std::move(finer);
  }
  for (std::int64_t row = 0; row < rows.count(); ++row)
    put(static_cast<std::size_t>(row), glm::vec4(values[rows.place(row).vertex].value));
}

void carry_colors(const PolygonMesh& mesh, const Far::TopologyRefiner& topology,
                  const SectorRows& rows, SurfaceMesh& surface) {
  surface.colors.resize(surface.positions.size());
  carry_linear(
      mesh, topology, rows, surface.level, [&](std::size_t v) { return mesh.colors[v]; },
      [&](std::size_t row, const glm::vec4& color) { surface.colors[row] = color; });
}

void carry_numbers(const PolygonMesh& mesh, const Far::TopologyRefiner& topology,
                   const SectorRows& rows, SurfaceMesh& surface) {
  for (const VertexAttribute& given : mesh.attributes) {
    VertexAttribute& made = surface.attributes.emplace_back(
        attribute_of_size(given.name, given.width, surface.positions.size()));
    for (int first = 0; first < given.width; first += 4)
      carry_linear(
          mesh, topology, rows, surface.level, [&](std::size_t v) { return given.four(v, first); },
          [&](std::size_t row, const glm::vec4& four) { made.set_four(row, first, four); });
  }
}

// Takes over the rows of `whole` that the surface's faces name, in their order.
void keep_named_rows(const SurfaceMesh& whole, SurfaceMesh& surface) {
  std::vector<std::int32_t> row(whole.positions.size(), -1);
  for (const std::int32_t v : surface.face_vertices) row[v] = 0;
  std::vector<std::int32_t> kept;
  for (std::size_t v = 0; v < row.size(); ++v) {
    if (row[v] < 0) continue;
    row[v] = static_cast<std::int32_t>(kept.size());
    kept.push_back(static_cast<std::int32_t>(v));
    surface.positions.push_back(whole.positions[v]);
    surface.normals.push_back(whole.normals[v]);
    if (!whole.colors.empty()) surface.colors.push_back(whole.colors[v]);
    if (v < whole.base_vertices.size()) surface.base_vertices.push_back(whole.base_vertices[v]);
  }
  surface.attributes = attributes_of(whole.attributes, kept);
  for (std::int32_t& v : surface.face_vertices) v = row[v];
}

}  // namespace

std::int64_t descendant_count(const SurfaceMesh& surface, std::int32_t face_size) {
  if (surface.level == 0) return 1;
  return surface.is_triangles() ? std::int64_t{1} << (2 * surface.level)
                                : static_cast<std::int64_t>(face_size) << (2 * (surface.level - 1));
}

void carry_attributes(const PolygonMesh& mesh, const Far::TopologyRefiner& topology,
                      const SectorRows& rows, SurfaceMesh& surface) {
  if (!mesh.face_uvs.empty()) carry_uvs(mesh, topology, surface);
  if (!mesh.colors.empty()) carry_colors(mesh, topology, rows, surface);
  carry_numbers(mesh, topology, rows, surface);
  if (mesh.face_groups.empty()) return;
  surface.groups = mesh.groups;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    surface.face_groups.insert(
        surface.face_groups.end(),
        static_cast<std::size_t>(descendant_count(surface, mesh.face_size(f))),
        mesh.face_groups[f]);
  }
}

void remove_holes(const PolygonMesh& mesh, SurfaceMesh& surface) {
  if (mesh.hole_faces.empty()) return;
  const std::vector<std::uint8_t> is_hole = hole_flags(mesh);

  const SurfaceMesh whole = std::move(surface);
  surface = SurfaceMesh{.level = whole.level};
  surface.uvs = whole.uvs;
  surface.groups = whole.groups;
  if (!whole.face_offsets.empty()) surface.face_offsets = {0};
  std::int64_t face = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const std::int64_t end = face + descendant_count(whole, mesh.face_size(f));
    for (; face < end; ++face) {
      if (is_hole[f]) continue;
      const auto vertices = whole.face(face);
      const auto first = vertices.data() - whole.face_vertices.data();
      surface.face_vertices.insert(surface.face_vertices.end(), vertices.begin(), vertices.end());
      if (!whole.face_offsets.empty()) {
        surface.face_offsets.push_back(static_cast<std::int32_t>(surface.face_vertices.size()));
      }
      if (!whole.face_uvs.empty()) {
        const auto uvs = whole.face_uvs.begin() + first;
        surface.face_uvs.insert(surface.face_uvs.end(), uvs,
                                uvs + static_cast<std::ptrdiff_t>(vertices.size()));
      }
      if (!whole.face_groups.empty()) surface.face_groups.push_back(whole.face_groups[face]);
    }
  }
  keep_named_rows(whole, surface);
}

namespace {

// Faces by their sizes; each child gives the corner that it keeps.
template <class SizeOf>
LevelFaces parents_of(const LevelFaces& finer, std::size_t face_count, bool triangles,
                      const SizeOf& size_of) {
  LevelFaces coarser;
  coarser.offsets.reserve(face_count + 1);
  std::size_t child = 0;
  for (std::size_t f = 0; f < face_count; ++f) {
    const std::size_t size = size_of(f);
    for (std::size_t k = 0; k < size; ++k) {
      const auto corners = finer.face(child + k);
      coarser.vertices.push_back(
          corners[child_corners(size, corners.size(), static_cast<int>(k)).corner]);
    }
    coarser.offsets.push_back(static_cast<std::int32_t>(coarser.vertices.size()));
    child += triangles ? 4 : size;
  }
  PLANISH_ASSERT(child == finer.face_count());
  return coarser;
}

}  // namespace

ChildCorners child_corners(std::size_t face_size, std::size_t child_size, int k) {
  const int m = static_cast<int>(child_size);
  const int corner = face_size == child_size ? k : 0;
  return {corner, (corner + 1) % m, m == 4 ? (corner + 2) % m : -1};
}

std::vector<LevelFaces> level_faces(const SurfaceMesh& surface, const PolygonMesh& mesh) {
  std::vector<LevelFaces> levels(static_cast<std::size_t>(surface.level) + 1);
  LevelFaces& last = levels.back();
  last.vertices.assign(surface.face_vertices.begin(), surface.face_vertices.end());
  last.offsets = surface.face_offsets;
  if (last.offsets.empty()) {
    for (std::int64_t f = 0; f <= surface.face_count(); ++f)
      last.offsets.push_back(static_cast<std::int32_t>(4 * f));
  }
  if (surface.level == 0) return levels;

  const bool triangles = surface.is_triangles();
  for (std::size_t l = levels.size() - 1; l > 1; --l) {
    const std::size_t size = triangles ? 3 : 4;
    levels[l - 1] = parents_of(levels[l], levels[l].face_count() / 4, triangles,
                               [&](std::size_t) { return size; });
  }
  std::vector<std::size_t> sizes;
  const std::vector<std::uint8_t> is_hole = hole_flags(mesh);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (!is_hole[f]) sizes.push_back(static_cast<std::size_t>(mesh.face_size(f)));
  }
  levels[0] =
      parents_of(levels[1], sizes.size(), triangles, [&](std::size_t f) { return sizes[f]; });
  return levels;
}

std::vector<std::int32_t> ancestor_faces(const SurfaceMesh& surface, const PolygonMesh& mesh) {
  const std::vector<std::uint8_t> is_hole = hole_flags(mesh);
  std::vector<std::int32_t> result;
  result.reserve(static_cast<std::size_t>(surface.face_count()));
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (is_hole[f]) continue;
    // Descendants of a face follow one another.
    const auto count = descendant_count(surface, mesh.face_size(f));
    result.insert(result.end(), static_cast<std::size_t>(count), f);
  }
  PLANISH_ASSERT(static_cast<std::int64_t>(result.size()) == surface.face_count());
  return result;
}

}  // namespace planish
