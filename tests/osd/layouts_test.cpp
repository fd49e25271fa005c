// The comparison of the conformance test notices what it is for.
#include "osd/layouts.h"

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <limits>

namespace planish::testing {
namespace {

TEST(OsdTally, NoticesAFloatThatIsOff) {
  EXPECT_NONFATAL_FAILURE(Tally().compare("off", {{4, 2, 1}}, {{4, 2, 1.00001f}}), "off");
  EXPECT_NONFATAL_FAILURE(
      Tally().compare("nan", {{4}}, {{std::numeric_limits<float>::quiet_NaN()}}), "nan");
  EXPECT_NONFATAL_FAILURE(Tally().compare("zero", {{0, 0}}, {{0, 1e-30f}}), "zero");
  EXPECT_FATAL_FAILURE(Tally().compare("short", {{1, 2}}, {{1}}), "short");
}

TEST(OsdTally, CountsAndMeasures) {
  Tally tally;
  tally.compare("near", {{4, 2}, {1}}, {{4, 2.000001f}, {1}});
  EXPECT_EQ(tally.floats, 3);
  EXPECT_NEAR(tally.largest, 1e-6 / 4, 1e-7);
}

}  // namespace
}  // namespace planish::testing
