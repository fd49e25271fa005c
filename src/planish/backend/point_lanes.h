#pragma once

#include <glm/vec3.hpp>

namespace planish {

/// A point in registers of 16 bytes, which every x86-64 and ARM has: one of four floats or two of
/// two doubles, the last lane idle. A row's sum is a chain of multiply-adds on whole registers.
/// (Wider vectors than the machine's go through memory with GCC 12, at a third of the speed.)
template <class Real>
struct PointLanes;

template <>
struct PointLanes<float> {
  typedef float Register __attribute__((vector_size(16)));
  Register xyz0;

  static PointLanes of(const glm::dvec3& v) {
    return {Register{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z), 0}};
  }
  [[nodiscard]] glm::dvec3 point() const { return {xyz0[0], xyz0[1], xyz0[2]}; }
  [[nodiscard]] PointLanes<double> in_double() const;
  friend PointLanes operator+(PointLanes a, PointLanes b) { return {a.xyz0 + b.xyz0}; }
  friend PointLanes operator-(PointLanes a, PointLanes b) { return {a.xyz0 - b.xyz0}; }
  friend PointLanes operator*(PointLanes a, PointLanes b) { return {a.xyz0 * b.xyz0}; }
  friend PointLanes operator*(float a, PointLanes b) { return {a * b.xyz0}; }
};

template <>
struct PointLanes<double> {
  typedef double Register __attribute__((vector_size(16)));
  Register xy, z0;

  static PointLanes of(const glm::dvec3& v) { return {Register{v.x, v.y}, Register{v.z, 0}}; }
  [[nodiscard]] glm::dvec3 point() const { return {xy[0], xy[1], z0[0]}; }
  [[nodiscard]] PointLanes in_double() const { return *this; }
  friend PointLanes operator+(PointLanes a, PointLanes b) { return {a.xy + b.xy, a.z0 + b.z0}; }
  friend PointLanes operator-(PointLanes a, PointLanes b) { return {a.xy - b.xy, a.z0 - b.z0}; }
  friend PointLanes operator*(PointLanes a, PointLanes b) { return {a.xy * b.xy, a.z0 * b.z0}; }
  friend PointLanes operator*(double a, PointLanes b) { return {a * b.xy, a * b.z0}; }
};

inline PointLanes<double> PointLanes<float>::in_double() const {
  using Pair = PointLanes<double>::Register;
  return {__builtin_convertvector(__builtin_shufflevector(xyz0, xyz0, 0, 1), Pair),
          __builtin_convertvector(__builtin_shufflevector(xyz0, xyz0, 2, 3), Pair)};
}

}  // namespace planish
