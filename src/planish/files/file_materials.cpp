#include "planish/files/file_materials.h"

#include "planish/core/error.h"
#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/files/gltf/gltf_to_mtl.h"
#include "planish/files/gltf/mtl_to_gltf.h"

namespace planish {

std::vector<Warning> FileMaterials::warnings() const {
  std::vector<Warning> all = library.warnings();
  all.insert(all.end(), gltf.warnings.begin(), gltf.warnings.end());
  return all;
}

FileMaterials read_materials(const FileBytes& file, FileFormat format, bool to_obj, bool to_gltf) {
  FileMaterials made;
  if (format == FileFormat::Obj && !file.path.empty() && (to_obj || to_gltf)) {
    made.library =
        file.bytes.empty() ? MaterialLibrary(file.path, file.reach) : MaterialLibrary(file);
    if (to_gltf) made.gltf = materials_of(made.library);
    made.gltf.input = file.path;
  }
  if (!(to_gltf || to_obj) || !info_of(format).is_gltf) return made;
  try {
    if (const auto asset = asset_of(file, format)) made.gltf = materials_of(*asset);
    if (to_obj) made.library = library_of(made.gltf);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::UnreadableInput) throw;
    made.gltf.warnings.push_back(
        {"missing-materials", std::string(error.what()) + "; materials are left out"});
  }
  made.gltf.input = file.path;
  return made;
}

}  // namespace planish
