// Based on: Pinkall & Polthier 1993 for the bending, see quality_sum.cpp, of which this is the
// same arithmetic for many quads at once; atan by its series after one halving of the range.
#include "planish/surface/quad_figures.h"

#include <cmath>

#include "planish/core/widest.h"

namespace planish {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kTangentOfEighth = 0.41421356237309503;  // tan(pi / 8)

// Of 0 to 1, within 3e-9.
PLANISH_IN_LINE double arc_tangent(double t) {
  const bool large = t > kTangentOfEighth;
  const double u = large ? (t - 1) / (t + 1) : t;
  const double v = u * u;
  double sum = 1.0 / 17;
  sum = 1.0 / 15 - v * sum;
  sum = 1.0 / 13 - v * sum;
  sum = 1.0 / 11 - v * sum;
  sum = 1.0 / 9 - v * sum;
  sum = 1.0 / 7 - v * sum;
  sum = 1.0 / 5 - v * sum;
  sum = 1.0 / 3 - v * sum;
  sum = u - u * v * sum;
  return large ? kPi / 4 + sum : sum;
}

PLANISH_IN_LINE double squared(double x, double y, double z) { return x * x + y * y + z * z; }

struct Edge {
  double x, y, z, turn;  // turn: squared difference of the normals
};

PLANISH_IN_LINE Edge edge_of(const QuadBatch& q, int i, int from, int to) {
  const double tx = q.normal[to][0][i] - q.normal[from][0][i];
  const double ty = q.normal[to][1][i] - q.normal[from][1][i];
  const double tz = q.normal[to][2][i] - q.normal[from][2][i];
  return {q.position[to][0][i] - q.position[from][0][i],
          q.position[to][1][i] - q.position[from][1][i],
          q.position[to][2][i] - q.position[from][2][i], squared(tx, ty, tz)};
}

PLANISH_IN_LINE double dot(const Edge& a, const Edge& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

// Edges in a circle.
PLANISH_IN_LINE double lane_bending(const Edge& a, const Edge& b, const Edge& c) {
  const double nx = a.y * b.z - a.z * b.y, ny = a.z * b.x - a.x * b.z, nz = a.x * b.y - a.y * b.x;
  const double double_area = std::sqrt(squared(nx, ny, nz));
  const double perimeter = std::sqrt(dot(a, a)) + std::sqrt(dot(b, b)) + std::sqrt(dot(c, c));
  const bool thin = double_area <= kThinTriangle * perimeter * perimeter;
  const double sum = -dot(b, c) * a.turn - dot(c, a) * b.turn - dot(a, b) * c.turn;
  return thin ? 0.0 : 0.5 * sum / double_area;
}

PLANISH_IN_LINE Edge reversed(const Edge& e) { return {-e.x, -e.y, -e.z, e.turn}; }

// a where `first`, else b.
PLANISH_IN_LINE Edge either(bool first, const Edge& a, const Edge& b) {
  return {first ? a.x : b.x, first ? a.y : b.y, first ? a.z : b.z, first ? a.turn : b.turn};
}

PLANISH_IN_LINE double quad_bending(const QuadBatch& q, int i) {
  const Edge e01 = edge_of(q, i, 0, 1), e12 = edge_of(q, i, 1, 2), e23 = edge_of(q, i, 2, 3),
             e30 = edge_of(q, i, 3, 0), even = edge_of(q, i, 0, 2), odd = edge_of(q, i, 1, 3);
  // Cut along the shorter diagonal.
  const bool turned = dot(odd, odd) < dot(even, even);
  const Edge cut = either(turned, odd, even);
  return lane_bending(either(turned, e12, e01), either(turned, e23, e12), reversed(cut)) +
         lane_bending(cut, either(turned, e30, e23), either(turned, e01, e30));
}

}  // namespace

// A coordinate at a time, so that what is stored comes as vectors.
PLANISH_WIDEST void take_corners(const double* positions, const float* normals, QuadBatch& quads) {
  constexpr int kNumbers = 12;
  double* const position = &quads.position[0][0][0];
  double* const normal = &quads.normal[0][0][0];
  for (int j = 0; j < kNumbers; ++j) {
    for (int i = 0; i < kQuadLanes; ++i) {
      position[j * kQuadLanes + i] = positions[kNumbers * i + j];
      normal[j * kQuadLanes + i] = static_cast<double>(normals[kNumbers * i + j]);
    }
  }
}

PLANISH_WIDEST void measure_quads(const QuadBatch& q, QuadFigures& figures) {
  for (int i = 0; i < kQuadLanes; ++i) {
    // The area vector is half the cross product of the diagonals.
    const Edge even = edge_of(q, i, 0, 2), odd = edge_of(q, i, 1, 3);
    const double nx = even.y * odd.z - even.z * odd.y, ny = even.z * odd.x - even.x * odd.z,
                 nz = even.x * odd.y - even.y * odd.x;
    figures.area[i] = 0.5 * std::sqrt(squared(nx, ny, nz));
    figures.folded[i] = figures.squares[i] = figures.largest[i] = 0;
  }
  for (int k = 0; k < 4; ++k) {
    for (int i = 0; i < kQuadLanes; ++i) {
      const double x = q.normal[k][0][i], y = q.normal[k][1][i], z = q.normal[k][2][i];
      const double wx = q.wanted[0][i], wy = q.wanted[1][i], wz = q.wanted[2][i];
      const double share = 0.25 * figures.area[i];
      // tan(angle / 2) of unit vectors.
      const double apart = squared(x - wx, y - wy, z - wz);
      const double together = squared(x + wx, y + wy, z + wz);
      const bool turned = apart > together;
      const double half = arc_tangent(std::sqrt(turned ? together / apart : apart / together));
      const double angle = turned ? kPi - 2 * half : 2 * half;
      figures.folded[i] += turned ? share : 0.0;
      figures.squares[i] += share * angle * angle;
      figures.largest[i] = angle > figures.largest[i] ? angle : figures.largest[i];
    }
  }
  for (int i = 0; i < kQuadLanes; ++i) figures.bending[i] = quad_bending(q, i);
}

}  // namespace planish
