#include "planish/measure/vertex_fields.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "planish/surface/surface_blocks.h"
#include "support/meshes.h"

namespace planish {
namespace {

// A surface of four quads over one face from 0 to 2, its texture as `uv` has it.
template <class Uv>
TextureSlide slide_of(const PolygonMesh& mesh, double height, const Uv& uv) {
  SurfaceMesh surface;
  surface.level = 1;
  for (int j = 0; j <= 2; ++j)
    for (int i = 0; i <= 2; ++i) {
      const bool is_middle = i == 1 && j == 1;
      surface.positions.emplace_back(i, j, is_middle ? height : 0.0);
      surface.normals.emplace_back(0, 0, 1);
      surface.uvs.push_back(uv(surface.positions.back()));
    }
  for (const auto& quad : {std::array{0, 1, 4, 3}, std::array{1, 2, 5, 4}, std::array{4, 5, 8, 7},
                           std::array{3, 4, 7, 6}})
    surface.face_vertices.insert(surface.face_vertices.end(), quad.begin(), quad.end());
  surface.face_uvs = surface.face_vertices;
  return texture_slide(*blocks_of(surface, mesh), mesh);
}

PolygonMesh square(double across, double up) {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
  mesh.add_face(std::array{0, 1, 2, 3});
  mesh.uvs = {{0, 0}, {across, 0}, {across, up}, {0, up}};
  mesh.face_uvs = {0, 1, 2, 3};
  return mesh;
}

TEST(TextureSlide, IsNothingWhereTheTextureIsTheInputs) {
  const TextureSlide slide =
      slide_of(square(1, 0.5), 0, [](const glm::dvec3& p) { return glm::dvec2(p.x / 2, p.y / 4); });
  EXPECT_LT(slide.largest, 1e-15);
  EXPECT_LT(slide.largest_distance, 1e-15);
}

// The middle lies over that of the face, and its texture by 0.1 of u and 0.2 of v beside it: that
// is 0.2 and 0.8 along a face whose texture is half as wide as it, and a quarter as high.
TEST(TextureSlide, IsWhatTheTextureLacks) {
  const auto moved = [](const glm::dvec3& p) {
    const bool is_middle = p.x == 1 && p.y == 1;
    return glm::dvec2(p.x / 2, p.y / 4) + (is_middle ? glm::dvec2(0.1, 0.2) : glm::dvec2(0));
  };
  const TextureSlide slide = slide_of(square(1, 0.5), 0, moved);
  EXPECT_NEAR(slide.largest, std::hypot(0.1, 0.2), 1e-15);
  EXPECT_NEAR(slide.largest_distance, std::hypot(0.2, 0.8), 1e-14);
  // The middle is one corner of each quad, which are alike.
  EXPECT_NEAR(slide.rms, slide.largest / 2, 1e-15);
  EXPECT_NEAR(slide.rms_distance, slide.largest_distance / 2, 1e-14);
  EXPECT_EQ(slide.face, 0);
  // Seen from above it is the same.
  EXPECT_NEAR(slide_of(square(1, 0.5), 0.3, moved).largest, std::hypot(0.1, 0.2), 1e-15);
}

// Where all of the texture lies on a line there is no way across it.
TEST(TextureSlide, HasNoDistanceWhereTheTextureHasNoArea) {
  const TextureSlide slide =
      slide_of(square(1, 0), 0, [](const glm::dvec3& p) { return glm::dvec2(p.x / 2, 0.3); });
  EXPECT_NEAR(slide.largest, 0.3, 1e-15);
  EXPECT_EQ(slide.largest_distance, 0);
  EXPECT_EQ(slide.face, -1);
}

// Faces without texture coordinates do not count.
TEST(TextureSlide, LeavesOutFacesWithoutATexture) {
  PolygonMesh mesh = square(1, 1);
  mesh.face_uvs[2] = -1;
  const TextureSlide slide = slide_of(mesh, 0, [](const glm::dvec3&) { return glm::dvec2(9); });
  EXPECT_EQ(slide.largest, 0);
  EXPECT_EQ(slide.rms, 0);
}

}  // namespace
}  // namespace planish
