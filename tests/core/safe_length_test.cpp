#include "planish/core/vectors.h"

#include <gtest/gtest.h>

#include <limits>

namespace planish {
namespace {

TEST(SafeLength, IsInfiniteWhereACoordinateIsNoNumber) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  for (const double none : {kNan, kInfinite, -kInfinite})
    for (int place = 0; place < 3; ++place) {
      glm::dvec3 vector(0.0);
      vector[place] = none;
      EXPECT_EQ(safe_length(vector), kInfinite) << none << " at " << place;
    }
}

TEST(SafeLength, NeitherOverflowsNorUnderflows) {
  EXPECT_DOUBLE_EQ(safe_length({3e300, 0, -4e300}), 5e300);
  EXPECT_DOUBLE_EQ(safe_length({3e-300, 4e-300, 0}), 5e-300);
  EXPECT_EQ(safe_length({0, 0, 0}), 0);
}

}  // namespace
}  // namespace planish
