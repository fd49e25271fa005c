#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>

#include "planish/files/tiles/tile_grid.h"
#include "planish/files/tiles/tile_mesh.h"
#include "planish/files/tiles/tile_plan.h"
#include "planish/files/tiles/tileset.h"
#include "planish/files/tiles/write_tiles.h"

namespace planish {

/// How far the given vertices of a set's blocks are from their middles, and from the model's
/// origin: what the grid of all positions follows from.
struct TileReach {
  double reach = 0, largest = 0;

  /// The box of the given vertices of a block's faces.
  void add(const TileBox& block);
  /// The surface between the vertices leaves their boxes: by a sixteenth, twice as much with each
  /// doubling.
  /// Compressed positions have as many bits as the form of `options` has, and may be as coarse as
  /// its position_error allows.
  [[nodiscard]] TileGrid grid(int doublings, const GltfOptions& options) const;
};

/// What is known of a tile once it is written.
struct WrittenTile {
  TileRecord record;
  double coarser_error = 0;     ///< of the level before in its place
  double largest_distance = 0;  ///< of a given vertex from its place
  DegenerateRows degenerate;
};

/// Where a tile goes.
struct TilePlace {
  std::filesystem::path path;
  glm::dvec3 origin{0.0};  ///< of its block
  double error = 0;        ///< its geometricError, which its children have told
};

/// Makes a tile and writes it: a function of the faces of its block, those around them, and of what
/// the whole set shares. Of the options level, skirts, given and gltf count, as TilesOptions says.
/// Nothing where the tile leaves the reach of its grid. Throws as write_tiles().
[[nodiscard]] std::optional<WrittenTile> write_tile(const TileSource& source,
                                                    const PlannedTile& tile, const TilePlace& place,
                                                    const TilesOptions& options);

/// Makes the errors of the parents of a level's tiles no smaller than theirs, and than what those
/// say of the level before.
void pass_errors_up(std::span<const PlannedTile> tiles, int level, std::span<WrittenTile> written);
/// Makes volumes hold those of children.
void pass_boxes_up(std::span<const PlannedTile> tiles, std::span<WrittenTile> written);

/// The figures of a set of these tiles; those of the finest level in one piece are left out.
[[nodiscard]] TilesFile sum_of_tiles(std::span<const PlannedTile> tiles,
                                     std::span<const WrittenTile> written, int level);

/// Throws Error{InvalidArgument} for a level, size or compression that tiles cannot have.
void require_tiles_options(const TilesOptions& options);

/// The documents of a set, as tileset_documents(); `path` is that of the document itself.
[[nodiscard]] std::vector<TilesetText> documents_of(const std::filesystem::path& path,
                                                    const TilePlan& plan,
                                                    std::span<const WrittenTile> written,
                                                    std::span<const glm::dvec3> origins,
                                                    const TilesOptions& options);

}  // namespace planish
