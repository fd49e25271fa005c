#include "planish/files/usda/usd_materials.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <system_error>

#include "planish/core/formatted.h"
#include "planish/core/number_text.h"
#include "planish/files/gltf/json_values.h"
#include "planish/files/shared/identifier.h"

namespace planish {
namespace {

using nlohmann::json;
using Numbers = JsonNumbers;

std::string tuple_text(const Numbers& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "(" : ", ") + shortest(value);
  return text + ")";
}

const char* wrap_of(const json& sampler, const char* key) {
  constexpr int kClamped = 33071, kMirrored = 33648;
  const json& value = json_at(sampler, key);
  return value == kClamped ? "clamp" : value == kMirrored ? "mirror" : "repeat";
}

// As USD names a file; empty where it cannot.
std::string asset_path(const std::filesystem::path& file, const std::filesystem::path& folder) {
  std::error_code error;
  const std::filesystem::path from = folder.empty() ? std::filesystem::path(".") : folder;
  std::filesystem::path seen = std::filesystem::relative(file, from, error);
  if (error || seen.empty()) seen = std::filesystem::absolute(file, error);
  std::string name = seen.generic_string();
  const bool is_plain = std::ranges::none_of(name, [](unsigned char c) { return c < ' '; });
  if (error || !is_plain || name.find("@@@") != std::string::npos || name.ends_with('@')) return "";
  if (seen.is_relative() && !name.starts_with("../")) name.insert(0, "./");
  const char* quotes = name.find('@') == std::string::npos ? "@" : "@@@";
  return quotes + name + quotes;
}

// A texture's part of a material.
struct TextureUse {
  const char* shader;  // name of the prim
  bool is_color = false;
  Numbers scale, bias{0, 0, 0, 0};
};

class UsdConverter {
 public:
  UsdConverter(const GltfMaterials& given, const std::filesystem::path& folder)
      : given_(given), folder_(folder) {}

  UsdMaterials convert(std::span<const std::string> names) {
    for (const json& material : json_at(given_.lists, "materials")) {
      const std::string name = material.value("name", std::string());
      if (std::ranges::find(names, name) != names.end() && !made_.paths.contains(name))
        add(name, material);
    }
    if (!left_out_.empty()) {
      std::string list;
      for (const std::string& image : left_out_) list += (list.empty() ? "" : ", ") + image;
      made_.warnings.push_back(
          {"left-out-textures",
           "textures are left out: " + list + "; USD as text names files, which these are not",
           std::ssize(left_out_)});
    }
    return std::move(made_);
  }

 private:
  void line(const std::string& text) { made_.text += "            " + text + "\n"; }
  void input(const std::string& name, const std::string& value) { line(name + " = " + value); }
  void begin_shader(const std::string& name, const std::string& id) {
    made_.text += "        def Shader \"" + name + "\"\n        {\n";
    line("uniform token info:id = \"" + id + "\"");
  }
  void end_shader() { made_.text += "        }\n"; }
  [[nodiscard]] std::string connected(const std::string& output) const {
    return formatted("<{}/{}>", path_, output);
  }

  void add(const std::string& name, const json& material) {
    std::string prim = identifier_of(name);
    while (!prims_.insert(prim).second) prim += formatted("_{}", prims_.size());
    path_ = std::string(kUsdMaterials) + "/" + prim;
    made_.paths.emplace(name, path_);
    made_.text +=
        formatted("    def Material \"{}\"\n    {\n        token outputs:surface.connect = {}\n",
                  prim, connected("surface.outputs:surface"));
    textures_.clear();
    begin_shader("surface", "UsdPreviewSurface");
    add_base(material);
    add_metal(json_at(material, "pbrMetallicRoughness"));
    add_rest(material);
    line("token outputs:surface");
    end_shader();
    for (const auto& [texture, use] : textures_) add_texture(*texture, use);
    if (!textures_.empty()) {
      begin_shader("st", "UsdPrimvarReader_float2");
      line("string inputs:varname = \"st\"");
      line("float2 outputs:result");
      end_shader();
    }
    made_.text += "    }\n";
  }

  // Whether the texture is in a file; a shader for it will be made then.
  bool takes(const json& info, TextureUse use) {
    const json& texture = json_at(given_.lists, "textures", json_at(info, "index"));
    const json& source = json_at(texture, "source");
    const json& image = json_at(given_.lists, "images", source);
    if (!info.is_object()) return false;
    if (image.is_object() && source < given_.images.size()) {
      const GltfImage& held = given_.images[source.get<std::size_t>()];
      const bool is_known = held.type == "image/png" || held.type == "image/jpeg";
      if (is_known && !held.path.empty() && !asset_path(held.path, folder_).empty()) {
        textures_.emplace_back(&info, std::move(use));
        return true;
      }
    }
    const json& named = json_at(image, "name");
    left_out_.insert(named.is_string() ? named.get<std::string>()
                     : source.is_number_integer()
                         ? formatted("image {}", source.get<std::int64_t>())
                         : "one without an image that USD knows");
    return false;
  }

  void add_base(const json& material) {
    const json& pbr = json_at(material, "pbrMetallicRoughness");
    const Numbers color = values_of(json_at(pbr, "baseColorFactor"), {1, 1, 1, 1});
    const json& mode = json_at(material, "alphaMode");
    const bool is_opaque = mode != "BLEND" && mode != "MASK";
    if (takes(json_at(pbr, "baseColorTexture"),
              {.shader = "baseColor", .is_color = true, .scale = color})) {
      line("color3f inputs:diffuseColor.connect = " + connected("baseColor.outputs:rgb"));
      if (!is_opaque) line("float inputs:opacity.connect = " + connected("baseColor.outputs:a"));
    } else {
      input("color3f inputs:diffuseColor", tuple_text({color[0], color[1], color[2]}));
      if (!is_opaque) input("float inputs:opacity", shortest(color[3]));
    }
    constexpr double kUsualCutoff = 0.5;
    if (mode == "MASK")
      input("float inputs:opacityThreshold",
            shortest(number_at(json_at(material, "alphaCutoff"), kUsualCutoff)));
  }

  void add_metal(const json& pbr) {
    const double metallic = number_at(json_at(pbr, "metallicFactor"), 1),
                 roughness = number_at(json_at(pbr, "roughnessFactor"), 1);
    if (takes(json_at(pbr, "metallicRoughnessTexture"),
              {.shader = "metallicRoughness", .scale = {1, roughness, metallic, 1}})) {
      line("float inputs:metallic.connect = " + connected("metallicRoughness.outputs:b"));
      line("float inputs:roughness.connect = " + connected("metallicRoughness.outputs:g"));
    } else {
      input("float inputs:metallic", shortest(metallic));
      input("float inputs:roughness", shortest(roughness));
    }
  }

  void add_rest(const json& material) {
    Numbers glow = values_of(json_at(material, "emissiveFactor"), {0, 0, 0});
    const json& strength =
        json_at(json_at(json_at(material, "extensions"), "KHR_materials_emissive_strength"),
                "emissiveStrength");
    for (double& part : glow) part *= number_at(strength, 1);
    if (takes(json_at(material, "emissiveTexture"),
              {.shader = "emissive", .is_color = true, .scale = {glow[0], glow[1], glow[2], 1}})) {
      line("color3f inputs:emissiveColor.connect = " + connected("emissive.outputs:rgb"));
    } else if (glow != Numbers{0, 0, 0}) {
      input("color3f inputs:emissiveColor", tuple_text(glow));
    }
    const json& bumps = json_at(material, "normalTexture");
    const double s = number_at(json_at(bumps, "scale"), 1);
    if (takes(bumps, {.shader = "normal", .scale = {2 * s, 2 * s, 2, 1}, .bias = {-s, -s, -1, 0}}))
      line("normal3f inputs:normal.connect = " + connected("normal.outputs:rgb"));
    const json& shade = json_at(material, "occlusionTexture");
    const double o = number_at(json_at(shade, "strength"), 1);
    if (takes(shade,
              {.shader = "occlusion", .scale = {o, o, o, 1}, .bias = {1 - o, 1 - o, 1 - o, 0}}))
      line("float inputs:occlusion.connect = " + connected("occlusion.outputs:r"));
  }

  void add_texture(const json& info, const TextureUse& use) {
    const std::string name = use.shader;
    const json& texture = json_at(given_.lists, "textures", json_at(info, "index"));
    const json& sampler = json_at(given_.lists, "samplers", json_at(texture, "sampler"));
    const json& place = json_at(json_at(info, "extensions"), "KHR_texture_transform");
    const std::filesystem::path& file =
        given_.images[json_at(texture, "source").get<std::size_t>()].path;
    begin_shader(name, "UsdUVTexture");
    input("asset inputs:file", asset_path(file, folder_));
    line("float2 inputs:st.connect = " +
         connected(place.is_object() ? name + "_place.outputs:result" : "st.outputs:result"));
    input("token inputs:wrapS", std::string("\"") + wrap_of(sampler, "wrapS") + "\"");
    input("token inputs:wrapT", std::string("\"") + wrap_of(sampler, "wrapT") + "\"");
    input("token inputs:sourceColorSpace", use.is_color ? "\"sRGB\"" : "\"raw\"");
    input("float4 inputs:scale", tuple_text(use.scale));
    input("float4 inputs:bias", tuple_text(use.bias));
    for (const char* output : {"float3 outputs:rgb", "float outputs:r", "float outputs:g",
                               "float outputs:b", "float outputs:a"})
      line(output);
    end_shader();
    if (!place.is_object()) return;
    // glTF's v runs down, ours and USD's up.
    const Numbers scale = values_of(json_at(place, "scale"), {1, 1}),
                  offset = values_of(json_at(place, "offset"), {0, 0});
    const double turn = number_at(json_at(place, "rotation"), 0);
    begin_shader(name + "_place", "UsdTransform2d");
    line("float2 inputs:in.connect = " + connected("st.outputs:result"));
    input("float2 inputs:scale", tuple_text(scale));
    input("float inputs:rotation", shortest(turn * 180 / std::numbers::pi));
    input("float2 inputs:translation", tuple_text({offset[0] + scale[1] * std::sin(turn),
                                                   1 - offset[1] - scale[1] * std::cos(turn)}));
    line("float2 outputs:result");
    end_shader();
  }

  const GltfMaterials& given_;
  const std::filesystem::path& folder_;
  UsdMaterials made_;
  std::set<std::string> prims_, left_out_;
  std::string path_;  // of the material at hand
  std::vector<std::pair<const json*, TextureUse>> textures_;
};

}  // namespace

UsdMaterials usd_materials(const GltfMaterials& given, std::span<const std::string> names,
                           const std::filesystem::path& folder) {
  return UsdConverter(given, folder).convert(names);
}

}  // namespace planish
