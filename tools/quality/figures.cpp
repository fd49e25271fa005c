#include "quality/figures.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>
#include <span>
#include <vector>

#include "planish/backend/cpu_backend.h"
#include "planish/core/parallel.h"
#include "planish/mesh/area_vector.h"
#include "planish/mesh/convex_faces.h"
#include "planish/reconstruct/compare_source.h"
#include "planish/surface/attributes.h"
#include "planish/surface/surface_blocks.h"
#include "planish/surface/surface_quality.h"
#include "quality/true_pieces.h"

namespace planish::quality {

namespace {

SurfaceMesh surface_of(const PolygonMesh& mesh, const Method& method) {
  // Each corner of the mesh becomes 4^(level - 1) quads.
  constexpr std::size_t kLargeMesh = 60'000;
  EvaluateOptions options;
  options.level = mesh.face_vertices.size() > kLargeMesh ? 2 : 3;
  options.weights = method.options.weights;
  options.rest_positions = mesh.positions;
  const auto backend = make_cpu_backend({Precision::Double});
  if (!method.interpolates) return evaluate(mesh, *backend, options);
  return evaluate(mesh, fit(mesh, *backend, method.options), *backend, options);
}

// What the command fits: for fair surfaces concave faces are cut.
ConvexMesh fitted_mesh(const PolygonMesh& mesh, const Method& method) {
  if (method.options.method == InterpolationMethod::Fair) return with_convex_faces(mesh);
  ConvexMesh same{mesh, {}, {}, {}};
  same.source_faces.resize(static_cast<std::size_t>(mesh.face_count()));
  std::iota(same.source_faces.begin(), same.source_faces.end(), 0);
  return same;
}

// Of each face of a surface the given face that it descends from; `source_faces` of the fitted
// mesh's, empty: they are the given ones.
std::vector<std::int32_t> given_faces_of(const SurfaceMesh& surface, const PolygonMesh& fitted,
                                         std::span<const std::int32_t> source_faces) {
  std::vector<std::int32_t> given;
  for (std::int32_t f = 0; f < fitted.face_count(); ++f) {
    const std::int64_t count = descendant_count(surface, fitted.face_size(f));
    given.insert(given.end(), static_cast<std::size_t>(count),
                 source_faces.empty() ? f : source_faces[f]);
  }
  return given;
}

// Against the faces of the mesh that was given, of which those of the fitted one are parts.
SurfaceQuality own_quality(const SurfaceMesh& surface, const ConvexMesh& fitted,
                           const PolygonMesh& given) {
  const std::vector<std::int32_t> ancestors =
      given_faces_of(surface, fitted.mesh, fitted.source_faces);
  return surface_quality(surface, [&](std::int64_t face, std::int32_t) {
    return area_vector(given.positions, given.face(ancestors[face]));
  });
}

// Feet of all vertices.
std::vector<Foot> feet_of(const SurfaceMesh& surface, const Truth& truth) {
  std::vector<Foot> feet(surface.positions.size());
  parallel_each(feet.size(), 1024, [&](std::size_t v) { feet[v] = truth(surface.positions[v]); });
  return feet;
}

// Largest and root of the mean square.
void note_distances(Figures& figures, std::span<const glm::dvec3> a,
                    const std::vector<Foot>& feet) {
  double sum = 0;
  for (std::size_t v = 0; v < a.size(); ++v) {
    const double distance = glm::distance(a[v], feet[v].point);
    figures.max_distance = std::max(figures.max_distance, distance);
    sum += distance * distance;
  }
  figures.rms_distance = std::sqrt(sum / static_cast<double>(a.size()));
}

void note_quality(Figures& figures, const SurfaceQuality& quality, double true_bending) {
  figures.folded_area = quality.folded_area;
  figures.rms_normal = quality.rms_normal_deviation;
  figures.max_normal = quality.max_normal_deviation;
  figures.bending = quality.bending / true_bending;
}

void compare_with_truth(Figures& figures, const SurfaceMesh& surface, const Truth& truth) {
  const std::vector<Foot> feet = feet_of(surface, truth);
  const ReferenceNormal reference = [&](std::int64_t face, std::int32_t corner) {
    return feet[surface.face(face)[corner]].normal;
  };
  SurfaceMesh ideal = surface;
  for (std::size_t v = 0; v < feet.size(); ++v) {
    ideal.positions[v] = feet[v].point;
    ideal.normals[v] = glm::vec3(feet[v].normal);
  }
  note_quality(figures, surface_quality(surface, reference),
               surface_quality(ideal, reference).bending);
  note_distances(figures, surface.positions, feet);
}

// Each face of a surface against the piece of the shape that its given face was taken from.
void compare_with_pieces(Figures& figures, const SurfaceMesh& surface, const FittedMesh& fitted,
                         const TruePieces& pieces) {
  // How far from its corner towards the face's middle a normal is looked up.
  constexpr double kInward = 0.01;
  const std::vector<std::int32_t> given_faces =
      given_faces_of(surface, fitted.mesh, fitted.source_faces);
  std::vector<std::int64_t> first_corners(given_faces.size() + 1, 0);
  for (std::size_t f = 0; f < given_faces.size(); ++f)
    first_corners[f + 1] = first_corners[f] + std::ssize(surface.face(f));
  std::vector<glm::dvec3> normals(static_cast<std::size_t>(first_corners.back()));
  std::vector<double> squares(normals.size());
  parallel_each(given_faces.size(), 64, [&](std::size_t f) {
    const auto corners = surface.face(static_cast<std::int64_t>(f));
    glm::dvec3 middle(0);
    for (const std::int32_t row : corners)
      middle += surface.positions[row] / static_cast<double>(corners.size());
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const glm::dvec3& place = surface.positions[corners[i]];
      const std::size_t at = static_cast<std::size_t>(first_corners[f]) + i;
      normals[at] = pieces.normal(given_faces[f], place + kInward * (middle - place));
      squares[at] = pieces.squared_distance(given_faces[f], place);
    }
  });
  note_quality(figures,
               surface_quality(surface,
                               [&](std::int64_t face, std::int32_t corner) {
                                 return normals[first_corners[face] + corner];
                               }),
               8 * std::numbers::pi);
  figures.max_distance = std::sqrt(std::ranges::max(squares));
  figures.rms_distance =
      std::sqrt(std::reduce(squares.begin(), squares.end()) / static_cast<double>(squares.size()));
}

}  // namespace

const std::vector<Method>& methods() {
  static const std::vector<Method> kMethods = [] {
    FitOptions exact;
    exact.tolerance = 1e-12;
    FitOptions averaged = exact, fair = exact;
    averaged.weights = Weights::Averaged;
    fair.method = InterpolationMethod::Fair;
    FitOptions unpolished = fair;
    unpolished.polish_steps = 0;
    return std::vector<Method>{{"none", false, {}},
                               {"averaged", true, averaged},
                               {"doo-sabin", true, exact},
                               {"fair", true, unpolished},
                               {"fair, polished", true, fair}};
  }();
  return kMethods;
}

Figures measure(const Case& what, const Method& method) {
  const ConvexMesh fitted = fitted_mesh(what.mesh, method);
  const SurfaceMesh surface = surface_of(fitted.mesh, method);
  Figures figures;
  if (what.truth) {
    compare_with_truth(figures, surface, what.truth);
  } else {
    const PolygonMesh& source = what.source.face_count() > 0 ? what.source : what.mesh;
    const SourceComparison comparison =
        compare_with_source(*blocks_of(surface, fitted.mesh), source);
    note_quality(
        figures,
        what.has_smooth_source ? comparison.quality : own_quality(surface, fitted, what.mesh),
        8 * std::numbers::pi);
    figures.max_distance = comparison.distances.max;
    figures.rms_distance = comparison.distances.rms;
  }
  for (std::size_t i = 0; i < surface.base_vertices.size(); ++i) {
    const glm::dvec3& given = what.mesh.positions[surface.base_vertices[i]];
    figures.interpolation_error =
        std::max(figures.interpolation_error, glm::distance(surface.positions[i], given));
  }
  const double diagonal = placement_of(what.mesh).diagonal;
  figures.max_distance /= diagonal;
  figures.rms_distance /= diagonal;
  figures.interpolation_error /= diagonal;
  return figures;
}

Figures measure(const Case& what, const FittedMesh& fitted, Backend& backend) {
  SurfaceMesh surface = evaluate(fitted.mesh, fitted.fit, backend, fitted.evaluate_options(2));
  Figures figures;
  if (what.truth) {
    compare_with_truth(figures, surface, what.truth);
  } else {
    compare_with_pieces(figures, surface, fitted, TruePieces(what.source, what.mesh));
  }
  const double diagonal = fitted.fit.placement.diagonal;
  figures.max_distance /= diagonal;
  figures.rms_distance /= diagonal;
  return figures;
}

}  // namespace planish::quality
