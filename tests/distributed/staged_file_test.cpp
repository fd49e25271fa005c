#include "planish/distributed/write_cage.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "distributed/rank_runs.h"
#include "planish/distributed/part_tiles.h"
#include "support/expect_error.h"

namespace planish::test {
namespace {

namespace fs = std::filesystem;

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

TEST(StagedFile, AppearsWholeWithTheBytesOfAllRanks) {
  const std::string path = shared_file("staged.txt", "old");
  on_ranks(3, [&](const Ranks& ranks) {
    StagedFile file(ranks, path);
    const std::string own(4, static_cast<char>('a' + ranks.rank));
    file.write(4 * ranks.rank, bytes_of(own));
    file.close(12);
    EXPECT_EQ(content_of(path), "old");
    MPI_Barrier(ranks.comm);
    file.commit();
  });
  if (is_first_rank()) {
    EXPECT_EQ(content_of(path), "aaaabbbbcccc");
  }
}

TEST(StagedFile, TouchesNoOtherProgramsFile) {
  const std::string path = shared_path("beside.txt");
  // As browsers name what they have not yet downloaded whole.
  const std::string part = shared_file("beside.txt.part", "a stranger's");
  on_ranks(2, [&](const Ranks& ranks) {
    StagedFile file(ranks, path);
    file.write(2 * ranks.rank, bytes_of("xy"));
    file.close(4);
    file.commit();
  });
  if (!is_first_rank()) return;
  EXPECT_EQ(content_of(path), "xyxy");
  EXPECT_EQ(content_of(part), "a stranger's");
}

TEST(StagedFile, ReplacesALinkAndNotWhatItNames) {
  const std::string target = shared_file("target.txt", "mine");
  const std::string path = shared_path("link.txt");
  if (is_first_rank()) {
    fs::remove(path);
    fs::create_symlink(target, path);
  }
  on_ranks(2, [&](const Ranks& ranks) {
    StagedFile file(ranks, path);
    file.write(2 * ranks.rank, bytes_of("xy"));
    file.close(4);
    file.commit();
  });
  if (is_first_rank()) {
    EXPECT_EQ(content_of(target), "mine");
  }
}

// Whoever runs the job without --force keeps what comes to the output's place meanwhile.
TEST(StagedFile, LeavesWhatCameMeanwhile) {
  const std::string path = shared_path("came.txt");
  if (is_first_rank()) fs::remove(path);
  on_ranks(2, [&](const Ranks& ranks) {
    StagedFile file(ranks, path, /*replaces=*/false);
    file.write(2 * ranks.rank, bytes_of("xy"));
    file.close(4);
    if (ranks.rank == 0) std::ofstream(path) << "a stranger's";
    (void)message_of(ErrorCode::UnwritableOutput, [&] { file.commit(); });
  });
  if (is_first_rank()) {
    EXPECT_EQ(content_of(path), "a stranger's");
  }
}

TEST(StagedTileset, LeavesWhatCameMeanwhile) {
  const fs::path folder = shared_path("tiles_meanwhile");
  const fs::path document = folder / "t.json";
  for (const char* const strange : {"t.json", "t/mine.txt"}) {
    if (is_first_rank()) {
      fs::remove_all(folder);
      fs::create_directories(folder);
    }
    on_ranks(2, [&](const Ranks& ranks) {
      StagedTileset tiles(ranks, document, /*resume=*/false, /*replaces=*/false);
      if (ranks.rank == 0) {
        std::ofstream(tiles.document()) << "ours";
        fs::create_directories((folder / strange).parent_path());
        std::ofstream(folder / strange) << "a stranger's";
      }
      (void)message_of(ErrorCode::UnwritableOutput, [&] { tiles.commit(); });
    });
    if (!is_first_rank()) continue;
    EXPECT_EQ(content_of((folder / strange).string()), "a stranger's");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1) << strange;
  }
}

TEST(StagedFile, WithoutCommitNothingIsLeft) {
  const std::string path = shared_file("kept.txt", "old");
  const auto count = [&] {
    std::int64_t entries = 0;
    for (const auto& entry : fs::directory_iterator(fs::path(path).parent_path()))
      entries += entry.path().filename().string().starts_with("kept.txt");
    return entries;
  };
  on_ranks(2, [&](const Ranks& ranks) {
    {
      StagedFile file(ranks, path);
      file.write(2 * ranks.rank, bytes_of("xy"));
    }
    MPI_Barrier(ranks.comm);
    EXPECT_EQ(count(), 1);
    EXPECT_EQ(content_of(path), "old");
  });
}

}  // namespace
}  // namespace planish::test
