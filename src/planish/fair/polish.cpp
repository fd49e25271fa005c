// Based on: Hestenes & Stiefel 1952, conjugate gradients, on the subspace of heights with sum 0
// over every polygon. With J the rows' coefficients a step is three passes: faces multiply by
// J^t J as far as a face sees it, vertices gather the residual, vertices turn the direction.
#include "planish/fair/polish.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/fair/piecewise_sum.h"

namespace planish {

using glm::dvec3;

namespace {

constexpr std::size_t kPolishGrain = 4096;
constexpr double kFarthestMove = 0.3;
// Of the first residual's square: single precision reaches no lower.
constexpr double kConverged = 1e-12;

// Conjugate gradients in the making.
struct Polisher {
  Polisher(const FairTopology& net_topology, BendingRows&& rows, FairHalo* net_halo);

  template <class Size>
  double multiply(std::int32_t first, Size m, std::vector<BendingLines>& scratch);
  double descend(std::int32_t vertex, float step);
  void turn(std::int32_t vertex, float step, float momentum);
  double descend_all(double step);
  void turn_all(double step, double momentum);
  void climb_all(double step);
  double multiply_all();
  void run(std::int32_t steps);

  const FairTopology& topology;
  FairHalo* halo;
  BendingRows bending;                 // its products: J^t J direction
  RawVector<float> heights, residual;  // per place
  RawVector<float> direction;          // per state index: 0 beyond the corners
};

Polisher::Polisher(const FairTopology& net_topology, BendingRows&& rows, FairHalo* net_halo)
    : topology(net_topology), halo(net_halo), bending(std::move(rows)) {
  const std::size_t count = bending.rows.size();
  for (auto* vector : {&heights, &residual, &direction}) vector->resize(count);
  direction.resize(static_cast<std::size_t>(topology.state_size), 0.0f);
  parallel_for(count, kPolishGrain, [&](std::size_t begin, std::size_t end) {
    for (auto* vector : {&heights, &residual, &direction}) {
      std::fill(&(*vector)[begin], &(*vector)[begin] + (end - begin), 0.0f);
    }
  });
}

// products = J^t J direction for the corners of a face; returns the square of J direction.
template <class Size>
double Polisher::multiply(std::int32_t first, Size m, std::vector<BendingLines>& scratch) {
  if (scratch.size() < static_cast<std::size_t>(m)) scratch.resize(static_cast<std::size_t>(m));
  BendingLines* const lines = scratch.data();
  const BendingRows::Row* const rows = &bending.rows[first];
  const float* const along = &direction[first];
  float square = 0;
  for (std::int32_t i = 0; i < m; ++i) {
    const BendingRows::Row& row = rows[i];
    lines[i] = {row.next * along[i + 1 == m ? 0 : i + 1] + row.own1 * along[i] +
                    row.after * direction[topology.corner_ccw[first + i]],
                row.previous * along[i == 0 ? m - 1 : i - 1] + row.own2 * along[i] +
                    row.before * direction[topology.corner_cw[first + i]]};
    square += lines[i].line1 * lines[i].line1 + lines[i].line2 * lines[i].line2;
  }
  for (std::int32_t i = 0; i < m; ++i) {
    const std::int32_t previous = i == 0 ? m - 1 : i - 1, next = i + 1 == m ? 0 : i + 1;
    bending.products[first + i] = transposed_product(rows[i], lines[i], rows[previous],
                                                     lines[previous], rows[next], lines[next]);
  }
  return square;
}

// residual -= step * products, less its mean; returns its preconditioned square.
double Polisher::descend(std::int32_t vertex, float step) {
  const std::int32_t first = topology.ring_offsets[vertex];
  const std::int32_t last = topology.ring_offsets[vertex + 1] - 1;
  const auto product = [&](std::int32_t place) {
    return &bending.products[topology.ring_corners[place]];
  };
  double sum = 0;
  const BendingRows::Product* before = product(last);
  const BendingRows::Product* own = product(first);
  for (std::int32_t i = first; i <= last; ++i) {
    const BendingRows::Product* after = product(i == last ? first : i + 1);
    residual[i] -= step * (own->face + before->after + after->before);
    sum += residual[i];
    before = own;
    own = after;
  }
  const auto mean = static_cast<float>(sum / (last + 1 - first));
  double square = 0;
  for (std::int32_t i = first; i <= last; ++i) {
    residual[i] -= mean;
    square += static_cast<double>(residual[i]) * residual[i];
  }
  return square * bending.preconditioner[vertex];
}

// heights += step * direction, then the next direction.
void Polisher::turn(std::int32_t vertex, float step, float momentum) {
  const float scale = bending.preconditioner[vertex];
  for (std::int32_t i = topology.ring_offsets[vertex]; i < topology.ring_offsets[vertex + 1]; ++i) {
    float& along = direction[topology.ring_corners[i]];
    heights[i] += step * along;
    along = scale * residual[i] + momentum * along;
  }
}

// The last step's part of turn().
void Polisher::climb_all(double step) {
  const auto length = static_cast<float>(step);
  parallel_each(heights.size(), kPolishGrain,
                [&](std::size_t i) { heights[i] += length * direction[topology.ring_corners[i]]; });
}

// body(i) of all elements, whose sum is the halo's.
template <class MakeBody>
std::vector<double> values_of(std::int32_t count, const MakeBody& make_body) {
  std::vector<double> values(static_cast<std::size_t>(count));
  parallel_for(values.size(), kPolishGrain, [&](std::size_t begin, std::size_t end) {
    auto body = make_body();
    for (std::size_t i = begin; i < end; ++i) values[i] = body(static_cast<std::int32_t>(i));
  });
  return values;
}

double Polisher::multiply_all() {
  const auto make_body = [&] {
    return [&, scratch = std::vector<BendingLines>{}](std::int32_t face) mutable {
      return for_face_size(topology, face,
                           [&](std::int32_t first, auto m) { return multiply(first, m, scratch); });
    };
  };
  if (halo) return halo->sum_of_faces(values_of(topology.face_count, make_body));
  return piecewise_sum(topology.face_count, make_body);
}

double Polisher::descend_all(double step) {
  const auto make_body = [&] {
    return [&](std::int32_t v) { return descend(v, static_cast<float>(step)); };
  };
  if (halo) return halo->sum_of_vertices(values_of(topology.vertex_count, make_body));
  return piecewise_sum(topology.vertex_count, make_body);
}

void Polisher::turn_all(double step, double momentum) {
  parallel_each(bending.preconditioner.size(), kPolishGrain, [&](std::int32_t v) {
    turn(v, static_cast<float>(step), static_cast<float>(momentum));
  });
  if (halo) {
    halo->exchange_corners(
        std::span<float>(direction).first(static_cast<std::size_t>(topology.corner_count)));
  }
}

void Polisher::run(std::int32_t steps) {
  // The first residual is minus the gradient at heights 0, whose products the rows bring along.
  double square = descend_all(1.0);
  turn_all(0.0, 0.0);
  const double enough = kConverged * square;
  for (std::int32_t step = 0; step < steps && square > enough; ++step) {
    const double curvature = multiply_all();
    if (!(curvature > 0)) return;
    const double length = square / curvature;
    if (step + 1 == steps) return climb_all(length);
    const double next_square = descend_all(length);
    turn_all(length, next_square / square);
    square = next_square;
  }
}

}  // namespace

std::vector<dvec3> polish_directions(const FairTopology& topology, std::span<const dvec3> normals,
                                     std::span<const double> shares, const PlanePlaces& planes) {
  std::vector<dvec3> directions(normals.size(), dvec3(0.0));
  parallel_each(normals.size(), kPolishGrain, [&](std::int32_t v) {
    if (!topology.has_polygon(v) || planes.of(v) >= 0) return;
    directions[v] = (topology.is_near_curve[v] ? 1 - shares[v] : 1.0) * normals[v];
  });
  return directions;
}

RawVector<float> polish_heights(const FairTopology& topology, BendingRows&& bending,
                                std::int32_t steps, FairHalo* halo) {
  Polisher polisher(topology, std::move(bending), halo);
  polisher.run(steps);
  return std::move(polisher.heights);
}

void apply_heights(const FairTopology& topology, std::span<const dvec3> directions,
                   std::span<const float> heights, std::span<dvec3> offsets) {
  parallel_for(directions.size(), kPolishGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const double size = glm::length(directions[v]);
      if (!(size > 0)) continue;
      const std::int32_t first = topology.ring_offsets[v], last = topology.ring_offsets[v + 1];
      double sum = 0, farthest = 0;  // the latter a square
      for (std::int32_t i = first; i < last; ++i) sum += heights[i];
      const double mean = sum / (last - first);
      for (std::int32_t i = first; i < last; ++i) {
        const dvec3& offset = offsets[topology.ring_corners[i]];
        const double move = (heights[i] - mean) * size;
        const double distance = glm::dot(offset, offset);
        if (move * move > farthest * distance) {
          farthest = distance > 0 ? move * move / distance : HUGE_VAL;
        }
      }
      const double trusted =
          farthest > kFarthestMove * kFarthestMove ? kFarthestMove / std::sqrt(farthest) : 1.0;
      for (std::int32_t i = first; i < last; ++i) {
        offsets[topology.ring_corners[i]] += (heights[i] - mean) * trusted * directions[v];
      }
    }
  });
}

}  // namespace planish
