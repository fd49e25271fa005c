#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "planish/core/json_fwd.h"
#include "planish/files/gltf/asset/asset_vertices.h"
#include "planish/files/gltf/gltf_budget.h"
#include "planish/files/gltf/gltf_source.h"
#include "planish/files/gltf/json_place.h"
#include "planish/files/mesh_file.h"

namespace planish {

/// A mesh of an asset in its own coordinates.
struct AssetMesh {
  std::int64_t number = 0;  ///< in the file
  std::string name;         ///< "meshes[3]" where it has none
  MeshFile file;
  AssetVertices vertices;
};

/// A glTF file with all that it holds, whose triangle meshes are to give way to surfaces: nodes,
/// materials, textures, skins, animations and what nobody here knows stay as they are. One thread
/// at a time: what lies beside the file or is packed is fetched when it is first asked for.
class GltfAsset {
 public:
  /// The bytes must outlive it. Throws Error{UnreadableInput}, naming the place, where something in
  /// it names what is not there.
  explicit GltfAsset(const FileBytes& file, const GltfLimits& limits = {});

  /// The numbers of the meshes that have triangles, in order.
  [[nodiscard]] const std::vector<std::int64_t>& surfaces() const { return surfaces_; }
  /// How many corners such a mesh names by what the file says, before it is read: those that the
  /// triangles of a strip or fan share count once. Throws Error{UnreadableInput}.
  [[nodiscard]] std::int64_t corner_count(std::int64_t number) const;
  /// What of the file is held until all is written: itself, buffers and images beside it, what it
  /// has packed. An upper estimate. Throws Error{UnreadableInput}.
  [[nodiscard]] std::uint64_t byte_count() const;
  /// One of those, by its number. `wants_tangents`: groups with texture coordinates whose material
  /// asks for no tangents get those of the first set. Throws Error{UnreadableInput},
  /// Error{OutOfMemory}.
  [[nodiscard]] AssetMesh read(std::int64_t number, bool wants_tangents = false) const;
  /// Whether its nodes may get children that scale it: they neither skin, instance nor morph it.
  [[nodiscard]] bool may_be_scaled(std::int64_t number) const;

  [[nodiscard]] const JsonPlace& root() const { return root_; }
  [[nodiscard]] GltfSource& source() const { return source_; }
  [[nodiscard]] const FileBytes& file() const { return file_; }

 private:
  [[nodiscard]] AssetMesh read_unguarded(std::int64_t number, bool wants_tangents) const;
  // Its nodes' skins have the joints that its vertices name.
  void require_joints(std::int64_t number, const AssetVertices& vertices) const;

  FileBytes file_;
  GltfLimits limits_;
  FileFormat format_;
  std::shared_ptr<const nlohmann::json> document_;
  JsonPlace root_;
  mutable GltfSource source_;  // fetches when it is asked
  std::vector<std::int64_t> surfaces_;
};

/// The same, where the file is a glTF with at least one mesh of triangles; else null.
[[nodiscard]] std::unique_ptr<const GltfAsset> asset_of(const FileBytes& file, FileFormat format);

}  // namespace planish
