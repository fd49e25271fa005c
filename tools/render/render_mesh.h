#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace planish::render {

/// What is drawn: a triangle mesh with normals.
struct RenderMesh {
  glm::dvec3 origin{0};  ///< that positions are from, in the scene's coordinates
  std::vector<glm::vec3> positions, normals;
  std::vector<std::uint32_t> indices;
  std::vector<float> values;  ///< of the attribute that was asked for, one a vertex; else none
};

/// All meshes of the default scene of a GLB that planish wrote, compressed or not, where their
/// nodes place them, from where the first one stands; with the numbers of an attribute
/// (_MEAN_CURVATURE and the like) if it is named. Throws Error{UnreadableInput} for anything else,
/// Error{OutOfMemory}.
[[nodiscard]] RenderMesh read_glb(const std::filesystem::path& path,
                                  const std::string& attribute = {});

/// The magnitude that 19 of 20 of these do not exceed, NaN left out; 1 where that is 0.
[[nodiscard]] float usual_magnitude(const std::vector<float>& values);

/// How fast the normal turns at each vertex, in radians over the bounding-box diagonal: the mean
/// over the edges of its triangles.
[[nodiscard]] std::vector<float> curvature_of(const RenderMesh& mesh);

}  // namespace planish::render
