// The committed corpus through the functions that the fuzzers call.
#include <gtest/gtest.h>

#include <filesystem>

#include "fuzz/fuzz_command.h"
#include "fuzz/fuzz_read.h"
#include "planish/files/read_file.h"

namespace planish {
namespace {

template <class Read>
void replay(const std::string& folder_name, FileFormat format, Read* read) {
  const std::filesystem::path folder = std::filesystem::path(PLANISH_FUZZ_CORPUS) / folder_name;
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    SCOPED_TRACE(entry.path());
    (void)read(read_file(entry.path()), format);
    ++count;
  }
  EXPECT_GT(count, 0) << folder;
}

TEST(FuzzCorpus, EveryMeshIsReadOrRefused) {
  for (const FormatInfo& info : formats())
    if (info.read_mesh) replay(std::string(info.name), info.format, test::fuzz_read_mesh);
}

TEST(FuzzCorpus, EveryDracoStreamIsReadOrRefused) {
  replay("draco", FileFormat::Glb, test::fuzz_read_draco);
}

TEST(FuzzCorpus, EveryMeshoptStreamIsReadOrRefused) {
  replay("meshopt", FileFormat::Glb, test::fuzz_read_meshopt);
}

TEST(FuzzCorpus, EveryLzfStreamIsReadOrRefused) {
  replay("lzf", FileFormat::Pcd, test::fuzz_read_lzf);
}

TEST(FuzzCorpus, EverySceneIsReadOrRefused) {
  replay("scene", FileFormat::Obj, test::fuzz_read_scene);
}

TEST(FuzzCorpus, EveryCageSaysAgainWhatWasRead) {
  replay("cage", FileFormat::Obj, test::fuzz_read_cage);
}

TEST(FuzzCorpus, EveryTextStaysInItsPlace) {
  replay("text", FileFormat::Obj, test::fuzz_write_text);
}

TEST(FuzzCorpus, EveryAssetIsReadOrRefused) {
  replay("glb", FileFormat::Glb, test::fuzz_read_asset);
  replay("gltf", FileFormat::Gltf, test::fuzz_read_asset);
}

TEST(FuzzCorpus, EveryMaterialIsRead) { replay("mtl", FileFormat::Obj, test::fuzz_read_mtl); }

TEST(FuzzCorpus, EveryQuestionIsAnsweredOrRefused) {
  replay("query", FileFormat::Xyz, test::fuzz_query);
}

TEST(FuzzCorpus, EveryFileIsInspectedOrRefused) {
  for (const FormatInfo& info : formats()) {
    const std::string name(info.name);
    if (info.read_mesh) replay(name, info.format, test::fuzz_inspect);
    if (info.read_points) replay("points_" + name, info.format, test::fuzz_inspect);
  }
}

TEST(FuzzCorpus, EveryCloudIsReadOrRefused) {
  for (const FormatInfo& info : formats())
    if (info.read_points)
      replay("points_" + std::string(info.name), info.format, test::fuzz_read_points);
}

}  // namespace
}  // namespace planish
