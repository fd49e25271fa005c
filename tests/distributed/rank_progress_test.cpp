#include "planish/distributed/ranks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <vector>

#include "distributed/rank_runs.h"

namespace planish::test {
namespace {

TEST(RankProgress, ShowsTheShareOfAllRanksOnTheFirst) {
  for (const int count : kRankCounts)
    on_ranks(count, [&](const Ranks& ranks) {
      constexpr std::int64_t kUnits = 100;
      std::vector<double> shown;
      RankProgress progress(ranks, 0, [&](std::string_view phase, double fraction) {
        EXPECT_EQ(ranks.rank, 0);
        EXPECT_EQ(phase, "tiles");
        shown.push_back(fraction);
      });
      progress.begin("tiles", kUnits);
      // The others have nothing done when the first has all.
      if (ranks.rank == 0) {
        for (std::int64_t i = 0; i < kUnits; ++i) progress.step();
        EXPECT_LE(shown.back(), 1.0 / ranks.size);
      }
      MPI_Barrier(ranks.comm);
      // Steps above the count of units do not count: all go on until the first has seen the end.
      MPI_Request seen = MPI_REQUEST_NULL;
      for (int is_seen = 0; is_seen == 0;) {
        progress.step();
        std::this_thread::sleep_for(std::chrono::microseconds(200));  // cores are for all
        const bool is_over = ranks.rank != 0 || shown.back() == 1;
        if (seen == MPI_REQUEST_NULL && is_over) MPI_Ibarrier(ranks.comm, &seen);
        if (seen != MPI_REQUEST_NULL) MPI_Test(&seen, &is_seen, MPI_STATUS_IGNORE);
      }
      progress.finish();
      EXPECT_TRUE(std::ranges::is_sorted(shown));
    });
}

TEST(RankProgress, SumsOnceAnIntervalAndEndsWhateverRanksBegan) {
  on_ranks(5, [&](const Ranks& ranks) {
    RankProgress seldom(ranks, 1000, [](std::string_view, double) {});
    RankProgress often(ranks, 0, [](std::string_view, double) {});
    for (RankProgress* progress : {&seldom, &often}) {
      progress->begin("rows", 10);
      for (int i = 0; i < 10 * (1 + ranks.rank); ++i) progress->step();
      progress->end();
    }
    EXPECT_EQ(seldom.sum_count(), 0);
    EXPECT_GE(often.sum_count(), 1);
    seldom.finish();
    often.finish();
    const std::int64_t sums = often.sum_count();
    EXPECT_EQ(max_over(ranks, sums), min_over(ranks, sums));
    EXPECT_EQ(seldom.sum_count(), 0);
  });
}

TEST(RankProgress, FollowsAWatch) {
  on_ranks(3, [&](const Ranks& ranks) {
    std::vector<std::string> phases;
    RankProgress progress(ranks, 0, [&](std::string_view phase, double) {
      if (phases.empty() || phases.back() != phase) phases.emplace_back(phase);
    });
    RankWatch watch(ranks.rank, 0, &progress);
    for (const std::string_view phase : kPhases) {
      watch.begin(phase, 2);
      watch.tick();
    }
    watch.end();
    progress.finish();
    if (ranks.rank != 0) return;
    EXPECT_EQ(phases, std::vector<std::string>(std::begin(kPhases), std::end(kPhases)));
  });
}

}  // namespace
}  // namespace planish::test
