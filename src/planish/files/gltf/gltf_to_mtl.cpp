#include "planish/files/gltf/gltf_to_mtl.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/formatted.h"
#include "planish/core/number_text.h"
#include "planish/core/visible_text.h"
#include "planish/files/gltf/json_values.h"

namespace planish {
namespace {

using nlohmann::json;

std::string numbers_text(const JsonNumbers& numbers) {
  std::string text;
  for (const double number : numbers) text += " " + shortest(number);
  return text;
}

// As a line of MTL in a folder names a file; empty where it cannot.
std::string file_in_mtl(const std::filesystem::path& file, const std::filesystem::path& folder) {
  std::string name =
      (folder.empty() || file.empty() ? file : file.lexically_relative(folder)).generic_string();
  const bool is_plain = std::ranges::none_of(name, [](unsigned char c) { return c < ' '; });
  if (!is_plain || name.find('#') != std::string::npos || name.ends_with(' ')) return "";
  if (name.starts_with('-') || name.starts_with(' ')) name.insert(0, "./");
  return name;
}

class MtlWriter {
 public:
  explicit MtlWriter(const GltfMaterials& given) : given_(given) {}

  MaterialLibrary convert() {
    const auto named = std::ranges::find_if(
        given_.images, [](const GltfImage& image) { return !image.path.empty(); });
    if (named != given_.images.end()) folder_ = named->path.parent_path();
    for (const json& material : json_at(given_.lists, "materials")) add(material);
    warn("left-out-textures", textures_,
         "textures are left out: {}; an MTL names files, which these are not");
    warn("left-out-material-properties", properties_,
         "of materials is left out what an MTL has no word for: {}");
    return std::move(made_);
  }

 private:
  void add(const json& material) {
    lines_.clear();
    const json& pbr = json_at(material, "pbrMetallicRoughness");
    add_base(material, pbr);
    JsonNumbers glow = values_of(json_at(material, "emissiveFactor"), {0, 0, 0});
    const json& extensions = json_at(material, "extensions");
    const json& strength = json_at(extensions, "KHR_materials_emissive_strength");
    for (double& part : glow) part *= number_at(json_at(strength, "emissiveStrength"), 1);
    if (glow != JsonNumbers{0, 0, 0}) lines_.push_back("Ke" + numbers_text(glow));
    add_texture("map_Ke", json_at(material, "emissiveTexture"));
    const json& bumps = json_at(material, "normalTexture");
    const double scale = number_at(json_at(bumps, "scale"), 1);
    add_texture("norm", bumps, scale == 1 ? "" : " -bm " + shortest(scale));
    if (json_at(material, "occlusionTexture").is_object()) properties_.insert("occlusionTexture");
    if (json_at(pbr, "metallicRoughnessTexture").is_object())
      properties_.insert("metallicRoughnessTexture");
    for (const auto& [name, value] : extensions.items())
      if (name != "KHR_materials_emissive_strength") properties_.insert(name);
    made_.add(material.value("name", std::string()), folder_, lines_);
  }

  void add_base(const json& material, const json& pbr) {
    const JsonNumbers color = values_of(json_at(pbr, "baseColorFactor"), {1, 1, 1, 1});
    lines_.push_back("Kd" + numbers_text({color[0], color[1], color[2]}));
    const json& mode = json_at(material, "alphaMode");
    if (mode == "BLEND") lines_.push_back("d" + numbers_text({color[3]}));
    if (mode == "MASK") properties_.insert("alphaMode MASK");
    lines_.push_back("Pr" + numbers_text({number_at(json_at(pbr, "roughnessFactor"), 1)}));
    lines_.push_back("Pm" + numbers_text({number_at(json_at(pbr, "metallicFactor"), 1)}));
    add_texture("map_Kd", json_at(pbr, "baseColorTexture"));
  }

  void add_texture(const char* keyword, const json& info, const std::string& options = {}) {
    if (!info.is_object()) return;
    const json& texture = json_at(given_.lists, "textures", json_at(info, "index"));
    const json& source = json_at(texture, "source");
    const bool has_image =
        source.is_number_unsigned() && source.get<std::size_t>() < given_.images.size();
    const std::filesystem::path file =
        has_image ? given_.images[source.get<std::size_t>()].path : std::filesystem::path();
    const std::string name = file_in_mtl(file, folder_);
    if (name.empty()) {
      const json& named = json_at(json_at(given_.lists, "images", source), "name");
      textures_.insert(named.is_string() ? visible(named.get<std::string>())
                       : has_image       ? formatted("image {}", source.get<std::size_t>())
                                         : "one without an image that OBJ knows");
      return;
    }
    const json& sampler = json_at(given_.lists, "samplers", json_at(texture, "sampler"));
    const bool clamps = json_at(sampler, "wrapS") == kClampToEdge;
    lines_.push_back(keyword +
                     place_options(json_at(json_at(info, "extensions"), "KHR_texture_transform")) +
                     (clamps ? " -clamp on" : "") + options + " " + name);
  }

  // glTF's v runs down, MTL's up.
  std::string place_options(const json& place) {
    if (!place.is_object()) return "";
    const JsonNumbers size = values_of(json_at(place, "scale"), {1, 1}),
                      offset = values_of(json_at(place, "offset"), {0, 0});
    if (number_at(json_at(place, "rotation"), 0) != 0) properties_.insert("texture rotation");
    return " -s" + numbers_text({size[0], size[1], 1}) + " -o" +
           numbers_text({offset[0], 1 - size[1] - offset[1], 0});
  }

  void warn(const char* code, const std::set<std::string>& what, std::string text) {
    if (what.empty()) return;
    std::string list;
    for (const std::string& one : what) list += (list.empty() ? "" : ", ") + one;
    text.replace(text.find("{}"), 2, list);
    made_.add_warning({code, text, std::ssize(what)});
  }

  const GltfMaterials& given_;
  MaterialLibrary made_;
  std::filesystem::path folder_;    // of the first image, that names start from
  std::vector<std::string> lines_;  // of the material at hand
  std::set<std::string> textures_, properties_;
};

}  // namespace

MaterialLibrary library_of(const GltfMaterials& given) { return MtlWriter(given).convert(); }

}  // namespace planish
