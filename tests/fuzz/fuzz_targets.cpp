#include "fuzz/fuzz_targets.h"

#include "fuzz/fuzz_command.h"
#include "fuzz/fuzz_read.h"

namespace planish::test {

std::vector<FuzzTarget> fuzz_targets() {
  std::vector<FuzzTarget> targets;
  std::vector<std::string> files;
  const auto add_format = [&](const std::string& name, FileFormat format, auto* read) {
    targets.push_back({name, format, read, {name}});
    files.push_back(name);
  };
  for (const FormatInfo& info : formats()) {
    const std::string name(info.name);
    if (info.read_mesh) add_format(name, info.format, fuzz_read_mesh);
    if (info.read_points) add_format("points_" + name, info.format, fuzz_read_points);
  }
  targets.insert(targets.end(), {{"draco", FileFormat::Glb, fuzz_read_draco, {"draco"}},
                                 {"meshopt", FileFormat::Glb, fuzz_read_meshopt, {"meshopt"}},
                                 {"lzf", FileFormat::Pcd, fuzz_read_lzf, {"lzf"}},
                                 {"asset_glb", FileFormat::Glb, fuzz_read_asset, {"glb"}},
                                 {"asset_gltf", FileFormat::Gltf, fuzz_read_asset, {"gltf"}},
                                 {"mtl", FileFormat::Obj, fuzz_read_mtl, {"mtl"}},
                                 {"scene", FileFormat::Obj, fuzz_read_scene, {"scene"}},
                                 {"cage", FileFormat::Obj, fuzz_read_cage, {"cage"}},
                                 {"text", FileFormat::Obj, fuzz_write_text, {"text"}},
                                 {"query", FileFormat::Xyz, fuzz_query, {"query"}},
                                 {"inspect", FileFormat::Obj, fuzz_inspect, files}});
  return targets;
}

}  // namespace planish::test
