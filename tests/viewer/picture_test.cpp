// The viewer's pictures, against the CPU's surface drawn by planish-render's rasteriser and shaded
// by a twin of surface.frag.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include "planish/job/page/render.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "support/meshes.h"
#include "viewer/fixture.h"
#include "viewer/overlay.h"

namespace planish::testing {
namespace {

using namespace viewer;

class PictureTest : public ViewerTest {
 protected:
  std::vector<std::uint8_t> picture_after(int frames, const PolygonMesh& rest,
                                          const HeadlessOptions& options) {
    return picture_after(frames, scene_of(rest), options);
  }
  std::vector<std::uint8_t> picture_after(int frames, const Scene& scene,
                                          const HeadlessOptions& options) {
    Headless headless(*device_, scene, options);
    headless.run(frames);
    return headless.picture();
  }
};

glm::ivec3 pixel(const std::vector<std::uint8_t>& picture, std::size_t index) {
  return {picture[3 * index], picture[3 * index + 1], picture[3 * index + 2]};
}

int distance(const glm::ivec3& a, const glm::ivec3& b) {
  const glm::ivec3 d = glm::abs(a - b);
  return std::max({d.x, d.y, d.z});
}

// The CPU's surface as one picture sees it.
struct Drawing {
  Drawing(const SurfaceMesh& mesh, std::vector<std::uint32_t> triangles,
          const HeadlessOptions& options)
      : surface(mesh),
        indices(std::move(triangles)),
        camera(options.camera),
        aspect(static_cast<float>(options.extent.width) /
               static_cast<float>(options.extent.height)),
        seen(static_cast<int>(options.extent.width), static_cast<int>(options.extent.height)) {
    const glm::vec2 half(0.5f * static_cast<float>(seen.width),
                         0.5f * static_cast<float>(seen.height));
    for (const glm::dvec3& p : surface.positions) {
      const glm::vec4 clip = camera.clip_from_world(aspect) * glm::vec4(glm::vec3(p), 1);
      projected.emplace_back((glm::vec2(clip) / clip.w + 1.0f) * half, 1 / clip.w);
    }
    render::rasterise(projected, indices, 0, seen.height, seen);
  }

  bool covers(int x, int y) const {
    return seen.what[seen.at(x, y)] != render::VisibilityBuffer::kNothing;
  }

  // Whether the surface goes on without a step around the pixel.
  bool is_inside(int x, int y) const {
    constexpr float kStep = 0.01f;
    const float here = seen.nearness[seen.at(x, y)];
    for (int j = y - 1; j <= y + 1; ++j)
      for (int i = x - 1; i <= x + 1; ++i)
        if (!covers(i, j) || std::abs(seen.nearness[seen.at(i, j)] - here) > kStep * here)
          return false;
    return true;
  }

  // Perspective-correct weights of a pixel's middle in the triangle that is seen there.
  glm::vec3 weights(int x, int y) const {
    const std::size_t first = 3 * std::size_t{seen.what[seen.at(x, y)]};
    const glm::vec2 p(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
    const auto corner = [&](int k) { return projected[indices[first + k]]; };
    const auto area = [](const glm::vec2& a, const glm::vec2& b) { return a.x * b.y - a.y * b.x; };
    glm::vec3 w;
    for (int k = 0; k < 3; ++k)
      w[k] = area(glm::vec2(corner((k + 1) % 3)) - p, glm::vec2(corner((k + 2) % 3)) - p) *
             corner(k).z;
    return w / (w.x + w.y + w.z);
  }

  glm::vec2 uv(int x, int y, std::span<const glm::vec2> uvs) const {
    const std::size_t first = 3 * std::size_t{seen.what[seen.at(x, y)]};
    const glm::vec3 w = weights(x, y);
    glm::vec2 sum(0);
    for (int k = 0; k < 3; ++k) sum += w[k] * uvs[indices[first + k]];
    return sum;
  }

  // As what is of that colour.
  glm::ivec3 shade(int x, int y, const glm::vec3& srgb = {0.82f, 0.80f, 0.77f}) const;

  const SurfaceMesh& surface;
  std::vector<std::uint32_t> indices;
  OrbitCamera camera;
  float aspect;
  render::VisibilityBuffer seen;
  std::vector<glm::vec3> projected;
};

// The twin of shade.glsl for front faces.
glm::ivec3 Drawing::shade(int x, int y, const glm::vec3& srgb) const {
  const std::size_t first = 3 * std::size_t{seen.what[seen.at(x, y)]};
  const glm::vec3 w = weights(x, y);
  glm::vec3 normal(0), position(0);
  for (int k = 0; k < 3; ++k) {
    normal += w[k] * surface.normals[indices[first + k]];
    position += w[k] * glm::vec3(surface.positions[indices[first + k]]);
  }
  normal = glm::normalize(normal);
  const glm::vec3 key = camera.key_light();
  const glm::vec3 to_eye = glm::normalize(camera.eye(aspect) - position);
  const glm::vec3 fill = glm::normalize(glm::vec3(-key.x, 0.25f, -key.z) + to_eye);
  const auto facing = [&](const glm::vec3& d) { return std::max(glm::dot(normal, d), 0.0f); };
  const glm::vec3 light = glm::mix(glm::vec3(0.10f, 0.09f, 0.09f), glm::vec3(0.24f, 0.27f, 0.32f),
                                   0.5f + 0.5f * normal.y) +
                          glm::vec3(0.86f, 0.82f, 0.75f) * facing(key) +
                          glm::vec3(0.13f, 0.16f, 0.20f) * facing(fill);
  const glm::vec3 clay = glm::pow(srgb, glm::vec3(2.2f));
  const float coat = 0.22f * std::pow(facing(glm::normalize(key + to_eye)), 48.0f) +
                     0.14f * std::pow(1 - facing(to_eye), 4.0f);
  glm::ivec3 shown;
  for (int k = 0; k < 3; ++k) {
    float value = clay[k] * light[k] + coat;
    if (value > 0.6f) value = 0.6f + 0.4f * (1 - std::exp((0.6f - value) / 0.4f));
    shown[k] = static_cast<int>(std::lround(255 * std::pow(value, 1 / 2.2f)));
  }
  return shown;
}

TEST_F(PictureTest, SurfaceIsTheCpusWhereItIsAndHowItIsLit) {
  for (const Scene& scene :
       {scene_of(test::torus(12, 7, 2, 0.7)), fair_scene_of(test::icosphere(1))}) {
    HeadlessOptions options = options_for(scene.mesh);
    options.settings.iterations = 20;
    const auto picture = picture_after(40, scene, options);
    options.settings.surface = false;
    const auto empty = picture_after(1, scene, options);
    const SurfaceMesh surface = surface_by_cpu(scene, posed(scene.mesh, 39));
    const vulkan::System system(scene.mesh, scene.system);
    const Drawing drawing(surface, {system.triangles().begin(), system.triangles().end()}, options);
    int inside = 0, outside = 0;
    for (int y = 1; y + 1 < drawing.seen.height; ++y)
      for (int x = 1; x + 1 < drawing.seen.width; ++x) {
        const std::size_t at = drawing.seen.at(x, y);
        bool any = false;
        for (int k = 0; k < 9; ++k) any = any || drawing.covers(x - 1 + k % 3, y - 1 + k / 3);
        if (!any) {
          ++outside;
          ASSERT_EQ(distance(pixel(picture, at), pixel(empty, at)), 0) << x << ' ' << y;
        } else if (drawing.is_inside(x, y)) {
          ++inside;
          // Two roundings to 8 bits, and the mean over samples of several triangles.
          ASSERT_LE(distance(pixel(picture, at), drawing.shade(x, y)), 3) << x << ' ' << y;
        }
      }
    EXPECT_GT(inside, 2000);
    EXPECT_GT(outside, 4000);
  }
}

// Squares lie where the System's texture coordinates have them, in their colours. Where the surface
// bulges over the outline of its mesh, these go past 0 and 1, too: squares go on, colours do not.
TEST_F(PictureTest, SquaresFollowTextureCoordinates) {
  PolygonMesh rest = test::flat_grid(6, 5);
  for (const glm::dvec3& p : rest.positions) rest.uvs.emplace_back(p.x / 6, p.y / 5);
  rest.face_uvs.assign(rest.face_vertices.begin(), rest.face_vertices.end());
  Scene scene = scene_of(rest);
  scene.system.textured = true;
  HeadlessOptions options = options_for(rest);
  options.extent = {480, 360};
  options.settings.iterations = 20;
  options.settings.texture = true;
  options.settings.tessellate = true;  // which shows at the level what it has no coordinates for
  const auto picture = picture_after(40, scene, options);
  const SurfaceMesh surface = surface_by_cpu(scene, posed(rest, 39));
  const vulkan::System system(scene.mesh, scene.system);
  const std::vector<glm::vec2> uvs = system.uvs();
  ASSERT_EQ(uvs.size(), surface.positions.size());
  const Drawing drawing(surface, {system.triangles().begin(), system.triangles().end()}, options);
  const auto square = [&](int x, int y) {
    return glm::ivec2(glm::floor(shared::kBoardSquares * drawing.uv(x, y, uvs)));
  };
  std::array<int, 2> seen{};  // dark and light ones
  for (int y = 1; y + 1 < drawing.seen.height; ++y)
    for (int x = 1; x + 1 < drawing.seen.width; ++x) {
      if (!drawing.is_inside(x, y)) continue;
      const glm::ivec2 at = square(x, y);
      bool is_whole = true;
      for (int k = 0; k < 9; ++k) is_whole &= square(x - 1 + k % 3, y - 1 + k / 3) == at;
      if (!is_whole) continue;
      const bool is_light = (at.x + at.y) % 2 != 0;
      const glm::vec2 uv = glm::clamp(drawing.uv(x, y, uvs), 0.0f, 1.0f);
      const glm::vec3 colour = is_light
                                   ? glm::vec3(0.86f)
                                   : glm::vec3(0.20f + 0.60f * uv.x, 0.30f, 0.20f + 0.60f * uv.y);
      ++seen[is_light ? 1 : 0];
      ASSERT_LE(distance(pixel(picture, drawing.seen.at(x, y)), drawing.shade(x, y, colour)), 4)
          << x << ' ' << y << ' ' << is_light;
    }
  EXPECT_GT(seen[0], 1000);
  EXPECT_GT(seen[1], 1000);
}

// Pixels of exactly that colour in the picture.
int count_of(const std::vector<std::uint8_t>& picture, const glm::vec3& colour) {
  const glm::ivec3 wanted(glm::round(255.0f * colour));
  int count = 0;
  for (std::size_t i = 0; i < picture.size() / 3; ++i)
    count += distance(pixel(picture, i), wanted) <= 1;
  return count;
}

TEST_F(PictureTest, ErrorColoursHaveALegendWithNumbers) {
  const PolygonMesh rest = test::torus(12, 7, 2, 0.7);
  HeadlessOptions options = options_for(rest);
  options.extent = {480, 360};
  options.settings.iterations = 1;
  options.settings.warm_start = false;
  const glm::vec3 ink = glm::vec3(30, 34, 42) / 255.0f;
  for (const bool heat : {false, true}) {
    options.settings.heat = heat;
    const auto picture = picture_after(10, rest, options);
    for (const std::size_t stop : {0, 1, 2, 3, 4})
      EXPECT_EQ(count_of(picture, shared::kHeatStops[stop]) > 10, heat) << stop;
    // Some 70 letters and digits of a dozen pixels each.
    EXPECT_EQ(count_of(picture, ink) > 700, heat);
  }
}

TEST(Legend, SaysHowItWasSolved) {
  using enum InterpolationMethod;
  EXPECT_EQ(solve_text(Progressive, 0), "0 iterations");
  EXPECT_EQ(solve_text(Progressive, 1), "1 iteration");
  EXPECT_EQ(solve_text(Progressive, 2), "2 iterations");
  EXPECT_EQ(solve_text(Fair, 6), "the fair method");
}

TEST_F(PictureTest, TogglesShowCageAndPoints) {
  const PolygonMesh rest = test::torus(12, 7, 2, 0.7);
  HeadlessOptions options = options_for(rest);
  options.extent = {480, 360};
  const glm::vec3 dot(0.82f, 0.20f, 0.10f), edge(0.10f, 0.28f, 0.52f);
  const auto plain = picture_after(2, rest, options);
  EXPECT_EQ(count_of(plain, dot), 0);
  EXPECT_EQ(count_of(plain, edge), 0);
  options.settings.cage = options.settings.points = true;
  const auto all = picture_after(2, rest, options);
  EXPECT_GT(count_of(all, dot), 100);
  EXPECT_GT(count_of(all, edge), 100);
}

}  // namespace
}  // namespace planish::testing
