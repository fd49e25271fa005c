#include "planish/doosabin/subdivision.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace planish {
namespace {

constexpr Weights kBoth[] = {Weights::DooSabin, Weights::Averaged};

TEST(FaceWeights, SumToOneAndAreSymmetric) {
  for (const Weights weights : kBoth) {
    for (int m = 2; m <= 70; ++m) {
      const auto c = face_weights(weights, m);
      EXPECT_NEAR(std::accumulate(c.begin(), c.end(), 0.0), 1.0, 1e-14);
      for (int j = 1; j < m; ++j) EXPECT_NEAR(c[j], c[m - j], 1e-15);
    }
  }
}

TEST(FaceWeights, AgreeOnQuads) {
  // 9/16, 3/16, 1/16, 3/16: biquadratic B-splines.
  for (const Weights weights : kBoth) {
    const auto c = face_weights(weights, 4);
    EXPECT_DOUBLE_EQ(c[0], 9.0 / 16);
    EXPECT_DOUBLE_EQ(c[1], 3.0 / 16);
    EXPECT_DOUBLE_EQ(c[2], 1.0 / 16);
    EXPECT_DOUBLE_EQ(c[3], 3.0 / 16);
  }
}

TEST(FaceWeights, OfATriangle) {
  // Averaged: (vertex + centroid + two edge midpoints) / 4 = 1/4 + 1/12 + 1/4, 1/12 + 1/8.
  EXPECT_DOUBLE_EQ(face_weights(Weights::Averaged, 3)[0], 7.0 / 12);
  EXPECT_DOUBLE_EQ(face_weights(Weights::Averaged, 3)[1], 5.0 / 24);
  // 1978: (3 + 5) / 12 and (3 + 2 cos 120) / 12.
  EXPECT_DOUBLE_EQ(face_weights(Weights::DooSabin, 3)[0], 2.0 / 3);
  EXPECT_NEAR(face_weights(Weights::DooSabin, 3)[1], 1.0 / 6, 1e-15);
}

TEST(FaceWeights, SmallestEigenvalueIsTheCirculants) {
  for (const Weights weights : kBoth) {
    for (int m = 3; m <= 40; ++m) {
      const auto c = face_weights(weights, m);
      double smallest = 1;
      for (int k = 0; k < m; ++k) {
        double eigenvalue = 0;
        for (int j = 0; j < m; ++j) {
          eigenvalue += c[j] * std::cos(2 * std::numbers::pi * j * k / m);
        }
        smallest = std::min(smallest, eigenvalue);
      }
      EXPECT_NEAR(smallest_face_eigenvalue(weights, m), smallest, 1e-13) << m;
    }
  }
}

}  // namespace
}  // namespace planish
