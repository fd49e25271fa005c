#include "quality/true_pieces.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <limits>
#include <utility>

#include "planish/core/parallel.h"
#include "planish/mesh/angle_between.h"
#include "planish/mesh/area_vector.h"
#include "planish/mesh/disjoint_sets.h"
#include "planish/mesh/edge_groups.h"

namespace planish::quality {

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

}  // namespace planish::quality
