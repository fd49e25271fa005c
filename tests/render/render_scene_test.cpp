// What planish-render draws of a glTF: the meshes that the default scene places, where it does.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <string>

#include "files/gltf/glb_bytes.h"
#include "picture.h"
#include "planish/core/error.h"
#include "support/expect_error.h"

namespace planish::render {
namespace {

using test::values;

class RenderScene : public ::testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(path_); }

  // Of the unit square with slanted normals.
  RenderMesh read(const std::string& scenes_and_nodes) {
    const float n = std::sqrt(0.5f);
    const std::string chunk =
        test::square_chunk() + values<float>({n, 0, n, n, 0, n, n, 0, n, n, 0, n});
    const std::string square =
        R"({"primitives":[{"attributes":{"POSITION":0,"NORMAL":2},"indices":1}]})";
    const std::string json =
        R"({"asset":{"version":"2.0"},)" + scenes_and_nodes + R"(,"meshes":[)" + square + "," +
        square +
        R"(],"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},)"
        R"({"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"},)"
        R"({"bufferView":2,"componentType":5126,"count":4,"type":"VEC3"}],)"
        R"("bufferViews":[{"buffer":0,"byteLength":48},)"
        R"({"buffer":0,"byteOffset":48,"byteLength":12},)"
        R"({"buffer":0,"byteOffset":60,"byteLength":48}],"buffers":[{"byteLength":108}]})";
    std::ofstream(path_, std::ios::binary) << test::glb_of(json, chunk);
    return read_glb(path_);
  }

  std::filesystem::path path_ =
      std::filesystem::temp_directory_path() /
      ("planish_render_" +
       std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()) + ".glb");
};

void expect_near(const glm::vec3& found, const glm::vec3& expected) {
  EXPECT_LT(glm::distance(found, expected), 1e-5f) << found.x << ' ' << found.y << ' ' << found.z;
}

// A quarter turn about x takes (x, y, z) to (x, -z, y); the scale mirrors.
TEST_F(RenderScene, MeshesStandWhereNodesPlaceThem) {
  const RenderMesh mesh = read(
      R"("scene":1,"scenes":[{"nodes":[2]},{"nodes":[0]}],"nodes":[)"
      R"({"mesh":0,"translation":[1000000,0,0],"children":[1]},)"
      R"({"mesh":1,"translation":[10,0,0],"rotation":[0.70710678,0,0,0.70710678],"scale":[-2,3,4]},)"
      R"({"mesh":0,"translation":[5,5,5]}])");
  EXPECT_EQ(mesh.origin, glm::dvec3(1e6, 0, 0));
  ASSERT_EQ(mesh.positions.size(), 8u);
  EXPECT_THAT(mesh.indices, ::testing::ElementsAre(0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7));
  expect_near(mesh.positions[0], {0, 0, 0});
  expect_near(mesh.positions[2], {1, 1, 0});
  expect_near(mesh.positions[4], {10, 0, 0});
  expect_near(mesh.positions[5], {8, 0, 0});
  expect_near(mesh.positions[6], {8, 0, 3});
  expect_near(mesh.normals[2], {std::sqrt(0.5f), 0, std::sqrt(0.5f)});
  // By the inverse of the scale: (-1/2, 0, 1/4), turned.
  expect_near(mesh.normals[6], glm::normalize(glm::vec3(-2, -1, 0)));
}

TEST_F(RenderScene, ScenesWithoutTrianglesAreRefused) {
  EXPECT_THAT(
      test::message_of(ErrorCode::UnreadableInput,
                       [&] { read(R"("scene":0,"scenes":[{"nodes":[]}],"nodes":[{"mesh":0}])"); }),
      ::testing::HasSubstr("places no triangles"));
}

}  // namespace
}  // namespace planish::render
