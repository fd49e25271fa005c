// The command planish-render: what its flags do to the picture, and which it refuses by name.
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stb/stb_image.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "planish/files/gltf/write_gltf.h"
#include "support/files.h"

namespace planish::render {
namespace {

using testing::HasSubstr;

struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;  // three bytes each

  [[nodiscard]] const std::uint8_t* at(int x, int y) const {
    return &pixels[3 * (static_cast<std::size_t>(y) * width + x)];
  }
  // Whether another picture is a part of it, from that place on.
  [[nodiscard]] bool has(const Picture& part, int column, int row = 0) const {
    for (int y = 0; y < part.height; ++y)
      if (!std::equal(part.at(0, y), part.at(0, y) + 3 * part.width, at(column, row + y)))
        return false;
    return true;
  }
};

class RenderCommand : public testing::Test {
 protected:
  // A square and a triangle, seen from the front.
  void SetUp() override {
    SurfaceMesh surface;
    surface.level = 1;
    surface.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    surface.normals.assign(4, glm::vec3(0, 0, 1));
    surface.face_vertices = {0, 1, 2, 3};
    (void)write_gltf(folder_.path() / "square.glb", surface, {});
    surface.positions[3] = {1, 1, 0};
    (void)write_gltf(folder_.path() / "triangle.glb", surface, {});
  }

  int run(const std::string& arguments) {
    const std::string said = (folder_.path() / "said.txt").string();
    const int status =
        std::system(("cd " + folder_.path().string() + " && " + PLANISH_RENDER_EXECUTABLE + " " +
                     arguments + " > " + said + " 2>&1")
                        .c_str());
    std::stringstream text;
    text << std::ifstream(said).rdbuf();
    said_ = text.str();
    return WEXITSTATUS(status);
  }
  Picture picture(const std::string& arguments) {
    const std::string file = (folder_.path() / "picture.png").string();
    EXPECT_EQ(run(arguments + " -o " + file), 0) << said_;
    Picture result;
    int channels = 0;
    const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
        stbi_load(file.c_str(), &result.width, &result.height, &channels, 3), stbi_image_free);
    EXPECT_TRUE(pixels) << file;
    if (pixels)
      result.pixels.assign(pixels.get(),
                           pixels.get() + std::size_t{3} * result.width * result.height);
    return result;
  }

  test::TemporaryFolder folder_;
  std::string said_;
};

// Nor what an input names: its buffer, its texture.
TEST_F(RenderCommand, WritesOverNothingThatItReads) {
  ASSERT_EQ(run("square.glb -o picture.png"), 0) << said_;
  std::filesystem::rename(folder_.path() / "picture.png", folder_.path() / "wood.png");
  std::ofstream(folder_.path() / "a.gltf")
      << R"({"asset":{"version":"2.0"},"images":[{"uri":"wood.png"}],"scenes":[{}]})";
  std::ofstream(folder_.path() / "b.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  for (const auto& [arguments, output] : {std::pair{"a.gltf", "wood.png"},
                                          {"square.glb", "square.glb"},
                                          {"square.glb --overlay b.obj", "b.obj"}}) {
    const auto size = std::filesystem::file_size(folder_.path() / output);
    EXPECT_NE(run(std::string(arguments) + " -o " + output), 0);
    EXPECT_THAT(said_, HasSubstr(output)) << arguments;
    EXPECT_THAT(said_, testing::ContainsRegex("is read with the input|is the input itself"));
    EXPECT_EQ(std::filesystem::file_size(folder_.path() / output), size);
  }
}

TEST_F(RenderCommand, DrawsInputsSideBySideEachFromItsView) {
  const Picture both = picture("square.glb triangle.glb --size 40x30 --view 0,0 --view=-30,20");
  EXPECT_EQ(both.width, 80);
  EXPECT_EQ(both.height, 30);
  const Picture square = picture("square.glb --size 40x30 --view 0,0");
  const Picture triangle = picture("triangle.glb --size 40x30 --view=-30,20");
  EXPECT_EQ(square.width, 40);
  EXPECT_TRUE(both.has(square, 0));
  EXPECT_TRUE(both.has(triangle, 40));
  EXPECT_FALSE(both.has(square, 40));
  const Picture above =
      picture("square.glb square.glb triangle.glb --columns 2 --size 40x30 --view 0,0");
  EXPECT_EQ(above.width, 80);
  EXPECT_EQ(above.height, 60);
  EXPECT_TRUE(above.has(square, 0));
  EXPECT_TRUE(above.has(square, 40));
  EXPECT_FALSE(above.has(square, 0, 30));
  EXPECT_TRUE(above.has(picture("triangle.glb --size 40x30 --view 0,0"), 0, 30));
}

TEST_F(RenderCommand, ColoursAndZoomsAsAsked) {
  const std::string square = "square.glb --size 40x30 --view 0,0";
  const Picture red = picture(square + " --color ff0000"),
                blue = picture(square + " --color 0000ff");
  EXPECT_GT(red.at(20, 15)[0], red.at(20, 15)[2] + 50);
  EXPECT_GT(blue.at(20, 15)[2], blue.at(20, 15)[0] + 50);
  // The square's middle fills the picture.
  const Picture middle = picture(square + " --color ff0000 --zoom 8,0.5,0.5");
  for (const int x : {0, 39}) {
    EXPECT_LT(red.at(x, 15)[0], red.at(x, 15)[2] + 20) << "ground at " << x;
    EXPECT_GT(middle.at(x, 15)[0], middle.at(x, 15)[2] + 50) << "square at " << x;
  }
}

TEST_F(RenderCommand, RefusesByNameWhatItCannotRead) {
  const std::pair<const char*, const char*> refused[] = {
      {"--size 40", "--size 40: is not WIDTHxHEIGHT up to 8192x8192"},
      {"--size 0x40", "--size 0x40: is not WIDTHxHEIGHT"},
      {"--size 40x8193", "--size 40x8193: is not WIDTHxHEIGHT"},
      {"--view 12", "--view 12: is not AZIMUTH,ELEVATION in degrees"},
      {"--view 1,2 --view 3,4", "--view: give one, or one for each input"},
      {"--zoom 2,0.5", "--zoom 2,0.5: is not FACTOR,X,Y"},
      {"--zoom 0,0.5,0.5", "--zoom 0,0.5,0.5: is not FACTOR,X,Y"},
      {"--color ff00", "--color ff00: is not RRGGBB"},
      {"--scale=-1", "--scale: is a number above 0"},
  };
  for (const auto& [flags, message] : refused) {
    EXPECT_EQ(run(std::string("square.glb -o refused.png ") + flags), 1) << flags;
    EXPECT_THAT(said_, HasSubstr(message));
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "refused.png")) << flags;
  }
  EXPECT_EQ(run("square.glb -o refused.png --stripes --heat"), 2);
  EXPECT_EQ(run("none.glb -o refused.png"), 1);
  EXPECT_THAT(said_, HasSubstr("none.glb"));
}

}  // namespace
}  // namespace planish::render
