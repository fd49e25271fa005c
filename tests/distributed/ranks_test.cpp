#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

#include "distributed/rank_runs.h"
#include "planish/distributed/mesh_part.h"
#include "planish/distributed/ranks.h"
#include "planish/files/tiles/tile.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

TEST(Messages, ExchangeInRoundsGivesWhatOneRoundGives) {
  for (const int count : {1, 3, 8}) {
    on_ranks(count, [](const Ranks& ranks) {
      std::vector<std::int64_t> counts, expected, sent;
      for (int r = 0; r < ranks.size; ++r) {
        counts.push_back(3 * r + ranks.rank);  // uneven, and none from 0 to 0
        for (int k = 0; k < counts.back(); ++k) sent.push_back(1000 * ranks.rank + 10 * r + k);
      }
      for (int r = 0; r < ranks.size; ++r)
        for (int k = 0; k < 3 * ranks.rank + r; ++k)
          expected.push_back(1000 * r + 10 * ranks.rank + k);
      const auto received = exchange_counts(ranks, counts);
      std::vector<std::int64_t> got(expected.size(), -1);
      for (const std::size_t round_bytes :
           {std::size_t{1} << 30, std::size_t{64}, std::size_t{1}}) {
        std::ranges::fill(got, -1);
        exchange_bytes(ranks, reinterpret_cast<const std::byte*>(sent.data()), counts,
                       reinterpret_cast<std::byte*>(got.data()), received, sizeof(std::int64_t),
                       round_bytes);
        EXPECT_EQ(got, expected) << round_bytes;
      }
    });
  }
}

TEST(Messages, GathersRunsInTheOrderOfRanks) {
  for (const int count : {1, 2, 3, 5})
    on_ranks(count, [&](const Ranks& ranks) {
      // Rank 1 has none, the others as many as their number squared.
      const auto size_of = [](int rank) { return rank == 1 ? 0 : rank * rank + 2; };
      std::vector<std::int64_t> own(static_cast<std::size_t>(size_of(ranks.rank)), ranks.rank);
      std::vector<std::int64_t> expected;
      for (int r = 0; r < ranks.size; ++r) expected.insert(expected.end(), size_of(r), r);
      const auto all = all_gather<std::int64_t>(ranks, own);
      EXPECT_EQ(std::vector<std::int64_t>(all.begin(), all.end()), expected);
      const auto first = gather<std::int64_t>(ranks, own);
      if (ranks.rank == 0)
        EXPECT_EQ(std::vector<std::int64_t>(first.begin(), first.end()), expected);
      else
        EXPECT_TRUE(first.empty());
    });
}

TEST(Messages, BroadcastsInRounds) {
  on_ranks(3, [&](const Ranks& ranks) {
    std::vector<std::byte> bytes(1000), expected(1000);
    for (std::size_t i = 0; i < expected.size(); ++i) expected[i] = static_cast<std::byte>(7 * i);
    if (ranks.rank == 2) bytes = expected;
    broadcast_bytes(ranks, bytes, 2, 64);
    EXPECT_EQ(bytes, expected);
  });
}

TEST(Messages, PeersGetWhatAllToAllGives) {
  for (const int count : {1, 3, 8}) {
    on_ranks(count, [](const Ranks& ranks) {
      // To oneself, and to the two ranks behind; none to the others.
      std::vector<std::int64_t> counts(static_cast<std::size_t>(ranks.size), 0), sent;
      for (int k = 0; k < 3; ++k) counts[(ranks.rank + k) % ranks.size] = 5 + k + ranks.rank;
      for (int r = 0; r < ranks.size; ++r)
        for (std::int64_t k = 0; k < counts[r]; ++k)
          sent.push_back(1000 * ranks.rank + 100 * r + k);
      std::vector<std::int64_t> received;
      const auto expected = all_to_all<std::int64_t>(ranks, sent, counts, &received);
      RawVector<std::int64_t> got(expected.size());
      exchange_with_peers(ranks, reinterpret_cast<const std::byte*>(sent.data()), counts,
                          reinterpret_cast<std::byte*>(got.data()), received, sizeof(std::int64_t));
      EXPECT_TRUE(got == expected);
    });
  }
}

TEST(Messages, FetchAsksOwners) {
  on_ranks(5, [](const Ranks& ranks) {
    const Layout layout = even_layout(17, ranks.size);
    std::vector<std::int64_t> wanted;
    for (std::int64_t n = ranks.rank; n < 17; n += 2) wanted.push_back(n);
    const auto values = fetch<std::int64_t>(
        ranks, wanted, layout, [&](std::int64_t place) { return 100 * ranks.rank + place; });
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const int owner = owner_of(layout, wanted[i]);
      EXPECT_EQ(values[i], 100 * owner + wanted[i] - layout[owner]);
    }
  });
}

TEST(Messages, AllRanksThrowWhatTheLowestDid) {
  on_ranks(5, [](const Ranks& ranks) {
    const Outcome outcome = outcome_of([&] {
      agree(ranks, [&] {
        if (ranks.rank == 4) throw Error(ErrorCode::UnusableMesh, "from rank 4");
        if (ranks.rank == 2) throw Error(ErrorCode::UnreadableInput, "from rank 2");
      });
    });
    EXPECT_EQ(outcome.message, "from rank 2");
    EXPECT_EQ(outcome.code, static_cast<int>(ErrorCode::UnreadableInput));
    EXPECT_EQ(outcome_of([&] { agree(ranks, [] {}); }).message, "no error");
    EXPECT_THROW(agree(ranks,
                       [&] {
                         if (ranks.rank == 1) throw std::logic_error("ours");
                       }),
                 std::runtime_error);
  });
}

TEST(VertexOrder, IsThatOfOneMachineForEveryRankCount) {
  PolygonMesh mesh = mixed_torus(24, 12);
  mesh.positions.push_back(mesh.positions[7]);  // coincident: the file's order decides
  const auto one_machine = curve_order(mesh.positions);
  const std::vector<std::int64_t> expected(one_machine.begin(), one_machine.end());
  for (const int count : kRankCounts) {
    on_ranks(count, [&](const Ranks& ranks) {
      MeshSlice slice = scatter_mesh(ranks, mesh);
      const CurveOrder order = order_along_curve(ranks, slice, 16);
      for (int r = 0; r <= ranks.size; ++r)
        EXPECT_TRUE(order.layout[r] % 16 == 0 || order.layout[r] == order.layout.back());
      std::vector<std::int64_t> counts(ranks.size, 0);
      counts[0] = static_cast<std::int64_t>(order.file_ids.size());
      const auto all = all_to_all<std::int64_t>(ranks, order.file_ids, counts);
      if (ranks.rank != 0) return;
      EXPECT_EQ(expected, std::vector<std::int64_t>(all.begin(), all.end())) << ranks.size;
    });
  }
}

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
