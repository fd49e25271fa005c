// Source: M. Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008, section 4.
#include "planish/files/gltf/tangent_batch.h"

#include <cmath>

#include "planish/core/widest.h"

namespace planish {

namespace {

constexpr double kPi = 3.14159265358979323846;

struct Vector {
  double x, y, z;
};

PLANISH_IN_LINE double dot(const Vector& a, const Vector& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

PLANISH_IN_LINE Vector scaled_to_one(const Vector& v) {
  const double length = std::sqrt(dot(v, v));
  const double scale = 1 / length;
  const bool has = length > 0;
  return {has ? v.x * scale : 0.0, has ? v.y * scale : 0.0, has ? v.z * scale : 0.0};
}

// An angle by its cosine, within 2e-8: Abramowitz and Stegun, "Handbook of Mathematical Functions",
// 4.4.46. It is a weight.
PLANISH_IN_LINE double angle_of(double cosine) {
  const double size = std::abs(cosine), x = size < 1 ? size : 1.0;
  const double shape =
      1.5707963050 +
      x * (-0.2145988016 +
           x * (0.0889789874 +
                x * (-0.0501743046 +
                     x * (0.0308918810 +
                          x * (-0.0170881256 + x * (0.0066700901 - x * 0.0012624911))))));
  const double angle = std::sqrt(1 - x) * shape;
  return cosine < 0 ? kPi - angle : angle;
}

using Lane = double[kTangentLanes];

PLANISH_IN_LINE Vector of_lane(const Lane* lanes, int i) {
  return {lanes[0][i], lanes[1][i], lanes[2][i]};
}

PLANISH_IN_LINE Vector difference(const Lane* from, const Lane* to, int i) {
  return {to[0][i] - from[0][i], to[1][i] - from[1][i], to[2][i] - from[2][i]};
}

// Between two directions, both seen along a normal.
PLANISH_IN_LINE double angle_between(const Vector& a, const Vector& b, const Vector& normal) {
  const double up_a = dot(normal, a), up_b = dot(normal, b);
  const double square = (dot(a, a) - up_a * up_a) * (dot(b, b) - up_b * up_b);
  const double cosine = (dot(a, b) - up_a * up_b) / std::sqrt(square);
  return angle_of(square > 0 ? cosine : 0.0);
}

// At the corner `here`, from which edges go to `next` and `last`; `to`: as TangentSums has it.
PLANISH_IN_LINE void measure_corner(const Lane* here, const Lane* next, const Lane* last,
                                    const Lane* normals, const Lane* directions, Lane* to) {
  Lane x, y, z;  // which nothing else can be, so that the loop becomes vectors
  for (int i = 0; i < kTangentLanes; ++i) {
    const Vector normal = of_lane(normals, i), u = of_lane(directions, i);
    const double angle =
        angle_between(difference(here, next, i), difference(here, last, i), normal);
    const double up = dot(normal, u);
    const Vector flat =
        scaled_to_one({u.x - normal.x * up, u.y - normal.y * up, u.z - normal.z * up});
    x[i] = angle * flat.x, y[i] = angle * flat.y, z[i] = angle * flat.z;
  }
  for (int i = 0; i < kTangentLanes; ++i) to[0][i] = x[i], to[1][i] = y[i], to[2][i] = z[i];
}

}  // namespace

PLANISH_WIDEST void measure_tangents(const TangentBatch& t, TangentSums& sums) {
  const auto& p = t.position;
  Lane along[3];
  for (int i = 0; i < kTangentLanes; ++i) {
    const double sx = t.uv[1][0][i] - t.uv[0][0][i], sy = t.uv[1][1][i] - t.uv[0][1][i];
    const double tx = t.uv[2][0][i] - t.uv[0][0][i], ty = t.uv[2][1][i] - t.uv[0][1][i];
    const double area = sx * ty - sy * tx;
    const Vector a = difference(p[0], p[1], i), b = difference(p[0], p[2], i);
    const double x = ty * a.x - sy * b.x, y = ty * a.y - sy * b.y, z = ty * a.z - sy * b.z;
    const bool is_mirrored = area < 0;
    const Vector u =
        scaled_to_one({is_mirrored ? -x : x, is_mirrored ? -y : y, is_mirrored ? -z : z});
    along[0][i] = u.x, along[1][i] = u.y, along[2][i] = u.z;
    sums.area[i] = area;
  }
  // One after another: a loop over them would keep what is within from becoming vectors.
  measure_corner(p[0], p[1], p[2], t.normal[0], along, sums.along[0]);
  measure_corner(p[1], p[2], p[0], t.normal[1], along, sums.along[1]);
  measure_corner(p[2], p[0], p[1], t.normal[2], along, sums.along[2]);
}

}  // namespace planish
