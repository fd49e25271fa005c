// Files that come to an output's place while the job runs.
#include "planish/job/staged_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "support/expect_error.h"
#include "support/temporary_folder.h"

namespace planish::command {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class StagedFilesTest : public testing::Test {
 protected:
  void put(const fs::path& name, const std::string& text) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
  }
  [[nodiscard]] std::string text_of(const fs::path& name) const {
    std::ifstream file(folder_ / name);
    return file ? std::string(std::istreambuf_iterator<char>(file), {}) : "none";
  }
  static std::string refusal(StagedFiles& staged) {
    return test::message_of(ErrorCode::UnwritableOutput, [&] { staged.commit(); });
  }
  // A document with one tile.
  void stage_tiles(StagedFiles& staged) const {
    const fs::path document = staged.stage_with_folder(folder_ / "t.json", folder_ / "t");
    std::ofstream(document) << "ours";
    fs::create_directories(document.parent_path() / "t");
    std::ofstream(document.parent_path() / "t" / "0.glb") << "ours";
  }

  test::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
};

TEST_F(StagedFilesTest, AppearTogetherOrNotAtAll) {
  for (const bool overwrites : {false, true}) {
    put("b", "somebody's");
    {
      StagedFiles staged(overwrites);
      staged.write(folder_ / "a", "ours");
      staged.write(folder_ / "b", "ours");
      staged.write(folder_ / "c", "ours");
      if (overwrites) {
        staged.commit();
      } else {
        EXPECT_EQ(refusal(staged),
                  (folder_ / "b").string() + " exists by now; --force overwrites it");
      }
    }
    const std::string others = overwrites ? "ours" : "none";
    EXPECT_EQ(text_of("a"), others);
    EXPECT_EQ(text_of("b"), overwrites ? "ours" : "somebody's");
    EXPECT_EQ(text_of("c"), others);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), overwrites ? 3 : 1);
  }
}

TEST_F(StagedFilesTest, LinksAreNotReplacedEither) {
  fs::create_symlink(folder_ / "nowhere", folder_ / "a");
  StagedFiles staged(false);
  staged.write(folder_ / "a", "ours");
  EXPECT_THAT(refusal(staged), HasSubstr("a exists by now"));
  EXPECT_TRUE(fs::is_symlink(folder_ / "a"));
}

TEST_F(StagedFilesTest, ATileSetReplacesNothingUnasked) {
  put("t/mine.txt", "somebody's");
  StagedFiles staged(false);
  stage_tiles(staged);
  EXPECT_THAT(refusal(staged), HasSubstr("t exists by now; --force"));
  EXPECT_EQ(text_of("t/mine.txt"), "somebody's");
  EXPECT_EQ(text_of("t.json"), "none");
}

TEST_F(StagedFilesTest, AFolderGoesWithItsDocument) {
  put("t.json", "somebody's");
  fs::create_directory(folder_ / "t");  // an empty one is in nobody's way
  {
    StagedFiles staged(false);
    stage_tiles(staged);
    EXPECT_THAT(refusal(staged), HasSubstr("t.json exists by now; --force"));
  }
  EXPECT_EQ(text_of("t.json"), "somebody's");
  EXPECT_EQ(text_of("t/0.glb"), "none");
  {
    StagedFiles staged(true);
    stage_tiles(staged);
    staged.commit();
  }
  EXPECT_EQ(text_of("t.json"), "ours");
  EXPECT_EQ(text_of("t/0.glb"), "ours");
}

}  // namespace
}  // namespace planish::command
