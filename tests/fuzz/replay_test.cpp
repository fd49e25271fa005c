// The committed corpus through the functions that the fuzzers call.
#include <gtest/gtest.h>

#include <filesystem>

#include "fuzz/fuzz_read.h"

namespace planish {
namespace {

TEST(FuzzCorpus, EveryFileIsReadOrRefused) {
  for (const MeshFormat format : {MeshFormat::Obj, MeshFormat::Ply, MeshFormat::Off,
                                  MeshFormat::Stl, MeshFormat::Gltf, MeshFormat::Glb}) {
    const std::filesystem::path folder =
        std::filesystem::path(PLANISH_FUZZ_CORPUS) / std::string(name_of(format));
    int count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      SCOPED_TRACE(entry.path());
      test::fuzz_read(read_file(entry.path()), format);
      ++count;
    }
    EXPECT_GT(count, 0) << folder;
  }
}

}  // namespace
}  // namespace planish
