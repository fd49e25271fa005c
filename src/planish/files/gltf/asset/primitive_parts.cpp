#include "planish/files/gltf/asset/primitive_parts.h"

#include <charconv>
#include <cstddef>
#include <initializer_list>

#include "planish/core/json.h"
#include "planish/files/gltf/draco_stream.h"

namespace planish {
namespace {

using nlohmann::json;

const json* found(const json& in, std::initializer_list<const char*> path) {
  const json* at = &in;
  for (const char* key : path) {
    const auto next = at->find(key);
    if (next == at->end()) return nullptr;
    at = &*next;
  }
  return at;
}

}  // namespace

json without_vertices(const json& primitive) {
  json rest = primitive;
  for (const char* key : {"attributes", "indices", "mode", "targets"}) rest.erase(key);
  if (const auto extensions = rest.find("extensions"); extensions != rest.end()) {
    if (extensions->is_object()) extensions->erase(kDracoExtension);
    if (extensions->empty()) rest.erase("extensions");
  }
  return rest;
}

std::int64_t primitive_number(std::string_view path) {
  std::int64_t number = 0;
  const std::string_view digits = path.substr(path.rfind('[') + 1);
  std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return number;
}

bool is_surface(const json& primitive) {
  constexpr int kTriangles = 4;
  if (!primitive.is_object()) return false;
  const auto mode = primitive.find("mode");
  const auto attributes = primitive.find("attributes");
  return attributes != primitive.end() && attributes->is_object() &&
         attributes->contains("POSITION") &&
         (mode == primitive.end() || (mode->is_number() && mode->get<double>() >= kTriangles));
}

int set_of_texture(const json& texture) {
  const json* moved = found(texture, {"extensions", "KHR_texture_transform", "texCoord"});
  return moved != nullptr ? moved->get<int>() : texture.value("texCoord", 0);
}

int tangent_set(const json& document, const json& primitive) {
  const auto number = primitive.find("material");
  if (number == primitive.end()) return -1;
  const json& material = document.at("materials").at(number->get<std::size_t>());
  const json* anisotropy = found(material, {"extensions", "KHR_materials_anisotropy"});
  for (const json* texture :
       {found(material, {"normalTexture"}),
        found(material, {"extensions", "KHR_materials_clearcoat", "clearcoatNormalTexture"}),
        anisotropy != nullptr ? found(*anisotropy, {"anisotropyTexture"}) : nullptr})
    if (texture != nullptr) return set_of_texture(*texture);
  return anisotropy != nullptr ? 0 : -1;
}

}  // namespace planish
