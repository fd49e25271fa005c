#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/distributed/mesh_part.h"
#include "planish/distributed/part_fair.h"
#include "planish/distributed/ranks.h"
#include "planish/doosabin/subdivision.h"
#include "planish/files/tiles/tile.h"
#include "planish/files/tiles/write_tiles.h"
#include "planish/measure/figures.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/surface/quality_sum.h"

namespace planish {

/// A set of tiles that all ranks write and that appears whole or not at all: into a hidden folder
/// beside it, `.NAME.part`, which rank 0 moves when all agree that everything is there. Every
/// function is called by all ranks and throws AgreedError{UnwritableOutput} naming the path.
class StagedTileset {
 public:
  /// Removes what an ended job may have left of it, unless it is to be resumed. Without `replaces`
  /// a document and a folder with something in it that stand there when commit() is called stay,
  /// and commit() throws.
  StagedTileset(const Ranks& ranks, std::filesystem::path document, bool resume,
                bool replaces = true);
  /// Removes what was not committed.
  ~StagedTileset();
  StagedTileset(const StagedTileset&) = delete;
  StagedTileset& operator=(const StagedTileset&) = delete;

  /// Where to write the document, its tiles beside it, and what is known of blocks.
  [[nodiscard]] std::filesystem::path document() const { return part_ / document_.filename(); }
  [[nodiscard]] std::filesystem::path records() const { return part_ / "records"; }

  /// The old document goes first, then its folder, then the new folder comes, then the document:
  /// whatever ends the process, a document is in place only while its folder is.
  void commit();

 private:
  void move_into_place() const;

  const Ranks& ranks_;
  std::filesystem::path document_, part_;
  bool replaces_;
};

struct PartTilesOptions {
  TilesOptions tiles;  ///< level, tile_vertices, skirts and gltf without its callbacks count
  Weights weights = Weights::DooSabin;
  SharpFeatureOptions sharp;
  Placement placement;                 ///< of the whole cage
  const PartFair* fair = nullptr;      ///< instead of a cage, which is the given mesh then
  std::span<const glm::dvec3> points;  ///< as TilesOptions has them, by local vertex
  std::filesystem::path records;       ///< folder of what is known of finished blocks
  std::function<void()> after_block;   ///< a sign of life, from any thread
};

/// What was written; `file` and `quality` are rank 0's.
struct PartTiles {
  TilesFile file;
  SurfaceQuality quality;  ///< of level 1 against the given faces, as planish fit reports it
  std::vector<std::int64_t> folded_faces;  ///< of quality.folded_places: numbers in the file
  std::int64_t blocks = 0;                 ///< with faces
  std::int64_t resumed = 0;                ///< of them those that were there already
};

/// Writes the surface of a cage as write_tiles() does, all ranks together: each the tiles of its
/// blocks, one block after another, rank 0 the documents. The bytes are those of write_tiles() on
/// the whole mesh, whatever the count of ranks. `cage`: by local vertex, ghosts too. The part needs
/// its ghosts' tags, and its ranks are cut between blocks of tile_vertices / 4.
/// Tiles go to tile_folder(path), which is there. A block whose record is there, of a job of the
/// same input and options, is not written again.
/// Throws AgreedError as write_tiles().
[[nodiscard]] PartTiles write_part_tiles(const Ranks& ranks, const std::filesystem::path& path,
                                         const MeshPart& part, std::span<const glm::dvec3> cage,
                                         const PartTilesOptions& options);

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
