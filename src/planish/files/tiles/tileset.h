#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/files/tiles/tile_mesh.h"
#include "planish/files/tiles/tile_plan.h"

namespace planish {

/// A tile that has been written.
struct TileRecord {
  TileBox box;       ///< about its block's origin
  double error = 0;  ///< its geometricError; 0 of the last level
  std::uint64_t bytes = 0, vertex_count = 0, triangle_count = 0;
};

/// Tiles in a folder; one that grows beyond that slows file systems and viewers of folders.
inline constexpr std::size_t kTilesInFolder = 4096;
/// Blocks of one document; a set of more has a document for each group of so many.
inline constexpr std::size_t kBlocksInDocument = 64;

/// Where tiles find the images that they share, as a relative URI, and their folder in the set's.
inline constexpr const char* kTileImages = "../images/";
inline constexpr const char* kImageFolder = "images";

/// Where a tile's file lies in the set's folder: "0/12-2-3.glb", the block, the level and the place
/// among those of its level in the block. `index`: among all tiles of the set.
[[nodiscard]] std::string tile_path(const PlannedTile& tile, std::size_t index);
/// "12-2-3" of it.
[[nodiscard]] std::string tile_name(const PlannedTile& tile);

/// Whether a name may stand in a set's folder, or in a folder of that: "0", "images" and
/// "group-0.json", or "12-2-3.glb".
[[nodiscard]] bool is_tileset_entry(std::string_view name);
[[nodiscard]] bool is_tile_name(std::string_view name);
/// Whether it may stand in the folder of images: "3.png".
[[nodiscard]] bool is_image_name(std::string_view name);
/// The first thing in a set's folder that no set has there; empty if there is none.
[[nodiscard]] std::filesystem::path foreign_in_tiles(const std::filesystem::path& folder);

struct TilesetText {
  std::string path;  ///< in the set's folder; empty: the document itself
  std::string text;
};

struct TilesetOptions {
  std::string folder;  ///< its name
  bool z_up = false;   ///< the content is turned upright, see GltfOptions
  std::string extras;  ///< of the asset, as JSON
};

/// The documents of a set of 3D Tiles 1.1: those of groups first, where there are several, the
/// document itself last. Of the plan only its tiles count; `origins` are those of the blocks. Tiles
/// of one block are a tree with refine REPLACE, whose root carries the origin as its transform;
/// what stands above is empty. Volumes hold their children's, errors never fall below theirs.
/// Source: OGC 22-025r4, "3D Tiles Specification 1.1".
[[nodiscard]] std::vector<TilesetText> tileset_documents(const TilePlan& plan,
                                                         std::span<const TileRecord> tiles,
                                                         std::span<const glm::dvec3> origins,
                                                         const TilesetOptions& options);

}  // namespace planish
