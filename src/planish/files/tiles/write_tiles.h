#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/files/gltf/write_gltf.h"
#include "planish/surface/doo_sabin_surface.h"

namespace planish {

struct TilesOptions {
  int level = 2;  ///< the finest, from 1 on; those before it are what viewers show from afar
  /// About so many vertices has a tile of any level; at least kLeastTileVertices.
  std::int64_t tile_vertices = 262'144;
  /// Strips along the edges of tiles, which hide gaps between tiles of different levels. They are
  /// as long as the gaps may be wide.
  bool skirts = false;
  /// The vertices of the mesh that was fitted, in its numbers, unused ones too: blocks are runs of
  /// those, and what is written is measured against them, or against `points` where the surface
  /// passes through those in their place.
  std::span<const glm::dvec3> given, points;
  /// name, double_sided, z_up, extras, materials (whose images stand once in the folder),
  /// compression, position_error, observe (the document's bytes) and callbacks (step "write",
  /// warning "degenerate-normals") count. Tiles have their own origins, and no fields.
  GltfOptions gltf;
};

inline constexpr std::int64_t kLeastTileVertices = 256;

/// The tiles of one level as written.
struct TileLevel {
  int level = 1;
  std::int64_t tiles = 0;
  std::uint64_t bytes = 0, vertex_count = 0, triangle_count = 0;
  double geometric_error = 0;  ///< the largest of them
};

struct TilesFile {
  std::uint64_t byte_count = 0;                ///< of all files
  std::int64_t row_count = 0, face_count = 0;  ///< of the finest level in one piece
  std::vector<TileLevel> levels;
  /// Largest distance of a given vertex from its place in any tile: float32 numbers and the tile's
  /// transform, added in double.
  double largest_distance = 0;
  DegenerateRows degenerate;  ///< of the finest level, as often as tiles have them
};

/// The folder of a document's tiles, beside it: "big/tileset" of "big/tileset.json".
[[nodiscard]] std::filesystem::path tile_folder(const std::filesystem::path& document);

/// Writes a surface as 3D Tiles 1.1: the document at `path`, and its tiles, each a GLB, in the
/// folder beside it. README.md in this folder says how they are cut. Bytes are the same for every
/// number of threads; memory beside the surface is a few tiles for each thread. Files appear one by
/// one, the document last; where that fails the folder is removed again.
/// Throws Error{InvalidArgument} for a level or size out of range, a surface without faces,
/// Error{UnwritableOutput}, also where the folder exists and is not empty,
/// Error{OutOfMemory} where 32-bit indices do not reach, Error{Cancelled}.
TilesFile write_tiles(const std::filesystem::path& path, const DooSabinSurface& surface,
                      const TilesOptions& options);

}  // namespace planish
