#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "planish/files/gltf/asset/asset_collector.h"
#include "planish/files/gltf/gltf_budget.h"
#include "planish/files/gltf/gltf_nodes.h"
#include "planish/files/gltf/gltf_points.h"
#include "planish/files/gltf/gltf_primitive.h"
#include "planish/files/gltf/gltf_source.h"
#include "planish/files/gltf/json_place.h"
#include "planish/files/mesh_file.h"
#include "planish/files/shared/attribute_collector.h"
#include "planish/files/shared/read_progress.h"
#include "planish/files/shared/split_normals.h"
#include "planish/files/shared/weld.h"

namespace planish {

/// Reads triangles, or points where there are none, of meshes as nodes place them; welded by exact
/// position over all of them. Everything that it is given must live longer.
class SceneReader {
 public:
  SceneReader(JsonPlace root, GltfSource& source, GltfBudget budget, const FileBytes& file)
      : root_(std::move(root)),
        source_(source),
        budget_(std::move(budget)),
        creases_from_normals_(file.split_normals_crease),
        bytes_(file.bytes.size()),
        progress_(file.progress) {}

  /// The default scene.
  [[nodiscard]] MeshFile read(FileFormat format);
  /// A mesh in its own coordinates; `asset` gets what no PolygonMesh has.
  [[nodiscard]] MeshFile read_mesh(FileFormat format, std::int64_t mesh, AssetCollector& asset);

 private:
  [[nodiscard]] MeshFile read(FileFormat format, std::span<const GltfInstance> instances);
  void read_instance(const GltfInstance& instance, std::size_t bytes);
  void read_primitive(const JsonPlace& place, const GltfInstance& instance, std::size_t bytes);
  void read_point_primitive(const JsonPlace& place, const GltfInstance& instance);
  [[nodiscard]] GltfInstance placed(std::int64_t vertex, const GltfInstance& instance) const;
  void name_group(const JsonPlace& place);
  void read_uvs(const JsonPlace& place, const SourcePrimitive& primitive);
  void read_normals(const SourcePrimitive& primitive, const GltfInstance& instance);
  void color_vertices(const SourcePrimitive& primitive);
  void find_faces(const JsonPlace& place, std::int64_t mode, bool mirrored);
  void find_polygons(bool mirrored);
  void add_faces();
  std::int32_t welded(const SourcePrimitive& primitive, std::int64_t vertex,
                      const GltfInstance& instance);

  JsonPlace root_;
  GltfSource& source_;
  GltfBudget budget_;
  Welder welder_;
  TriangleCollector triangles_;
  AttributeCollector attributes_;
  AssetCollector* asset_ = nullptr;
  bool creases_from_normals_;
  std::size_t bytes_;
  ReadProgress* progress_;
  std::vector<glm::dmat4> joints_;    // of the current instance's skin; empty: it has none
  std::vector<JointSet> joint_sets_;  // of the current primitive, where there are joints
  CornerNormals normals_;
  GltfPoints points_;
  std::vector<glm::dvec2> uvs_;
  std::int64_t first_uv_ = -1, first_normal_ = -1;  // of the current primitive; -1: it has none
  // By corner of the current primitive: its vertex, and what that is welded to.
  std::vector<std::int32_t> corners_, vertices_;
  PrimitiveFaces faces_;
  MeshFile file_;
  std::vector<std::string> material_names_;
  std::set<std::string> lost_of_points_;  // what points have that no mesh is made with
  std::int64_t colored_count_ = 0, shared_count_ = 0, first_shared_ = -1;
  std::int64_t deformed_count_ = 0, point_primitive_count_ = 0, primitive_count_ = 0;
  // By vertex of the current primitive: its welded vertex, valid where the stamp is the current.
  std::vector<std::int32_t> welded_vertices_;
  std::vector<std::int64_t> stamps_;
  std::int64_t stamp_ = 0;
  // By welded vertex: the last polygon that had it.
  std::vector<std::int64_t> polygon_of_;
  std::int64_t polygon_number_ = 0;
};

/// Throws Error{UnreadableInput} for a version but 2.x, for one that needs a later reader, and for
/// an extension that the file requires and nobody here reads.
void require_gltf_version(const JsonPlace& root);

}  // namespace planish
