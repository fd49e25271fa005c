#include <cmath>
#include <fstream>
#include <memory>

#include "fuzz/fuzz_read.h"
#include "planish/core/json.h"
#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/files/materials.h"
#include "planish/mesh/check.h"
#include "support/temporary_folder.h"

namespace planish::test {

namespace {

void require_usable(const AssetMesh& mesh, std::int64_t corner_count) {
  require(static_cast<std::int64_t>(mesh.file.mesh.face_vertices.size()) <= 3 * corner_count);
  for (const MeshProblem& problem : check(mesh.file.mesh))
    require(problem.kind != MeshProblemKind::IndexOutOfRange &&
            problem.kind != MeshProblemKind::NonFinitePosition);
  require_visible(mesh.file.warnings);
}

// Each image has its place in the list, and all of it can be written.
void require_writable(const GltfMaterials& materials) {
  require(!materials.lists.contains("images") ||
          materials.lists["images"].size() == materials.images.size());
  (void)materials.lists.dump();
  require_visible(materials.warnings);
}

}  // namespace

void fuzz_read_asset(std::span<const std::byte> bytes, FileFormat format) {
  const FileBytes file{.bytes = bytes, .name = "fuzz", .path = {}};
  std::unique_ptr<const GltfAsset> asset;
  try {
    asset = asset_of(file, format);
    if (asset) (void)contents_of(*asset);
    if (asset) require_writable(materials_of(*asset));
    if (asset) (void)asset->byte_count();
  } catch (const Error& error) {
    require_refusal(error, {ErrorCode::UnreadableInput});
  }
  if (!asset) return;
  // One that cannot be read does not keep others from it.
  for (const std::int64_t number : asset->surfaces()) {
    try {
      (void)asset->may_be_scaled(number);
      require_usable(asset->read(number), asset->corner_count(number));
    } catch (const Error& error) {
      require_refusal(error, {ErrorCode::UnreadableInput});
    }
  }
}

void fuzz_read_mtl(std::span<const std::byte> bytes, FileFormat) {
  static const TemporaryFolder folder;
  const std::filesystem::path obj = folder.path() / "fuzz.obj";
  if (!std::filesystem::exists(obj)) std::ofstream(obj) << "mtllib fuzz.mtl\n";
  std::ofstream(folder.path() / "fuzz.mtl", std::ios::binary) << text_of(bytes);
  const MaterialLibrary library(obj);
  require_visible(library.warnings());
  for (const std::string& name : library.names()) {
    for (const MaterialStatement& statement : library.parsed(name)) {
      for (const double number : statement.numbers) require(std::isfinite(number));
      const MaterialTexture& texture = statement.texture;
      for (const double number :
           {texture.size.x, texture.size.y, texture.offset.x, texture.offset.y, texture.scale})
        require(std::isfinite(number));
    }
    const std::string moved = library.statements(name, folder.path().parent_path());
    require(moved.empty() || moved.ends_with('\n'));
  }
  const GltfMaterials materials = materials_of(library);
  require_writable(materials);
  const UsdMaterials usd = usd_materials(materials, library.names(), folder.path());
  require_visible(usd.warnings);
  for (const char c : usd.text) require(c == '\n' || c == '\t' || c < '\0' || c >= ' ');
}

}  // namespace planish::test
