#include "planish/surface/vertex_fields.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <numbers>
#include <tuple>

#include "planish/mesh/angle_between.h"
#include "planish/mesh/area_vector.h"
#include "planish/mesh/hole_flags.h"
#include "planish/surface/derivative_curvatures.h"
#include "planish/surface/level_faces.h"

namespace planish {
namespace {

// A face of the surface with the mesh's face that it should follow.
struct FacePair {
  std::int64_t face;
  std::int32_t ancestor;
  std::span<const std::int32_t> vertices;
  glm::dvec3 wanted;   // area vector of the ancestor
  double corner_area;  // share of the face's area for each corner
};

template <class Visit>
void for_faces(const SurfaceMesh& surface, const PolygonMesh& mesh, const Visit& visit) {
  const std::vector<std::int32_t> ancestors = ancestor_faces(surface, mesh);
  std::int32_t last = -1;
  glm::dvec3 wanted(0.0);
  for (std::int64_t f = 0; f < surface.face_count(); ++f) {
    const std::int32_t ancestor = ancestors[f];
    if (ancestor != last) wanted = area_vector(mesh.positions, mesh.face(ancestor));
    last = ancestor;
    const auto vertices = surface.face(f);
    const double area = glm::length(area_vector(surface.positions, vertices));
    visit(FacePair{f, ancestor, vertices, wanted, area / static_cast<double>(vertices.size())});
  }
}

void compare_normals(const SurfaceMesh& surface, const PolygonMesh& mesh, VertexFields& fields) {
  const std::size_t count = surface.positions.size();
  fields.normal_deviation.assign(count, 0.0f);
  fields.folded.assign(count, 0.0f);
  std::vector<double> whole(count, 0.0), folded(count, 0.0);
  for_faces(surface, mesh, [&](const FacePair& pair) {
    for (const std::int32_t v : pair.vertices) {
      const glm::dvec3 normal(surface.normals[v]);
      const double angle = angle_between(normal, pair.wanted) * 180 / std::numbers::pi;
      fields.normal_deviation[v] = std::max(fields.normal_deviation[v], static_cast<float>(angle));
      whole[v] += pair.corner_area;
      if (glm::dot(normal, pair.wanted) < 0) folded[v] += pair.corner_area;
    }
  });
  for (std::size_t v = 0; v < count; ++v) {
    if (folded[v] > 0) fields.folded[v] = static_cast<float>(folded[v] / whole[v]);
  }
}

// Errors of level 0, copies of vertices included.
void note_given_errors(const SurfaceMesh& surface, const PolygonMesh& mesh, const LevelFaces& faces,
                       double diagonal, std::vector<float>& error) {
  const auto note = [&](std::int32_t row, std::int32_t vertex) {
    const glm::dvec3 off = surface.positions[row] - mesh.positions[vertex];
    error[row] = static_cast<float>(glm::length(off) / diagonal);
  };
  for (std::size_t i = 0; i < surface.base_vertices.size(); ++i)
    note(static_cast<std::int32_t>(i), surface.base_vertices[i]);
  const std::vector<std::uint8_t> is_hole = hole_flags(mesh);
  std::size_t face = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (is_hole[f]) continue;
    const auto rows = faces.face(face++);
    for (std::size_t k = 0; k < rows.size(); ++k) note(rows[k], mesh.face(f)[k]);
  }
}

// Each new vertex of a level takes the mean of the edge or face that it halves.
void spread(const LevelFaces& coarse, const LevelFaces& fine, std::vector<float>& values) {
  std::size_t child = 0;
  for (std::size_t f = 0; f < coarse.face_count(); ++f) {
    const auto face = coarse.face(f);
    const std::size_t n = face.size();
    double sum = 0;
    for (const std::int32_t v : face) sum += values[v];
    for (std::size_t k = 0; k < n; ++k) {
      const auto corners = fine.face(child + k);
      const ChildCorners places = child_corners(n, corners.size(), static_cast<int>(k));
      const double edge = 0.5 * (double{values[face[k]]} + values[face[(k + 1) % n]]);
      values[corners[places.edge]] = static_cast<float>(edge);
      if (places.middle >= 0)
        values[corners[places.middle]] = static_cast<float>(sum / static_cast<double>(n));
    }
    child += fine.face(child).size() == 3 ? 4 : n;
  }
}

}  // namespace

const char* name_of(CurvatureSource source) {
  switch (source) {
    case CurvatureSource::Normals:
      return "normals";
    case CurvatureSource::Derivatives:
      return "second derivatives";
  }
  return "";
}

VertexFields vertex_fields(const SurfaceMesh& surface, const PolygonMesh& mesh, double diagonal,
                           const DooSabinSurface* exact) {
  VertexFields fields;
  fields.error.assign(surface.positions.size(), 0.0f);
  {
    const std::vector<LevelFaces> levels = level_faces(surface, mesh);
    note_given_errors(surface, mesh, levels[0], diagonal, fields.error);
    for (std::size_t l = 1; l < levels.size(); ++l) spread(levels[l - 1], levels[l], fields.error);
  }
  compare_normals(surface, mesh, fields);
  fields.curvatures = curvatures_of_normals(surface);
  if (exact != nullptr) {
    fields.curvatures = curvatures_of_derivatives(*exact, surface, std::move(fields.curvatures));
    fields.curvature_source = CurvatureSource::Derivatives;
  }
  return fields;
}

std::vector<NamedField> named_fields(const VertexFields& fields, const FieldChoice& choice) {
  std::vector<NamedField> named;
  if (choice.error) named.push_back({"error", fields.error});
  if (choice.deviation) named.push_back({"deviation", fields.normal_deviation});
  if (choice.fold) named.push_back({"fold", fields.folded});
  if (choice.curvature) {
    named.push_back({"mean_curvature", fields.curvatures.mean});
    named.push_back({"gaussian_curvature", fields.curvatures.gaussian});
  }
  return named;
}

std::vector<FoldedFace> folded_faces(const SurfaceMesh& surface, const PolygonMesh& mesh) {
  std::vector<FoldedFace> folds;
  for_faces(surface, mesh, [&](const FacePair& pair) {
    const auto count = std::ranges::count_if(pair.vertices, [&](std::int32_t v) {
      return glm::dot(glm::dvec3(surface.normals[v]), pair.wanted) < 0;
    });
    if (count == 0) return;
    folds.push_back({pair.face, pair.ancestor, pair.corner_area * static_cast<double>(count)});
  });
  std::ranges::sort(folds, [](const FoldedFace& a, const FoldedFace& b) {
    return std::tuple(-a.area, a.face) < std::tuple(-b.area, b.face);
  });
  return folds;
}

}  // namespace planish
