#pragma once

#include <cstring>
#include <glm/vec3.hpp>

namespace planish {

/// A weighted sum of vectors, x and y in one register: the bits of the sums of each coordinate, in
/// two thirds of the instructions.
class VectorSum {
 public:
  void add(double weight, const glm::dvec3& vector) {
    Pair pair;
    std::memcpy(&pair, &vector.x, sizeof pair);
    xy_ += weight * pair;
    z_ += weight * vector.z;
  }
  void add(double weight, const VectorSum& other) {
    xy_ += weight * other.xy_;
    z_ += weight * other.z_;
  }
  [[nodiscard]] glm::dvec3 value() const { return {xy_[0], xy_[1], z_}; }

 private:
  typedef double Pair __attribute__((vector_size(16)));

  Pair xy_{0, 0};
  double z_ = 0;
};

}  // namespace planish
