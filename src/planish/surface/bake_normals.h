#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/raw_vector.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// A corner of triangles that lie in a texture.
struct BakeVertex {
  glm::vec2 uv{0.0f};       ///< v runs upwards
  glm::vec3 normal{0.0f};   ///< unit
  glm::vec4 tangent{0.0f};  ///< as glTF's TANGENT has it: where u grows, and 1 where v is to its
                            ///< left, -1 to its right
};

/// Triangles of a surface in a texture.
struct BakeSheet {
  RawVector<BakeVertex> vertices;
  RawVector<std::array<std::int32_t, 3>> triangles;
  RawVector<std::int32_t> faces;  ///< the face of the mesh that each triangle lies on
};

/// A texel of a normal texture, or what stands for one: x to the right, y upwards, z outwards.
using NormalDetail = std::function<glm::dvec3(const glm::dvec2& uv)>;

struct BakeOptions {
  int size = 1024;  ///< texels along a side, kLeastBakeSize to kMostBakeSize
  /// By face of the mesh: the part of the texture that it lies in, see texture_charts(); -1: none
  /// of it is baked.
  std::span<const std::int32_t> charts;
  /// What a normal texture adds to the fine surface, whose tangents are needed then; empty: none.
  NormalDetail detail;
  Callbacks callbacks;  ///< step "bake"
};

inline constexpr int kLeastBakeSize = 16, kMostBakeSize = 8192;

/// A tangent-space normal texture, and what is known of the texture coordinates it lies by.
struct NormalMap {
  int size = 0;
  std::vector<std::uint8_t> pixels;    ///< RGB, the top row first, as glTF has it: +Y is up
  double covered = 0;                  ///< share of the texture that the mesh covers
  double overlapped = 0;               ///< of that: share where several places of the mesh lie
  double filled = 0;                   ///< of that: share that has the normal of a texel beside it
  std::int32_t overlapping_face = -1;  ///< the first that lies on others; -1: none
  std::int32_t outside_face = -1;      ///< the first that leaves the square from 0 to 1; -1: none
  /// The first whose chart lies on itself once its coordinates are wrapped: the texture repeats
  /// there. -1: none.
  std::int32_t repeating_face = -1;
};

/// Parts of a texture: faces that lie beside each other there, the same way round. By face a number
/// from 0; -1: it has no coordinates, or `is_wanted` says no. `uvs`: as many as those of the mesh,
/// whose indices are taken.
[[nodiscard]] std::vector<std::int32_t> texture_charts(
    const PolygonMesh& mesh, std::span<const glm::dvec2> uvs,
    const std::function<bool(std::int32_t face)>& is_wanted);

/// The normals of a fine surface in the frames of a mesh that has the same texture coordinates:
/// what a renderer turns back into them that interpolates normal and tangent, without making them
/// unit, and takes sign * cross(normal, tangent) as bitangent. Each texel has the mean of several
/// places. Where faces lie on each other the first counts, one inside of the square before one that
/// is wrapped into it. Texels beside the mesh have those next to them, as far as mipmaps mix them
/// in; all others are flat. The same bits for every number of threads. Source: M. Mikkelsen,
/// "Simulation of Wrinkled Surfaces Revisited", 2008; Khronos Group, "glTF 2.0 Specification",
/// section 3.9.3.
[[nodiscard]] NormalMap bake_normals(const BakeSheet& low, const BakeSheet& fine,
                                     const BakeOptions& options);

}  // namespace planish
