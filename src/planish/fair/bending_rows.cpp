// An own derivation. The bending of a line (x-, x, x+) with unequal parts r- and r+ is its second
// divided difference 2 / (r+ + r-) ((x+ - x) / r+ - (x - x-) / r-) along the net's normal n at x.
// Its square is weighted by the area A around x.
#include "planish/fair/bending_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "planish/core/parallel.h"

namespace planish {

using glm::dvec3;

namespace {

constexpr std::size_t kGrain = 1024;
// A part of a line below this of the whole measures noise: its divided difference would outweigh
// all others.
constexpr double kShortestPart = 0.02;
// Of the largest mean diagonal of the Hessian: control points without rows stay where they are.
constexpr double kLeastDiagonal = 1e-14;

struct RowBuilder {
  const FairTopology& topology;
  std::span<const dvec3> given, normals, offsets;

  [[nodiscard]] std::int32_t owner(std::int32_t state_index) const {
    return state_index < topology.corner_count
               ? topology.corner_vertices[state_index]
               : topology.curve_points[state_index - topology.corner_count].vertex;
  }

  // Control point `target` relative to that of `corner`.
  [[nodiscard]] dvec3 edge(std::int32_t corner, std::int32_t target) const {
    return (given[owner(target)] - given[topology.corner_vertices[corner]]) +
           (offsets[target] - offsets[corner]);
  }

  // The direction in which the height of a control point moves it; none where it must stay.
  [[nodiscard]] dvec3 direction(std::int32_t vertex) const {
    return topology.has_polygon(vertex) ? normals[vertex] : dvec3(0.0);
  }

  [[nodiscard]] BendingRows::Row row(std::int32_t corner, std::int32_t next, std::int32_t previous,
                                     std::span<const double> units) const;
};

// One line with `scale` (the square root of the area) times the normal.
struct Line {
  double far = 0, own = 0, near = 0, value = 0;
};
Line make_line(const dvec3& to_far, double far_length, const dvec3& to_near, double near_length,
               const dvec3& scaled_normal) {
  const double whole = far_length + near_length;
  if (!(std::min(far_length, near_length) > kShortestPart * whole)) return {};
  const double far = 2 / (whole * far_length);
  const double near = 2 / (whole * near_length);
  return {far, -(far + near), near, glm::dot(scaled_normal, far * to_far + near * to_near)};
}

// In units of height, rounded. A line whose numbers leave single precision is no line.
void store(const Line& line, double far_unit, double own_unit, float& far, float& own, float& near,
           float& value) {
  constexpr double kLargest = 1e15;
  const double largest = std::max(
      {std::abs(line.far * far_unit), std::abs(line.own * own_unit), std::abs(line.value)});
  if (!(largest < kLargest)) return;
  far = static_cast<float>(line.far * far_unit);
  own = static_cast<float>(line.own * own_unit);
  near = static_cast<float>(line.near * own_unit);
  value = static_cast<float>(line.value);
}

BendingRows::Row RowBuilder::row(std::int32_t corner, std::int32_t next, std::int32_t previous,
                                 std::span<const double> units) const {
  // Counter-clockwise around the control point.
  const std::array<dvec3, 4> edges{edge(corner, next), edge(corner, previous),
                                   edge(corner, topology.corner_ccw[corner]),
                                   edge(corner, topology.corner_cw[corner])};
  std::array<double, 4> lengths;
  for (int k = 0; k < 4; ++k) lengths[k] = glm::length(edges[k]);
  dvec3 normal(0.0);
  double area = 0;
  for (int k = 0; k < 4; ++k) {
    const dvec3 turn = glm::cross(edges[k], edges[(k + 1) % 4]);
    const double size = lengths[k] * lengths[(k + 1) % 4];
    if (size > 0) normal += turn / size;
    area += glm::length(turn) / 4;
  }
  BendingRows::Row row{};
  const double length = glm::length(normal);
  if (!(length > 0)) return row;
  normal *= std::sqrt(area) / length;

  // The unit by which the height of a vertex's control points moves them along `normal`.
  const auto unit = [&](std::int32_t of) {
    const std::int32_t vertex = topology.corner_vertices[of];
    return glm::dot(normal, direction(vertex)) * units[vertex];
  };
  const double own = unit(corner);
  store(make_line(edges[0], lengths[0], edges[2], lengths[2], normal), unit(next), own, row.next,
        row.own1, row.after, row.value1);
  store(make_line(edges[1], lengths[1], edges[3], lengths[3], normal), unit(previous), own,
        row.previous, row.own2, row.before, row.value2);
  return row;
}

// Mean distance of a vertex's control points.
std::vector<double> polygon_sizes(const FairTopology& topology, std::span<const dvec3> offsets) {
  std::vector<double> sizes(static_cast<std::size_t>(topology.vertex_count), 0.0);
  parallel_for(sizes.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      for (std::int32_t i = topology.ring_offsets[v]; i < topology.ring_offsets[v + 1]; ++i) {
        sizes[v] += glm::length(offsets[topology.ring_corners[i]]);
      }
      sizes[v] /= topology.valence(static_cast<std::int32_t>(v));
    }
  });
  return sizes;
}

// Places of the corners beside each corner in its face.
void find_face_neighbours(const FairTopology& topology, BendingRows& bending) {
  std::vector<std::int32_t> place_of_corner(topology.ring_corners.size());
  for (std::size_t i = 0; i < place_of_corner.size(); ++i) {
    place_of_corner[topology.ring_corners[i]] = static_cast<std::int32_t>(i);
  }
  bending.next.resize(place_of_corner.size());
  bending.previous.resize(place_of_corner.size());
  parallel_for(static_cast<std::size_t>(topology.face_count), kGrain,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t f = begin; f < end; ++f) {
                   const std::int32_t first = topology.face_offsets[f];
                   std::int32_t previous = place_of_corner[topology.face_offsets[f + 1] - 1];
                   for (std::int32_t c = first; c < topology.face_offsets[f + 1]; ++c) {
                     const std::int32_t own = place_of_corner[c];
                     bending.previous[own] = previous;
                     bending.next[previous] = own;
                     previous = own;
                   }
                 }
               });
}

// Mean diagonal of the Hessian over each vertex's control points.
std::vector<double> mean_diagonals(const FairTopology& topology, const BendingRows& bending) {
  std::vector<double> diagonals(static_cast<std::size_t>(topology.vertex_count), 0.0);
  const auto square = [](double x) { return x * x; };
  parallel_for(diagonals.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      double sum = 0;
      for (std::int32_t i = topology.ring_offsets[v]; i < topology.ring_offsets[v + 1]; ++i) {
        const BendingRows::Row& row = bending.rows[i];
        sum += square(row.own1) + square(row.own2) + square(row.after) + square(row.before) +
               square(bending.rows[bending.previous[i]].next) +
               square(bending.rows[bending.next[i]].previous);
      }
      diagonals[v] = sum / topology.valence(static_cast<std::int32_t>(v));
    }
  });
  return diagonals;
}

// Changes to units in which every vertex's mean diagonal is 1: what is left of the conditioning is
// the business of conjugate gradients.
void balance_units(const FairTopology& topology, BendingRows& bending) {
  std::vector<double> factors = mean_diagonals(topology, bending);
  const double largest = *std::max_element(factors.begin(), factors.end());
  if (!(largest > 0)) return;
  for (double& factor : factors) factor = 1 / std::sqrt(std::max(factor, kLeastDiagonal * largest));
  parallel_for(factors.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    const auto factor_at = [&](std::int32_t place) {
      return static_cast<float>(factors[topology.corner_vertices[topology.ring_corners[place]]]);
    };
    for (std::size_t v = begin; v < end; ++v) {
      const auto own = static_cast<float>(factors[v]);
      for (std::int32_t i = topology.ring_offsets[v]; i < topology.ring_offsets[v + 1]; ++i) {
        BendingRows::Row& row = bending.rows[i];
        row.next *= factor_at(bending.next[i]);
        row.previous *= factor_at(bending.previous[i]);
        for (float* coefficient : {&row.own1, &row.after, &row.own2, &row.before}) {
          *coefficient *= own;
        }
      }
      bending.height_units[v] *= factors[v];
    }
  });
}

}  // namespace

BendingRows make_bending_rows(const FairTopology& topology, std::span<const dvec3> given,
                              std::span<const dvec3> normals, std::span<const dvec3> offsets) {
  BendingRows bending;
  find_face_neighbours(topology, bending);
  bending.height_units = polygon_sizes(topology, offsets);
  bending.rows.resize(topology.ring_corners.size());
  const RowBuilder builder{topology, given, normals, offsets};
  parallel_for(bending.rows.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      bending.rows[i] =
          builder.row(topology.ring_corners[i], topology.ring_corners[bending.next[i]],
                      topology.ring_corners[bending.previous[i]], bending.height_units);
    }
  });
  balance_units(topology, bending);
  return bending;
}

}  // namespace planish
