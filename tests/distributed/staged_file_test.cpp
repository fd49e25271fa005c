#include "planish/distributed/staged_file.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "distributed/rank_runs.h"

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
