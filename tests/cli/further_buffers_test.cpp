// Buffers of a .gltf behind the first: put in place with it, and removed with it.
#include "planish/job/staged_files.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "files/gltf/surfaces.h"
#include "planish/core/error.h"
#include "planish/files/gltf/write_gltf.h"
#include "support/temporary_folder.h"

namespace planish::command {
namespace {

namespace fs = std::filesystem;

class FurtherBuffers : public testing::Test {
 protected:
  // As a job does; returns how many buffers there are.
  std::size_t put(std::uint64_t buffer_bytes, bool overwrites) const {
    StagedFiles staged(overwrites);
    const PlannedOutput planned{
        .path = folder_ / "a b.gltf", .format = FileFormat::Gltf, .fineness = {}};
    const fs::path target = staged.stage(planned.path);
    GltfOptions options;
    options.buffer_bytes = buffer_bytes;
    const GltfFile written = write_gltf(target, test::wavy_grid(30, 20), options);
    (void)staged.stage(folder_ / "a b.bin");
    stage_further_buffers(planned, target, staged);
    staged.commit();
    return written.buffer_count;
  }
  [[nodiscard]] std::set<std::string> names() const {
    std::set<std::string> found;
    for (const auto& entry : fs::directory_iterator(folder_)) found.insert(entry.path().filename());
    return found;
  }
  void write(const char* name) const { std::ofstream(folder_ / name) << "somebody's"; }

  test::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
};

TEST_F(FurtherBuffers, ComeWithTheDocument) {
  EXPECT_EQ(put(20000, false), 2u);
  EXPECT_EQ(names(), (std::set<std::string>{"a b.gltf", "a b.bin", "a b-2.bin"}));
}

TEST_F(FurtherBuffers, OfTheReplacedDocumentGo) {
  EXPECT_EQ(put(10000, false), 4u);
  write("a b-9.bin");
  write("a b-x.bin");
  EXPECT_EQ(put(20000, true), 2u);
  EXPECT_EQ(names(),
            (std::set<std::string>{"a b.gltf", "a b.bin", "a b-2.bin", "a b-9.bin", "a b-x.bin"}));
  EXPECT_EQ(put(1 << 20, true), 1u);
  EXPECT_EQ(names(), (std::set<std::string>{"a b.gltf", "a b.bin", "a b-9.bin", "a b-x.bin"}));
}

TEST_F(FurtherBuffers, OfNobodyKnownStay) {
  write("a b-2.bin");
  // Not named so by the document that is replaced.
  std::ofstream(folder_ / "a b.gltf")
      << R"({"buffers": [{"uri": "a b.bin"}, {"uri": "a b-2.bin"}]})";
  EXPECT_EQ(put(1 << 20, true), 1u);
  EXPECT_TRUE(fs::exists(folder_ / "a b-2.bin"));
  std::ofstream(folder_ / "a b.gltf") << "no JSON";
  EXPECT_EQ(put(1 << 20, true), 1u);
  EXPECT_TRUE(fs::exists(folder_ / "a b-2.bin"));
}

TEST_F(FurtherBuffers, AreNotReplacedUnasked) {
  write("a b-2.bin");
  try {
    (void)put(20000, false);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::UnwritableOutput);
  }
  EXPECT_EQ(names(), (std::set<std::string>{"a b-2.bin"}));
}

}  // namespace
}  // namespace planish::command
