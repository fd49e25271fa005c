#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/distributed/mesh_part.h"
#include "planish/distributed/part_fair.h"
#include "planish/doosabin/face_rule.h"
#include "planish/files/tiles/write_tiles.h"
#include "planish/mesh/placement.h"
#include "planish/mesh/sharpness.h"
#include "planish/surface/surface_quality.h"

namespace planish {

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

}  // namespace planish
