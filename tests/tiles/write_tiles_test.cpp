#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <signal.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vector_relational.hpp>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "cli/json_schema.h"
#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "files/gltf/asset_sample.h"
#include "files/gltf/glb_bytes.h"
#include "files/gltf/parsed_gltf.h"
#include "planish/core/json.h"
#include "planish/files/mesh_file.h"
#include "planish/files/tiles/write_tiles.h"
#include "planish/mesh/check.h"
#include "planish/mesh/polygon_mesh.h"
#include "support/calls.h"
#include "support/files.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

// A tile of a set as a viewer meets it, with all transforms applied: in the frame of tiles, Z up.
struct ReadTile {
  int parent = -1;  // in the same list
  glm::dvec3 lower{0.0}, upper{0.0};
  double error = 0;
  glm::dvec3 origin{0.0};
  std::filesystem::path content;  // a .glb; empty: none
  int level = 0;                  // by the file's name; 0: no content

  [[nodiscard]] bool holds(const glm::dvec3& least, const glm::dvec3& most) const {
    return glm::all(glm::lessThanEqual(lower, least)) && glm::all(glm::lessThanEqual(most, upper));
  }
};

namespace fs = std::filesystem;
using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

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

struct ReadTileset {
  std::vector<json> documents;  // the set's own first
  std::vector<ReadTile> tiles;  // parents before children

  explicit ReadTileset(const fs::path& document) { read(document, -1, glm::dvec3(0.0)); }

 private:
  void read(const fs::path& document, int parent, const glm::dvec3& origin) {
    documents.push_back(json::parse(content_of(document)));
    add(json(documents.back()["root"]), document.parent_path(), parent, origin);
  }
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
    const auto box = tile["boundingVolume"]["box"].get<std::vector<double>>();
    const glm::dvec3 centre = origin + glm::dvec3(box[0], box[1], box[2]),
                     half(box[3], box[7], box[11]);
    for (const std::size_t i : {4, 5, 6, 8, 9, 10}) EXPECT_EQ(box[i], 0);
    const auto index = static_cast<int>(tiles.size());
    ReadTile& made = tiles.emplace_back(ReadTile{.parent = parent,
                                                 .lower = centre - half,
                                                 .upper = centre + half,
                                                 .error = tile["geometricError"].get<double>(),
                                                 .origin = origin});
    if (tile.contains("content")) {
      const fs::path content = folder / decoded(tile["content"]["uri"].get<std::string>());
      if (content.extension() == ".json") {
        EXPECT_FALSE(tile.contains("children"));
        read(content, index, origin);
      } else {
        const std::string name = content.stem().string();
        made.content = content;
        made.level = std::stoi(name.substr(name.find('-') + 1));
      }
    }
    for (const json& child : tile.value("children", json::array()))
      add(child, folder, index, origin);
  }
};

// Y up to Z up, as viewers turn it.
glm::dvec3 upright(const ReadTile& tile, const glm::dvec3& p) {
  return tile.origin + glm::dvec3(p.x, -p.z, p.y);
}

// tinygltf does not unpack; planish's reader is compared with meshoptimizer's elsewhere.
PolygonMesh unpacked(const ReadTile& tile) {
  PolygonMesh mesh = read_mesh(tile.content).mesh;
  for (glm::dvec3& p : mesh.positions) p = upright(tile, p);
  return mesh;
}

// A tile's triangles, corners not joined, in the frame of tiles; texture coordinates, if any, by
// vertex.
PolygonMesh triangles_of(const ReadTile& tile) {
  const std::string bytes = content_of(tile.content);
  if (bytes.find("extensionsRequired") != std::string::npos) return unpacked(tile);
  const tinygltf::Model model = parsed(std::as_bytes(std::span(bytes)));
  EXPECT_TRUE(model.nodes.at(0).translation.empty());
  PolygonMesh mesh;
  for (std::size_t part = 0; part < model.meshes.at(0).primitives.size(); ++part) {
    const auto first = static_cast<std::int32_t>(mesh.positions.size());
    for (const glm::vec3& p : vectors_of(model, attribute(model, "POSITION", part)))
      mesh.positions.push_back(upright(tile, p));
    if (model.meshes[0].primitives[part].attributes.contains("TEXCOORD_0"))
      for (const glm::vec2& uv : values_of<glm::vec2>(model, attribute(model, "TEXCOORD_0", part)))
        mesh.uvs.emplace_back(uv);
    const auto indices = indices_of(model, part);
    for (std::size_t i = 0; i < indices.size(); ++i) {
      mesh.face_vertices.push_back(first + static_cast<std::int32_t>(indices[i]));
      if (i % 3 == 2)
        mesh.face_offsets.push_back(static_cast<std::int32_t>(mesh.face_vertices.size()));
    }
  }
  return mesh;
}

// The triangles of all tiles of a level, corners at equal places joined.
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

// A mesh as the cage of a surface, and the limit points of its vertices, which stand for given
// ones; the folder that its tiles are written to.
class TiledSurface {
 public:
  explicit TiledSurface(PolygonMesh mesh)
      : mesh_(std::move(mesh)), surface_(mesh_, EvaluateOptions{}), given_(mesh_.positions) {
    const SurfaceMesh limit = whole(1);
    for (std::size_t i = 0; i < limit.base_vertices.size(); ++i)
      given_[limit.base_vertices[i]] = limit.positions[i];
  }

  [[nodiscard]] SurfaceMesh whole(int level) const { return collect(*surface_.level(level), {}); }
  [[nodiscard]] const fs::path& folder() const { return folder_.path(); }
  [[nodiscard]] TilesFile write(const char* name, TilesOptions options) const {
    options.given = given_;
    return write_tiles(folder() / name, surface_, options);
  }
  [[nodiscard]] ReadTileset tiles(TilesOptions options, const char* name = "t.json") const {
    (void)write(name, std::move(options));
    return ReadTileset(folder() / name);
  }

 private:
  PolygonMesh mesh_;
  DooSabinSurface surface_;
  std::vector<glm::dvec3> given_;
  TemporaryFolder folder_;
};

PolygonMesh far_torus() {
  PolygonMesh mesh = torus(40, 20, 3, 1);
  for (glm::dvec3& p : mesh.positions) p += glm::dvec3(1e6, -2e5, 17);
  return mesh;
}

// The welded tiles of a level are the level in one piece, snapped: as many places and triangles.
void expect_level_whole(const ReadTileset& set, const TiledSurface& surface, int level,
                        bool is_closed) {
  const SurfaceMesh whole = surface.whole(level);
  const PolygonMesh mesh = welded(set, level);
  std::set<std::array<double, 3>> places;
  for (const glm::dvec3& p : whole.positions) places.insert({p.x, p.y, p.z});
  EXPECT_EQ(mesh.positions.size(), places.size());
  EXPECT_EQ(mesh.face_count(), 2 * whole.face_count());
  if (is_closed) {
    EXPECT_THAT(check(mesh), IsEmpty());
    EXPECT_EQ(mesh.positions.size(), whole.positions.size());
  }
}

void expect_nested(const ReadTileset& set) {
  const double whole = glm::length(set.tiles[0].upper - set.tiles[0].lower);
  EXPECT_NEAR(set.tiles[0].error, whole, 1e-9 * whole);
  std::vector<bool> is_leaf(set.tiles.size(), true);
  for (const ReadTile& tile : set.tiles) {
    if (tile.parent < 0) continue;
    const ReadTile& parent = set.tiles[tile.parent];
    is_leaf[tile.parent] = false;
    EXPECT_TRUE(parent.holds(tile.lower, tile.upper)) << tile.content;
    EXPECT_GE(parent.error, tile.error) << tile.content;
    if (parent.level > 0) {
      EXPECT_EQ(tile.level, parent.level + 1);
    }
  }
  for (std::size_t i = 0; i < set.tiles.size(); ++i) {
    const ReadTile& tile = set.tiles[i];
    if (tile.content.empty()) continue;
    EXPECT_EQ(tile.error == 0, is_leaf[i]) << tile.content;
    for (const glm::dvec3& p : triangles_of(tile).positions)
      ASSERT_TRUE(tile.holds(p, p)) << tile.content;
  }
}

TEST(WriteTiles, LevelsWeldToTheSurfaceInOnePiece) {
  for (const bool far : {false, true}) {
    const TiledSurface surface(far ? far_torus() : torus(40, 20, 3, 1));
    const TilesFile file = surface.write("t.json", {.level = 3, .tile_vertices = 400});
    const ReadTileset set(surface.folder() / "t.json");
    EXPECT_EQ(file.levels.size(), 3u);
    for (int level = 1; level <= 3; ++level) expect_level_whole(set, surface, level, true);
    expect_nested(set);
    // Of a diagonal of 8.5: float32 about the model's own origin would be off by 0.06.
    EXPECT_LT(file.largest_distance, 1e-6);
    EXPECT_GT(file.largest_distance, 0);
  }
}

// A named error, whichever tile it is in, before a file of the set is seen. Positions come of a
// surface, which is refused itself where they are not finite.
TEST(WriteTiles, NumbersThatAreNotFiniteAreRefused) {
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              inf = std::numeric_limits<float>::infinity();
  for (const auto compression : {GltfCompression::None, GltfCompression::Meshopt}) {
    for (const float wrong : {nan, inf, -inf}) {
      for (const std::size_t vertex : {0u, 411u, 799u}) {
        PolygonMesh mesh = torus(40, 20, 3, 1);
        mesh.colors.assign(mesh.positions.size(), glm::vec4(1));
        mesh.colors[vertex].g = wrong;
        const TiledSurface surface(mesh);
        TilesOptions options{.level = 3, .tile_vertices = 400};
        options.gltf.compression = compression;
        EXPECT_THAT(
            message_of(ErrorCode::InvalidArgument, [&] { (void)surface.write("t.json", options); }),
            HasSubstr("is not finite"));
        EXPECT_TRUE(fs::is_empty(surface.folder()));
      }
    }
  }
}

// All on one grid, as coarse as the error allows: what meets is equal there too.
TEST(WriteTiles, CompressedTilesMeetAsOthersDo) {
  const TiledSurface surface(far_torus());
  std::map<GltfCompression, std::uint64_t> bytes;
  for (const auto compression :
       {GltfCompression::None, GltfCompression::Quantize, GltfCompression::Meshopt}) {
    for (const double error : {0.0, 1e-3}) {
      TilesOptions options{.level = 3, .tile_vertices = 400};
      options.gltf.compression = compression;
      options.gltf.position_error = error;
      const std::string name =
          std::to_string(static_cast<int>(compression)) + std::to_string(error) + ".json";
      const TilesFile file = surface.write(name.c_str(), options);
      const ReadTileset set(surface.folder() / name);
      for (int level = 1; level <= 3; ++level) expect_level_whole(set, surface, level, true);
      EXPECT_LT(file.largest_distance, std::max(error, 1e-6));
      EXPECT_GT(file.largest_distance, compression == GltfCompression::None ? 0 : error / 40);
      if (error > 0) bytes[compression] = file.byte_count;
    }
  }
  EXPECT_LT(bytes[GltfCompression::Quantize], 0.85 * bytes[GltfCompression::None]);
  EXPECT_LT(bytes[GltfCompression::Meshopt], 0.6 * bytes[GltfCompression::None]);
}

TEST(WriteTiles, BoundariesCreasesAndHolesWeldToo) {
  for (const std::uint32_t seed : {1u, 2u, 3u}) {
    const TiledSurface surface(laden_mesh(seed));
    const ReadTileset set = surface.tiles({.level = 2, .tile_vertices = 256});
    for (int level = 1; level <= 2; ++level) expect_level_whole(set, surface, level, false);
    expect_nested(set);
  }
}

TEST(WriteTiles, BytesDoNotDependOnThreads) {
  using oneapi::tbb::global_control;
  const auto with = [&](std::size_t threads) {
    const global_control limit(global_control::max_allowed_parallelism, threads);
    const TiledSurface surface(laden_mesh(6));
    (void)surface.write("t.json", {.level = 2, .tile_vertices = 256, .skirts = true});
    return files_below(surface.folder());
  };
  const auto one = with(1);
  EXPECT_GT(one.size(), 8u);
  EXPECT_EQ(one, with(2));
  EXPECT_EQ(one, with(5));
}

void expect_schema(const ReadTileset& set) {
  const json schema = json::parse(content_of(PLANISH_TILESET_SCHEMA));
  for (json document : set.documents) {
    EXPECT_THAT(schema_problems(document, schema), IsEmpty());
    document["root"]["geometricError"] = -1;
    EXPECT_FALSE(schema_problems(document, schema).empty());
  }
}

TEST(WriteTiles, ManyBlocksComeInDocumentsOfTheirOwn) {
  const TiledSurface surface(torus(120, 60, 3, 1));
  const ReadTileset set = surface.tiles({.level = 1, .tile_vertices = 256}, "two words.json");
  EXPECT_EQ(set.documents.size(), 3u);  // 113 blocks, 64 a document
  expect_level_whole(set, surface, 1, true);
  expect_nested(set);
  expect_schema(set);
}

TEST(WriteTiles, DocumentsFollowTheSchema) {
  expect_schema(TiledSurface(torus(20, 10, 3, 1)).tiles({.level = 3, .tile_vertices = 256}));
}

TEST(WriteTiles, ErrorsAreAboutTheDistanceOfLevels) {
  // The estimate against the distance between corresponding points of levels 1 and 5.
  const TiledSurface surface(torus(16, 12, 3, 1));
  const TilesFile file = surface.write("t.json", {.level = 2, .tile_vertices = 1 << 20});
  const SurfaceMesh coarse = surface.whole(1), fine = surface.whole(5);
  double farthest = 0;
  for (std::int64_t q = 0; q < coarse.face_count(); ++q) {
    const auto at = [&](int k) { return coarse.positions[coarse.face_vertices[4 * q + k]]; };
    const glm::dvec3 c[4] = {at(0), at(1), at(2), at(3)};
    // Path 0202...: the descendants of child 0 and then of its child at the centre.
    for (int first = 0; first < 256; ++first) {
      double x = 0, y = 0, size = 1;
      int digits[4] = {first >> 6 & 3, first >> 4 & 3, first >> 2 & 3, first & 3};
      for (const int digit : digits) {
        size /= 2;
        if (digit == 1 || digit == 2) x += size;
        if (digit >= 2) y += size;
      }
      const glm::dvec3 flat =
          (1 - x) * (1 - y) * c[0] + x * (1 - y) * c[1] + x * y * c[2] + (1 - x) * y * c[3];
      const glm::dvec3 real = fine.positions[fine.face_vertices[4 * (256 * q + first)]];
      farthest = std::max(farthest, glm::length(real - flat));
    }
  }
  EXPECT_GT(file.levels[0].geometric_error, farthest);
  EXPECT_LT(file.levels[0].geometric_error, 2.5 * farthest);
}

TEST(WriteTiles, SkirtsHangFromEdgesOfTilesOnly) {
  // An open sheet in tiles: its own boundary gets none.
  const TiledSurface surface(
      grid(24, 24, [](double x, double y) { return glm::dvec3(x, y, 0.05 * (x * x + y * y)); }));
  const ReadTileset plain = surface.tiles({.level = 2, .tile_vertices = 1024}, "plain.json");
  const ReadTileset skirts =
      surface.tiles({.level = 2, .tile_vertices = 1024, .skirts = true}, "skirts.json");
  ASSERT_EQ(plain.tiles.size(), skirts.tiles.size());
  expect_nested(skirts);
  std::int64_t strips = 0, edges = 0;
  for (std::size_t i = 0; i < plain.tiles.size(); ++i) {
    if (plain.tiles[i].content.empty()) continue;
    const PolygonMesh without = triangles_of(plain.tiles[i]);
    const PolygonMesh with = triangles_of(skirts.tiles[i]);
    // Edges with one face, as pairs of places: what hangs is joined to the tile, and the sheet's
    // own boundary stays one.
    const auto rim = [](const PolygonMesh& mesh) {
      std::map<std::pair<std::int32_t, std::int32_t>, int> uses;
      for (std::int32_t f = 0; f < mesh.face_count(); ++f)
        for (int k = 0; k < 3; ++k) ++uses[std::minmax(mesh.face(f)[k], mesh.face(f)[(k + 1) % 3])];
      return std::ranges::count_if(uses, [](const auto& use) { return use.second == 1; });
    };
    EXPECT_GT(with.face_count(), without.face_count());
    EXPECT_GT(with.positions.size(), without.positions.size());
    EXPECT_LE((with.face_count() - without.face_count()) / 2, rim(without));
    strips += (with.face_count() - without.face_count()) / 2;
    edges += rim(without);
    for (std::size_t v = 0; v < without.positions.size(); ++v)
      ASSERT_EQ(with.positions[v], without.positions[v]);
    // As far as the level before may be away.
    const double length =
        plain.tiles[i].level == 1 ? plain.tiles[i].error : plain.tiles[plain.tiles[i].parent].error;
    for (std::size_t v = without.positions.size(); v < with.positions.size(); ++v) {
      double nearest = 1e9;
      for (const glm::dvec3& p : without.positions)
        nearest = std::min(nearest, glm::length(p - with.positions[v]));
      EXPECT_LE(nearest, length * 1.01);
    }
  }
  // 96 edges of each level are the sheet's boundary: twice and four times as many at levels 1
  // and 2.
  EXPECT_EQ(edges - strips, 96 * 2 + 96 * 4);
}

// The places of a mesh's corners, each with the sum of area vectors of the triangles around it.
std::map<std::array<double, 3>, glm::dvec3> places_of(const PolygonMesh& mesh) {
  std::map<std::array<double, 3>, glm::dvec3> places;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto at = [&](int k) { return mesh.positions[mesh.face(f)[k]]; };
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3 p = at(k);
      places[{p.x, p.y, p.z}] += glm::cross(at(1) - at(0), at(2) - at(0));
    }
  }
  return places;
}

TEST(WriteTiles, SkirtsHangBehindTheirEdgeWithItsTextureCoordinates) {
  PolygonMesh mesh = torus(40, 20, 3, 1);
  mesh.face_uvs = mesh.face_vertices;
  for (const glm::dvec3& p : mesh.positions) mesh.uvs.emplace_back(p.x / 8 + 0.5, p.y / 8 + 0.5);
  const TiledSurface surface(std::move(mesh));
  const ReadTileset plain = surface.tiles({.level = 2, .tile_vertices = 400}, "plain.json");
  const ReadTileset skirts =
      surface.tiles({.level = 2, .tile_vertices = 400, .skirts = true}, "skirts.json");
  std::int64_t hanging = 0;
  for (std::size_t i = 0; i < plain.tiles.size(); ++i) {
    if (plain.tiles[i].content.empty()) continue;
    const PolygonMesh without = triangles_of(plain.tiles[i]);
    const PolygonMesh with = triangles_of(skirts.tiles[i]);
    ASSERT_EQ(with.uvs.size(), with.positions.size());
    const auto places = places_of(without);
    for (std::int32_t f = without.face_count(); f < with.face_count(); ++f) {
      // Of each triangle of a strip, what hangs and what it hangs from.
      std::vector<std::int32_t> upper, lower;
      for (const std::int32_t v : with.face(f)) {
        const glm::dvec3& p = with.positions[v];
        (places.contains({p.x, p.y, p.z}) ? upper : lower).push_back(v);
      }
      ASSERT_TRUE(!upper.empty() && !lower.empty()) << f;
      for (const std::int32_t v : lower) {
        const auto from = std::ranges::min_element(upper, {}, [&](std::int32_t u) {
          return glm::length(with.positions[u] - with.positions[v]);
        });
        const bool is_above =
            std::ranges::any_of(upper, [&](std::int32_t u) { return with.uvs[u] == with.uvs[v]; });
        if (upper.size() == 1 && !is_above) continue;  // below the edge's other end
        ++hanging;
        EXPECT_EQ(with.uvs[*from], with.uvs[v]);
        const glm::dvec3 way = with.positions[v] - with.positions[*from];
        const glm::dvec3& p = with.positions[*from];
        EXPECT_LT(glm::dot(glm::normalize(way), glm::normalize(places.at({p.x, p.y, p.z}))), -0.8);
      }
    }
  }
  EXPECT_GT(hanging, 1000);
}

TEST(WriteTiles, RefusesByName) {
  const TiledSurface surface(cube());
  const auto message = [&](const TilesOptions& options) {
    return message_of(ErrorCode::InvalidArgument, [&] { (void)surface.write("t.json", options); });
  };
  EXPECT_THAT(message({.level = 0}), HasSubstr("levels from 1 on"));
  EXPECT_THAT(message({.tile_vertices = 255}), HasSubstr("255 vertices; 256 are the least"));
  EXPECT_TRUE(fs::is_empty(surface.folder()));
}

TEST(WriteTiles, FailureLeavesNothing) {
  const TiledSurface surface(torus(100, 50, 3, 1));  // is asked every few milliseconds
  fs::create_directory(surface.folder() / "t");
  std::ofstream(surface.folder() / "t" / "mine.txt") << "mine";
  const auto before = files_below(surface.folder());
  EXPECT_THAT(
      message_of(ErrorCode::UnwritableOutput,
                 [&] { (void)surface.write("t.json", {.level = 1, .tile_vertices = 256}); }),
      HasSubstr("is not empty"));
  TilesOptions thrown{.level = 2, .tile_vertices = 256};
  thrown.gltf.callbacks.progress = [](std::string_view, double) {
    throw Error(ErrorCode::Cancelled, "enough");
  };
  EXPECT_EQ(message_of(ErrorCode::Cancelled, [&] { (void)surface.write("u.json", thrown); }),
            "enough");
  // The other way to end it: while tiles are written, too.
  int asked = 0, most = 0;
  TilesOptions stopped{.level = 3, .tile_vertices = 256};
  stopped.gltf.callbacks.cancelled = [&] { return asked++ >= most; };
  for (; most < 2; ++most) {
    asked = 0;
    EXPECT_NE(message_of(ErrorCode::Cancelled, [&] { (void)surface.write("v.json", stopped); }),
              "no error");
  }
  EXPECT_EQ(files_below(surface.folder()), before);
  EXPECT_THAT(
      std::vector<fs::path>(fs::directory_iterator(surface.folder()), fs::directory_iterator()),
      ElementsAre(surface.folder() / "t"));
}

// Sets of tiles as the command writes them.

class TileCommand : public FolderTest {
 protected:
  ProcessResult fit(std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"fit", torus_, "--device", "cpu"});
    return run_planish(flags);
  }
  ProcessResult fit_set(std::vector<std::string> flags = {}) {
    flags.insert(flags.end(), {"-o", path("t.json"), "--tile-vertices", "1000"});
    return fit(std::move(flags));
  }

  std::string torus_ = write("torus.obj", torus_obj(32));
};

TEST_F(TileCommand, WritesASetAndReportsIt) {
  const ProcessResult result = fit_set({"--report", path("r.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(names(), ElementsAre("r.json", "t", "t.json", "torus.obj"));
  const nlohmann::json report = read_json("r.json");
  std::ifstream file(PLANISH_REPORT_SCHEMA);
  EXPECT_THAT(schema_problems(report, nlohmann::json::parse(file)), IsEmpty());
  const nlohmann::json output = report["outputs"][0];
  EXPECT_EQ(output["level"], 2);
  EXPECT_EQ(output["vertices"], 16 * 32 * 32);
  EXPECT_EQ(output["quads"], 16 * 32 * 32);
  EXPECT_LT(output["as_written_error"], 1e-6);
  EXPECT_GT(output["as_written_error"], 0);
  const ReadTileset set(path("t.json"));
  std::vector<std::int64_t> tiles(3), bytes(3), triangles(3);
  for (const ReadTile& tile : set.tiles) {
    if (tile.content.empty()) continue;
    ++tiles[tile.level];
    bytes[tile.level] += static_cast<std::int64_t>(fs::file_size(tile.content));
    triangles[tile.level] += triangles_of(tile).face_count();
  }
  std::int64_t all = static_cast<std::int64_t>(read("t.json").size());
  ASSERT_EQ(output["tiles"].size(), 2u);
  for (int level = 1; level <= 2; ++level) {
    const nlohmann::json& at = output["tiles"][level - 1];
    EXPECT_EQ(at["level"], level);
    EXPECT_EQ(at["tiles"], tiles[level]);
    EXPECT_EQ(at["bytes"], bytes[level]);
    EXPECT_EQ(at["triangles"], triangles[level]);
    all += bytes[level];
  }
  EXPECT_EQ(output["bytes"], all);
  EXPECT_GT(tiles[2], tiles[1]);
  EXPECT_GT(output["tiles"][0]["geometric_error"], 0);
  EXPECT_EQ(output["tiles"][1]["geometric_error"], 0);
  EXPECT_THAT(result.err + result.out, HasSubstr("tiles, to level 2"));
}

TEST_F(TileCommand, FairSurfacesAndAxesToo) {
  ASSERT_EQ(fit_set({"--interpolation", "fair"}).exit_code, 0);
  const PolygonMesh y_up = welded(ReadTileset(path("t.json")), 2);
  EXPECT_EQ(y_up.vertex_count(), 16 * 32 * 32);
  // Of a model with Z up, tiles have its own axes.
  ASSERT_EQ(fit_set({"--interpolation", "fair", "--up", "z", "-f"}).exit_code, 0);
  const PolygonMesh z_up = welded(ReadTileset(path("t.json")), 2);
  ASSERT_EQ(z_up.vertex_count(), y_up.vertex_count());
  for (std::int32_t v = 0; v < z_up.vertex_count(); ++v) {
    const glm::dvec3 p = z_up.positions[v];
    ASSERT_EQ(y_up.positions[v], glm::dvec3(p.x, -p.z, p.y));
  }
}

TEST_F(TileCommand, ScenesHaveTheSameSettings) {
  write("s.json", R"({"version": 1, "jobs": [{"input": "torus.obj", "tile_vertices": 1000,
    "skirts": true, "device": "cpu", "outputs": [{"path": "a.json"}]}]})");
  const ProcessResult result = run_planish({"run", path("s.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  ASSERT_EQ(fit({"-o", path("b.json"), "--tile-vertices", "1000", "--skirts"}).exit_code, 0);
  EXPECT_EQ(files_below(path("a")), files_below(path("b")));
  ASSERT_EQ(fit_set().exit_code, 0);
  EXPECT_NE(files_below(path("a")), files_below(path("t"))) << "skirts are more";
}

// Each tile has the materials of its faces; images stand once beside all of them.
TEST_F(TileCommand, TilesHaveTheMaterialsOfAnAsset) {
  AssetSample sample;
  const std::string input = write("asset.glb", sample.glb());
  for (int turn = 0; turn < 2; ++turn) {
    const ProcessResult result = run_planish(
        {"fit", input, "--device", "cpu", "-f", "-o", path("t.json"), "--tile-vertices", "256"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }
  EXPECT_EQ(read("t/images/0.png"), AssetSample::image());
  std::set<std::string> seen;
  for (const ReadTile& tile : ReadTileset(path("t.json")).tiles) {
    if (tile.content.empty()) continue;
    const nlohmann::json made = document_of(read(tile.content.string()));
    for (const nlohmann::json& material : made["materials"]) {
      const auto given = std::ranges::find(sample.json["materials"], material);
      ASSERT_NE(given, sample.json["materials"].end()) << material;
      seen.insert(material["name"]);
    }
    EXPECT_EQ(made["images"][0]["uri"], "../images/0.png");
    EXPECT_EQ(made["textures"], sample.json["textures"]);
  }
  EXPECT_EQ(seen, (std::set<std::string>{"check", "red", "plain"}));
  // A stranger's file in that folder stays.
  write("t/images/mine.txt", "");
  EXPECT_EQ(run_planish({"fit", input, "-f", "-o", path("t.json")}).exit_code, 7);
}

TEST_F(TileCommand, FlagsWithoutTilesAreToldToHaveNoEffect) {
  const ProcessResult result = fit({"-o", path("t.glb"), "--skirts", "--tile-vertices", "1000"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("without effect here: --tile-vertices, --skirts"));
  EXPECT_THAT(result.err, HasSubstr("no output 3D Tiles)"));
  EXPECT_THAT(fit_set({"--skirts"}).err, Not(HasSubstr("without effect")));
}

TEST_F(TileCommand, RefusesByName) {
  const auto error = [&](std::vector<std::string> flags) {
    const ProcessResult result = fit_set(std::move(flags));
    EXPECT_EQ(result.exit_code, 2);
    return result.err;
  };
  EXPECT_THAT(error({"--scheme", "catmull-clark"}),
              HasSubstr("3D Tiles are made of Doo-Sabin surfaces, not of catmull-clark"));
  EXPECT_THAT(error({"--levels", "0"}), HasSubstr("3D Tiles have levels from 1 on, not 0"));
  EXPECT_THAT(error({"--attributes", "error"}), HasSubstr("t.json cannot hold them"));
  EXPECT_THAT(fit({"-o", path("t.json"), "--tile-vertices", "255"}).err,
              HasSubstr("--tile-vertices: 255 is out of range; 256 to 16777216"));
  EXPECT_THAT(names(), ElementsAre("torus.obj"));
}

TEST_F(TileCommand, ForceReplacesASetAndNothingElse) {
  ASSERT_EQ(fit_set({"--levels", "3"}).exit_code, 0);
  const auto old = files_below(path("t"));
  const std::string document = read("t.json");
  const ProcessResult refused = fit_set();
  EXPECT_EQ(refused.exit_code, 7);
  EXPECT_THAT(refused.err, HasSubstr("t.json exists; --force overwrites it"));
  fs::remove(path("t.json"));
  EXPECT_THAT(fit_set().err, HasSubstr("exists; --force replaces it"));
  EXPECT_EQ(files_below(path("t")), old);
  write("t.json", document);
  // A file of somebody else's, in the folder and in one of its own.
  for (const char* foreign : {"t/readme.txt", "t/0/picture.glb"}) {
    write(foreign, "mine");
    const ProcessResult kept = fit_set({"-f"});
    EXPECT_EQ(kept.exit_code, 7) << foreign;
    EXPECT_THAT(kept.err, HasSubstr(foreign));
    EXPECT_EQ(read(foreign), "mine");
    EXPECT_EQ(read("t.json"), document);
    fs::remove(path(foreign));
  }
  EXPECT_EQ(files_below(path("t")), old);
  ASSERT_EQ(fit_set({"-f"}).exit_code, 0);
  EXPECT_LT(files_below(path("t")).size(), old.size());
  EXPECT_EQ(welded(ReadTileset(path("t.json")), 2).vertex_count(), 16 * 32 * 32);
  EXPECT_THAT(names(), ElementsAre("t", "t.json", "torus.obj"));
}

TEST_F(TileCommand, TheFolderIsNoPlaceForOtherOutputs) {
  fs::create_directory(path("t"));
  const ProcessResult result = fit({"-o", path("t/a.glb"), "-o", path("t.json")});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("the folder of the tiles, has"));
  const ProcessResult reversed = fit({"-o", path("t.json"), "-o", path("t/a.glb")});
  EXPECT_EQ(reversed.exit_code, 2);
  EXPECT_THAT(reversed.err, HasSubstr("t/a.glb lies in the folder of tiles"));
}

TEST_F(TileCommand, FullDisksAndInterruptsLeaveTheOldSet) {
  ASSERT_EQ(fit_set().exit_code, 0);
  const auto old = files_below(path("t"));
  const std::string document = read("t.json");
  const auto expect_old = [&] {
    EXPECT_EQ(files_below(path("t")), old);
    EXPECT_EQ(read("t.json"), document);
    EXPECT_THAT(names(), ElementsAre("t", "t.json", "torus.obj"));
  };
  {
    const ProcessResult result = [&] {
      const FileSizeLimit limit(16 << 10);
      return fit({"-o", path("t.json"), "-f", "--levels", "3"});
    }();
    EXPECT_EQ(result.exit_code, 7) << result.err;
    EXPECT_THAT(result.err, HasSubstr("cannot write"));
    expect_old();
  }
  PlanishProcess process({"fit", torus_, "--device", "cpu", "-o", path("t.json"), "-f", "--levels",
                          "6", "--progress", "json"},
                         {});
  EXPECT_TRUE(process.wait_for_message("\"write\""));
  ::kill(process.id(), SIGINT);
  EXPECT_EQ(process.finish().exit_code, 130);
  expect_old();
}

}  // namespace
}  // namespace planish::test
