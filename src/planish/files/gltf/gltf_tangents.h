#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// Which corners of some quads are one vertex: the same row and texture coordinate.
struct TangentShape {
  std::vector<std::uint8_t> corners;  ///< the vertex of each, four a quad
  std::vector<std::uint8_t> first;    ///< the first corner of each vertex
};

/// Neighbouring quads, at most 16: what they sum up is one for each vertex.
struct TangentCluster {
  std::size_t shape = 0;
  int set = 0;  ///< of texture coordinates
  std::size_t first_vertex = 0, first_cut = 0;
  std::int64_t face = 0;  ///< of the surface, its first; all descend from one of the mesh
};

/// The triangles of some faces, as write_gltf() writes them, by clusters.
struct TangentClusters {
  std::vector<TangentShape> shapes;
  std::vector<TangentCluster> clusters;
  RawVector<std::int32_t> rows, uvs;  ///< of each vertex
  RawVector<glm::vec3> positions, normals;
  std::vector<std::uint8_t> cuts;  ///< of each quad: whether it is cut from corner 1 to 3
};

/// Makes them; keeps its memory. Of a surface of quads alone the faces that descend from one of the
/// mesh come together; else each quad is one cluster, and each triangle of another polygon.
class TangentClusterMaker {
 public:
  /// `set_of_group`: the texture coordinates of faces; -1: they are left out. Positions are about
  /// 0, in the single precision in which they are written.
  TangentClusterMaker(const SurfaceBlocks& surface, std::span<const int> set_of_group)
      : surface_(surface), set_of_group_(set_of_group) {}

  void operator()(RowRange faces, TangentClusters& made);

 private:
  void add_quads(RowRange faces, TangentClusters& made);
  void add_polygons(RowRange faces, TangentClusters& made);
  [[nodiscard]] std::size_t shape_of(std::size_t corner, std::size_t count,
                                     TangentClusters& made) const;
  void add(const TangentCluster& cluster, std::size_t corner, TangentClusters& made);
  void take_rows(TangentClusters& made);

  const SurfaceBlocks& surface_;
  std::span<const int> set_of_group_;
  RawVector<std::int32_t> rows_, uvs_, groups_, ancestors_;  // of all corners, of all faces
  RawVector<glm::dvec3> positions_;                          // of all corners, where needed
  RawVector<glm::vec3> normals_;
  std::vector<std::size_t> corners_;  // of each vertex
  std::vector<std::int32_t> numbers_;
  std::vector<std::uint32_t> triangles_;
};

/// Texture coordinates of normal textures on a surface.
struct TangentSource {
  std::vector<std::span<const glm::dvec2>> sets;  ///< one value for each of the surface's
  std::vector<int> set_of_group;                  ///< by the group of a face; -1: none is wanted
};

/// glTF's TANGENT: where u grows, of unit length and square to the normal, and whether v grows to
/// its left (1) or right (-1).
struct SurfaceTangents {
  /// Four numbers for each texture coordinate of the surface; zeros where none is wanted.
  RawVector<float> values;
  /// The same of texture coordinates on further rows, across sharp edges; ascending.
  std::vector<UvOnRow> further;
  std::vector<float> further_values;
};

/// They are those of MikkTSpace for the triangles that write_gltf() writes, of positions about 0 in
/// single precision, where no texture coordinate belongs to faces that lie either way round in the
/// texture; where a texture has no extent they are any square to the normal. Takes 24 bytes a
/// texture coordinate. Throws Error{Cancelled}.
/// Source: M. Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008, section 4, and the
/// program that goes with it.
[[nodiscard]] SurfaceTangents surface_tangents(const SurfaceBlocks& surface,
                                               const TangentSource& source);

}  // namespace planish
