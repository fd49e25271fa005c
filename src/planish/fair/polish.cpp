#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <type_traits>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/fair/bending.h"

namespace planish {

// An own derivation. The bending of a line (x-, x, x+) with unequal parts r- and r+ is its second
// divided difference 2 / (r+ + r-) ((x+ - x) / r+ - (x - x-) / r-) along the net's normal n at x.
// Its square is weighted by the area A around x.

using glm::dvec3;
using glm::vec3;

namespace {

constexpr std::size_t kRowGrain = 4096;
// A part of a line below this of the whole measures noise. Much lower than it might be: lines left
// out at 0.02 cost a scan's thin triangles twice the bending.
constexpr float kShortestPart = 0.001f;
// Coincident points may lead out of single precision; lines with such coefficients are none.
constexpr float kLargestCoefficient = 1e15f;
// Of the largest mean diagonal of the Hessian: polygons with next to no rows hardly move.
constexpr float kLeastDiagonal = 1e-14f;

// Faces of one size are done four at a time, one in each lane, so that roots and products are those
// of vectors.
constexpr int kLanes = 4;

struct Lanes {
  float lane[kLanes];
};

template <class Operation>
Lanes each(const Operation& operation) {
  Lanes result;
  for (int l = 0; l < kLanes; ++l) result.lane[l] = operation(l);
  return result;
}
Lanes operator+(const Lanes& a, const Lanes& b) {
  return each([&](int l) { return a.lane[l] + b.lane[l]; });
}
Lanes operator-(const Lanes& a, const Lanes& b) {
  return each([&](int l) { return a.lane[l] - b.lane[l]; });
}
Lanes operator*(const Lanes& a, const Lanes& b) {
  return each([&](int l) { return a.lane[l] * b.lane[l]; });
}

struct LaneVector {
  Lanes x, y, z;

  void set(int l, const vec3& vector) {
    x.lane[l] = vector.x;
    y.lane[l] = vector.y;
    z.lane[l] = vector.z;
  }
};
LaneVector operator-(const LaneVector& a, const LaneVector& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
LaneVector negated(const LaneVector& a) { return LaneVector{} - a; }
Lanes dot(const LaneVector& a, const LaneVector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
LaneVector cross(const LaneVector& a, const LaneVector& b) {
  return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
}
Lanes length(const LaneVector& a) {
  const Lanes square = dot(a, a);
  return each([&](int l) { return std::sqrt(square.lane[l]); });
}

// One line: the coefficients of its ends and its value.
struct Line {
  Lanes far, near, value;
};

// `turn`: along the normal, `scale` times it the normal times the square root of the area. The
// scale comes late out of two roots: whatever can do without it runs beside them. `to_far` and
// `to_near` are the lengths of the turn along the two parts, `size` is its own length.
struct LineParts {
  const Lanes &far_length, &near_length, &to_far, &to_near;
};
Line make_line(const LineParts& parts, const Lanes& scale, const Lanes& size) {
  const Lanes &far_length = parts.far_length, &near_length = parts.near_length;
  const Lanes whole = far_length + near_length;
  const Lanes shorter = each([&](int l) {
    return far_length.lane[l] < near_length.lane[l] ? far_length.lane[l] : near_length.lane[l];
  });
  // A ramp to full weight, so that no line appears at once in a deforming mesh.
  const Lanes ramp =
      each([&](int l) { return shorter.lane[l] / (kShortestPart * whole.lane[l]) - 1; });
  const Lanes weight = each(
      [&](int l) { return ramp.lane[l] > 0 ? (ramp.lane[l] < 1 ? ramp.lane[l] : 1.0f) : 0.0f; });
  const Lanes product = whole * far_length * near_length;
  const Lanes unit = each([&](int l) { return 2 * weight.lane[l] / product.lane[l]; }) * scale;
  const Lanes far = unit * near_length, near = unit * far_length;
  const Lanes value = far * parts.to_far + near * parts.to_near;
  const Lanes larger = each([&](int l) {
    return (far.lane[l] > near.lane[l] ? far.lane[l] : near.lane[l]) * size.lane[l];
  });
  // Lines that are none may have numbers that are none.
  const auto counted = [&](const Lanes& x) {
    return each([&](int l) { return larger.lane[l] < kLargestCoefficient ? x.lane[l] : 0.0f; });
  };
  return {counted(far), counted(near), counted(value)};
}

// A corner of the faces whose rows are being made.
struct FaceCorner {
  dvec3 position[kLanes];
  LaneVector direction;            // in which a height moves it; 0 where it must stay
  LaneVector edge, after, before;  // to the next corner, and around the vertex
  Lanes edge_length;
  Lanes next, own1, after1, previous, own2, before2;  // its row
  Lanes line1, line2;                                 // its lines' values
};

struct RowBuilder {
  const FairTopology& topology;
  std::span<const dvec3> given, directions, offsets;
  BendingRows& bending;
  std::span<float> diagonals;  // per corner, of the Hessian
  std::vector<FaceCorner> corners{};

  // The faces [begin, end); returns the square of their values.
  double build(std::int32_t begin, std::int32_t end);
  // `m`: the faces' size, a constant of the type for the sizes that matter.
  template <class Size>
  double build_faces(std::span<const std::int32_t> firsts, Size m);
  template <class Size>
  void gather(int lane, std::int32_t first, Size m);
  void build_row(const FaceCorner& previous, FaceCorner& own, const FaceCorner& next);
  Lanes write_products(std::span<const std::int32_t> firsts, std::int32_t place,
                       const FaceCorner& previous, const FaceCorner& own, const FaceCorner& next);
};

double RowBuilder::build(std::int32_t begin, std::int32_t end) {
  double square = 0;
  for (std::int32_t face = begin; face < end;) {
    const std::int32_t m = topology.face_size(face);
    std::int32_t firsts[kLanes];
    std::size_t count = 0;
    for (; count < kLanes && face < end && topology.face_size(face) == m; ++face) {
      firsts[count++] = topology.face_offsets[face];
    }
    const auto faces = std::span(firsts).first(count);
    if (m == 3) {
      square += build_faces(faces, std::integral_constant<std::int32_t, 3>{});
    } else if (m == 4) {
      square += build_faces(faces, std::integral_constant<std::int32_t, 4>{});
    } else {
      square += build_faces(faces, m);
    }
  }
  return square;
}

template <class Size>
double RowBuilder::build_faces(std::span<const std::int32_t> firsts, Size m) {
  if (corners.size() < static_cast<std::size_t>(m)) corners.resize(static_cast<std::size_t>(m));
  FaceCorner* const c = corners.data();
  const int count = static_cast<int>(firsts.size());
  // Lanes without a face repeat the last one.
  for (int l = 0; l < kLanes; ++l) gather(l, firsts[std::min(l, count - 1)], m);
  for (std::int32_t i = 0; i < m; ++i) c[i].edge_length = length(c[i].edge);
  for (std::int32_t i = 0; i < m; ++i) {
    build_row(c[i == 0 ? m - 1 : i - 1], c[i], c[i + 1 == m ? 0 : i + 1]);
  }
  Lanes squares{};
  for (std::int32_t i = 0; i < m; ++i) {
    squares = squares +
              write_products(firsts, i, c[i == 0 ? m - 1 : i - 1], c[i], c[i + 1 == m ? 0 : i + 1]);
  }
  double sum = 0;
  for (int l = 0; l < count; ++l) sum += squares.lane[l];
  return sum;
}

template <class Size>
void RowBuilder::gather(int lane, std::int32_t first, Size m) {
  FaceCorner* const c = corners.data();
  for (std::int32_t i = 0; i < m; ++i) {
    const std::int32_t vertex = topology.corner_vertices[first + i];
    c[i].position[lane] = given[vertex] + offsets[first + i];
    c[i].direction.set(lane, vec3(directions[vertex]));
  }
  for (std::int32_t i = 0; i < m; ++i) {
    c[i].edge.set(lane, vec3(c[i + 1 == m ? 0 : i + 1].position[lane] - c[i].position[lane]));
    // Control points around the same vertex differ by their offsets alone.
    const dvec3& own = offsets[first + i];
    c[i].after.set(lane, vec3(offsets[topology.corner_ccw[first + i]] - own));
    c[i].before.set(lane, vec3(offsets[topology.corner_cw[first + i]] - own));
  }
}

void RowBuilder::build_row(const FaceCorner& previous, FaceCorner& own, const FaceCorner& next) {
  // Along the normal of the quad of the four neighbours, twice its area long.
  const LaneVector turn = cross(own.edge - own.after, negated(previous.edge) - own.before);
  const Lanes size = length(turn);
  // The square root of half the quad's area by the length; coincident points have no normal.
  const Lanes scale =
      each([&](int l) { return size.lane[l] > 0 ? 0.5f / std::sqrt(size.lane[l]) : 0.0f; });
  const Lanes to_previous =
      each([&, along = dot(turn, previous.edge)](int l) { return -along.lane[l]; });
  const Line line1 = make_line(
      {own.edge_length, length(own.after), dot(turn, own.edge), dot(turn, own.after)}, scale, size);
  const Line line2 = make_line(
      {previous.edge_length, length(own.before), to_previous, dot(turn, own.before)}, scale, size);
  const Lanes move = dot(turn, own.direction);
  const Lanes none{};
  own.next = line1.far * dot(turn, next.direction);
  own.own1 = none - (line1.far + line1.near) * move;
  own.after1 = line1.near * move;
  own.previous = line2.far * dot(turn, previous.direction);
  own.own2 = none - (line2.far + line2.near) * move;
  own.before2 = line2.near * move;
  own.line1 = line1.value;
  own.line2 = line2.value;
}

// Writes what corner `place` of the faces has; returns the squares of its values.
Lanes RowBuilder::write_products(std::span<const std::int32_t> firsts, std::int32_t place,
                                 const FaceCorner& previous, const FaceCorner& own,
                                 const FaceCorner& next) {
  const Lanes face = own.own1 * own.line1 + own.own2 * own.line2 + previous.next * previous.line1 +
                     next.previous * next.line2;
  const Lanes after = own.after1 * own.line1, before = own.before2 * own.line2;
  // The rows beside it around the vertex are counted where they stand: over the polygon it comes to
  // the same mean.
  const Lanes diagonal = own.own1 * own.own1 + own.own2 * own.own2 + own.after1 * own.after1 +
                         own.before2 * own.before2 + previous.next * previous.next +
                         next.previous * next.previous;
  for (std::size_t l = 0; l < firsts.size(); ++l) {
    const std::int32_t corner = firsts[l] + place;
    bending.rows[corner] = {own.next.lane[l],     own.own1.lane[l], own.after1.lane[l],
                            own.previous.lane[l], own.own2.lane[l], own.before2.lane[l]};
    bending.products[corner] = {face.lane[l], after.lane[l], before.lane[l]};
    diagonals[corner] = diagonal.lane[l];
  }
  return own.line1 * own.line1 + own.line2 * own.line2;
}

float largest_of(std::span<const float> diagonals, FairHalo* halo) {
  if (!halo) return *std::max_element(diagonals.begin(), diagonals.end());
  float largest = 0;
  for (std::size_t v = 0; v < diagonals.size(); ++v)
    if (owns_vertex(halo, static_cast<std::int32_t>(v))) largest = std::max(largest, diagonals[v]);
  return static_cast<float>(halo->largest(largest));
}

RawVector<float> make_preconditioner(const FairTopology& topology, std::span<const float> diagonals,
                                     FairHalo* halo) {
  RawVector<float> result(static_cast<std::size_t>(topology.vertex_count));
  parallel_each(result.size(), kRowGrain, [&](std::int32_t v) {
    const auto corners = topology.ring(v).corners;
    float sum = 0;
    for (const std::int32_t corner : corners) sum += diagonals[corner];
    result[v] = sum / static_cast<float>(corners.size());
  });
  const float largest = largest_of(result, halo);
  for (float& diagonal : result) {
    diagonal = diagonal > 0 ? 1 / std::max(diagonal, kLeastDiagonal * largest) : 0;
  }
  return result;
}

}  // namespace

BendingRows make_bending_rows(const FairTopology& topology, std::span<const dvec3> given,
                              std::span<const dvec3> directions, std::span<const dvec3> offsets,
                              FairHalo* halo) {
  BendingRows bending;
  bending.rows.resize(topology.ring_corners.size());
  bending.products.resize(bending.rows.size());
  RawVector<float> diagonals(bending.rows.size());
  bending.value_square = piecewise_sum_of_ranges(topology.face_count, [&] {
    return [builder = RowBuilder{topology, given, directions, offsets, bending, diagonals}](
               std::int32_t begin, std::int32_t end) mutable { return builder.build(begin, end); };
  });
  bending.preconditioner = make_preconditioner(topology, diagonals, halo);
  return bending;
}

// Based on: Hestenes & Stiefel 1952, conjugate gradients, on the subspace of heights with sum 0
// over every polygon. With J the rows' coefficients a step is three passes: faces multiply by
// J^t J as far as a face sees it, vertices gather the residual, vertices turn the direction.

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
