#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/distributed/mesh_part.h"
#include "planish/distributed/part_tiles.h"
#include "planish/files/tiles/write_tile.h"
#include "planish/surface/block_quality.h"

namespace planish {

/// Where a block's surface is folded, with the file's number of the face.
struct BlockFold {
  std::int64_t face = -1;
  glm::dvec3 position{0.0};
};

/// The figures of a block's own faces; a plain struct, so that rank 0 can gather them.
struct BlockFigures {
  std::int64_t row_count = 0, face_count = 0;  ///< of the finest level
  double area = 0, folded = 0, folded_elsewhere = 0, squares = 0, largest = 0, bending = 0;
  std::array<BlockFold, kNamedFolds> folds, folds_elsewhere;
};

/// What is known of a block whose tiles are written.
struct WrittenBlock {
  std::vector<WrittenTile> tiles;  ///< as the block's plan has them
  BlockFigures figures;
};

/// The sums of a block's faces, of which `file_faces` says the numbers in the file.
void note_quality(const QualitySums& sums, std::span<const std::int64_t> file_faces,
                  BlockFigures& figures);
/// The figures of all blocks, in their order: of the places those of the lowest faces.
[[nodiscard]] SurfaceQuality quality_of(std::span<const BlockFigures> blocks,
                                        std::vector<std::int64_t>& folded_faces);

/// Of all that a tile depends on.
using TilesKey = std::array<std::uint64_t, 2>;

/// The key of a part's mesh, cage and options: the same on all ranks and for every count of them.
[[nodiscard]] TilesKey tiles_key(const Ranks& ranks, const MeshPart& part,
                                 std::span<const glm::dvec3> cage, const PartTilesOptions& options);
/// The same on another grid.
[[nodiscard]] TilesKey tiles_key_on_grid(const TilesKey& key, int doublings);

/// Leaves in the folder of tiles what an ended job of that key has finished, and nothing in either
/// folder where there is none; notes the key. Throws Error{UnwritableOutput}.
void keep_only_of(const TilesKey& key, const std::filesystem::path& tiles,
                  const std::filesystem::path& records);

/// Where a block's record lies in their folder: 4,096 in each folder of it.
[[nodiscard]] std::filesystem::path record_path(const std::filesystem::path& records,
                                                std::int64_t block);

/// Writes a record, after the block's tiles: it is there only if they are.
void write_record(const std::filesystem::path& path, const TilesKey& key,
                  const WrittenBlock& block);

/// The record of a block with so many tiles, if it is there and of that key.
[[nodiscard]] std::optional<WrittenBlock> read_record(const std::filesystem::path& path,
                                                      const TilesKey& key, std::size_t tile_count);

}  // namespace planish
