// Based on: Hestenes & Stiefel 1952, conjugate gradients, on the subspace of heights with sum 0
// over every polygon; the scaling of BendingRows stands for the preconditioner. With J the rows'
// coefficients: two passes over the rows a step, one for J p, one for J^t (J p).
#include "planish/fair/polish.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>

#include "planish/core/parallel.h"

namespace planish {

using glm::dvec3;

namespace {

// Vertices of a piece. Sums are over pieces of fixed size, so that they round the same whatever
// the threads.
constexpr std::int32_t kPiece = 2048;
constexpr double kFarthestMove = 0.3;

// body(vertex) over all vertices, its results summed.
template <class Body>
double sum_over_vertices(const FairTopology& topology, const Body& body) {
  std::vector<double> pieces(
      static_cast<std::size_t>((topology.vertex_count + kPiece - 1) / kPiece));
  parallel_for(pieces.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t piece = begin; piece < end; ++piece) {
      const auto first = static_cast<std::int32_t>(piece) * kPiece;
      const std::int32_t last = std::min(first + kPiece, topology.vertex_count);
      double sum = 0;
      for (std::int32_t v = first; v < last; ++v) sum += body(v);
      pieces[piece] = sum;
    }
  });
  return std::accumulate(pieces.begin(), pieces.end(), 0.0);
}

struct RowValues {
  float line1, line2;
};

// Conjugate gradients in the making; vectors per place.
struct Polisher {
  const FairTopology& topology;
  const BendingRows& bending;
  std::vector<float> heights, residual, direction;
  std::vector<RowValues> images;  // J direction

  Polisher(const FairTopology& net_topology, const BendingRows& rows)
      : topology(net_topology),
        bending(rows),
        heights(rows.rows.size(), 0.0f),
        residual(heights),
        direction(heights),
        images(heights.size()) {}

  double apply_rows(std::int32_t vertex);
  double descend(std::int32_t vertex, double step);
  void turn(std::int32_t vertex, float momentum);
  void run(std::int32_t steps);
};

// images = J direction around a vertex; returns their square.
double Polisher::apply_rows(std::int32_t vertex) {
  const std::int32_t first = topology.ring_offsets[vertex];
  const std::int32_t last = topology.ring_offsets[vertex + 1] - 1;
  double square = 0;
  float before = direction[last];
  for (std::int32_t i = first; i <= last; ++i) {
    const BendingRows::Row& row = bending.rows[i];
    const float own = direction[i];
    const float after = direction[i == last ? first : i + 1];
    const RowValues image{
        row.next * direction[bending.next[i]] + row.own1 * own + row.after * after,
        row.previous * direction[bending.previous[i]] + row.own2 * own + row.before * before};
    images[i] = image;
    square += static_cast<double>(image.line1) * image.line1 +
              static_cast<double>(image.line2) * image.line2;
    before = own;
  }
  return square;
}

// heights += step * direction, residual -= step * J^t images less its mean; returns the residual's
// square.
double Polisher::descend(std::int32_t vertex, double step) {
  const std::int32_t first = topology.ring_offsets[vertex];
  const std::int32_t last = topology.ring_offsets[vertex + 1] - 1;
  const auto factor = static_cast<float>(step);
  double sum = 0;
  for (std::int32_t i = first; i <= last; ++i) {
    const BendingRows::Row& row = bending.rows[i];
    const std::int32_t before = i == first ? last : i - 1;
    const std::int32_t after = i == last ? first : i + 1;
    const std::int32_t next = bending.next[i], previous = bending.previous[i];
    const float gradient = row.own1 * images[i].line1 + row.own2 * images[i].line2 +
                           bending.rows[before].after * images[before].line1 +
                           bending.rows[after].before * images[after].line2 +
                           bending.rows[previous].next * images[previous].line1 +
                           bending.rows[next].previous * images[next].line2;
    residual[i] -= factor * gradient;
    heights[i] += factor * direction[i];
    sum += residual[i];
  }
  const auto mean = static_cast<float>(sum / (last + 1 - first));
  double square = 0;
  for (std::int32_t i = first; i <= last; ++i) {
    residual[i] -= mean;
    square += static_cast<double>(residual[i]) * residual[i];
  }
  return square;
}

void Polisher::turn(std::int32_t vertex, float momentum) {
  for (std::int32_t i = topology.ring_offsets[vertex]; i < topology.ring_offsets[vertex + 1]; ++i) {
    direction[i] = residual[i] + momentum * direction[i];
  }
}

void Polisher::run(std::int32_t steps) {
  // The first residual is minus the gradient at heights 0: as a step along direction 0.
  for (std::size_t i = 0; i < images.size(); ++i) {
    images[i] = {bending.rows[i].value1, bending.rows[i].value2};
  }
  double square = sum_over_vertices(topology, [&](std::int32_t v) { return descend(v, 1.0); });
  direction = residual;
  // Of the first residual's square: single precision reaches no lower.
  constexpr double kConverged = 1e-12;
  const double enough = kConverged * square;
  for (std::int32_t step = 0; step < steps && square > enough; ++step) {
    const double curvature =
        sum_over_vertices(topology, [&](std::int32_t v) { return apply_rows(v); });
    if (!(curvature > 0)) return;
    const double length = square / curvature;
    const double next_square =
        sum_over_vertices(topology, [&](std::int32_t v) { return descend(v, length); });
    const auto momentum = static_cast<float>(next_square / square);
    square = next_square;
    sum_over_vertices(topology, [&](std::int32_t v) {
      turn(v, momentum);
      return 0.0;
    });
  }
}

}  // namespace

std::vector<float> polish_heights(const FairTopology& topology, const BendingRows& bending,
                                  std::int32_t steps) {
  Polisher polisher(topology, bending);
  polisher.run(steps);
  return std::move(polisher.heights);
}

double bending_energy(const FairTopology& topology, const BendingRows& bending,
                      std::span<const float> heights) {
  return sum_over_vertices(topology, [&](std::int32_t vertex) {
    const std::int32_t first = topology.ring_offsets[vertex];
    const std::int32_t last = topology.ring_offsets[vertex + 1] - 1;
    double square = 0;
    for (std::int32_t i = first; i <= last; ++i) {
      const BendingRows::Row& row = bending.rows[i];
      const double own = heights[i];
      const double line1 = row.value1 + row.next * static_cast<double>(heights[bending.next[i]]) +
                           row.own1 * own +
                           row.after * static_cast<double>(heights[i == last ? first : i + 1]);
      const double line2 =
          row.value2 + row.previous * static_cast<double>(heights[bending.previous[i]]) +
          row.own2 * own + row.before * static_cast<double>(heights[i == first ? last : i - 1]);
      square += line1 * line1 + line2 * line2;
    }
    return square;
  });
}

void apply_heights(const FairTopology& topology, const BendingRows& bending,
                   std::span<const dvec3> normals, std::span<const float> heights,
                   std::span<dvec3> offsets) {
  sum_over_vertices(topology, [&](std::int32_t v) {
    if (!topology.has_polygon(v)) return 0.0;
    const std::int32_t first = topology.ring_offsets[v], end = topology.ring_offsets[v + 1];
    double sum = 0, farthest = 0;
    for (std::int32_t i = first; i < end; ++i) sum += heights[i];
    const double mean = sum / (end - first);
    const double unit = bending.height_units[v];
    for (std::int32_t i = first; i < end; ++i) {
      const double distance = glm::length(offsets[topology.ring_corners[i]]);
      const double move = std::abs(heights[i] - mean) * unit;
      if (move > farthest * distance) farthest = distance > 0 ? move / distance : HUGE_VAL;
    }
    const double trusted = farthest > kFarthestMove ? kFarthestMove / farthest : 1.0;
    for (std::int32_t i = first; i < end; ++i) {
      offsets[topology.ring_corners[i]] += (heights[i] - mean) * unit * trusted * normals[v];
    }
    return 0.0;
  });
}

}  // namespace planish
