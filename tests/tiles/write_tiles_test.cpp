#include "planish/files/tiles/write_tiles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <set>

#include "cli/json_schema.h"
#include "planish/files/mesh_file.h"
#include "planish/mesh/check.h"
#include "support/expect_error.h"
#include "support/files_below.h"
#include "support/random_meshes.h"
#include "support/temporary_folder.h"
#include "tiles/read_tiles.h"

namespace planish {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

// A mesh as the cage of a surface, and the limit points of its vertices, which stand for given
// ones.
class TiledSurface {
 public:
  explicit TiledSurface(PolygonMesh mesh)
      : mesh_(std::move(mesh)), surface_(mesh_, EvaluateOptions{}), given_(mesh_.positions) {
    const SurfaceMesh limit = whole(1);
    for (std::size_t i = 0; i < limit.base_vertices.size(); ++i)
      given_[limit.base_vertices[i]] = limit.positions[i];
  }

  [[nodiscard]] SurfaceMesh whole(int level) const { return collect(*surface_.level(level), {}); }
  [[nodiscard]] TilesFile write(const fs::path& path, TilesOptions options) const {
    options.given = given_;
    return write_tiles(path, surface_, options);
  }
  [[nodiscard]] TilesFile write(const fs::path& path, int level, std::int64_t vertices) const {
    return write(path, {.level = level, .tile_vertices = vertices});
  }

 private:
  PolygonMesh mesh_;
  DooSabinSurface surface_;
  std::vector<glm::dvec3> given_;
};

PolygonMesh far_torus() {
  PolygonMesh mesh = test::torus(40, 20, 3, 1);
  for (glm::dvec3& p : mesh.positions) p += glm::dvec3(1e6, -2e5, 17);
  return mesh;
}

// The welded tiles of a level are the level in one piece, snapped: as many places and triangles.
void expect_level_whole(const test::ReadTileset& set, const TiledSurface& surface, int level,
                        bool is_closed) {
  const SurfaceMesh whole = surface.whole(level);
  const PolygonMesh mesh = test::welded(set, level);
  std::set<std::array<double, 3>> places;
  for (const glm::dvec3& p : whole.positions) places.insert({p.x, p.y, p.z});
  EXPECT_EQ(mesh.positions.size(), places.size());
  EXPECT_EQ(mesh.face_count(), 2 * whole.face_count());
  if (is_closed) {
    EXPECT_THAT(check(mesh), IsEmpty());
    EXPECT_EQ(mesh.positions.size(), whole.positions.size());
  }
}

void expect_nested(const test::ReadTileset& set) {
  const double whole = glm::length(set.tiles[0].upper - set.tiles[0].lower);
  EXPECT_NEAR(set.tiles[0].error, whole, 1e-9 * whole);
  std::vector<bool> is_leaf(set.tiles.size(), true);
  for (const test::ReadTile& tile : set.tiles) {
    if (tile.parent < 0) continue;
    const test::ReadTile& parent = set.tiles[tile.parent];
    is_leaf[tile.parent] = false;
    EXPECT_TRUE(parent.holds(tile)) << tile.content;
    EXPECT_GE(parent.error, tile.error) << tile.content;
    if (parent.level > 0) {
      EXPECT_EQ(tile.level, parent.level + 1);
    }
  }
  for (std::size_t i = 0; i < set.tiles.size(); ++i) {
    const test::ReadTile& tile = set.tiles[i];
    if (tile.content.empty()) continue;
    EXPECT_EQ(tile.error == 0, is_leaf[i]) << tile.content;
    for (const glm::dvec3& p : test::triangles_of(tile).positions)
      ASSERT_TRUE(tile.holds({.lower = p, .upper = p})) << tile.content;
  }
}

TEST(WriteTiles, LevelsWeldToTheSurfaceInOnePiece) {
  for (const bool far : {false, true}) {
    const test::TemporaryFolder folder;
    const TiledSurface surface(far ? far_torus() : test::torus(40, 20, 3, 1));
    const TilesFile file = surface.write(folder.path() / "t.json", 3, 400);
    const test::ReadTileset set = test::read_tileset(folder.path() / "t.json");
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
  for (const bool compressed : {false, true}) {
    for (const float wrong : {nan, inf, -inf}) {
      for (const std::size_t vertex : {0u, 411u, 799u}) {
        PolygonMesh mesh = test::torus(40, 20, 3, 1);
        mesh.colors.assign(mesh.positions.size(), glm::vec4(1));
        mesh.colors[vertex].g = wrong;
        const TiledSurface surface(mesh);
        const test::TemporaryFolder folder;
        TilesOptions options{.level = 3, .tile_vertices = 400};
        if (compressed) options.gltf.compression = GltfCompression::Meshopt;
        EXPECT_THAT(
            test::message_of(ErrorCode::InvalidArgument,
                             [&] { (void)surface.write(folder.path() / "t.json", options); }),
            HasSubstr("is not finite"));
        EXPECT_TRUE(fs::is_empty(folder.path()));
      }
    }
  }
}

// All on one grid, as coarse as the error allows: what meets is equal there too.
TEST(WriteTiles, CompressedTilesMeetAsOthersDo) {
  const TiledSurface surface(far_torus());
  const test::TemporaryFolder folder;
  std::map<GltfCompression, std::uint64_t> bytes;
  for (const auto compression :
       {GltfCompression::None, GltfCompression::Quantize, GltfCompression::Meshopt}) {
    for (const double error : {0.0, 1e-3}) {
      TilesOptions options{.level = 3, .tile_vertices = 400};
      options.gltf.compression = compression;
      options.gltf.position_error = error;
      const fs::path path = folder.path() / (std::to_string(static_cast<int>(compression)) +
                                             std::to_string(error) + ".json");
      const TilesFile file = surface.write(path, options);
      const test::ReadTileset set = test::read_tileset(path);
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
    const test::TemporaryFolder folder;
    const TiledSurface surface(test::laden_mesh(seed));
    (void)surface.write(folder.path() / "t.json", 2, 256);
    const test::ReadTileset set = test::read_tileset(folder.path() / "t.json");
    for (int level = 1; level <= 2; ++level) expect_level_whole(set, surface, level, false);
    expect_nested(set);
  }
}

TEST(WriteTiles, BytesDoNotDependOnThreads) {
  const TiledSurface surface(test::laden_mesh(6));
  const test::TemporaryFolder folder;
  using oneapi::tbb::global_control;
  const auto with = [&](std::size_t threads) {
    const global_control limit(global_control::max_allowed_parallelism, threads);
    const fs::path place = folder.path() / std::to_string(threads);
    fs::create_directory(place);
    (void)surface.write(place / "t.json", {.level = 2, .tile_vertices = 256, .skirts = true});
    return test::files_below(place);
  };
  const auto one = with(1);
  EXPECT_GT(one.size(), 8u);
  EXPECT_EQ(one, with(2));
  EXPECT_EQ(one, with(5));
}

TEST(WriteTiles, ManyBlocksComeInDocumentsOfTheirOwn) {
  const test::TemporaryFolder folder;
  const TiledSurface surface(test::torus(120, 60, 3, 1));
  (void)surface.write(folder.path() / "two words.json", 1, 256);
  const test::ReadTileset set = test::read_tileset(folder.path() / "two words.json");
  EXPECT_EQ(set.documents.size(), 3u);  // 113 blocks, 64 a document
  expect_level_whole(set, surface, 1, true);
  expect_nested(set);
}

TEST(WriteTiles, DocumentsFollowTheSchema) {
  std::ifstream file(PLANISH_TILESET_SCHEMA);
  const auto schema = nlohmann::json::parse(file);
  const test::TemporaryFolder folder;
  (void)TiledSurface(test::torus(120, 60, 3, 1)).write(folder.path() / "t.json", 1, 256);
  (void)TiledSurface(test::torus(20, 10, 3, 1)).write(folder.path() / "u.json", 3, 256);
  for (const char* name : {"t.json", "u.json"}) {
    const test::ReadTileset set = test::read_tileset(folder.path() / name);
    for (nlohmann::json document : set.documents) {
      EXPECT_THAT(test::schema_problems(document, schema), IsEmpty()) << name;
      document["root"]["geometricError"] = -1;
      EXPECT_FALSE(test::schema_problems(document, schema).empty());
    }
  }
}

TEST(WriteTiles, ErrorsAreAboutTheDistanceOfLevels) {
  // The estimate against the distance between corresponding points of levels 1 and 5.
  const test::TemporaryFolder folder;
  const TiledSurface surface(test::torus(16, 12, 3, 1));
  const TilesFile file = surface.write(folder.path() / "t.json", 2, 1 << 20);
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
  const test::TemporaryFolder folder;
  // An open sheet in tiles: its own boundary gets none.
  const TiledSurface surface(test::grid(
      24, 24, [](double x, double y) { return glm::dvec3(x, y, 0.05 * (x * x + y * y)); }));
  (void)surface.write(folder.path() / "plain.json", {.level = 2, .tile_vertices = 1024});
  (void)surface.write(folder.path() / "skirts.json",
                      {.level = 2, .tile_vertices = 1024, .skirts = true});
  const test::ReadTileset plain = test::read_tileset(folder.path() / "plain.json");
  const test::ReadTileset skirts = test::read_tileset(folder.path() / "skirts.json");
  ASSERT_EQ(plain.tiles.size(), skirts.tiles.size());
  expect_nested(skirts);
  std::int64_t strips = 0, edges = 0;
  for (std::size_t i = 0; i < plain.tiles.size(); ++i) {
    if (plain.tiles[i].content.empty()) continue;
    const PolygonMesh without = test::triangles_of(plain.tiles[i]);
    const PolygonMesh with = test::triangles_of(skirts.tiles[i]);
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
  const test::TemporaryFolder folder;
  PolygonMesh mesh = test::torus(40, 20, 3, 1);
  mesh.face_uvs = mesh.face_vertices;
  for (const glm::dvec3& p : mesh.positions) mesh.uvs.emplace_back(p.x / 8 + 0.5, p.y / 8 + 0.5);
  const TiledSurface surface(std::move(mesh));
  (void)surface.write(folder.path() / "plain.json", {.level = 2, .tile_vertices = 400});
  (void)surface.write(folder.path() / "skirts.json",
                      {.level = 2, .tile_vertices = 400, .skirts = true});
  const test::ReadTileset plain = test::read_tileset(folder.path() / "plain.json");
  const test::ReadTileset skirts = test::read_tileset(folder.path() / "skirts.json");
  std::int64_t hanging = 0;
  for (std::size_t i = 0; i < plain.tiles.size(); ++i) {
    if (plain.tiles[i].content.empty()) continue;
    const PolygonMesh without = test::triangles_of(plain.tiles[i]);
    const PolygonMesh with = test::triangles_of(skirts.tiles[i]);
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
  const test::TemporaryFolder folder;
  const TiledSurface surface(test::cube());
  const auto message = [&](const TilesOptions& options) {
    return test::message_of(ErrorCode::InvalidArgument,
                            [&] { (void)surface.write(folder.path() / "t.json", options); });
  };
  EXPECT_THAT(message({.level = 0}), HasSubstr("levels from 1 on"));
  EXPECT_THAT(message({.tile_vertices = 255}), HasSubstr("255 vertices; 256 are the least"));
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(WriteTiles, FailureLeavesNothing) {
  const test::TemporaryFolder folder;
  const TiledSurface surface(test::torus(20, 10, 3, 1));
  fs::create_directory(folder.path() / "t");
  std::ofstream(folder.path() / "t" / "mine.txt") << "mine";
  EXPECT_THAT(test::message_of(ErrorCode::UnwritableOutput,
                               [&] { (void)surface.write(folder.path() / "t.json", 1, 256); }),
              HasSubstr("is not empty"));
  EXPECT_TRUE(fs::exists(folder.path() / "t" / "mine.txt"));
  TilesOptions cancelled{.level = 2, .tile_vertices = 256};
  cancelled.gltf.callbacks.progress = [](std::string_view, double) {
    throw Error(ErrorCode::Cancelled, "enough");
  };
  (void)test::message_of(ErrorCode::Cancelled,
                         [&] { (void)surface.write(folder.path() / "u.json", cancelled); });
  EXPECT_FALSE(fs::exists(folder.path() / "u"));
  EXPECT_FALSE(fs::exists(folder.path() / "u.json"));
  // The other way to end it: while tiles are written, too.
  int asked = 0, most = 1 << 30;
  const TiledSurface large(test::torus(100, 50, 3, 1));  // is asked every few milliseconds
  TilesOptions stopped{.level = 3, .tile_vertices = 256};
  stopped.gltf.callbacks.cancelled = [&] { return asked++ >= most; };
  (void)large.write(folder.path() / "whole.json", stopped);
  EXPECT_GE(asked, 2);
  for (most = 0; most < 2; ++most) {
    asked = 0;
    (void)test::message_of(ErrorCode::Cancelled,
                           [&] { (void)large.write(folder.path() / "v.json", stopped); });
    EXPECT_FALSE(fs::exists(folder.path() / "v")) << most;
    EXPECT_FALSE(fs::exists(folder.path() / "v.json")) << most;
  }
}

}  // namespace
}  // namespace planish
