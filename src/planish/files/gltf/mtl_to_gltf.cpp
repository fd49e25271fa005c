#include "planish/files/gltf/mtl_to_gltf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "planish/core/visible_text.h"
#include "planish/files/gltf/asset/image_type.h"
#include "planish/files/gltf/json_values.h"
#include "planish/files/read_file.h"

namespace planish {
namespace {

using nlohmann::json;

constexpr double kUsualRoughness = 0.5, kMostShininess = 1000;

class Converter {
 public:
  explicit Converter(const MaterialLibrary& library) : library_(library) {}

  GltfMaterials convert() {
    made_.has_sides = false;
    for (const std::string& name : library_.names()) add(name, library_.parsed(name));
    if (left_out_ > 0)
      made_.warnings.push_back(
          {"left-out-textures",
           first_ + "; the texture is left out" + (left_out_ > 1 ? ", and others" : ""),
           left_out_});
    if (!untaken_.empty()) {
      std::string list;
      for (const std::string& keyword : untaken_) list += (list.empty() ? "" : ", ") + keyword;
      made_.warnings.push_back({"left-out-textures",
                                "textures of an MTL that are left out: " + list +
                                    "; map_Kd, map_Ke, norm and map_bump are taken",
                                std::ssize(untaken_)});
    }
    return std::move(made_);
  }

 private:
  void add(const std::string& name, const std::vector<MaterialStatement>& statements) {
    json material{{"name", valid_utf8(name)}}, pbr = json::object();
    std::vector<double> color{1, 1, 1}, glow{0, 0, 0};
    double alpha = 1, metallic = 0;
    std::optional<double> roughness, shininess;
    for (const MaterialStatement& statement : statements) {
      const auto& [keyword, numbers, texture] = statement;
      const double first = numbers.empty() ? 0 : numbers[0];
      if (keyword == "kd" && numbers.size() >= 3) color = {numbers.begin(), numbers.begin() + 3};
      if (keyword == "ke" && numbers.size() >= 3) glow = {numbers.begin(), numbers.begin() + 3};
      if (numbers.empty() && texture.path.empty()) continue;
      if (keyword == "d") alpha = first;
      if (keyword == "tr") alpha = 1 - first;
      if (keyword == "pr") roughness = first;
      if (keyword == "pm") metallic = first;
      if (keyword == "ns") shininess = first;
      constexpr std::array<std::string_view, 5> kTaken = {"map_kd", "map_ke", "norm", "map_bump",
                                                          "bump"};
      if (!texture.path.empty() && std::ranges::find(kTaken, keyword) == kTaken.end())
        untaken_.insert(keyword);
      if (keyword == "map_kd") set_texture(pbr, "baseColorTexture", texture);
      if (keyword == "map_ke") set_texture(material, "emissiveTexture", texture);
      if (keyword == "norm" || keyword == "map_bump" || keyword == "bump") {
        set_texture(material, "normalTexture", texture);
        if (material.contains("normalTexture") && texture.scale != 1)
          material["normalTexture"]["scale"] = texture.scale;
      }
    }
    const auto share = [](double value) {
      return std::isfinite(value) ? std::clamp(value, 0.0, 1.0) : 1.0;
    };
    if (pbr.contains("baseColorTexture")) color = {1, 1, 1};
    for (double& part : color) part = share(part);
    color.push_back(share(alpha));
    if (color != std::vector<double>{1, 1, 1, 1}) pbr["baseColorFactor"] = color;
    if (color[3] < 1) material["alphaMode"] = "BLEND";
    if (!roughness && shininess)
      roughness = 1 - std::sqrt(std::clamp(*shininess / kMostShininess, 0.0, 1.0));
    pbr["roughnessFactor"] = share(roughness.value_or(kUsualRoughness));
    pbr["metallicFactor"] = share(metallic);
    set_glow(glow, material);
    material["pbrMetallicRoughness"] = std::move(pbr);
    made_.lists["materials"].push_back(std::move(material));
  }

  // Factors end at 1; what is brighter has a strength.
  void set_glow(std::vector<double> glow, json& material) {
    constexpr const char* kStrength = "KHR_materials_emissive_strength";
    const double most = std::ranges::max(glow);
    if (material.contains("emissiveTexture") && !(most > 0)) glow = {1, 1, 1};
    if (!std::isfinite(most) || (!(most > 0) && !material.contains("emissiveTexture"))) return;
    if (most > 1) {
      for (double& part : glow) part /= most;
      material["extensions"][kStrength]["emissiveStrength"] = most;
      if (!made_.lists.contains("extensionsUsed")) made_.lists["extensionsUsed"] = json::array();
      json& used = made_.lists["extensionsUsed"];
      if (std::ranges::find(used, kStrength) == used.end()) used.push_back(kStrength);
    }
    for (double& part : glow) part = std::clamp(part, 0.0, 1.0);
    material["emissiveFactor"] = glow;
  }

  void set_texture(json& of, const char* name, const MaterialTexture& texture) {
    const std::optional<std::size_t> image = image_of(texture.path);
    if (!image) return;
    json entry{{"source", *image}};
    if (texture.clamps) {
      if (!made_.lists.contains("samplers"))
        made_.lists["samplers"] = {{{"wrapS", kClampToEdge}, {"wrapT", kClampToEdge}}};
      entry["sampler"] = 0;
    }
    json& textures = made_.lists["textures"];
    if (textures.is_null()) textures = json::array();
    auto found = std::ranges::find(textures, entry);
    const auto number = found - textures.begin();
    if (found == textures.end()) textures.push_back(entry);
    of[name] = {{"index", number}};
    if (texture.size == glm::dvec2(1.0) && texture.offset == glm::dvec2(0.0)) return;
    constexpr const char* kTransform = "KHR_texture_transform";
    // Our v runs upwards, glTF's down.
    of[name]["extensions"][kTransform] = {
        {"scale", {texture.size.x, texture.size.y}},
        {"offset", {texture.offset.x, 1 - texture.size.y - texture.offset.y}}};
    json& used = made_.lists["extensionsUsed"];
    if (used.is_null()) used = json::array();
    if (std::ranges::find(used, kTransform) == used.end()) used.push_back(kTransform);
  }

  // Each file once.
  std::optional<std::size_t> image_of(const std::filesystem::path& path) {
    const auto [known, is_new] = images_.try_emplace(path.lexically_normal());
    if (!is_new) return known->second;
    NamedFile file = read_named(path, library_.obj(), library_.reach());
    const std::string type = image_type(file.bytes, "");
    if (type != "image/png" && type != "image/jpeg") {
      if (left_out_++ == 0)
        first_ =
            file.trouble.empty() ? visible(path) + ": glTF takes PNG and JPEG files" : file.trouble;
      return std::nullopt;
    }
    made_.images.push_back({type, std::move(file.bytes), path});
    made_.lists["images"].push_back({{"name", visible(path.filename())}});
    known->second = made_.images.size() - 1;
    return known->second;
  }

  const MaterialLibrary& library_;
  GltfMaterials made_;
  std::map<std::filesystem::path, std::optional<std::size_t>> images_;
  std::set<std::string> untaken_;  // keywords, in small letters
  std::string first_;
  std::int64_t left_out_ = 0;
};

}  // namespace

GltfMaterials materials_of(const MaterialLibrary& library) { return Converter(library).convert(); }

}  // namespace planish
