#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/core/range.h"
#include "planish/core/raw_vector.h"
#include "planish/mesh/mesh_topology.h"

namespace planish {

/// A run of the curve at one level, with at least one face.
struct PlannedTile {
  int level = 1;
  std::int32_t block = 0;    ///< the run of level 1 that it lies in
  std::int32_t quarter = 0;  ///< its place among those of its level in the block
  RowRange run;              ///< of places on the curve
  std::int32_t parent = -1;  ///< the tile of the level below; -1 at level 1
};

/// Which faces of a mesh are in which tile: what depends on the mesh and the sizes alone.
struct TilePlan {
  /// The place on the curve of each face's first vertex there; -1: a hole. Places behind the last
  /// one are those of faces in tiles of others.
  RawVector<std::int32_t> face_places;
  RawVector<std::int32_t> faces;        ///< by these places, then ascending
  RawVector<std::int32_t> face_begins;  ///< place_count + 1: where those of a place begin
  std::int32_t block_count = 0;
  /// Blocks one after another, in each a tile before its children, these in their order.
  std::vector<PlannedTile> tiles;

  [[nodiscard]] std::span<const std::int32_t> faces_of(const PlannedTile& tile) const {
    return faces_in(tile.run);
  }
  [[nodiscard]] std::span<const std::int32_t> faces_in(RowRange run) const {
    const std::int32_t begin = face_begins[run.first];
    return std::span(faces).subspan(begin, face_begins[run.first + run.count] - begin);
  }
  [[nodiscard]] bool holds(const PlannedTile& tile, std::int32_t face) const {
    const std::int32_t place = face_places[face];
    return place >= tile.run.first && place < tile.run.first + tile.run.count;
  }
};

/// How faces are cut into tiles.
struct TileCut {
  std::int64_t place_count = 0;     ///< places on the curve
  std::int64_t block_vertices = 0;  ///< of each run of it
  int level = 1;                    ///< the finest
};

/// Tiles of levels 1 to `level`: blocks are runs of `block_vertices` places on the curve, the
/// children of a tile are the quarters of its run. A face belongs to the first of its vertices, of
/// which `places` says where they are; tiles without faces are left out. `hidden` has one flag a
/// face, or nothing.
[[nodiscard]] TilePlan plan_tiles(const MeshTopology& topology,
                                  std::span<const std::uint8_t> hidden,
                                  std::span<const std::int32_t> places, const TileCut& cut);

/// The same of faces that have their places already; those from place_count on are seen, but in
/// tiles of others.
[[nodiscard]] TilePlan plan_tiles(RawVector<std::int32_t> face_places, const TileCut& cut);

}  // namespace planish
