#include "planish/files/gltf/asset/gltf_asset.h"

#include <algorithm>
#include <utility>

#include "planish/core/json.h"
#include "planish/core/visible_text.h"
#include "planish/files/gltf/asset/asset_checks.h"
#include "planish/files/gltf/asset/json_guard.h"
#include "planish/files/gltf/asset/primitive_parts.h"
#include "planish/files/gltf/glb_parts.h"
#include "planish/files/gltf/scene_reader.h"
#include "planish/mesh/mirrored_charts.h"

namespace planish {
namespace {

void copy_elements(std::vector<glm::dvec2>& values, std::span<const std::int32_t> copied) {
  for (const std::int32_t from : copied) values.push_back(values[from]);
}

// In every set of texture coordinates, with all that goes by their indices.
void cut_mirrored(PolygonMesh& mesh, AssetVertices& vertices) {
  for (std::size_t set = 0; set <= vertices.further_uvs.size(); ++set) {
    const std::vector<std::int32_t> copied =
        cut_mirrored_charts(mesh, set == 0 ? mesh.uvs : vertices.further_uvs[set - 1]);
    for (std::vector<glm::dvec2>& further : vertices.further_uvs) copy_elements(further, copied);
    for (AssetUvMoves& moves : vertices.uv_moves) copy_elements(moves.values, copied);
    for (AssetArray& array : vertices.arrays)
      if (array.of_corners)
        for (const std::int32_t from : copied)
          for (int k = 0; k < array.width; ++k)
            array.values.push_back(array.values[static_cast<std::size_t>(array.width * from + k)]);
  }
}

}  // namespace

GltfAsset::GltfAsset(const FileBytes& file, const GltfLimits& limits)
    : file_(file),
      limits_(limits),
      format_(split_glb(file.bytes, file.name).format),
      document_(std::make_shared<nlohmann::json>(
          parse_json(split_glb(file.bytes, file.name).json, file.name))),
      root_(*document_, file_.name, ""),
      source_(root_, split_glb(file.bytes, file.name).chunk, file) {
  file_.progress = nullptr;  // which counts the bytes of a scene
  require_gltf_version(root_);
  require_sound_asset(root_);
  const auto meshes = root_.find("meshes");
  for (std::int64_t i = 0; meshes && i < meshes->array_size(); ++i) {
    const JsonPlace primitives = (*meshes)[i]["primitives"];
    bool has_triangles = false;
    for (std::int64_t k = 0; k < primitives.array_size(); ++k)
      has_triangles |= is_surface(primitives[k].value());
    if (has_triangles) surfaces_.push_back(i);
  }
}

std::int64_t GltfAsset::corner_count(std::int64_t number) const {
  const JsonPlace primitives = root_["meshes"][number]["primitives"];
  std::int64_t count = 0;
  for (std::int64_t i = 0; i < primitives.array_size(); ++i) {
    const JsonPlace primitive = primitives[i];
    if (!is_surface(primitive.value())) continue;
    const auto indices = primitive.find("indices");
    const JsonPlace accessor = indices ? *indices : primitive["attributes"]["POSITION"];
    count += root_["accessors"][accessor.integer()]["count"].integer();
  }
  return count;
}

std::uint64_t GltfAsset::byte_count() const {
  std::uint64_t bytes = file_.bytes.size();
  const auto add_lengths = [&](std::string_view list, std::string_view having) {
    const auto all = root_.find(list);
    for (std::int64_t i = 0; all && i < all->array_size(); ++i)
      if ((*all)[i].find(having))
        bytes += static_cast<std::uint64_t>((*all)[i]["byteLength"].integer());
  };
  add_lengths("buffers", "uri");
  add_lengths("bufferViews", "extensions");
  const auto images = root_.find("images");
  for (std::int64_t i = 0; images && i < images->array_size(); ++i) {
    const auto uri = (*images)[i].find("uri");
    if (!uri || file_.path.empty()) continue;
    std::error_code error;
    if (const auto name = decode_uri_path(uri->text())) {
      const auto size = std::filesystem::file_size(file_.path.parent_path() / *name, error);
      if (!error) bytes += size;
    }
  }
  return bytes;
}

AssetMesh GltfAsset::read(std::int64_t number, bool wants_tangents) const {
  return guard_json(file_.name, [&] { return read_unguarded(number, wants_tangents); });
}

AssetMesh GltfAsset::read_unguarded(std::int64_t number, bool wants_tangents) const {
  const JsonPlace place = root_["meshes"][number];
  AssetMesh mesh{.number = number, .name = place.path(), .file = {}, .vertices = {}};
  if (const auto name = place.find("name"); name && name->is_text() && !name->text().empty())
    mesh.name = visible(name->text());
  AssetCollector collector;
  mesh.file = SceneReader(root_, source_, GltfBudget(limits_, file_.name), file_)
                  .read_mesh(format_, number, collector);
  mesh.vertices = collector.finish(mesh.file.mesh);
  const std::vector<Warning>& warnings = mesh.vertices.warnings;
  mesh.file.warnings.insert(mesh.file.warnings.end(), warnings.begin(), warnings.end());
  mesh.file.stands_alone = !mesh.vertices.moves() && !mesh.vertices.rides_on_uvs();
  require_joints(number, mesh.vertices);
  const auto set_of = [&](std::int64_t primitive) {
    return tangent_set(root_.value(), place["primitives"][primitive].value());
  };
  for (AssetGroup& group : mesh.vertices.groups) {
    int set = set_of(group.primitive);
    if (set < 0 && wants_tangents) set = 0;
    if (set < group.uv_sets) group.tangent_set = set;
    for (AssetLayer& layer : group.layers) {
      const int own = set_of(layer.primitive);
      if (own >= 0 && own < layer.uv_sets) layer.tangent_set = layer.first_uv_set + own;
    }
  }
  cut_mirrored(mesh.file.mesh, mesh.vertices);
  return mesh;
}

void GltfAsset::require_joints(std::int64_t number, const AssetVertices& vertices) const {
  if (vertices.influences.empty()) return;
  const std::int64_t last = std::ranges::max(vertices.influences, {}, &JointWeight::joint).joint;
  const auto nodes = root_.find("nodes");
  for (std::int64_t i = 0; nodes && i < nodes->array_size(); ++i) {
    const auto mesh = (*nodes)[i].find("mesh"), skin = (*nodes)[i].find("skin");
    if (!mesh || !skin || mesh->integer() != number) continue;
    const std::int64_t joints = root_["skins"][skin->integer()]["joints"].array_size();
    if (last >= joints)
      skin->fail(
          "its mesh names joint {}, and the skin has {}; take the skin that the mesh was made for",
          last, joints);
  }
}

bool GltfAsset::may_be_scaled(std::int64_t number) const {
  const JsonPlace primitives = root_["meshes"][number]["primitives"];
  for (std::int64_t i = 0; i < primitives.array_size(); ++i)
    if (primitives[i].find("targets") || !is_surface(primitives[i].value())) return false;
  const auto nodes = root_.find("nodes");
  for (std::int64_t i = 0; nodes && i < nodes->array_size(); ++i) {
    const JsonPlace node = (*nodes)[i];
    const auto mesh = node.find("mesh");
    // Nobody knows what extensions do with the node's mesh.
    if (mesh && mesh->integer() == number && (node.find("skin") || node.find("extensions")))
      return false;
  }
  return true;
}

std::unique_ptr<const GltfAsset> asset_of(const FileBytes& file, FileFormat format) {
  if (!info_of(format).is_gltf) return nullptr;
  auto asset = std::make_unique<const GltfAsset>(file);
  return asset->surfaces().empty() ? nullptr : std::move(asset);
}

}  // namespace planish
