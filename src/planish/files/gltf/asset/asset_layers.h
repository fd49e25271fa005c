#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <unordered_map>
#include <vector>

#include "planish/files/gltf/asset/asset_vertices.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Faces of a primitive: those of face f are corners[ends[f - 1]] to corners[ends[f]].
struct PrimitiveFaces {
  std::vector<std::int32_t> ends;
  std::vector<std::int32_t> corners;  ///< of the primitive, in its order

  void add(std::span<const std::int32_t> face) {
    corners.insert(corners.end(), face.begin(), face.end());
    ends.push_back(static_cast<std::int32_t>(corners.size()));
  }
  void clear() { ends.clear(), corners.clear(); }
  [[nodiscard]] std::size_t count() const { return ends.size(); }
  [[nodiscard]] std::span<const std::int32_t> face(std::size_t f) const {
    const auto begin = static_cast<std::size_t>(f == 0 ? 0 : ends[f - 1]);
    return std::span(corners).subspan(begin, static_cast<std::size_t>(ends[f]) - begin);
  }
};

/// Primitives on faces that others have already, as decals and coats are: a further material on the
/// same surface. While a mesh is read, and then joined with what its corners have.
class AssetLayers {
 public:
  /// What the layers' corners have, by the numbers of vertices that AssetCollector gives.
  struct Given {
    /// TEXCOORD_0, TEXCOORD_1 ...
    std::vector<std::vector<glm::dvec2>> uvs;
    std::vector<AssetUvMoves> uv_moves;
    std::vector<AssetArray> arrays;  ///< of_corners
  };

  /// Faces that follow in the mesh are of primitives of a kind: with the same material.
  void begin_kind(std::int32_t first_face, int kind);
  /// Whether every face of a primitive is one of `mesh`, with the same vertices in the same order
  /// round, and none has its kind: then it is a layer, which add() makes it. `vertices`: of the
  /// mesh, by corner of the primitive.
  [[nodiscard]] bool find(const PolygonMesh& mesh, const PrimitiveFaces& faces,
                          std::span<const std::int32_t> vertices, int kind);
  /// The primitive that was found last. `numbers`: of vertices, by corner of the primitive.
  void add(const PolygonMesh& mesh, const PrimitiveFaces& faces,
           std::span<const std::int32_t> numbers, AssetLayer layer, int kind);
  [[nodiscard]] bool empty() const { return layers_.empty(); }
  /// Gives corners of the mesh indices by which they have what is the mesh's own and what is of
  /// their layers, and faces groups with their layers.
  void join(PolygonMesh& mesh, AssetVertices& made, const Given& given) const;

 private:
  struct Kind {
    std::int32_t first_face;
    int kind;
  };
  struct Layer {
    AssetLayer made;
    int kind;
  };
  // So many layers lie under these. Negative: a face has none.
  struct Depth {
    std::vector<std::int32_t> layer_of_face;
    std::vector<std::int32_t> numbers;  // by corner of the mesh
  };

  // A face of the mesh, and how far another is turned against it.
  struct Found {
    std::int32_t face = -1;
    std::size_t turn = 0;
  };

  [[nodiscard]] Found face_of(const PolygonMesh& mesh, std::span<const std::int32_t> vertices);
  [[nodiscard]] int kind_of(std::int32_t face) const;
  // Sets of texture coordinates that layers of a depth have.
  [[nodiscard]] int uv_sets_at(int depth) const;
  void join_corners(PolygonMesh& mesh, AssetVertices& made, const Given& given) const;
  void join_groups(PolygonMesh& mesh, AssetVertices& made) const;

  std::vector<Kind> kinds_;  // by first face
  std::vector<Layer> layers_;
  std::vector<Depth> depths_;
  // Faces by their least vertex and the next, and how many of the mesh are here.
  std::unordered_multimap<std::uint64_t, std::int32_t> faces_;
  std::int32_t known_faces_ = 0;
  // Of the primitive that was found last.
  std::vector<Found> found_;
  std::size_t depth_ = 0;
};

}  // namespace planish
