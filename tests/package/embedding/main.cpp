// Two applications that own their device, by nothing but the installed package: that of
// src/planish/vulkan/README.md, whose positions are checked against the CPU, and a renderer
// (frames.cpp), whose pixels are. What the validation layer says, if it is there, fails either.
#include <planish/planish.h>
#include <planish/vulkan/vulkan_backend.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <span>
#include <string>
#include <vector>

#include "example.h"
#include "frames.h"

namespace {

constexpr int kFrames = 10;
// Single precision of coordinates of a few units.
constexpr double kTolerance = 1e-5;

planish::PolygonMesh torus(int around, int across) {
  planish::PolygonMesh mesh;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double u = 2 * M_PI * i / around, v = 2 * M_PI * j / across;
      mesh.positions.emplace_back((2 + 0.7 * std::cos(v)) * std::cos(u),
                                  (2 + 0.7 * std::cos(v)) * std::sin(u), 0.7 * std::sin(v));
    }
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const auto at = [&](int a, int b) { return a % around * across + b % across; };
      const std::int32_t face[] = {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
      mesh.add_face(face);
    }
  return mesh;
}

planish::PolygonMesh posed(planish::PolygonMesh mesh, int frame) {
  for (glm::dvec3& p : mesh.positions)
    p += 0.2 * glm::dvec3(0, std::sin(p.x + 0.4 * frame), std::cos(p.y - 0.3 * frame));
  return mesh;
}

/// How far the vertices of a frame are from the CPU's.
double difference(const planish::PolygonMesh& pose, std::span<const std::byte> vertices) {
  const auto backend = planish::make_cpu_backend();
  planish::FitOptions options;
  options.tolerance = 1e-10;
  const planish::Fit fit = planish::fit(pose, *backend, options);
  const planish::SurfaceMesh surface = planish::evaluate(fit.cage, *backend, {.level = 2});
  if (vertices.size() != 24 * surface.positions.size()) return HUGE_VAL;
  double largest = 0;
  for (std::size_t i = 0; i < surface.positions.size(); ++i) {
    glm::vec3 vertex[2];
    std::memcpy(vertex, &vertices[24 * i], sizeof vertex);
    largest = std::max(largest, glm::distance(glm::dvec3(vertex[0]), surface.positions[i]));
    largest = std::max<double>(largest, 0.1 * glm::distance(vertex[1], surface.normals[i]));
  }
  return largest;
}

/// The torus with texture coordinates: u around, v across, seams where they begin again.
planish::PolygonMesh textured_torus(int around, int across) {
  planish::PolygonMesh mesh = torus(around, across);
  for (int i = 0; i <= around; ++i)
    for (int j = 0; j <= across; ++j) mesh.uvs.emplace_back(double(i) / around, double(j) / across);
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const auto at = [&](int a, int b) { return a * (across + 1) + b; };
      for (const int uv : {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)})
        mesh.face_uvs.push_back(uv);
    }
  return mesh;
}

constexpr int kRenderedFrames = 40, kFirstRigid = 4;
constexpr float kHalf = 3.5f;

glm::vec3 moved_by(int frame) {
  return {0.4f * std::sin(0.3f * float(frame)), -0.3f * std::sin(0.2f * float(frame)), 0};
}
/// From all around.
glm::mat4 view_of(int frame) {
  const glm::mat4 turned = glm::rotate(glm::mat4(1.0f), -0.9f, glm::vec3(1, 0, 0));
  if (frame <= kFirstRigid) return turned;
  return glm::rotate(turned, 0.37f * float(frame), glm::normalize(glm::vec3(1, 2, 0.5f)));
}

/// Twisted at first, then a rigid move.
std::array<glm::mat4x3, 2> bones_of(int frame) {
  std::array<glm::mat4x3, 2> bones = {glm::mat4x3(1.0f), glm::mat4x3(1.0f)};
  for (glm::mat4x3& bone : bones) bone[3] = moved_by(frame);
  if (frame >= kFirstRigid) return bones;
  const float angle = 0.1f * float(kFirstRigid - frame);
  bones[1][1] = {0, std::cos(angle), std::sin(angle)};
  bones[1][2] = {0, -std::sin(angle), std::cos(angle)};
  return bones;
}

/// A picture to look at.
void write_picture(const char* path, const std::vector<std::array<unsigned char, 4>>& colours) {
  std::FILE* file = std::fopen(path, "wb");
  if (!file) return;
  std::fprintf(file, "P6 %d %d 255\n", kImageSide, kImageSide);
  for (const auto& colour : colours) std::fwrite(colour.data(), 1, 3, file);
  std::fclose(file);
}

/// Pixels without the tessellated surface that have it all around, farther than a slit of the
/// outline reaches, and those where it is not as the triangles are.
int wrong_patches(const DrawnFrame& drawn) {
  constexpr int kAround = 3;
  int holes = 0, different = 0;
  const auto is_covered = [&](int x, int y) { return drawn.patches[y * kImageSide + x][3] != 0; };
  for (int y = kAround; y + kAround < kImageSide; ++y)
    for (int x = kAround; x + kAround < kImageSide; ++x) {
      const float side = drawn.motions[y * kImageSide + x].w;
      different += is_covered(x, y) != (side != 0);
      if (is_covered(x, y)) continue;
      int uncovered = 0;
      for (int dy = -kAround; dy <= kAround; ++dy)
        for (int dx = -kAround; dx <= kAround; ++dx) uncovered += !is_covered(x + dx, y + dy);
      holes += uncovered == 1;
    }
  // Outlines, which triangles of another size have elsewhere by less than a pixel: up to 46.
  return holes + (different > 80 ? different : 0);
}

/// Pixels that are not as they must be.
int wrong_pixels(int frame, const DrawnFrame& drawn) {
  int covered = 0, wrong = 0;
  const bool is_rigid = frame > kFirstRigid;
  const glm::vec3 move = moved_by(frame) - moved_by(frame - 1);
  for (std::size_t i = 0; i < drawn.motions.size(); ++i) {
    const glm::vec4 motion = drawn.motions[i], texture = drawn.textures[i];
    const bool is_covered = motion.w != 0;
    covered += is_covered;
    // Both passes draw the same positions.
    wrong += is_covered != (drawn.shadow[i] < 1);
    if (!is_covered || !is_rigid) continue;
    // Between two roundings to 1/32767 of the box; where a solve is not yet at its tolerance, too.
    wrong += glm::distance(glm::vec3(motion), move) > 3e-4f;
    // u grows around the torus; v counts the image's rows, from the last one on.
    const float angle = 2 * float(M_PI) * texture.x;
    wrong += glm::dot(glm::vec2(texture.z, texture.w),
                      glm::vec2(-std::sin(angle), std::cos(angle))) < 0.99f;
    wrong += motion.w < 0.999f;
  }
  if (covered < kImageSide * kImageSide / 20) ++wrong;
  return wrong;
}

int run_renderer() {
  const planish::PolygonMesh mesh = textured_torus(16, 9);
  int wrong = 0, frames = 0;
  std::vector<std::string> messages;
  {
    Application app;
    render_frames(app, mesh, kHalf, kRenderedFrames, bones_of, view_of,
                  [&](int frame, const DrawnFrame& drawn) {
                    wrong += wrong_pixels(frame, drawn);
                    if (!drawn.patches.empty()) wrong += wrong_patches(drawn);
                    wrong += frame != frames++;
                    if (frame == 0) write_picture("textured.ppm", drawn.colours);
                    if (frame == 0) write_picture("tessellated.ppm", drawn.patches);
                  });
    messages = app.messages;
  }
  for (const std::string& message : messages) std::printf("%s\n", message.c_str());
  std::printf("%d frames rendered, %d pixels wrong\n", frames, wrong);
  return wrong == 0 && frames == kRenderedFrames && messages.empty() ? 0 : 1;
}

int run() {
  const planish::PolygonMesh mesh = torus(16, 9);
  double largest = 0;
  std::size_t index_bytes = 0;
  std::vector<std::byte> last;
  bool keeps_last = true;
  std::vector<std::string> messages;
  {
    Application app;
    draw_frames(
        app, mesh, kFrames,
        [&](int frame, std::span<std::byte> points) {
          const planish::PolygonMesh pose = posed(mesh, frame);
          const std::vector<glm::vec3> rounded(pose.positions.begin(), pose.positions.end());
          std::memcpy(points.data(), rounded.data(), points.size());
        },
        [&](int frame, std::span<const std::byte> vertices,
            std::span<const std::byte> last_vertices, std::span<const std::byte> indices) {
          largest = std::max(largest, difference(posed(mesh, frame), vertices));
          // What motion vectors go from: the frame before as it was drawn.
          if (frame > 0) keeps_last &= std::ranges::equal(last_vertices, last);
          last.assign(vertices.begin(), vertices.end());
          index_bytes = indices.size();
        });
    messages = app.messages;
  }
  for (const std::string& message : messages) std::printf("%s\n", message.c_str());
  std::printf("%d frames, off by %g\n", kFrames, largest);
  const bool right = keeps_last && largest < kTolerance && index_bytes == 4u * 6 * 16 * 9 * 16;
  return right && messages.empty() ? 0 : 1;
}

}  // namespace

int main() {
  // The package's own list of devices says whether there is any.
  const planish::VulkanDeviceList list = planish::list_vulkan_devices();
  const char* required = std::getenv("PLANISH_REQUIRE_VULKAN");
  if (list.best < 0 && !(required && std::string(required) == "1")) {
    std::printf("skipped: no Vulkan device: %s\n", list.reason.c_str());
    return 1;  // ctest knows the words
  }
  try {
    const int drawn = run();
    return run_renderer() != 0 ? 1 : drawn;
  } catch (const std::exception& error) {
    std::printf("%s\n", error.what());
    return 1;
  }
}
