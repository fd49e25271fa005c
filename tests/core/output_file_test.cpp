#include "planish/core/output_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "planish/core/error.h"
#include "planish/core/platform/files.h"
#include "planish/core/words.h"

namespace planish {
namespace {

class OutputFileTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    directory_ = std::filesystem::path(testing::TempDir()) / info->name();
    std::filesystem::remove_all(directory_);
    std::filesystem::create_directories(directory_);
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  [[nodiscard]] std::string content(const std::string& name) const {
    std::ifstream file(directory_ / path_of(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  [[nodiscard]] std::ptrdiff_t file_count() const {
    return std::distance(std::filesystem::directory_iterator(directory_), {});
  }

  std::filesystem::path directory_;
};

TEST_F(OutputFileTest, AppearsOnlyWhenCommitted) {
  OutputFile file(directory_ / "a.txt");
  file.write("hello ");
  EXPECT_FALSE(std::filesystem::exists(directory_ / "a.txt"));
  file.write("world");
  file.commit();
  EXPECT_EQ(content("a.txt"), "hello world");
  EXPECT_EQ(file_count(), 1);
}

TEST_F(OutputFileTest, KeepsTheOldFileAndLeavesNoTemporaryWithoutCommit) {
  std::ofstream(directory_ / "a.txt") << "old";
  {
    OutputFile file(directory_ / "a.txt");
    file.write("new");
  }
  EXPECT_EQ(content("a.txt"), "old");
  EXPECT_EQ(file_count(), 1);
}

TEST_F(OutputFileTest, NamesPathAndReasonWhenTheFolderIsMissing) {
  try {
    OutputFile file(directory_ / "missing" / "a.txt");
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::UnwritableOutput);
    EXPECT_EQ(error.what(), (directory_ / "missing" / "a.txt").string() +
                                ": cannot create: No such file or directory");
  }
}

// As long as the system lets any be.
TEST_F(OutputFileTest, ANameThatFitsIsWritten) {
  const std::string umlauts = [] {
    std::string text;
    for (int i = 0; i < 120; ++i) text += "\u00fc";
    return text;
  }();
  for (const std::string& name : {std::string(255, 'n'), std::string(241, 'n'),
                                  std::string(101, 'n'), umlauts + "x", "x" + umlauts}) {
    OutputFile file(directory_ / path_of(name));
    file.write("hello");
    std::string temporary;
    for (const auto& entry : std::filesystem::directory_iterator(directory_))
      temporary = utf8(entry.path().filename());
    EXPECT_LE(temporary.size(), name.size());
    if (name.find('n') == std::string::npos) {  // whole characters
      EXPECT_EQ((temporary.find('.') - (name[0] == 'x' ? 1 : 0)) % 2, 0u) << temporary;
    }
    file.commit();
    EXPECT_EQ(content(name), "hello");
    std::filesystem::remove(directory_ / path_of(name));
    EXPECT_EQ(file_count(), 0);
  }
  EXPECT_THROW(OutputFile(directory_ / std::string(256, 'n')), Error);
}

TEST_F(OutputFileTest, FailsWhenTheTargetIsAFolder) {
  std::filesystem::create_directories(directory_ / "target" / "inside");
  OutputFile file(directory_ / "target");
  file.write("x");
  EXPECT_THROW(file.commit(), Error);
  EXPECT_TRUE(std::filesystem::exists(directory_ / "target" / "inside"));
}

TEST_F(OutputFileTest, ReservedRoomIsNoPartOfTheFile) {
  for (const std::uint64_t bytes : {std::uint64_t{1}, std::uint64_t{5}, std::uint64_t{1} << 20}) {
    OutputFile file(directory_ / "a.txt");
    file.reserve(bytes);
    file.write("hello");
    file.commit();
    EXPECT_EQ(content("a.txt"), "hello");
#ifndef _WIN32
    struct stat status {};
    ASSERT_EQ(::stat((directory_ / "a.txt").c_str(), &status), 0);
    EXPECT_LE(512 * status.st_blocks, 1 << 16) << "room of " << bytes << " bytes was kept";
#endif
  }
}

TEST_F(OutputFileTest, RoomThatADiskHasNotIsRefused) {
  OutputFile file(directory_ / "a.txt");
  try {
    file.reserve(std::uint64_t{1} << 62);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::UnwritableOutput);
    EXPECT_EQ(error.what(),
              visible(directory_ / "a.txt") +
                  ": cannot take room for 4611686018427387904 bytes: No space left on device");
  }
}

TEST_F(OutputFileTest, GivesTheFileOrdinaryPermissions) {
  std::ofstream(directory_ / "ordinary") << "x";
  OutputFile file(directory_ / "ours");
  file.commit();
  EXPECT_EQ(std::filesystem::status(directory_ / "ours").permissions(),
            std::filesystem::status(directory_ / "ordinary").permissions());
}

TEST_F(OutputFileTest, ReplacesNothingWhereThatIsNotWanted) {
  OutputFile file(directory_ / "a.txt", false);
  file.write("ours");
  std::ofstream(directory_ / "a.txt") << "somebody's";
  EXPECT_THROW(file.commit(), Error);
  EXPECT_EQ(content("a.txt"), "somebody's");
  OutputFile other(directory_ / "b.txt", false);
  other.write("ours");
  other.commit();
  EXPECT_EQ(content("b.txt"), "ours");
}

// What a file system can do that knows no renaming without replacing.
TEST_F(OutputFileTest, LinksGiveANameThatIsFree) {
  std::ofstream(directory_ / "a") << "ours";
  std::ofstream(directory_ / "b") << "somebody's";
  EXPECT_EQ(platform::link_in_place(directory_ / "a", directory_ / "b"), std::errc::file_exists);
  EXPECT_EQ(content("b"), "somebody's");
  EXPECT_FALSE(platform::link_in_place(directory_ / "a", directory_ / "c"));
  EXPECT_EQ(content("c"), "ours");
  EXPECT_EQ(file_count(), 2);
  // Folders have no second names.
  std::filesystem::create_directory(directory_ / "d");
  EXPECT_EQ(platform::link_in_place(directory_ / "d", directory_ / "b"), std::errc::file_exists);
  EXPECT_FALSE(platform::link_in_place(directory_ / "d", directory_ / "e"));
  EXPECT_TRUE(std::filesystem::is_directory(directory_ / "e"));
}

}  // namespace
}  // namespace planish
