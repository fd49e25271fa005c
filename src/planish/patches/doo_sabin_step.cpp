#include "planish/patches/doo_sabin_step.h"

#include <glm/vec2.hpp>
#include <numbers>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/core/work.h"
#include "planish/doosabin/vertex_ring.h"
#include "planish/patches/patch_mesh.h"
#include "planish/solve/stencil_builder.h"

namespace planish {
namespace {

// One step of Doo-Sabin subdivision cuts a patch into four, which are patches of classes again when
// each is seen from its own corner: so the rules of the rings are all there is to know.

VertexRing ring_at_vertex(const PatchClass& patch) {
  VertexRing ring;
  for (std::int32_t i = 0; i < patch.ring_size; ++i) ring.faces.push_back(patch.face_column(i));
  if (patch.has_vertex()) {
    ring.kind = VertexKind::Corner;
    ring.corner_point = patch.vertex_column();
  }
  switch (patch.kind) {
    case PatchKind::Smooth:
    case PatchKind::Cone:
      return ring;
    case PatchKind::Dart:
      ring.kind = VertexKind::Dart;
      ring.dart_face = 0;
      return ring;
    case PatchKind::Crease:
      ring.kind = VertexKind::Crease;
      break;
    case PatchKind::Convex:
    case PatchKind::HalfPlane:
    case PatchKind::Reflex:
      break;
  }
  const CornerSector corner = patch.kind == PatchKind::HalfPlane ? CornerSector::HalfPlane
                              : patch.kind == PatchKind::Reflex  ? CornerSector::Reflex
                                                                 : CornerSector::Convex;
  ring.sectors.push_back(
      {0, patch.ring_size, patch.curve_column(0), patch.curve_column(1), corner});
  return ring;
}

VertexRing smooth_ring(std::vector<std::int32_t> faces) {
  VertexRing ring;
  ring.faces = std::move(faces);
  return ring;
}

// One side of the midpoint of a sharp edge.
VertexRing crease_ring(std::int32_t first, std::int32_t second, std::int32_t curve0,
                       std::int32_t curve1) {
  VertexRing ring;
  ring.kind = VertexKind::Crease;
  ring.faces = {first, second};
  ring.sectors = {{0, 2, curve0, curve1}};
  return ring;
}

}  // namespace

// Rows of points after a step, in the columns of the class.
class PatchRings::RowMaker {
 public:
  RowMaker(const PatchRings& rings, const FaceWeights& weights, const UseRow& use)
      : rings_(rings), weights_(weights), use_(use) {}

  // Of the face `offset` places behind the own one around a corner; -1, 0 or 1 where the ring is by
  // sums.
  void face(int corner, std::int32_t offset) {
    row_.clear();
    add_face(corner, offset, 1.0);
    hand_over();
  }
  // The one before a ring's sector or behind it; a dart has one.
  void curve(int corner, bool behind) {
    row_.clear();
    if (rings_.summed_[corner]) {
      add_curve_by_sums(corner, behind);
    } else {
      const VertexRing& ring = rings_.rings_[corner];
      std::int32_t own = rings_.class_.curve_column(0);
      if (!ring.sectors.empty()) {
        const VertexRing::Sector& sector = ring.sectors.front();
        own = behind ? sector.curve1 : sector.curve0;
      }
      add_refined_curve_point(weights_, ring, own, scratch_, row_);
    }
    hand_over();
  }
  void point(std::int32_t column) {
    row_.clear();
    row_.add(column, 1.0);
    hand_over();
  }
  // Mean, cosine and sine sum of a ring: the sums halve, seen from the mean.
  void sums(const Summed& ring) {
    for (std::int32_t i = 0; i < 3; ++i) {
      row_.clear();
      if (ring.vertex < 0) {
        row_.add(ring.sums, i == 0 ? 1.0 : 0.5);
      } else {
        row_.add(ring.vertex, 0.5);
        if (i == 0) row_.add(ring.sums, 0.5);
      }
      if (i > 0) row_.add(ring.sums + i, 0.5);
      hand_over();
    }
  }

 private:
  void add_face(int corner, std::int32_t offset, double scale) {
    const std::optional<Summed>& summed = rings_.summed_[corner];
    if (!summed) {
      const VertexRing& ring = rings_.rings_[corner];
      const auto n = static_cast<std::int32_t>(ring.faces.size());
      add_refined_face(weights_, ring, (rings_.own_[corner] + offset + n) % n, scale, scratch_,
                       row_);
      return;
    }
    const double c = offset == 0 ? 1 : summed->cosine, s = offset * summed->sine;
    row_.add(offset == 0 ? summed->own : offset > 0 ? summed->next : summed->previous, scale / 4);
    const bool is_tip = summed->vertex >= 0;
    row_.add(summed->sums, scale * ((is_tip ? 0.25 : 0.75) - (c + s) / 4));
    row_.add(summed->sums + 1, scale * c / 4);
    row_.add(summed->sums + 2, scale * s / 4);
    if (is_tip) row_.add(summed->vertex, scale / 2);
  }
  void add_curve_by_sums(int corner, bool behind) {
    const Summed& summed = *rings_.summed_[corner];
    const PatchClass& patch = rings_.class_;
    if (patch.kind == PatchKind::Dart) {
      add_face(corner, 0, 0.5);
      add_face(corner, patch.is_leading_sharp() ? -1 : 1, 0.5);
      return;
    }
    // The mean of a crease's two curve points is the sector's.
    row_.add(patch.curve_column(behind ? 1 : 0), 0.5);
    row_.add(summed.vertex >= 0 ? summed.vertex : summed.sums, 0.5);
  }
  void hand_over() {
    dense_.assign(static_cast<std::size_t>(rings_.class_.column_count()), 0.0);
    for (const StencilRow::Entry& entry : row_.entries()) dense_[entry.index] += entry.weight;
    use_(dense_);
  }

  const PatchRings& rings_;
  const FaceWeights& weights_;
  const UseRow& use_;
  std::vector<double> scratch_;
  StencilRow row_;
  PatchRowsOfWeights dense_;
};

PatchRings::PatchRings(const PatchClass& patch)
    : class_(patch), kinds_{patch.kind}, own_{patch.place}, sharp_{} {
  if (patch.has_ring_sums) {
    const double step = ring_angles(patch.kind, patch.ring_size).step;
    summed_[0] = {0,
                  patch.face_column_beside(1),
                  patch.face_column_beside(-1),
                  patch.ring_sums_column(),
                  patch.has_vertex() ? patch.vertex_column() : -1,
                  portable::cos(step),
                  portable::sin(step)};
  } else {
    rings_[0] = ring_at_vertex(patch);
  }
  if (patch.is_limit_only()) return;
  const std::int32_t m = patch.face_size;
  const std::int32_t e1 = patch.leading_column(), e2 = patch.trailing_column();
  const std::int32_t next = patch.ring_column(1), previous = patch.ring_column(m - 1);
  sharp_ = {patch.is_leading_sharp(), false, false, patch.is_trailing_sharp()};
  if (patch.has_face_sums) {
    const double step = ring_angles(PatchKind::Smooth, m).step;
    summed_[2] = {
        0, next, previous, patch.face_sums_column(), -1, portable::cos(step), portable::sin(step)};
  } else {
    std::vector<std::int32_t> face(static_cast<std::size_t>(m), 0);
    for (std::int32_t i = 1; i < m; ++i) face[i] = patch.ring_column(i);
    rings_[2] = smooth_ring(std::move(face));
  }
  rings_[1] = sharp_[0] ? crease_ring(next, 0, e1, patch.curve_column(0))
                        : smooth_ring({0, patch.face_column_beside(-1), e1, next});
  rings_[3] = sharp_[3] ? crease_ring(0, previous, patch.curve_column(1), e2)
                        : smooth_ring({0, previous, e2, patch.face_column_beside(1)});
  own_ = {patch.place, sharp_[0] ? 1 : 0, 0, 0};
  kinds_ = {patch.kind, sharp_[0] ? PatchKind::Crease : PatchKind::Smooth, PatchKind::Smooth,
            sharp_[3] ? PatchKind::Crease : PatchKind::Smooth};
}

PatchRowsOfWeights PatchRings::limit(int corner) const {
  const auto column_count = static_cast<std::size_t>(class_.column_count());
  StencilRow row;
  if (const std::optional<Summed>& summed = summed_[corner]) {
    const bool is_tip = summed->vertex >= 0;
    row.add(summed->sums, is_tip ? 0.0 : 1.0, -1.0, -1.0);
    row.add(summed->sums + 1, 0.0, 1.0, 0.0);
    row.add(summed->sums + 2, 0.0, 0.0, 1.0);
    if (is_tip) row.add(summed->vertex, 1.0);
  } else {
    add_limit(rings_[corner], 0, row);
  }
  PatchRowsOfWeights rows(3 * column_count, 0.0);
  for (const StencilRow::Entry& entry : row.entries()) {
    rows[entry.index] += entry.weight;
    rows[column_count + entry.index] += entry.du;
    rows[2 * column_count + entry.index] += entry.dv;
  }
  return rows;
}

PatchClass PatchRings::quarter_class(int quarter) const {
  PatchClass result{kinds_[quarter], static_cast<std::int32_t>(rings_[quarter].faces.size()),
                    own_[quarter], 4};
  if (summed_[quarter]) {
    result.ring_size = quarter == 0 ? class_.ring_size : class_.face_size;
    result.has_ring_sums = true;
  }
  return result;
}

std::span<const std::int32_t> PatchRings::ring_columns(int quarter) const {
  const VertexRing& ring = rings_[quarter];
  if (ring.kind != VertexKind::Smooth || own_[quarter] != 0) return {};
  return ring.faces;
}

void PatchRings::visit_ring_points(int quarter, const FaceWeights& weights,
                                   const UseRow& use) const {
  RowMaker make(*this, weights, use);
  make.face(quarter, 0);
  if (const std::optional<Summed>& summed = summed_[quarter]) {
    make.face(quarter, 1);
    make.face(quarter, -1);
    make.sums(*summed);
    return;
  }
  for (std::int32_t i = 0; i < quarter_class(quarter).ring_size; ++i) {
    if (i != own_[quarter]) make.face(quarter, i - own_[quarter]);
  }
}

void PatchRings::visit_further_points(int quarter, const FaceWeights& weights,
                                      const UseRow& use) const {
  RowMaker make(*this, weights, use);
  const PatchClass quarter_class = this->quarter_class(quarter);
  if (quarter_class.has_ring_sums && quarter_class.curve_count() == 1) {
    make.curve(quarter, quarter_class.is_trailing_sharp());
  } else {
    for (std::int32_t i = 0; i < quarter_class.curve_count(); ++i) make.curve(quarter, i == 1);
  }
  if (quarter_class.has_vertex()) make.point(class_.vertex_column());
  const int next = (quarter + 1) % 4, previous = (quarter + 3) % 4;
  for (int j = 1; j < 4; ++j) make.face((quarter + j) % 4, 0);
  if (sharp_[quarter]) {
    make.curve(next, true);
  } else {
    make.face(next, 1);
  }
  if (sharp_[previous]) {
    make.curve(previous, false);
  } else {
    make.face(previous, -1);
  }
}

void PatchRings::visit_quarter_points(int quarter, const FaceWeights& weights,
                                      const UseRow& use) const {
  visit_ring_points(quarter, weights, use);
  visit_further_points(quarter, weights, use);
}

namespace {

// Based on: Doo & Sabin 1978; "Smooth Surface Reconstruction using Doo-Sabin Subdivision Surfaces",
// equation (1). Curve points: the uniform quadratic B-spline of a sharp polyline.

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
    return glm::dvec2(portable::cos(angle), portable::sin(angle));
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
