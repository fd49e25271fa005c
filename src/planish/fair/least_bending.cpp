// An own discretisation. The functional is that of a thin plate, the integral of the squared mean
// curvature (Halstead, Kass & DeRose 1993 take it with a membrane's): by Gauss and Bonnet that of
// the squared principal curvatures, but for a constant. Divided by own areas the rows are exact on
// spheres whatever the mesh, and symmetric weights make the gradient vanish there: round shapes
// do not shrink where the mesh is uneven.
#include "planish/fair/bending.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/vectors.h"

namespace planish {

using glm::dvec3;

namespace {

// Of unit diagonal: shorter edges weigh as this long ones.
constexpr double kShortestEdge = 1e-9;
// The same of areas: rows of smaller ones are left out.
constexpr double kLeastArea = 1e-30;

bool is_smooth(VertexKind kind) { return kind == VertexKind::Smooth || kind == VertexKind::Dart; }

VertexKind kind_of(const BendingTable& table, std::int32_t vertex) {
  return static_cast<VertexKind>(table.kinds[vertex]);
}

// Per edge.
RawVector<float> edge_weights(const MeshTopology& topology, std::span<const dvec3> given) {
  RawVector<dvec3> centroids(static_cast<std::size_t>(topology.face_count()));
  parallel_each(centroids.size(), [&](std::int32_t f) {
    dvec3 sum(0.0);
    for (const std::int32_t v : topology.face(f)) sum += given[v];
    centroids[f] = sum / static_cast<double>(topology.face_size(f));
  });
  RawVector<float> weights(static_cast<std::size_t>(topology.edge_count()));
  parallel_each(weights.size(), [&](std::int32_t e) {
    const auto [v0, v1] = topology.edge_vertices(e);
    const std::int32_t corner = topology.corner_of(e);
    const std::int32_t twin = topology.twin(corner);
    const dvec3 middle = (given[v0] + given[v1]) / 2.0;
    double dual = glm::distance(centroids[topology.face_of(corner)], middle);
    if (twin >= 0) dual += glm::distance(centroids[topology.face_of(twin)], middle);
    weights[e] =
        static_cast<float>(dual / std::max(glm::distance(given[v0], given[v1]), kShortestEdge));
  });
  return weights;
}

bool is_sharp(const SharpFeatures& features, std::int32_t edge) {
  return !features.sharp_of_edge.empty() && features.sharp_of_edge[edge] >= 0;
}

// The weight of an edge in the row of one of its ends.
float weight_in_row(VertexKind kind, bool sharp, float weight) {
  if (is_smooth(kind)) return weight;
  return kind == VertexKind::Crease && sharp ? 1.0f : 0.0f;
}

// steps, from the sums of rows without signs.
void set_steps(BendingTable& table) {
  const auto count = static_cast<std::size_t>(table.vertex_count());
  RawVector<double> shares(count);  // of a row's sum, by area: what each of its heights takes
  parallel_each(count, [&](std::int32_t v) {
    double sum = 0;
    for (const BendingTable::Entry& entry : table.row(v)) sum += entry.own;
    shares[v] = 2 * sum * table.inverse_areas[v];
  });
  table.steps.resize(count);
  parallel_each(count, [&](std::int32_t v) {
    double own = 0, sum = 0;
    for (const BendingTable::Entry& entry : table.row(v)) {
      own += entry.own;
      sum += entry.theirs * shares[entry.vertex];
    }
    sum += own * shares[v];
    table.steps[v] = static_cast<float>(sum > 0 ? 1 / sum : 0.0);
  });
}

// sum_j own_vj (x_j - x_v)
template <class Value>
dvec3 difference(const BendingTable& table, std::span<const Value> values, std::int32_t vertex) {
  dvec3 sum(0.0);
  for (const BendingTable::Entry& entry : table.row(vertex))
    sum += static_cast<double>(entry.own) * (values[entry.vertex] - values[vertex]);
  return sum;
}

// Of smooth vertices the normal, by the areas of the faces' corners; of vertices on sharp curves
// the tangent.
dvec3 direction_of(const BendingTable& table, std::span<const dvec3> given, std::int32_t vertex) {
  const auto row = table.row(vertex);
  dvec3 sum(0.0);
  if (kind_of(table, vertex) == VertexKind::Crease) {
    double sign = 1;
    for (const BendingTable::Entry& entry : row) {
      if (!(entry.own > 0)) continue;
      sum += sign * given[entry.vertex];
      sign = -sign;
    }
    return unit_or_zero(sum);
  }
  const std::size_t corners = row.size() - (table.is_closed[vertex] != 0 ? 0 : 1);
  for (std::size_t i = 0; i < corners && row.size() > 1; ++i) {
    const BendingTable::Entry &entry = row[i], &next = row[i + 1 == row.size() ? 0 : i + 1];
    sum += glm::cross(given[entry.vertex] - given[vertex], given[next.vertex] - given[vertex]);
  }
  return unit_or_zero(sum);
}

RawVector<dvec3> directions_of(const BendingTable& table, std::span<const dvec3> given) {
  RawVector<dvec3> directions(given.size());
  parallel_each(given.size(),
                [&](std::int32_t v) { directions[v] = direction_of(table, given, v); });
  return directions;
}

// What a vertex may move by.
dvec3 allowed(VertexKind kind, const dvec3& direction, const dvec3& vector) {
  const dvec3 along = direction * glm::dot(direction, vector);
  if (is_smooth(kind)) return along;
  return kind == VertexKind::Crease ? vector - along : dvec3(0.0);
}

struct Descent {
  const BendingTable& table;
  RawVector<dvec3> directions, base;  // base: the rows without moves
  RawVector<dvec3> rows;              // by area
  RawVector<dvec3> moves, ahead;      // ahead: where the momentum leads

  // rows = base and what moves do to it, by area.
  void set_rows(std::span<const dvec3> moved) {
    parallel_each(rows.size(), [&](std::int32_t v) {
      rows[v] = static_cast<double>(table.inverse_areas[v]) *
                allowed(kind_of(table, v), directions[v], base[v] + difference(table, moved, v));
    });
  }

  [[nodiscard]] double bending(FairHalo* halo) const {
    const auto of = [&](std::size_t v) {
      const double inverse = table.inverse_areas[v];
      return inverse > 0 ? glm::dot(rows[v], rows[v]) / inverse : 0.0;
    };
    if (halo == nullptr) return piecewise_sum(table.vertex_count(), [&] { return of; });
    RawVector<double> values(rows.size());
    parallel_each(values.size(), [&](std::size_t v) { values[v] = of(v); });
    return halo->sum_of_vertices(values);
  }

  void step(std::int32_t v, double bound, double momentum) {
    dvec3 gradient(0.0);
    for (const BendingTable::Entry& entry : table.row(v)) {
      gradient += static_cast<double>(entry.theirs) * rows[entry.vertex] -
                  static_cast<double>(entry.own) * rows[v];
    }
    const VertexKind kind = kind_of(table, v);
    dvec3 next =
        ahead[v] - static_cast<double>(table.steps[v]) * allowed(kind, directions[v], gradient);
    const double length = glm::length(next);
    if (length > bound) next *= bound / length;
    ahead[v] = next + momentum * (next - moves[v]);
    moves[v] = next;
  }
};

double median_of(std::vector<double>& values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Of unit deviation, as if drawn: the sum of four uniform numbers (of splitmix64's finaliser).
double normal_number(std::uint64_t number) {
  number = (number + 1) * 0x9e3779b97f4a7c15u;
  number = (number ^ (number >> 30)) * 0xbf58476d1ce4e5b9u;
  number = (number ^ (number >> 27)) * 0x94d049bb133111ebu;
  number ^= number >> 31;
  double sum = 0;
  for (int piece = 0; piece < 4; ++piece, number >>= 16)
    sum += static_cast<double>(number & 0xffff) / 0xffff - 0.5;
  return std::sqrt(3.0) * sum;
}

// The curvatures of the rows differenced twice over the mesh, where `counts` is set: in the unit of
// heights.
std::vector<double> fourth_differences(const BendingTable& table, RawVector<double> curvatures,
                                       std::span<const std::uint8_t> counts) {
  const auto laplacian = [&](const RawVector<double>& values, std::int32_t v) {
    double sum = 0;
    for (const BendingTable::Entry& entry : table.row(v))
      sum += entry.own * (values[entry.vertex] - values[v]);
    return sum;
  };
  RawVector<double> once(curvatures.size());
  parallel_each(once.size(), [&](std::int32_t v) {
    once[v] = table.inverse_areas[v] * laplacian(curvatures, v);
  });
  std::vector<double> result;
  for (std::int32_t v = 0; v < table.vertex_count(); ++v) {
    if (counts[v] == 0) continue;
    const double area = 1 / table.inverse_areas[v];
    result.push_back(std::abs(laplacian(once, v)) * area * std::sqrt(area));
  }
  return result;
}

}  // namespace

BendingTable make_bending_table(const MeshTopology& topology, const SharpFeatures& features,
                                std::span<const dvec3> given) {
  BendingTable table;
  const auto count = static_cast<std::size_t>(topology.vertex_count());
  table.kinds.resize(count);
  table.is_closed.resize(count);
  table.offsets.resize(count + 1);
  parallel_each(count, [&](std::int32_t v) {
    table.kinds[v] = static_cast<std::uint8_t>(features.vertex_kinds[v]);
    table.is_closed[v] = topology.is_boundary_vertex(v) ? 0 : 1;
    table.offsets[v] = topology.valence(v);
  });
  table.offsets[count] = 0;
  std::exclusive_scan(table.offsets.begin(), table.offsets.end(), table.offsets.begin(), 0);
  table.entries.resize(static_cast<std::size_t>(table.offsets[count]));
  table.inverse_areas.resize(count);

  const RawVector<float> weights = edge_weights(topology, given);
  parallel_each(count, [&](std::int32_t v) {
    BendingTable::Entry* entry = table.entries.data() + table.offsets[v];
    double area = 0;
    const auto add = [&](std::int32_t other, std::int32_t edge) {
      const bool sharp = is_sharp(features, edge);
      const float own = weight_in_row(kind_of(table, v), sharp, weights[edge]);
      *entry++ = {other, own, weight_in_row(kind_of(table, other), sharp, weights[edge])};
      const dvec3 offset = given[other] - given[v];
      area += own * glm::dot(offset, offset) / 2;
    };
    const auto corners = topology.corners_at(v);
    for (const std::int32_t corner : corners)
      add(topology.vertex_of(topology.next(corner)), topology.edge_of(corner));
    if (!corners.empty() && table.is_closed[v] == 0) {
      const std::int32_t last = topology.prev(corners.back());
      add(topology.vertex_of(last), topology.edge_of(last));
    }
    table.inverse_areas[v] = static_cast<float>(area > kLeastArea ? 1 / area : 0.0);
  });
  set_steps(table);
  return table;
}

std::array<double, kLeastBendingSteps> nesterov_momenta() {
  std::array<double, kLeastBendingSteps> momenta{};
  double age = 1;
  for (double& momentum : momenta) {
    const double next_age = (1 + std::sqrt(1 + 4 * age * age)) / 2;
    momentum = (age - 1) / next_age;
    age = next_age;
  }
  return momenta;
}

LeastBending least_bending_moves(const BendingTable& table, std::span<const dvec3> given,
                                 double bound, FairHalo* halo) {
  Descent descent{.table = table, .directions = directions_of(table, given)};
  descent.base.resize(given.size());
  descent.rows.resize(given.size());
  for (auto* moves : {&descent.moves, &descent.ahead}) moves->assign(given.size(), dvec3(0.0));
  parallel_each(given.size(),
                [&](std::int32_t v) { descent.base[v] = difference(table, given, v); });
  LeastBending result;
  descent.set_rows(std::span<const dvec3>(descent.ahead));
  result.bending_before = descent.bending(halo);
  for (const double momentum : nesterov_momenta()) {
    parallel_each(given.size(), [&](std::int32_t v) { descent.step(v, bound, momentum); });
    // With two rings of faces around its own vertices, a part's rows are right around them.
    if (halo != nullptr) halo->exchange_vertices(std::span(descent.ahead));
    descent.set_rows(std::span<const dvec3>(descent.ahead));
  }
  if (halo != nullptr) halo->exchange_vertices(std::span(descent.moves));
  descent.set_rows(std::span<const dvec3>(descent.moves));
  result.bending_after = descent.bending(halo);
  result.moves.assign(descent.moves.begin(), descent.moves.end());
  return result;
}

LeaveWithin leave_within(const std::optional<double>& wanted, const BendingTable& table,
                         std::span<const dvec3> given) {
  if (!wanted) {
    const double noise = measured_noise(table, given);
    return {kNoiseBound * noise, noise};
  }
  if (!(*wanted >= 0 && *wanted < kMostWithin))
    throw Error(ErrorCode::InvalidArgument, "within " + shortest(*wanted) + " is outside 0 to " +
                                                shortest(kMostWithin) + " of the diagonal");
  return {*wanted, {}};
}

double measured_noise(const BendingTable& table, std::span<const dvec3> given) {
  constexpr std::ptrdiff_t kFewest = 50;
  const RawVector<dvec3> normals = directions_of(table, given);
  std::vector<std::uint8_t> counts(given.size());
  RawVector<double> curvatures(given.size()), of_unit(given.size());
  parallel_each(given.size(), [&](std::int32_t v) {
    curvatures[v] = of_unit[v] = 0;
    if (!is_smooth(kind_of(table, v)) || !(table.inverse_areas[v] > 0)) return;
    counts[v] = 1;
    double sum = 0;
    for (const BendingTable::Entry& entry : table.row(v)) {
      if (!is_smooth(kind_of(table, entry.vertex))) counts[v] = 0;
      sum += entry.own * (glm::dot(normals[v], normals[entry.vertex]) *
                              normal_number(static_cast<std::uint64_t>(entry.vertex)) -
                          normal_number(v));
    }
    of_unit[v] = table.inverse_areas[v] * sum;
    curvatures[v] = table.inverse_areas[v] * glm::dot(normals[v], difference(table, given, v));
  });
  std::vector<double> found = fourth_differences(table, std::move(curvatures), counts);
  if (std::ssize(found) < kFewest) return 0;
  std::vector<double> of_unit_noise = fourth_differences(table, std::move(of_unit), counts);
  return median_of(found) / median_of(of_unit_noise);
}

}  // namespace planish
