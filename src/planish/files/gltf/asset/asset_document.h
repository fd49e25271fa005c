#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "planish/core/json.h"
#include "planish/files/gltf/asset/asset_references.h"
#include "planish/files/gltf/asset/geometry_extensions.h"
#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/files/gltf/asset/mesh_levels.h"
#include "planish/files/gltf/gltf_document.h"

namespace planish {

struct AssetSurface;  // write_asset.h

/// An asset's document while surfaces come in the place of triangles. New accessors and buffer
/// views take the places of those that nothing else names, so that no number in the rest of the
/// document changes, which may be one of an extension that nobody here knows.
class AssetDocument {
 public:
  /// `keeps_files`: images beside the asset, and those in data URIs, stay there; else all come into
  /// the buffer. Throws Error{UnreadableInput} where the
  /// asset names bytes that are not there.
  AssetDocument(const GltfAsset& asset, const std::set<std::int64_t>& replaced_meshes,
                bool keeps_files);

  /// Puts a surface's document, `made` as gltf_json() has it, in the place of a mesh's triangles;
  /// its bytes follow those before it.
  void replace(std::int64_t mesh, const AssetVertices& vertices, const GltfDocument& document,
               const nlohmann::json& made, double least_coverage = 0);
  /// Another surface of the same mesh, coarser than those before it, as a level of detail: see
  /// place_levels(). It has what the mesh has besides triangles, too.
  void add_level(std::int64_t mesh, const AssetVertices& vertices, const GltfDocument& document,
                 const nlohmann::json& made, double least_coverage);
  /// An image in the buffer; before the first surface. Returns its number.
  std::int64_t add_image(std::span<const std::byte> bytes, const std::string& type);
  /// Gives the materials of a mesh that was replaced these normal textures: `images` of its maps.
  /// Materials that other primitives have, too, are copied.
  void set_normal_maps(std::int64_t mesh, const GltfDocument& document, const AssetSurface& surface,
                       std::span<const std::int64_t> images);
  /// Adds what stands in `extras` to asset.extras, unless the asset has that already.
  void add_extras(const nlohmann::json& extras);
  /// The text, with `uri` for the buffer of a .gltf. Throws Error{UnreadableInput} where the asset
  /// requires an extension that its new triangles make untrue.
  [[nodiscard]] std::string text(const std::string& uri);

  /// Bytes that come before those of the surfaces, each piece padded to a multiple of four.
  [[nodiscard]] const std::vector<std::span<const std::byte>>& kept() const { return kept_; }
  [[nodiscard]] std::uint64_t buffer_bytes() const { return buffer_bytes_; }
  /// What of the asset could not come along.
  [[nodiscard]] const std::vector<Warning>& warnings() const { return warnings_; }

 private:
  // Of a list of the document, the places that new elements take.
  struct Places {
    std::set<std::int64_t> free;
    std::int64_t next(nlohmann::json& list);
  };

  std::uint64_t keep(std::span<const std::byte> bytes);
  void keep_views();
  [[nodiscard]] bool stays(const JsonPlace& uri) const;
  void keep_images();
  void put_material(nlohmann::json& primitive, std::int64_t given, std::int64_t number);
  std::vector<std::int64_t> append_accessors(const GltfDocument& document,
                                             const nlohmann::json& made);
  nlohmann::json primitives_of(std::int64_t mesh, const AssetVertices& vertices,
                               const GltfDocument& document, const nlohmann::json& made);
  void drop_unused_places(const char* list, Places& places, const nlohmann::json& filler);
  void tell_lost_extensions();
  void settle_extensions();

  const GltfAsset& asset_;
  nlohmann::json json_;
  bool keeps_files_;
  Places accessors_, views_;
  std::vector<std::span<const std::byte>> kept_;
  std::uint64_t buffer_bytes_ = 0, decoded_bytes_ = 0;
  std::set<std::string> new_extensions_;
  std::vector<Warning> warnings_;
  LostExtensions lost_;
  std::map<std::int64_t, std::vector<MeshLevel>> levels_;  // by the mesh that gave way
  bool keeps_vertices_ = false;                            // of some primitive
};

}  // namespace planish
