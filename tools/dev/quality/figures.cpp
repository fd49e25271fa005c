#include "quality/figures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <limits>
#include <memory>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/mend/repair.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/statistics.h"
#include "planish/reconstruct/compare_source.h"
#include "planish/reconstruct/spatial_search.h"
#include "planish/solve/backend.h"
#include "planish/surface/level_faces.h"
#include "planish/surface/quality_sum.h"
#include "planish/surface/surface_blocks.h"

namespace planish::quality {

Truth true_sphere(double radius) {
  return [radius](const glm::dvec3& p) {
    const glm::dvec3 normal = glm::normalize(p);
    return Foot{radius * normal, normal};
  };
}

Truth true_torus(double radius, double tube_radius) {
  return [=](const glm::dvec3& p) {
    const glm::dvec3 middle = radius * glm::normalize(glm::dvec3(p.x, p.y, 0.0));
    const glm::dvec3 normal = glm::normalize(p - middle);
    return Foot{middle + tube_radius * normal, normal};
  };
}

Truth true_zero_set(shapes::Field field) {
  return [field = std::move(field)](const glm::dvec3& p) {
    constexpr double kLongestStep = 0.02;  // surfaces are that near to their shapes
    const glm::dvec3 foot = shapes::projected(field, p, kLongestStep);
    return Foot{foot, glm::normalize(shapes::gradient(field, foot))};
  };
}

namespace {

// A dense mesh in triangles, with normals at its vertices.
struct DenseMesh {
  std::vector<glm::dvec3> positions, normals;
  std::vector<Triangle> triangles;
  TriangleTree tree;

  explicit DenseMesh(const PolygonMesh& mesh)
      : positions(mesh.positions),
        normals(positions.size(), glm::dvec3(0)),
        triangles(triangles_of(mesh)),
        tree(positions, triangles) {
    for (const Triangle& t : triangles) {
      for (int i = 0; i < 3; ++i) {
        const glm::dvec3 a = positions[t[(i + 1) % 3]] - positions[t[i]];
        const glm::dvec3 b = positions[t[(i + 2) % 3]] - positions[t[i]];
        const glm::dvec3 cross = glm::cross(a, b);
        const double length = glm::length(cross);
        if (length > 0) normals[t[i]] += angle_between(a, b) / length * cross;
      }
    }
    for (glm::dvec3& normal : normals) normal /= std::max(glm::length(normal), 1e-300);
  }

  [[nodiscard]] Foot foot(const glm::dvec3& p) const {
    const Triangle& t = triangles[tree.nearest(p).triangle];
    const TriangleShape shape(positions[t[0]], positions[t[1]], positions[t[2]]);
    const glm::dvec3 shares = shape.shares(p);
    glm::dvec3 point(0), normal(0);
    for (int i = 0; i < 3; ++i) {
      point += shares[i] * positions[t[i]];
      normal += shares[i] * normals[t[i]];
    }
    return {point, glm::normalize(normal)};
  }

  static std::vector<Triangle> triangles_of(const PolygonMesh& mesh) {
    std::vector<Triangle> triangles;
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      const auto face = mesh.face(f);
      for (std::size_t i = 2; i < face.size(); ++i)
        triangles.push_back({face[0], face[i - 1], face[i]});
    }
    return triangles;
  }
};

}  // namespace

Truth true_mesh(const PolygonMesh& mesh) {
  return [dense = std::make_shared<const DenseMesh>(mesh)](const glm::dvec3& p) {
    return dense->foot(p);
  };
}

namespace {

// Degrees between faces of a shape. Smooth parts are made of segments that turn by 8 at most, but
// for straight sides that are twisted, which are as wide as in the coarse mesh.
constexpr double kSharp = 30;
// Of a face's squared radius: what a piece that is turned round weighs, where one lies on another.
constexpr double kTurned = 1e-3;

// The faces of each piece, all sides of one at which it goes on smoothly.
std::vector<std::vector<std::int32_t>> smooth_pieces(const PolygonMesh& shape) {
  std::vector<glm::dvec3> normals;
  for (std::int32_t f = 0; f < shape.face_count(); ++f)
    normals.push_back(area_vector(shape.positions, shape.face(f)));
  DisjointSets sets(normals.size());
  group_edges(shape).for_each([&](std::int32_t, std::span<const FaceSide> sides) {
    if (sides.size() != 2) return;
    const double turn = angle_between(normals[sides[0].face], normals[sides[1].face]);
    if (turn < glm::radians(kSharp)) sets.unite(sides[0].face, sides[1].face);
  });
  std::vector<std::vector<std::int32_t>> faces(normals.size());
  for (std::int32_t f = 0; f < shape.face_count(); ++f) faces[sets.find(f)].push_back(f);
  std::erase_if(faces, [](const auto& piece) { return piece.empty(); });
  return faces;
}

double squared(const glm::dvec3& vector) { return glm::dot(vector, vector); }

}  // namespace

TruePieces::TruePieces(const PolygonMesh& shape, const PolygonMesh& coarse)
    : positions_(shape.positions) {
  for (const auto& faces : smooth_pieces(shape)) {
    std::vector<Triangle> triangles;
    glm::dvec3 low(std::numeric_limits<double>::max()), high(-low);
    for (const std::int32_t f : faces) {
      const auto v = shape.face(f);
      for (std::size_t i = 2; i < v.size(); ++i) triangles.push_back({v[0], v[i - 1], v[i]});
      for (const std::int32_t vertex : v) {
        low = glm::min(low, positions_[vertex]);
        high = glm::max(high, positions_[vertex]);
      }
    }
    TriangleTree tree(positions_, triangles);
    pieces_.push_back({std::move(triangles), std::move(tree), low, high});
  }
  of_face_.resize(static_cast<std::size_t>(coarse.face_count()));
  parallel_each(of_face_.size(), 16, [&](std::size_t f) {
    std::vector<glm::dvec3> places;
    glm::dvec3 middle(0);
    const auto corners = coarse.face(static_cast<std::int32_t>(f));
    for (const std::int32_t v : corners) {
      places.push_back(coarse.positions[v]);
      middle += coarse.positions[v];
    }
    places.push_back(middle / static_cast<double>(places.size()));
    of_face_[f] = piece_of(places, area_vector(coarse.positions, corners));
  });
}

// The one that is nearest to a face's corners and, the last, its middle together.
std::int32_t TruePieces::piece_of(std::span<const glm::dvec3> places,
                                  const glm::dvec3& area) const {
  const glm::dvec3& middle = places.back();
  const double radius = glm::distance(places.front(), middle);
  std::int32_t best = -1;
  double least = std::numeric_limits<double>::max();
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    const Piece& piece = pieces_[p];
    double bound = 0, sum = 0;
    for (const glm::dvec3& place : places)
      bound += squared(place - glm::clamp(place, piece.low, piece.high));
    if (bound >= least) continue;
    for (const glm::dvec3& place : places) sum += piece.tree.nearest(place).squared_distance;
    const double cosine = std::cos(angle_between(normal_at(piece, middle), area));
    sum += kTurned * radius * radius * (1 - cosine);
    if (sum >= least) continue;
    least = sum;
    best = static_cast<std::int32_t>(p);
  }
  return best;
}

glm::dvec3 TruePieces::normal_at(const Piece& piece, const glm::dvec3& place) const {
  const Triangle& t = piece.triangles[piece.tree.nearest(place).triangle];
  const glm::dvec3& origin = positions_[t[0]];
  return glm::cross(positions_[t[1]] - origin, positions_[t[2]] - origin);
}

glm::dvec3 TruePieces::normal(std::int32_t coarse_face, const glm::dvec3& place) const {
  return normal_at(pieces_[of_face_[coarse_face]], place);
}

double TruePieces::squared_distance(std::int32_t coarse_face, const glm::dvec3& place) const {
  return pieces_[of_face_[coarse_face]].tree.nearest(place).squared_distance;
}

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

namespace {

constexpr double kFoldedArea = 1e-5;
constexpr double kScanShare = 0.5;
constexpr double kInterpolation = 1e-6;
// Equal to the two digits that the table shows.
constexpr double kEqual = 1.02;

}  // namespace

std::string shortfall(const Case& what, const char* figure, double value, double limit) {
  char text[200];
  std::snprintf(text, sizeof text, "%s: %s %.3g, aim %.3g", what.name.c_str(), figure, value,
                limit);
  return text;
}

std::vector<std::string> shortfalls(const Case& what, const std::vector<Figures>& figures) {
  PLANISH_ASSERT(figures.size() == methods().size());
  const Figures& progressive = figures[2];
  const Figures& fair = figures.back();
  std::vector<std::string> lines;
  const auto require = [&](const char* figure, double value, double limit) {
    if (!(value <= limit)) lines.push_back(shortfall(what, figure, value, limit));
  };
  if (statistics(what.mesh).boundary_loop_count == 0) {
    require("folded area", fair.folded_area, kFoldedArea);
  }
  require("rms normal deviation", fair.rms_normal,
          progressive.rms_normal * (what.is_scan ? kScanShare : kEqual));
  require("interpolation error", fair.interpolation_error, kInterpolation);
  return lines;
}

}  // namespace planish::quality
