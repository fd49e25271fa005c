// Source: M. Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008, section 4.
#include "planish/files/gltf/tangent_batch.h"

#include <cmath>

#include "planish/core/widest.h"

namespace planish {

namespace {

constexpr float kPi = 3.14159265f;

struct Vector {
  float x, y, z;
};

PLANISH_IN_LINE float dot(const Vector& a, const Vector& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
PLANISH_IN_LINE Vector difference(const Vector& from, const Vector& to) {
  return {to.x - from.x, to.y - from.y, to.z - from.z};
}
PLANISH_IN_LINE Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// An angle by multiples of its sine, which is not negative, and cosine, within 1e-7; 0 of nothing.
// Abramowitz and Stegun, "Handbook of Mathematical Functions", 4.4.49. It is a weight.
PLANISH_IN_LINE float angle_of(float sine, float cosine) {
  const float size = std::abs(cosine);
  const float large = sine > size ? sine : size, small = sine > size ? size : sine;
  const float ratio = small / (large > 0 ? large : 1.0f), x = ratio * ratio;
  const float of_ratio =
      ratio *
      (1.0f +
       x * (-0.3333314528f +
            x * (0.1999355085f +
                 x * (-0.1420889944f +
                      x * (0.1065626393f + x * (-0.0752896400f +
                                                x * (0.0429096138f + x * (-0.0161657367f +
                                                                          x * 0.0028662257f))))))));
  const float of_size = sine > size ? kPi / 2 - of_ratio : of_ratio;
  return cosine < 0 ? kPi - of_size : of_size;
}

struct Corner {
  Vector position, normal;
  float u, v;
};

struct Sum {
  float x, y, z, area;
};

PLANISH_IN_LINE Sum sum_of(const Sum& a, const Sum& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z, a.area + b.area};
}

// `cross`: of two edges of the triangle; `cosine`: the product of those that meet here, which rise
// by `up_a` and `up_b` along the normal.
PLANISH_IN_LINE Sum at_corner(const Vector& normal, const Vector& cross, float cosine, float up_a,
                              float up_b, const Vector& along, float area) {
  const float angle = angle_of(std::abs(dot(normal, cross)), cosine - up_a * up_b);
  const float up = dot(normal, along);
  const Vector flat{along.x - normal.x * up, along.y - normal.y * up, along.z - normal.z * up};
  const float square = dot(flat, flat);
  const float weight = angle / std::sqrt(square > 0 ? square : 1.0f);
  return {flat.x * weight, flat.y * weight, flat.z * weight, area};
}

PLANISH_IN_LINE void measure_triangle(const Corner& a, const Corner& b, const Corner& c, Sum& of_a,
                                      Sum& of_b, Sum& of_c) {
  const Vector ab = difference(a.position, b.position), ac = difference(a.position, c.position),
               bc = difference(b.position, c.position);
  const float sx = b.u - a.u, sy = b.v - a.v, tx = c.u - a.u, ty = c.v - a.v;
  const float area = sx * ty - sy * tx;
  const float way = area < 0 ? -1.0f : 1.0f;
  const Vector along{way * (ty * ab.x - sy * ac.x), way * (ty * ab.y - sy * ac.y),
                     way * (ty * ab.z - sy * ac.z)};
  const Vector n = cross(ab, ac);
  of_a = at_corner(a.normal, n, dot(ab, ac), dot(a.normal, ab), dot(a.normal, ac), along, area);
  of_b = at_corner(b.normal, n, -dot(ab, bc), dot(b.normal, ab), -dot(b.normal, bc), along, area);
  of_c = at_corner(c.normal, n, dot(ac, bc), dot(c.normal, ac), dot(c.normal, bc), along, area);
}

PLANISH_IN_LINE Corner corner_of(const float* a, const float* b, bool takes_b, int i) {
  constexpr int n = kTangentLanes;
  const auto number = [&](int k) __attribute__((always_inline)) {
    const float of_a = a[k * n + i], of_b = b[k * n + i];
    return takes_b ? of_b : of_a;
  };
  return {
      {number(0), number(1), number(2)}, {number(3), number(4), number(5)}, number(6), number(7)};
}

using Lanes = float[4][kTangentLanes];

PLANISH_IN_LINE void put(const Sum& a, const Sum& b, bool takes_b, Lanes& to, int i) {
  to[0][i] = takes_b ? b.x : a.x, to[1][i] = takes_b ? b.y : a.y;
  to[2][i] = takes_b ? b.z : a.z, to[3][i] = takes_b ? b.area : a.area;
}

// The power of two that makes a number up to this about 1, where single precision has it.
float scale_of(float most) {
  int exponent = 0;
  (void)std::frexp(most, &exponent);
  return std::ldexp(1.0f, exponent > -120 ? -exponent : 120);
}

// Of some numbers of all vertices.
PLANISH_IN_LINE void scale(const TangentQuads& quads, int first, int count) {
  float most[kTangentLanes] = {}, scales[kTangentLanes];
  const auto for_numbers = [&](const auto& visit) __attribute__((always_inline)) {
    for (int v = 0; v < quads.vertex_count; ++v)
      for (int k = first; k < first + count; ++k) {
        float* const numbers = quads.vertices + (v * kTangentNumbers + k) * kTangentLanes;
        for (int i = 0; i < kTangentLanes; ++i) visit(numbers[i], i);
      }
  };
  for_numbers([&](float& number, int i) __attribute__((always_inline)) {
    const float size = std::abs(number);
    most[i] = most[i] > size ? most[i] : size;
  });
  for (int i = 0; i < kTangentLanes; ++i) scales[i] = scale_of(most[i]);
  for_numbers([&](float& number, int i) __attribute__((always_inline)) { number *= scales[i]; });
}

}  // namespace

PLANISH_WIDEST void measure_tangents(const TangentQuads& quads, float* sums) {
  constexpr int kVertex = kTangentNumbers * kTangentLanes, kSum = 4 * kTangentLanes;
  scale(quads, 0, 3);
  scale(quads, 6, 2);
  for (int q = 0; q < quads.count; ++q) {
    const unsigned char* at = quads.corners + 4 * q;
    const float* const v0 = quads.vertices + at[0] * kVertex;
    const float* const v1 = quads.vertices + at[1] * kVertex;
    const float* const v2 = quads.vertices + at[2] * kVertex;
    const float* const v3 = quads.vertices + at[3] * kVertex;
    const int* const cuts = quads.cuts + q * kTangentLanes;
    Lanes made[4];  // which nothing else can be, so that the loop becomes vectors
    for (int i = 0; i < kTangentLanes; ++i) {
      // Cut from corner 1 it is the quad that begins there.
      const bool turned = cuts[i] != 0;
      const Corner a = corner_of(v0, v1, turned, i), b = corner_of(v1, v2, turned, i),
                   c = corner_of(v2, v3, turned, i), d = corner_of(v3, v0, turned, i);
      Sum a1, b1, c1, a2, c2, d2;
      measure_triangle(a, b, c, a1, b1, c1);
      measure_triangle(a, c, d, a2, c2, d2);
      const Sum of_a = sum_of(a1, a2), of_c = sum_of(c1, c2);
      put(of_a, d2, turned, made[0], i), put(b1, of_a, turned, made[1], i);
      put(of_c, b1, turned, made[2], i), put(d2, of_c, turned, made[3], i);
    }
    for (int k = 0; k < 4; ++k) {
      float* const sum = sums + at[k] * kSum;
      for (int n = 0; n < 4; ++n)
        for (int i = 0; i < kTangentLanes; ++i) sum[n * kTangentLanes + i] += made[k][n][i];
    }
  }
}

}  // namespace planish
