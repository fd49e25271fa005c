// The continuation rules of polygons of control points around a vertex, a derivation of our own.
// Names: x_i face control points, w0 and w1 curve control points before and after a sector of k
// faces, V a corner's position, theta_i = pi (2i - 1) / (2k) the angle of face i in a half plane,
// b_i the affine image of a regular half ring, a_i = x_i - b_i, A = (a_1..a_k, -a_k..-a_1) its odd
// extension across the sharp curve.
#include "planish/doosabin/sector_rules.h"

#include <cmath>
#include <numbers>

#include "planish/core/assert.h"

namespace planish {

namespace {

constexpr double kPi = std::numbers::pi;

// The unit vectors at angles 2 pi i / n.
struct RegularPolygon {
  explicit RegularPolygon(std::int32_t n) {
    for (std::int32_t i = 0; i < n; ++i) {
      const double angle = 2 * kPi * i / n;
      cosines.push_back(std::cos(angle));
      sines.push_back(std::sin(angle));
    }
    // Two opposite points span no plane: rounding must not make one up.
    if (n == 2) sines = {0, 0};
  }
  std::vector<double> cosines, sines;
};

// Nearly all rings of a surface are quads: computing sines anew would be the dearest part of
// their rows.
const RegularPolygon& regular_quad() {
  static const RegularPolygon quad(4);
  return quad;
}

double half_plane_angle(std::int32_t i, std::int32_t k) { return kPi * (2 * i + 1) / (2.0 * k); }

// b_i = (1/2 + q_i) w0 + (1/2 - q_i) w1 with this q_i.
double half_plane_offset(std::int32_t i, std::int32_t k) {
  return std::cos(half_plane_angle(i, k)) / std::numbers::sqrt2;
}

struct HalfPlaneRule {
  const FaceWeights& face_weights;
  const VertexRing& ring;
  const VertexRing::Sector& sector;

  // base_share: how much of the even part's b_i and of the point it contracts to is taken; the
  // rest of the unit comes from w0, w1 (creases) or V (corners).
  void add(std::int32_t i, double scale, std::vector<double>& scratch, StencilRow& row) const {
    const std::int32_t k = sector.count;
    // A single face has a ring of two, for which the general weights would not halve the odd part
    // as the curve halves the even one: a flat grid would fold.
    static constexpr double kSingleFace[] = {0.75, 0.25};
    const auto c = k == 1 ? std::span<const double>(kSingleFace) : face_weights.of(2 * k, scratch);
    const double q_i = half_plane_offset(i, k);
    double w0 = 0, w1 = 0;
    if (ring.kind == VertexKind::Corner) {  // (b_i + V) / 2
      row.add(ring.corner_point, scale / 2);
      w0 = (0.5 + q_i) / 2;
      w1 = (0.5 - q_i) / 2;
    } else {  // Lc + (b_i - Lc) / 2 with Lc = (w0 + w1) / 2
      w0 = 0.5 + q_i / 2;
      w1 = 0.5 - q_i / 2;
    }
    for (std::int32_t j = 0; j < k; ++j) {
      const std::int32_t mirrored = 2 * k - 1 - j;
      const double g = c[std::abs(j - i)] - c[mirrored - i];
      row.add(ring.faces[sector.first + j], scale * g);
      const double q_j = half_plane_offset(j, k);
      w0 -= g * (0.5 + q_j);
      w1 -= g * (0.5 - q_j);
    }
    row.add(sector.curve0, scale * w0);
    row.add(sector.curve1, scale * w1);
  }
};

// b_i = V + alpha (w0 - V) + beta (w1 - V), a circular fan over the sector's opening;
// x'_i = (b_i + V) / 2 + (x_i - b_i) / 4.
void add_refined_fan_face(const VertexRing& ring, const VertexRing::Sector& sector, std::int32_t i,
                          double scale, StencilRow& row) {
  const double opening = sector.corner == CornerSector::Reflex ? 1.5 * kPi : 0.5 * kPi;
  const double t = (i + 0.5) / sector.count;
  const double alpha = std::numbers::sqrt2 * std::sin((1 - t) * opening) / std::sin(opening);
  const double beta = std::numbers::sqrt2 * std::sin(t * opening) / std::sin(opening);
  row.add(ring.faces[sector.first + i], scale / 4);
  row.add(sector.curve0, scale * alpha / 4);
  row.add(sector.curve1, scale * beta / 4);
  row.add(ring.corner_point, scale * (0.5 + (1 - alpha - beta) / 4));
}

void add_refined_ring_face(const FaceWeights& face_weights, const VertexRing& ring, std::int32_t i,
                           double scale, std::vector<double>& scratch, StencilRow& row) {
  const auto n = static_cast<std::int32_t>(ring.faces.size());
  const auto c = face_weights.of(n, scratch);
  // A tagged vertex without sharp edges is the tip of a cone: its ring shrinks towards V at the
  // rate of its shape, 1/2, instead of keeping its mean.
  const bool cone = ring.kind == VertexKind::Corner;
  const double towards_mean = cone ? -0.5 / n : 0.0;
  for (std::int32_t j = 0; j < n; ++j) {
    row.add(ring.faces[j], scale * (c[(j - i + n) % n] + towards_mean));
  }
  if (cone) row.add(ring.corner_point, scale / 2);
}

void add_sector_limit(const VertexRing& ring, const VertexRing::Sector& sector, StencilRow& row) {
  const bool corner = ring.kind == VertexKind::Corner;
  if (corner && sector.corner != CornerSector::HalfPlane) {
    // du x dv is outward while the opening is below pi; reversed beyond.
    const double sign = sector.corner == CornerSector::Reflex ? -1.0 : 1.0;
    row.add(ring.corner_point, 1.0, -1.0, -sign);
    row.add(sector.curve0, 0.0, 1.0, 0.0);
    row.add(sector.curve1, 0.0, 0.0, sign);
    return;
  }
  const std::int32_t k = sector.count;
  double w0 = 0, w1 = 0;
  for (std::int32_t j = 0; j < k; ++j) {
    const double s = std::sin(half_plane_angle(j, k));
    const double q = half_plane_offset(j, k);
    row.add(ring.faces[sector.first + j], 0.0, 0.0, s);
    w0 -= s * (0.5 + q);
    w1 -= s * (0.5 - q);
  }
  const double curve_share = corner ? 0.0 : 0.5;
  row.add(sector.curve0, curve_share, 1.0, w0);
  row.add(sector.curve1, curve_share, -1.0, w1);
  if (corner) row.add(ring.corner_point, 1.0);
}

}  // namespace

void add_refined_face(const FaceWeights& face_weights, const VertexRing& ring, std::int32_t i,
                      double scale, std::vector<double>& weights_scratch, StencilRow& row) {
  for (const VertexRing::Sector& sector : ring.sectors) {
    const std::int32_t place = i - sector.first;
    if (place < 0 || place >= sector.count) continue;
    if (ring.kind == VertexKind::Corner && sector.corner != CornerSector::HalfPlane) {
      add_refined_fan_face(ring, sector, place, scale, row);
    } else {
      HalfPlaneRule{face_weights, ring, sector}.add(place, scale, weights_scratch, row);
    }
    return;
  }
  add_refined_ring_face(face_weights, ring, i, scale, weights_scratch, row);
}

void add_refined_curve_point(const FaceWeights& face_weights, const VertexRing& ring,
                             std::int32_t own, std::vector<double>& weights_scratch,
                             StencilRow& row) {
  const auto n = static_cast<std::int32_t>(ring.faces.size());
  switch (ring.kind) {
    case VertexKind::Dart:
      add_refined_face(face_weights, ring, ring.dart_face, 0.5, weights_scratch, row);
      add_refined_face(face_weights, ring, (ring.dart_face + n - 1) % n, 0.5, weights_scratch, row);
      return;
    case VertexKind::Corner:
      row.add(own, 0.5);
      row.add(ring.corner_point, 0.5);
      return;
    case VertexKind::Crease: {
      const auto& sector = ring.sectors.front();
      row.add(own, 0.75);
      row.add(sector.curve0 == own ? sector.curve1 : sector.curve0, 0.25);
      return;
    }
    case VertexKind::Smooth:
      break;
  }
  PLANISH_ASSERT(!"a sharp edge ends at a smooth vertex");
}

void add_limit(const VertexRing& ring, std::int32_t sector, StencilRow& row) {
  if (!ring.sectors.empty()) {
    add_sector_limit(ring, ring.sectors[sector], row);
    return;
  }
  const auto n = static_cast<std::int32_t>(ring.faces.size());
  const bool cone = ring.kind == VertexKind::Corner;
  const double share = cone ? 0.0 : 1.0 / n;
  const auto add = [&](const RegularPolygon& polygon) {
    for (std::int32_t i = 0; i < n; ++i) {
      row.add(ring.faces[i], share, polygon.cosines[i], polygon.sines[i]);
    }
  };
  if (n == 4) {
    add(regular_quad());
  } else {
    add(RegularPolygon(n));
  }
  if (cone) row.add(ring.corner_point, 1.0);
}

}  // namespace planish
