#include <cmath>

#include "make_scenes/bust.h"
#include "make_scenes/implicit.h"

namespace planish::shapes {

namespace {

double skull(const glm::dvec3& p) {
  double head = Ellipsoid{{0.0, 0.16, -0.08}, {0.43, 0.47, 0.53}}(p);
  head = smooth_union(head, Ellipsoid{{0.0, -0.16, 0.10}, {0.335, 0.43, 0.365}}(p), 0.15);
  head = smooth_union(head, Cone{{0.0, -0.41, 0.22}, {0.22, -0.30, 0.0}, 0.14, 0.13}(p), 0.12);
  head = smooth_union(head, Ellipsoid{{0.0, -0.50, 0.31}, {0.14, 0.095, 0.115}}(p), 0.10);
  head = smooth_union(head, Ellipsoid{{0.2, -0.10, 0.29}, {0.13, 0.11, 0.13}}(p), 0.10);
  return smooth_union(head, Ellipsoid{{0.0, 0.30, 0.22}, {0.27, 0.20, 0.215}}(p), 0.12);
}

double with_eyes(double head, const glm::dvec3& p) {
  const double brow = Cone{{0.045, 0.075, 0.455}, {0.26, 0.145, 0.335}, 0.055, 0.045}(p);
  head = smooth_union(head, brow, 0.05);
  head = smooth_difference(head, Ellipsoid{{0.16, 0.0, 0.50}, {0.105, 0.075, 0.12}}(p), 0.06);
  const double ball = Ellipsoid{{0.155, -0.005, 0.355}, {0.088, 0.08, 0.088}}(p);
  head = smooth_union(head, ball, 0.02);
  const double upper_lid = Cone{{0.085, 0.03, 0.425}, {0.225, 0.025, 0.385}, 0.026, 0.026}(p);
  const double lower_lid = Cone{{0.09, -0.06, 0.415}, {0.22, -0.055, 0.38}, 0.02, 0.02}(p);
  head = smooth_union(head, upper_lid, 0.04);
  return smooth_union(head, lower_lid, 0.03);
}

double with_nose(double head, const glm::dvec3& p) {
  const double bridge = Cone{{0.0, 0.10, 0.445}, {0.0, -0.10, 0.555}, 0.036, 0.062}(p);
  head = smooth_union(head, bridge, 0.05);
  head = smooth_union(head, Ellipsoid{{0.0, -0.115, 0.565}, {0.06, 0.055, 0.055}}(p), 0.03);
  return smooth_union(head, Ellipsoid{{0.058, -0.128, 0.50}, {0.042, 0.042, 0.06}}(p), 0.035);
}

double with_mouth(double head, const glm::dvec3& p) {
  head = smooth_union(head, Ellipsoid{{0.0, -0.295, 0.345}, {0.17, 0.125, 0.11}}(p), 0.06);
  const double upper_lip = Cone{{0.0, -0.252, 0.440}, {0.12, -0.292, 0.375}, 0.042, 0.024}(p);
  const double lower_lip = Cone{{0.0, -0.345, 0.428}, {0.095, -0.338, 0.385}, 0.048, 0.032}(p);
  head = smooth_union(head, upper_lip, 0.03);
  head = smooth_union(head, lower_lip, 0.03);
  const double gap = Cone{{0.0, -0.297, 0.487}, {0.15, -0.312, 0.405}, 0.016, 0.012}(p);
  head = smooth_difference(head, gap, 0.04);
  const double below = Cone{{0.0, -0.412, 0.485}, {0.08, -0.408, 0.445}, 0.03, 0.02}(p);
  return smooth_difference(head, below, 0.06);
}

}  // namespace

double bust_face(const glm::dvec3& p) {
  const glm::dvec3 half(std::abs(p.x), p.y, p.z);  // both sides alike
  double head = skull(half);
  head = with_eyes(head, half);
  head = with_nose(head, half);
  head = with_mouth(head, half);
  double ear = Ellipsoid{{0.425, -0.03, -0.02}, {0.05, 0.13, 0.085}}(half);
  ear = smooth_difference(ear, Ellipsoid{{0.48, -0.02, 0.0}, {0.035, 0.07, 0.045}}(half), 0.03);
  return smooth_union(head, ear, 0.04);
}

}  // namespace planish::shapes
