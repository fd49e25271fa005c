// Based on: Doo & Sabin 1978; "Smooth Surface Reconstruction using Doo-Sabin Subdivision Surfaces",
// equation (1). Curve points: the uniform quadratic B-spline of a sharp polyline.
#include "planish/patches/first_step.h"

#include <cmath>
#include <glm/vec2.hpp>
#include <numbers>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/core/work.h"

namespace planish {

namespace {

// Four corners, which most meshes have most of: the weights do not depend on the rule.
void refine_quad(std::span<const std::int32_t> vertices, std::span<const double> c,
                 std::span<const glm::dvec3> points, glm::dvec3* result) {
  const glm::dvec3 p[4] = {points[vertices[0]], points[vertices[1]], points[vertices[2]],
                           points[vertices[3]]};
  for (int i = 0; i < 4; ++i) {
    result[i] = c[0] * p[i] + c[1] * p[(i + 1) & 3] + c[2] * p[(i + 2) & 3] + c[3] * p[(i + 3) & 3];
  }
}

void refine_face(std::span<const std::int32_t> vertices, std::span<const double> c,
                 std::span<const glm::dvec3> points, glm::dvec3* result) {
  const std::size_t m = vertices.size();
  for (std::size_t i = 0; i < m; ++i) {
    glm::dvec3 sum(0.0);
    for (std::size_t j = 0; j < m; ++j) {
      sum += c[j] * points[vertices[i + j < m ? i + j : i + j - m]];
    }
    result[i] = sum;
  }
}

// About one of the corners: far from the origin sums would lose digits.
void refine_large_face(std::span<const std::int32_t> vertices, const FaceSumRule& rule,
                       std::span<const glm::dvec3> points, glm::dvec3* result) {
  const std::size_t m = vertices.size();
  const glm::dvec3 origin = points[vertices[0]];
  const double step = 2 * std::numbers::pi / static_cast<double>(m);
  const auto turn = [&](std::size_t i) {
    const double angle = step * static_cast<double>(i);
    return glm::dvec2(std::cos(angle), std::sin(angle));
  };
  glm::dvec3 mean(0.0), even(0.0), odd(0.0);
  for (std::size_t i = 0; i < m; ++i) {
    const glm::dvec3 p = points[vertices[i]] - origin;
    const glm::dvec2 at = turn(i);
    mean += p;
    even += at.x * p;
    odd += at.y * p;
  }
  const double share = 1 / static_cast<double>(m);
  mean *= rule.mean * share;
  even *= 2 * rule.turn * share;
  odd *= 2 * rule.turn * share;
  for (std::size_t i = 0; i < m; ++i) {
    const glm::dvec3 p = points[vertices[i]] - origin;
    const glm::dvec3 beside = (points[vertices[i == 0 ? m - 1 : i - 1]] - origin) +
                              (points[vertices[i + 1 == m ? 0 : i + 1]] - origin);
    const glm::dvec2 at = turn(i);
    result[i] = origin + (rule.own * p + rule.beside * beside + mean + (at.x * even + at.y * odd));
  }
}

// The two halves of a sharp edge.
void refine_curve(const PatchMesh& mesh, std::int32_t edge, std::span<const glm::dvec3> points,
                  std::span<const glm::dvec3> corners, glm::dvec3* result) {
  const MeshTopology& topology = mesh.topology();
  const std::int32_t corner = topology.corner_of(edge);
  const auto [v0, v1] = topology.edge_vertices(edge);
  for (int end = 0; end < 2; ++end) {
    const std::int32_t own = end == 0 ? v0 : v1, other = end == 0 ? v1 : v0;
    if (mesh.features().vertex_kinds[own] != VertexKind::Dart) {
      result[end] = 0.75 * points[own] + 0.25 * points[other];
      continue;
    }
    // Between the two faces beside the edge.
    const std::int32_t twin = topology.twin(corner);
    const std::int32_t left = end == 0 ? corner : topology.next(corner);
    const std::int32_t right = end == 0 ? topology.next(twin) : twin;
    result[end] = 0.5 * (corners[left] + corners[right]);
  }
}

// Refines one face after another.
struct FaceStep {
  const MeshTopology& topology;
  const FaceWeights& weights;
  std::span<const glm::dvec3> points;
  std::vector<double> scratch{};
  std::int64_t pairs = 0;

  void operator()(std::int32_t face, std::span<glm::dvec3> state) {
    const auto vertices = topology.face(face);
    const auto size = static_cast<std::int32_t>(vertices.size());
    glm::dvec3* result = state.data() + topology.first_corner(face);
    if (size >= kSummedRing) {
      refine_large_face(vertices, face_sum_rule(weights.weights()), points, result);
      return;
    }
    pairs += std::int64_t{size} * size;
    const auto c = weights.of(size, scratch);
    if (size == 4) {
      refine_quad(vertices, c, points, result);
    } else {
      refine_face(vertices, c, points, result);
    }
  }
};

}  // namespace

RawVector<glm::dvec3> first_step(const PatchMesh& mesh, Weights weights,
                                 std::span<const glm::dvec3> points) {
  const MeshTopology& topology = mesh.topology();
  const FaceWeights face_weights(weights);
  RawVector<glm::dvec3> state(static_cast<std::size_t>(mesh.point_count()));
  parallel_for(static_cast<std::size_t>(topology.face_count()), 4096,
               [&](std::size_t begin, std::size_t end) {
                 FaceStep step{topology, face_weights, points};
                 for (std::size_t f = begin; f < end; ++f)
                   step(static_cast<std::int32_t>(f), state);
                 count_work(Work::Pairs, step.pairs);
               });
  const SharpFeatures& features = mesh.features();
  if (features.sharp_edge_count > 0) {
    for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
      const std::int32_t sharp = features.sharp_of_edge[e];
      if (sharp < 0) continue;
      refine_curve(mesh, e, points, state, state.data() + mesh.first_sharp() + 2 * sharp);
    }
  }
  for (std::int32_t i = 0; i < features.corner_count; ++i) {
    state[mesh.first_corner_vertex() + i] = points[features.corner_vertices[i]];
  }
  mesh.update_sums(state);
  return state;
}

void update_first_step(const PatchMesh& mesh, const FaceWeights& weights,
                       std::span<const glm::dvec3> points, std::span<const std::int32_t> faces,
                       std::span<glm::dvec3> state) {
  const MeshTopology& topology = mesh.topology();
  const SharpFeatures& features = mesh.features();
  FaceStep step{topology, weights, points};
  for (const std::int32_t face : faces) step(face, state);
  if (features.sharp_edge_count == 0 && features.corner_count == 0) return;
  for (const std::int32_t face : faces) {
    for (std::int32_t c = topology.first_corner(face); c < topology.first_corner(face + 1); ++c) {
      const std::int32_t vertex = topology.vertex_of(c);
      if (features.corner_count > 0 && features.corner_of_vertex[vertex] >= 0)
        state[mesh.first_corner_vertex() + features.corner_of_vertex[vertex]] = points[vertex];
      if (!mesh.is_sharp(c)) continue;
      const std::int32_t edge = topology.edge_of(c);
      refine_curve(mesh, edge, points, state,
                   state.data() + mesh.first_sharp() + 2 * features.sharp_of_edge[edge]);
    }
  }
}

}  // namespace planish
