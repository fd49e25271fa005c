// The committed corpus through the functions that the fuzzers call.
#include <gtest/gtest.h>

#include <filesystem>

#include "fuzz/fuzz_read.h"

namespace planish {
namespace {

template <class Format>
void replay(const std::string& folder_name, Format format) {
  const std::filesystem::path folder = std::filesystem::path(PLANISH_FUZZ_CORPUS) / folder_name;
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    SCOPED_TRACE(entry.path());
    test::fuzz_read(read_file(entry.path()), format);
    ++count;
  }
  EXPECT_GT(count, 0) << folder;
}

TEST(FuzzCorpus, EveryMeshIsReadOrRefused) {
  for (const MeshFormat format : {MeshFormat::Obj, MeshFormat::Ply, MeshFormat::Off,
                                  MeshFormat::Stl, MeshFormat::Gltf, MeshFormat::Glb})
    replay(std::string(name_of(format)), format);
}

TEST(FuzzCorpus, EveryCloudIsReadOrRefused) {
  for (const PointFormat format :
       {PointFormat::Ply, PointFormat::Xyz, PointFormat::Pts, PointFormat::Pcd})
    replay("points_" + std::string(name_of(format)), format);
}

}  // namespace
}  // namespace planish
