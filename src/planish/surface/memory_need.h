#pragma once

#include <cstdint>
#include <span>

#include "planish/mesh/polygon_mesh.h"
#include "planish/solve/stencil_table.h"

namespace planish {

/// What a scheme keeps of the levels.
enum class LastLevel {
  None,    ///< no topology: surfaces of patches
  Blocks,  ///< nor the surface: patches for who takes it piece by piece and keeps rows at most
  Full,    ///< OpenSubdiv's, of all levels: the primal schemes
};

/// What of a mesh is refined with it, besides points and normals.
struct RefinedAttributes {
  bool uvs = false, colors = false, groups = false;
  std::uint64_t numbers = 0;  ///< of each vertex, of all its attributes
  bool holes = false;         ///< the surface without them is a copy
  bool device_rows = false;   ///< patches leave their rows as a device made them

  static RefinedAttributes of(const PolygonMesh& mesh);
};

/// Peak of host memory that tessellating takes, in bytes: an upper estimate. `levels` holds the
/// element counts of level 0 to the one whose points give the limit. By blocks, what keep_rows()
/// and the writers of files hold is in it.
[[nodiscard]] std::uint64_t tessellation_bytes(std::span<const LevelCounts> levels, LastLevel last,
                                               const RefinedAttributes& attributes = {});

/// Memory that the machine can still give, in bytes: the least of what the kernel calls available,
/// what control groups and the process's limit of address space (ulimit -v) leave; the largest
/// value where none can be read.
[[nodiscard]] std::uint64_t available_memory_bytes();

/// For a program whose operator new takes large arrays from elsewhere, a disk say:
/// available_memory_bytes() counts so many bytes more from now on. Any thread.
void set_memory_elsewhere(std::uint64_t bytes);

/// Throws Error{OutOfMemory} where 32-bit indices do not reach all corners of the last level.
void require_indices(std::span<const LevelCounts> levels);

/// Throws Error{OutOfMemory} naming counts, need and limit when tessellating exceeds `limit_bytes`
/// (0: what is available) or 32-bit indices.
void require_memory(std::span<const LevelCounts> levels, LastLevel last,
                    const RefinedAttributes& attributes, std::uint64_t limit_bytes);

}  // namespace planish
