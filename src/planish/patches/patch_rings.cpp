// One step of Doo-Sabin subdivision cuts a patch into four, which are patches of classes again when
// each is seen from its own corner: so the rules of the rings are all there is to know.
#include "planish/patches/patch_rings.h"

#include "planish/doosabin/sector_rules.h"
#include "planish/stencil/stencil_builder.h"

namespace planish {

namespace {

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

// Rows of points after a step, in the columns of `patch`.
struct RowMaker {
  const FaceWeights& weights;
  const PatchClass& patch;
  const PatchRings::UseRow& use;
  std::vector<double> scratch{};
  StencilRow row{};
  PatchRowsOfWeights dense{};

  void face(const VertexRing& ring, std::int32_t place) {
    row.clear();
    add_refined_face(weights, ring, place, 1.0, scratch, row);
    hand_over();
  }
  // The one before a ring's sector or behind it; a dart has one.
  void curve(const VertexRing& ring, bool behind) {
    std::int32_t own = patch.curve_column(0);
    if (!ring.sectors.empty()) {
      const VertexRing::Sector& sector = ring.sectors.front();
      own = behind ? sector.curve1 : sector.curve0;
    }
    row.clear();
    add_refined_curve_point(weights, ring, own, scratch, row);
    hand_over();
  }
  void point(std::int32_t column) {
    row.clear();
    row.add(column, 1.0);
    hand_over();
  }
  void hand_over() {
    dense.assign(static_cast<std::size_t>(patch.column_count()), 0.0);
    for (const StencilRow::Entry& entry : row.entries()) dense[entry.index] += entry.weight;
    use(dense);
  }
};

}  // namespace

PatchRings::PatchRings(const PatchClass& patch)
    : class_(patch), kinds_{patch.kind}, own_{patch.place}, sharp_{} {
  rings_[0] = ring_at_vertex(patch);
  if (patch.is_limit_only()) return;
  const std::int32_t k = patch.ring_size, m = patch.face_size;
  const std::int32_t e1 = patch.leading_column(), e2 = patch.trailing_column();
  sharp_ = {patch.is_leading_sharp(), false, false, patch.is_trailing_sharp()};
  std::vector<std::int32_t> face(static_cast<std::size_t>(m), 0);
  for (std::int32_t i = 1; i < m; ++i) face[i] = patch.ring_column(i);
  rings_[2] = smooth_ring(face);
  rings_[1] = sharp_[0]
                  ? crease_ring(face[1], 0, e1, patch.curve_column(0))
                  : smooth_ring({0, patch.face_column((patch.place + k - 1) % k), e1, face[1]});
  rings_[3] = sharp_[3]
                  ? crease_ring(0, face[m - 1], patch.curve_column(1), e2)
                  : smooth_ring({0, face[m - 1], e2, patch.face_column((patch.place + 1) % k)});
  own_ = {patch.place, sharp_[0] ? 1 : 0, 0, 0};
  kinds_ = {patch.kind, sharp_[0] ? PatchKind::Crease : PatchKind::Smooth, PatchKind::Smooth,
            sharp_[3] ? PatchKind::Crease : PatchKind::Smooth};
}

std::int32_t PatchRings::place(int corner, std::int32_t offset) const {
  const auto n = static_cast<std::int32_t>(rings_[corner].faces.size());
  return (own_[corner] + offset + n) % n;
}

PatchRowsOfWeights PatchRings::limit(int corner) const {
  const auto column_count = static_cast<std::size_t>(class_.column_count());
  StencilRow row;
  add_limit(rings_[corner], 0, row);
  PatchRowsOfWeights rows(3 * column_count, 0.0);
  for (const StencilRow::Entry& entry : row.entries()) {
    rows[entry.index] += entry.weight;
    rows[column_count + entry.index] += entry.du;
    rows[2 * column_count + entry.index] += entry.dv;
  }
  return rows;
}

PatchClass PatchRings::quarter_class(int quarter) const {
  return {kinds_[quarter], static_cast<std::int32_t>(rings_[quarter].faces.size()), own_[quarter],
          4};
}

std::span<const std::int32_t> PatchRings::ring_columns(int quarter) const {
  const VertexRing& ring = rings_[quarter];
  if (ring.kind != VertexKind::Smooth || own_[quarter] != 0) return {};
  return ring.faces;
}

void PatchRings::visit_ring_points(int quarter, const FaceWeights& weights,
                                   const UseRow& use) const {
  RowMaker make{weights, class_, use};
  make.face(rings_[quarter], own_[quarter]);
  for (std::int32_t i = 0; i < quarter_class(quarter).ring_size; ++i) {
    if (i != own_[quarter]) make.face(rings_[quarter], i);
  }
}

void PatchRings::visit_further_points(int quarter, const FaceWeights& weights,
                                      const UseRow& use) const {
  RowMaker make{weights, class_, use};
  const PatchClass quarter_class = this->quarter_class(quarter);
  for (std::int32_t i = 0; i < quarter_class.curve_count(); ++i)
    make.curve(rings_[quarter], i == 1);
  if (quarter_class.has_vertex()) make.point(rings_[quarter].corner_point);
  const int next = (quarter + 1) % 4, previous = (quarter + 3) % 4;
  for (int j = 1; j < 4; ++j) {
    const int corner = (quarter + j) % 4;
    make.face(rings_[corner], own_[corner]);
  }
  if (sharp_[quarter]) {
    make.curve(rings_[next], true);
  } else {
    make.face(rings_[next], place(next, 1));
  }
  if (sharp_[previous]) {
    make.curve(rings_[previous], false);
  } else {
    make.face(rings_[previous], place(previous, -1));
  }
}

void PatchRings::visit_quarter_points(int quarter, const FaceWeights& weights,
                                      const UseRow& use) const {
  visit_ring_points(quarter, weights, use);
  visit_further_points(quarter, weights, use);
}

}  // namespace planish
