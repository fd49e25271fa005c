#include "planish/files/gltf/asset/tangent_sets.h"

#include <cstddef>

#include "planish/core/json.h"

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
