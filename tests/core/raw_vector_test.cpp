#include "planish/core/raw_vector.h"

#include <gtest/gtest.h>

namespace planish {
namespace {

TEST(RawVector, FillsOnlyWhereAValueIsGiven) {
  RawVector<float> numbers;
  numbers.resize(3, 2.5f);
  numbers.resize(5, 0.0f);
  EXPECT_EQ(numbers, (RawVector<float>{2.5f, 2.5f, 2.5f, 0.0f, 0.0f}));

  // Memory that is at hand already keeps what was written to it.
  numbers.clear();
  numbers.resize(3);
  EXPECT_EQ(numbers[1], 2.5f);
}

}  // namespace
}  // namespace planish
