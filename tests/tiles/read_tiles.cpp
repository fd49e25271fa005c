#include "tiles/read_tiles.h"

#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>

#include "planish/files/mesh_file.h"

namespace planish::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string content_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

// The files of these tests have no other letters that URIs encode.
std::string decoded(std::string uri) {
  for (std::size_t at; (at = uri.find("%20")) != std::string::npos;) uri.replace(at, 3, " ");
  return uri;
}

class TilesetReader {
 public:
  explicit TilesetReader(ReadTileset& set) : set_(set) {}

  void read(const fs::path& document, int parent, const glm::dvec3& origin) {
    const json parsed = json::parse(content_of(document));
    set_.documents.push_back(parsed);
    add(parsed["root"], document.parent_path(), parent, origin);
  }

 private:
  void add(const json& tile, const fs::path& folder, int parent, glm::dvec3 origin) {
    if (tile.contains("transform")) {
      const auto m = tile["transform"].get<std::vector<double>>();
      for (std::size_t i = 0; i < 16; ++i) {
        if (i < 12 || i == 15) {
          EXPECT_EQ(m[i], i % 5 == 0 ? 1 : 0) << "only moved";
        }
      }
      origin += glm::dvec3(m[12], m[13], m[14]);
    }
    ReadTile read{
        .parent = parent, .error = tile["geometricError"].get<double>(), .origin = origin};
    const auto box = tile["boundingVolume"]["box"].get<std::vector<double>>();
    const glm::dvec3 centre(box[0], box[1], box[2]), half(box[3], box[7], box[11]);
    for (const std::size_t i : {4, 5, 6, 8, 9, 10}) EXPECT_EQ(box[i], 0);
    read.lower = origin + centre - half;
    read.upper = origin + centre + half;
    const auto index = static_cast<int>(set_.tiles.size());
    const fs::path content = tile.contains("content")
                                 ? folder / decoded(tile["content"]["uri"].get<std::string>())
                                 : fs::path();
    const bool links = content.extension() == ".json";
    if (!content.empty() && !links) {
      read.content = content;
      const std::string name = content.stem().string();
      read.level = std::stoi(name.substr(name.find('-') + 1));
    }
    set_.tiles.push_back(read);
    if (links) {
      EXPECT_FALSE(tile.contains("children"));
      this->read(content, index, origin);
    }
    if (!tile.contains("children")) return;
    for (const json& child : tile["children"]) add(child, folder, index, origin);
  }

  ReadTileset& set_;
};

}  // namespace

bool ReadTile::holds(const ReadTile& other) const {
  for (int d = 0; d < 3; ++d)
    if (other.lower[d] < lower[d] || other.upper[d] > upper[d]) return false;
  return true;
}

ReadTileset read_tileset(const fs::path& document) {
  ReadTileset set;
  TilesetReader(set).read(document, -1, glm::dvec3(0.0));
  return set;
}

namespace {

// tinygltf does not unpack; planish's reader is compared with meshoptimizer's elsewhere.
PolygonMesh unpacked(const ReadTile& tile) {
  PolygonMesh mesh = read_mesh(tile.content).mesh;
  for (glm::dvec3& p : mesh.positions) p = tile.origin + glm::dvec3(p.x, -p.z, p.y);
  return mesh;
}

}  // namespace

PolygonMesh triangles_of(const ReadTile& tile) {
  const std::string bytes = content_of(tile.content);
  if (bytes.find("extensionsRequired") != std::string::npos) return unpacked(tile);
  tinygltf::Model model;
  std::string error, warning;
  EXPECT_TRUE(tinygltf::TinyGLTF().LoadBinaryFromMemory(
      &model, &error, &warning, reinterpret_cast<const unsigned char*>(bytes.data()),
      static_cast<unsigned>(bytes.size())))
      << error;
  EXPECT_TRUE(model.nodes.at(0).translation.empty());
  PolygonMesh mesh;
  for (const tinygltf::Primitive& primitive : model.meshes.at(0).primitives) {
    const auto first = static_cast<std::int32_t>(mesh.positions.size());
    const auto data = [&](int accessor) {
      return model.buffers[0].data.data() +
             model.bufferViews[model.accessors[accessor].bufferView].byteOffset;
    };
    const int positions = primitive.attributes.at("POSITION");
    for (std::size_t i = 0; i < model.accessors[positions].count; ++i) {
      glm::vec3 p;
      std::memcpy(&p, data(positions) + i * sizeof(p), sizeof(p));
      // Y up to Z up, as viewers turn it.
      mesh.positions.push_back(tile.origin + glm::dvec3(p.x, -p.z, p.y));
    }
    if (const auto uvs = primitive.attributes.find("TEXCOORD_0"); uvs != primitive.attributes.end())
      for (std::size_t i = 0; i < model.accessors[uvs->second].count; ++i) {
        glm::vec2 uv;
        std::memcpy(&uv, data(uvs->second) + i * sizeof(uv), sizeof(uv));
        mesh.uvs.emplace_back(uv);
      }
    const bool is_short =
        model.accessors[primitive.indices].componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
    for (std::size_t i = 0; i < model.accessors[primitive.indices].count; ++i) {
      std::uint32_t index = 0;
      const std::size_t size = is_short ? 2 : 4;
      std::memcpy(&index, data(primitive.indices) + i * size, size);
      mesh.face_vertices.push_back(first + static_cast<std::int32_t>(index));
      if (i % 3 == 2)
        mesh.face_offsets.push_back(static_cast<std::int32_t>(mesh.face_vertices.size()));
    }
  }
  return mesh;
}

PolygonMesh welded(const ReadTileset& set, int level) {
  PolygonMesh all;
  std::map<std::array<double, 3>, std::int32_t> places;
  for (const ReadTile& tile : set.tiles) {
    if (tile.level != level) continue;
    const PolygonMesh mesh = triangles_of(tile);
    for (const std::int32_t vertex : mesh.face_vertices) {
      const glm::dvec3& p = mesh.positions[vertex];
      const auto [place, is_new] =
          places.try_emplace({p.x, p.y, p.z}, static_cast<std::int32_t>(all.positions.size()));
      if (is_new) all.positions.push_back(p);
      all.face_vertices.push_back(place->second);
      if (all.face_vertices.size() % 3 == 0)
        all.face_offsets.push_back(static_cast<std::int32_t>(all.face_vertices.size()));
    }
  }
  return all;
}

}  // namespace planish::test
