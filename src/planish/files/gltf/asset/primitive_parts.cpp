#include "planish/files/gltf/asset/primitive_parts.h"

#include <charconv>

#include "planish/core/json.h"
#include "planish/files/gltf/draco_stream.h"

namespace planish {

nlohmann::json without_vertices(const nlohmann::json& primitive) {
  nlohmann::json rest = primitive;
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

bool is_surface(const nlohmann::json& primitive) {
  constexpr int kTriangles = 4;
  if (!primitive.is_object()) return false;
  const auto mode = primitive.find("mode");
  const auto attributes = primitive.find("attributes");
  return attributes != primitive.end() && attributes->is_object() &&
         attributes->contains("POSITION") &&
         (mode == primitive.end() || (mode->is_number() && mode->get<double>() >= kTriangles));
}

}  // namespace planish
