#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <vector>

namespace planish::render {

/// What is drawn: a triangle mesh with normals, in the file's coordinates.
struct RenderMesh {
  std::vector<glm::vec3> positions, normals;
  std::vector<std::uint32_t> indices;
};

/// The first mesh of a GLB that planish wrote, compressed or not, in the coordinates of its
/// accessors. Throws Error{UnreadableInput} for anything else.
[[nodiscard]] RenderMesh read_glb(const std::filesystem::path& path);

/// How fast the normal turns at each vertex, in radians over the bounding-box diagonal: the mean
/// over the edges of its triangles.
[[nodiscard]] std::vector<float> curvature_of(const RenderMesh& mesh);

}  // namespace planish::render
