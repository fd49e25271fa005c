#include "planish/files/materials.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/portable_math.h"
#include "planish/core/words.h"
#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/files/gltf/gltf_json.h"
#include "planish/files/gltf/gltf_payload.h"
#include "planish/files/gltf/gltf_source.h"
#include "planish/files/images.h"
#include "planish/files/read_file.h"
#include "planish/files/shared/attributes.h"

namespace planish {
namespace {

using nlohmann::json;

void add_extensions(const json& in, std::set<std::string>& names) {
  if (!in.is_structured()) return;
  if (in.is_object() && in.contains("extensions"))
    for (const auto& [name, value] : in["extensions"].items()) names.insert(name);
  for (const json& value : in) add_extensions(value, names);
}

// Members that name a texture and another set of texture coordinates than the first.
std::int64_t drop_further_sets(json& in) {
  if (!in.is_structured()) return 0;
  std::int64_t count = 0;
  std::vector<std::string> dropped;
  for (const auto& [key, value] : in.items()) {
    if (in.is_object() && value.is_object() && value.contains("index") &&
        set_of_texture(value) != 0) {
      dropped.push_back(key);
    } else {
      count += drop_further_sets(value);
    }
  }
  for (const std::string& key : dropped) in.erase(key);
  return count + std::ssize(dropped);
}

void add_names(const json& names, const char* list, json& document) {
  for (const json& name : names) {
    json& all = document[list];
    if (std::ranges::find(all, name) == all.end()) all.push_back(name);
  }
}

GltfMaterials made_of(const GltfAsset& asset) {
  const json& document = asset.root().value();
  GltfMaterials made;
  if (!document.contains("materials")) return made;
  for (const char* list : {"materials", "textures", "samplers", "images"})
    if (document.contains(list)) made.lists[list] = document[list];
  const std::vector<std::string> names = material_names(asset.root());
  for (std::size_t i = 0; i < names.size(); ++i) made.lists["materials"][i]["name"] = names[i];
  const std::int64_t dropped = drop_further_sets(made.lists["materials"]);
  if (dropped > 0)
    made.warnings.push_back(
        {"left-out-textures",
         std::string(asset.file().name) +
             ": textures of further sets of texture coordinates are left out, since a scene that "
             "becomes one mesh has one",
         dropped});
  std::set<std::string> extensions;
  add_extensions(made.lists, extensions);
  for (const char* list : {"extensionsUsed", "extensionsRequired"})
    for (const json& name : document.value(list, json::array()))
      if (extensions.contains(name.get<std::string>())) made.lists[list].push_back(name);
  if (!made.lists.contains("images")) return made;
  std::vector<std::string> missing;
  for (std::size_t i = 0; i < made.lists["images"].size(); ++i) {
    json& image = made.lists["images"][i];
    const JsonPlace place = asset.root()["images"][static_cast<std::int64_t>(i)];
    const auto uri = place.find("uri");
    const AssetImage found = asset_image(asset, static_cast<std::int64_t>(i));
    made.images.push_back({image.value("mimeType", found.type), {}, {}});
    if (!found.missing.empty()) {
      made.images.back().type = found.type;
      missing.push_back(found.missing);
    } else if (const auto file = uri ? decode_uri_path(uri->text()) : std::nullopt;
               file && !is_data_uri(uri->text())) {
      made.images.back().path = asset.file().path.parent_path() / path_of(*file);
    }
    made.images.back().bytes.assign(found.bytes.begin(), found.bytes.end());
    image.erase("uri");
    image.erase("bufferView");
  }
  if (!missing.empty()) made.warnings.push_back(missing_images(missing));
  return made;
}

}  // namespace

std::string valid_utf8(const std::string& text) {
  const json value = text;
  return json::parse(value.dump(-1, ' ', false, json::error_handler_t::replace)).get<std::string>();
}

std::optional<glm::dvec3> GltfMaterials::display_color(std::string_view name) const {
  if (!lists.contains("materials")) return std::nullopt;
  const std::string wanted = valid_utf8(std::string(name));
  for (const json& material : lists["materials"]) {
    if (material.value("name", std::string()) != wanted) continue;
    const json factor = material.value("pbrMetallicRoughness", json::object())
                            .value("baseColorFactor", json::array());
    if (factor.size() < 3) return std::nullopt;
    glm::dvec3 color;
    for (int k = 0; k < 3; ++k) color[k] = srgb_of_linear(factor[k].get<double>());
    return color;
  }
  return std::nullopt;
}

void GltfMaterials::apply(GltfDocument& document, std::string_view folder) const {
  std::map<std::string, const json*> by_name;
  if (lists.contains("materials"))
    for (const json& material : lists["materials"])
      by_name[material["name"].get<std::string>()] = &material;
  bool has_any = false;
  for (json& material : document.json["materials"]) {
    const auto found = by_name.find(material.value("name", std::string()));
    if (found == by_name.end()) continue;
    has_any = true;
    const bool is_double_sided = !has_sides && material.value("doubleSided", false);
    material = *found->second;
    if (is_double_sided) material["doubleSided"] = true;
  }
  if (!has_any) return;
  for (const char* list : {"textures", "samplers", "images"})
    if (lists.contains(list)) document.json[list] = lists[list];
  for (const char* list : {"extensionsUsed", "extensionsRequired"})
    if (lists.contains(list)) add_names(lists[list], list, document.json);
  for (std::size_t i = 0; i < images.size(); ++i) {
    json& image = document.json["images"][i];
    if (folder.empty()) {
      image["mimeType"] = images[i].type;
      image["bufferView"] = document.add_view(images[i].bytes);
    } else {
      image["uri"] = std::string(folder) + image_name(i);
      image.erase("mimeType");
    }
  }
}

std::string GltfMaterials::image_name(std::size_t image) const {
  const std::string& type = images[image].type;
  const std::size_t slash = type.find('/');
  const std::string kind = slash == std::string::npos ? "bin" : type.substr(slash + 1);
  const bool is_plain =
      std::ranges::all_of(kind, [](char c) { return std::isalnum(static_cast<unsigned char>(c)); });
  return std::to_string(image) + "." + (kind == "jpeg" ? "jpg" : is_plain ? kind : "bin");
}

std::vector<std::string> material_names(const JsonPlace& root) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  const auto materials = root.find("materials");
  for (std::int64_t i = 0; materials && i < materials->array_size(); ++i) {
    const auto named = (*materials)[i].find("name");
    std::string name = named && named->is_text() ? named->text() : "";
    while (name.empty() || !taken.insert(name).second)
      name += (name.empty() ? "material_" : "_") + std::to_string(i);
    names.push_back(std::move(name));
  }
  return names;
}

GltfMaterials materials_of(const GltfAsset& asset) {
  return guard_json(asset.file().name, [&] { return made_of(asset); });
}

namespace {

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

namespace {

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

namespace {

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
    input("float2 inputs:translation",
          tuple_text({offset[0] + scale[1] * portable::sin(turn),
                      1 - offset[1] - scale[1] * portable::cos(turn)}));
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
