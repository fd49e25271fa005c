// An own derivation. The bending of a line (x-, x, x+) with unequal parts r- and r+ is its second
// divided difference 2 / (r+ + r-) ((x+ - x) / r+ - (x - x-) / r-) along the net's normal n at x.
// Its square is weighted by the area A around x.
#include "planish/fair/bending_rows.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <type_traits>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/fair/piecewise_sum.h"

namespace planish {

using glm::dvec3;
using glm::vec3;

namespace {

constexpr std::size_t kGrain = 4096;
// A part of a line below this of the whole measures noise. Much lower than it might be: lines left
// out at 0.02 cost a scan's thin triangles twice the bending.
constexpr float kShortestPart = 0.001f;
// Coincident points may lead out of single precision; lines with such coefficients are none.
constexpr float kLargestCoefficient = 1e15f;
// Of the largest mean diagonal of the Hessian: polygons with next to no rows hardly move.
constexpr float kLeastDiagonal = 1e-14f;

// An edge of the net with its length.
struct NetEdge {
  vec3 vector;
  float length;
};

NetEdge net_edge(const dvec3& vector) {
  const vec3 rounded(vector);
  return {rounded, glm::length(rounded)};
}

// One line: the coefficients of its ends and its value.
struct Line {
  float far = 0, near = 0, value = 0;
};

// `turn`: along the normal, `scale` times it the normal times the square root of the area. The
// scale comes late out of two roots: whatever can do without it runs beside them.
Line make_line(const NetEdge& far_edge, float far_sign, const NetEdge& near_edge, const vec3& turn,
               float scale) {
  const float whole = far_edge.length + near_edge.length;
  const float shorter = std::min(far_edge.length, near_edge.length);
  if (!(shorter > kShortestPart * whole)) return {};
  // A ramp to full weight, so that no line appears at once in a deforming mesh.
  const float weight = std::min(shorter / (kShortestPart * whole) - 1, 1.0f);
  const float unit = 2 * weight / (whole * far_edge.length * near_edge.length);
  const float far = unit * near_edge.length, near = unit * far_edge.length;
  const float value =
      far_sign * far * glm::dot(turn, far_edge.vector) + near * glm::dot(turn, near_edge.vector);
  return {scale * far, scale * near, scale * value};
}

// A corner of the face whose rows are being made.
struct FaceCorner {
  dvec3 position;
  vec3 direction;         // in which a height moves the control point; 0 where it must stay
  NetEdge edge;           // to the next corner
  NetEdge after, before;  // around the vertex
  BendingLines lines;
};

struct RowBuilder {
  const FairTopology& topology;
  std::span<const dvec3> given, directions, offsets;
  BendingRows& bending;
  std::span<float> diagonals;  // per corner, of the Hessian
  std::vector<FaceCorner> corners{};

  // `m`: the face's size, a constant of the type for the sizes that matter.
  template <class Size>
  double build_face(std::int32_t first, Size m);
  void build_row(std::int32_t corner, const FaceCorner& previous, FaceCorner& own,
                 const FaceCorner& next);
};

template <class Size>
double RowBuilder::build_face(std::int32_t first, Size m) {
  if (corners.size() < static_cast<std::size_t>(m)) corners.resize(static_cast<std::size_t>(m));
  FaceCorner* const c = corners.data();
  for (std::int32_t i = 0; i < m; ++i) {
    const std::int32_t vertex = topology.corner_vertices[first + i];
    c[i].position = given[vertex] + offsets[first + i];
    c[i].direction = vec3(directions[vertex]);
  }
  for (std::int32_t i = 0; i < m; ++i) {
    c[i].edge = net_edge(c[i + 1 == m ? 0 : i + 1].position - c[i].position);
    // Control points around the same vertex differ by their offsets alone.
    const dvec3& own = offsets[first + i];
    c[i].after = net_edge(offsets[topology.corner_ccw[first + i]] - own);
    c[i].before = net_edge(offsets[topology.corner_cw[first + i]] - own);
  }
  for (std::int32_t i = 0; i < m; ++i) {
    build_row(first + i, c[i == 0 ? m - 1 : i - 1], c[i], c[i + 1 == m ? 0 : i + 1]);
  }
  const auto square = [](float x) { return x * x; };
  double value_square = 0;
  for (std::int32_t i = 0; i < m; ++i) {
    const std::int32_t previous = i == 0 ? m - 1 : i - 1, next = i + 1 == m ? 0 : i + 1;
    const BendingRows::Row& own = bending.rows[first + i];
    const BendingRows::Row& row_before = bending.rows[first + previous];
    const BendingRows::Row& row_after = bending.rows[first + next];
    bending.products[first + i] = transposed_product(own, c[i].lines, row_before, c[previous].lines,
                                                     row_after, c[next].lines);
    // The rows beside it around the vertex are counted where they stand: over the polygon it comes
    // to the same mean.
    diagonals[first + i] = square(own.own1) + square(own.own2) + square(own.after) +
                           square(own.before) + square(row_before.next) +
                           square(row_after.previous);
    value_square += square(c[i].lines.line1) + square(c[i].lines.line2);
  }
  return value_square;
}

void RowBuilder::build_row(std::int32_t corner, const FaceCorner& previous, FaceCorner& own,
                           const FaceCorner& next) {
  // Along the normal of the quad of the four neighbours, twice its area long.
  const vec3 turn =
      glm::cross(own.edge.vector - own.after.vector, -previous.edge.vector - own.before.vector);
  const float length = glm::length(turn);
  // The square root of half the quad's area by the length; coincident points have no normal.
  const float scale = length > 0 ? 0.5f / std::sqrt(length) : 0.0f;
  Line line1 = make_line(own.edge, 1.0f, own.after, turn, scale);
  Line line2 = make_line(previous.edge, -1.0f, own.before, turn, scale);
  for (Line* line : {&line1, &line2}) {
    if (!(std::max(line->far, line->near) * length < kLargestCoefficient)) *line = {};
  }
  const float move = glm::dot(turn, own.direction);
  bending.rows[corner] = {line1.far * glm::dot(turn, next.direction),
                          -(line1.far + line1.near) * move,
                          line1.near * move,
                          line2.far * glm::dot(turn, previous.direction),
                          -(line2.far + line2.near) * move,
                          line2.near * move};
  own.lines = {line1.value, line2.value};
}

RawVector<float> make_preconditioner(const FairTopology& topology,
                                     std::span<const float> diagonals) {
  RawVector<float> result(static_cast<std::size_t>(topology.vertex_count));
  parallel_for(result.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const auto vertex = static_cast<std::int32_t>(v);
      float sum = 0;
      for (std::int32_t i = topology.ring_offsets[v]; i < topology.ring_offsets[v + 1]; ++i) {
        sum += diagonals[topology.ring_corners[i]];
      }
      result[v] = sum / static_cast<float>(topology.valence(vertex));
    }
  });
  const float largest = *std::max_element(result.begin(), result.end());
  for (float& diagonal : result) {
    diagonal = diagonal > 0 ? 1 / std::max(diagonal, kLeastDiagonal * largest) : 0;
  }
  return result;
}

}  // namespace

BendingRows make_bending_rows(const FairTopology& topology, std::span<const dvec3> given,
                              std::span<const dvec3> directions, std::span<const dvec3> offsets) {
  BendingRows bending;
  bending.rows.resize(topology.ring_corners.size());
  bending.products.resize(bending.rows.size());
  RawVector<float> diagonals(bending.rows.size());
  bending.value_square = piecewise_sum(topology.face_count, [&] {
    return [&, builder = RowBuilder{topology, given, directions, offsets, bending, diagonals}](
               std::int32_t face) mutable {
      return for_face_size(
          topology, face, [&](std::int32_t first, auto m) { return builder.build_face(first, m); });
    };
  });
  bending.preconditioner = make_preconditioner(topology, diagonals);
  return bending;
}

}  // namespace planish
