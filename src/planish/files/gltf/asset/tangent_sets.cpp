#include "planish/files/gltf/asset/tangent_sets.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "planish/core/json.h"
#include "planish/core/parallel.h"

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

// The way round of a face in the texture.
enum class Way : std::uint8_t { Unknown, Left, Right };

Way way_of(std::span<const std::int32_t> face, std::span<const glm::dvec2> uvs) {
  double area = 0;
  for (std::size_t k = 0; k < face.size(); ++k) {
    const glm::dvec2& a = uvs[face[k]];
    const glm::dvec2& b = uvs[face[k + 1 < face.size() ? k + 1 : 0]];
    area += a.x * b.y - a.y * b.x;
  }
  return area > 0 ? Way::Left : area < 0 ? Way::Right : Way::Unknown;
}

std::span<std::int32_t> uvs_of_face(PolygonMesh& mesh, std::size_t face) {
  const auto begin = static_cast<std::size_t>(mesh.face_offsets[face]);
  return std::span(mesh.face_uvs)
      .subspan(begin, static_cast<std::size_t>(mesh.face_offsets[face + 1]) - begin);
}

// Of all faces; none where they all lie alike, as most do.
std::vector<Way> ways_of_faces(PolygonMesh& mesh, const AssetVertices& vertices) {
  std::vector<Way> ways(static_cast<std::size_t>(mesh.face_count()), Way::Unknown);
  std::atomic<bool> has_left{false}, has_right{false};
  parallel_for(ways.size(), 4096, [&](std::size_t begin, std::size_t end) {
    bool left = false, right = false;
    for (std::size_t f = begin; f < end; ++f) {
      const std::int32_t group = mesh.face_groups.empty() ? 0 : mesh.face_groups[f];
      const int set = vertices.groups[group].tangent_set;
      if (set < 0) continue;
      ways[f] = way_of(uvs_of_face(mesh, f), set == 0 ? mesh.uvs : vertices.further_uvs[set - 1]);
      left = left || ways[f] == Way::Left;
      right = right || ways[f] == Way::Right;
    }
    if (left) has_left = true;
    if (right) has_right = true;
  });
  if (!has_left || !has_right) ways.clear();
  return ways;
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
  const std::vector<Way> ways_of = ways_of_faces(mesh, vertices);
  if (ways_of.empty()) return;
  // The way round of the first face that has a texture coordinate is that one's.
  std::vector<Way> ways(mesh.uvs.size(), Way::Unknown);
  std::unordered_map<std::int32_t, std::int32_t> copies;
  for (std::size_t f = 0; f < ways_of.size(); ++f) {
    const Way way = ways_of[f];
    if (way == Way::Unknown) continue;
    for (std::int32_t& uv : uvs_of_face(mesh, f)) {
      Way& known = ways[uv];
      if (known == Way::Unknown) known = way;
      if (known == way) continue;
      const auto [copy, is_new] =
          copies.try_emplace(uv, static_cast<std::int32_t>(mesh.uvs.size()));
      if (is_new) {
        mesh.uvs.push_back(mesh.uvs[uv]);
        for (std::vector<glm::dvec2>& further : vertices.further_uvs)
          further.push_back(further[uv]);
        for (AssetUvMoves& moves : vertices.uv_moves) moves.values.push_back(moves.values[uv]);
        for (AssetArray& array : vertices.arrays)
          for (int k = 0; array.of_corners && k < array.width; ++k)
            array.values.push_back(array.values[static_cast<std::size_t>(array.width * uv + k)]);
        ways.push_back(way);
      }
      uv = copy->second;
    }
  }
}

}  // namespace planish
