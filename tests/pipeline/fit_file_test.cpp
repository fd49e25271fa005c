#include "planish/pipeline/fit_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "planish/files/mesh_file.h"
#include "support/expect_error.h"
#include "support/meshes.h"
#include "support/temporary_folder.h"

namespace planish {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class FitFilePlaces : public testing::Test {
 protected:
  FitFilePlaces() { write_mesh(input_, FileFormat::Obj, test::cube()); }

  [[nodiscard]] std::string refusal(const fs::path& output, const fs::path& cage) const {
    return test::message_of(ErrorCode::InvalidArgument, [&] {
      FitFileOptions options;
      options.cage = cage;
      (void)fit_file(input_, output, options);
    });
  }
  static std::string bytes_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  test::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
  fs::path input_ = folder_ / "a.obj";
};

TEST_F(FitFilePlaces, TheInputIsNeverWritten) {
  const std::string before = bytes_of(input_);
  fs::create_symlink(input_, folder_ / "soft.obj");
  fs::create_hard_link(input_, folder_ / "hard.obj");
  for (const char* name : {"a.obj", "./a.obj", "soft.obj", "hard.obj"}) {
    EXPECT_THAT(refusal(folder_ / name, {}), HasSubstr("is the input itself")) << name;
    EXPECT_THAT(refusal(folder_ / "b.glb", folder_ / name), HasSubstr("is the input itself"))
        << name;
  }
  EXPECT_EQ(bytes_of(input_), before);
  EXPECT_FALSE(fs::exists(folder_ / "b.glb"));
}

TEST_F(FitFilePlaces, SurfaceAndCageAreTwoFiles) {
  EXPECT_THAT(refusal(folder_ / "b.ply", folder_ / "b.ply"), HasSubstr("cannot be one file"));
  EXPECT_THAT(refusal(folder_ / "b.ply", folder_ / "." / "b.ply"), HasSubstr("cannot be one file"));
  EXPECT_FALSE(fs::exists(folder_ / "b.ply"));
  FitFileOptions options;
  options.cage = folder_ / "d.obj";
  (void)fit_file(input_, folder_ / "b.ply", options);
  EXPECT_EQ(read_mesh(folder_ / "d.obj").mesh.face_count(), 6);
}

// What the surface has and its format has not is told once.
TEST_F(FitFilePlaces, WhatAFormatCannotHoldIsTold) {
  PolygonMesh mesh = test::cube();
  mesh.colors.assign(8, glm::vec4(1));
  mesh.groups = {{"a", ""}, {"b", ""}};
  mesh.face_groups = {0, 0, 0, 1, 1, 1};
  mesh.uvs = {{0, 0}};
  mesh.face_uvs.assign(24, 0);
  write_mesh(input_, FileFormat::Obj, mesh);
  const auto warnings_of = [&](const char* output) {
    std::vector<std::string> warnings;
    FitFileOptions options;
    options.level = 1;
    options.mesh.fit.callbacks.warning = [&](const Warning& warning) {
      EXPECT_EQ(warning.code, "lost-attributes");
      warnings.push_back(warning.message);
    };
    (void)fit_file(input_, folder_ / output, options);
    return warnings;
  };
  using testing::ElementsAre;
  for (const char* output : {"a.glb", "b.obj", "a.usda"})
    EXPECT_THAT(warnings_of(output), testing::IsEmpty()) << output;
  EXPECT_THAT(warnings_of("a.stl"),
              ElementsAre(".stl holds no texture coordinates, colours or groups, which the input "
                          "has; .glb, .gltf, .obj, .usda and .json do"));
  EXPECT_THAT(warnings_of("a.ply"), ElementsAre(".ply holds no groups, which the input has; .glb, "
                                                ".gltf, .obj, .usda and .json do"));
}

}  // namespace
}  // namespace planish
