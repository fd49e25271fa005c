#include "planish/surface/memory_need.h"

#include <gtest/gtest.h>

#include "planish/core/error.h"
#include "support/meshes.h"

namespace planish {
namespace {

TEST(MemoryNeed, GrowsFourfoldWithEachLevel) {
  const QuadSplit split(test::torus(100, 100, 1.0, 0.4));
  const double coarse =
      static_cast<double>(tessellation_bytes(split.counts_to(4), LastLevel::FacesOnly) -
                          tessellation_bytes(split.counts_to(3), LastLevel::FacesOnly));
  const double fine =
      static_cast<double>(tessellation_bytes(split.counts_to(5), LastLevel::FacesOnly) -
                          tessellation_bytes(split.counts_to(4), LastLevel::FacesOnly));
  EXPECT_NEAR(fine / coarse, 4.0, 0.01);
}

TEST(MemoryNeed, IsComparedWithTheLimit) {
  const QuadSplit split(test::torus(100, 100, 1.0, 0.4));
  EXPECT_NO_THROW(require_memory(split.counts_to(2), LastLevel::FacesOnly, 1ull << 30));
  EXPECT_THROW(require_memory(split.counts_to(5), LastLevel::FacesOnly, 1ull << 30), Error);
}

TEST(MemoryNeed, IndicesStayWithin32Bits) {
  const QuadSplit split(test::torus(1000, 1000, 1.0, 0.4));
  try {
    require_memory(split.counts_to(6), LastLevel::FacesOnly, ~0ull);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("32-bit"), std::string::npos) << error.what();
  }
}

TEST(MemoryNeed, TheMachineHasSome) { EXPECT_GT(available_memory_bytes(), 1ull << 20); }

}  // namespace
}  // namespace planish
