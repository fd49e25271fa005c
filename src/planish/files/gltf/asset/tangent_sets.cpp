#include "planish/files/gltf/asset/tangent_sets.h"

#include <nlohmann/json.hpp>
#include <unordered_map>

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

// Twice its area in the texture, with a sign.
double area_of(std::span<const std::int32_t> face, std::span<const glm::dvec2> uvs) {
  double area = 0;
  for (std::size_t k = 0; k < face.size(); ++k) {
    const glm::dvec2& a = uvs[static_cast<std::size_t>(face[k])];
    const glm::dvec2& b = uvs[static_cast<std::size_t>(face[(k + 1) % face.size()])];
    area += a.x * b.y - a.y * b.x;
  }
  return area;
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

void cut_mirrored_charts(PolygonMesh& mesh, AssetVertices& vertices) {
  if (!vertices.has_tangents()) return;
  // The way round of the first face that has a texture coordinate is that one's.
  enum class Way : std::uint8_t { Unknown, Left, Right };
  std::vector<Way> ways(mesh.uvs.size(), Way::Unknown);
  std::unordered_map<std::int32_t, std::int32_t> copies;
  for (std::int64_t f = 0; f < mesh.face_count(); ++f) {
    const std::int32_t group = mesh.face_groups.empty() ? 0 : mesh.face_groups[f];
    const int set = vertices.groups[static_cast<std::size_t>(group)].tangent_set;
    if (set < 0) continue;
    const auto begin = static_cast<std::size_t>(mesh.face_offsets[f]);
    const std::span face =
        std::span(mesh.face_uvs)
            .subspan(begin, static_cast<std::size_t>(mesh.face_offsets[f + 1]) - begin);
    const double area = area_of(
        face, set == 0 ? mesh.uvs : vertices.further_uvs[static_cast<std::size_t>(set - 1)]);
    if (area == 0) continue;
    const Way way = area > 0 ? Way::Left : Way::Right;
    for (std::int32_t& uv : face) {
      Way& known = ways[static_cast<std::size_t>(uv)];
      if (known == Way::Unknown) known = way;
      if (known == way) continue;
      const auto [copy, is_new] =
          copies.try_emplace(uv, static_cast<std::int32_t>(mesh.uvs.size()));
      if (is_new) {
        mesh.uvs.push_back(mesh.uvs[static_cast<std::size_t>(uv)]);
        for (std::vector<glm::dvec2>& further : vertices.further_uvs)
          further.push_back(further[static_cast<std::size_t>(uv)]);
        ways.push_back(way);
      }
      uv = copy->second;
    }
  }
}

}  // namespace planish
