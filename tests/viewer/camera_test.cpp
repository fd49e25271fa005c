#include "viewer/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>
#include <vector>

namespace planish::testing {
namespace {

using viewer::OrbitCamera;

glm::vec3 projected(const OrbitCamera& camera, const glm::vec3& point, float aspect) {
  const glm::vec4 clip = camera.clip_from_world(aspect) * glm::vec4(point, 1);
  return glm::vec3(clip) / clip.w;
}

TEST(OrbitCamera, KeepsItsSphereInView) {
  OrbitCamera camera;
  camera.centre = {3, -1, 2};
  camera.radius = 2.5f;
  for (const float aspect : {0.4f, 1.0f, 2.5f})
    for (const float elevation : {-89.0f, 20.0f, 89.0f}) {
      camera.elevation_degrees = elevation;
      const glm::vec3 middle = projected(camera, camera.centre, aspect);
      EXPECT_NEAR(middle.x, 0, 1e-5);
      EXPECT_NEAR(middle.y, 0, 1e-5);
      float largest = 0;
      for (int i = 0; i < 400; ++i) {
        const float z = -1 + 2 * (static_cast<float>(i) + 0.5f) / 400, turn = 2.4f * i;
        const float r = std::sqrt(1 - z * z);
        const glm::vec3 p = projected(
            camera,
            camera.centre + camera.radius * glm::vec3(r * std::cos(turn), r * std::sin(turn), z),
            aspect);
        largest = std::max({largest, std::abs(p.x), std::abs(p.y)});
        EXPECT_GT(p.z, 0);
        EXPECT_LT(p.z, 1);
      }
      EXPECT_LT(largest, 1);
      EXPECT_GT(largest, 0.9);
    }
}

TEST(OrbitCamera, UpIsUpAndRightIsRight) {
  OrbitCamera camera;
  camera.azimuth_degrees = 0;
  camera.elevation_degrees = 0;
  EXPECT_GT(camera.eye(1).z, 0);                       // looks along -z
  EXPECT_LT(projected(camera, {0, 0.5f, 0}, 1).y, 0);  // Vulkan's y points down
  EXPECT_GT(projected(camera, {0.5f, 0, 0}, 1).x, 0);
  EXPECT_LT(projected(camera, {0, 0, 0.5f}, 1).z, projected(camera, {0, 0, -0.5f}, 1).z);
}

TEST(OrbitCamera, DragsThingsAlongAndStopsAtThePoles) {
  OrbitCamera camera;
  camera.azimuth_degrees = camera.elevation_degrees = 0;
  camera.orbit(0.1f, 0.1f);
  const glm::vec3 front = projected(camera, {0, 0, 1}, 1);
  EXPECT_GT(front.x, 0);
  EXPECT_GT(front.y, 0);
  camera.orbit(0, 10);
  EXPECT_EQ(camera.elevation_degrees, 89);
  for (int i = 0; i < 100; ++i) camera.zoom_by(2);
  EXPECT_EQ(camera.zoom, 20);
}

TEST(OrbitCamera, FramesABoxOfPoints) {
  const std::vector<glm::dvec3> points{{1, 2, 3}, {3, 2, 3}, {1, 4, 4}};
  const OrbitCamera camera = viewer::camera_around(points);
  EXPECT_EQ(camera.centre, glm::vec3(2, 3, 3.5));
  EXPECT_FLOAT_EQ(camera.radius, 1.5f);
}

TEST(OrbitCamera, KeyLightComesFromTheUpperLeftOfTheEye) {
  OrbitCamera camera;
  for (const float azimuth : {0.0f, 120.0f, -75.0f}) {
    camera.azimuth_degrees = azimuth;
    const glm::vec3 key = camera.key_light();
    EXPECT_NEAR(glm::length(key), 1, 1e-6);
    const glm::vec3 lamp = projected(camera, 0.5f * key, 1);
    EXPECT_LT(lamp.x, 0);
    EXPECT_LT(lamp.y, 0);
    EXPECT_GT(glm::dot(key, glm::normalize(camera.eye(1))), 0.3);
  }
}

}  // namespace
}  // namespace planish::testing
