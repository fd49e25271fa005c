#include "planish/core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace planish {
namespace {

TEST(ParallelFor, VisitsEachIndexOnce) {
  for (const std::size_t count : {0u, 1u, 63u, 64u, 65u, 10000u}) {
    std::vector<std::atomic<int>> visits(count);
    parallel_for(count, 64, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) ++visits[i];
    });
    for (const auto& visit : visits) ASSERT_EQ(visit, 1);
  }
}

TEST(ParallelFor, PassesExceptionsOn) {
  EXPECT_THROW(parallel_for(10000, 16,
                            [](std::size_t begin, std::size_t) {
                              if (begin > 0) throw std::runtime_error("piece failed");
                            }),
               std::runtime_error);
}

}  // namespace
}  // namespace planish
