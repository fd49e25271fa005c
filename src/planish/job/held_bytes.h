#pragma once

#include <cstdint>
#include <vector>

#include "planish/files/gltf/asset/asset_vertices.h"
#include "planish/job/job.h"
#include "planish/surface/memory_need.h"

namespace planish {

/// Elements of a mesh.
struct MeshCounts {
  LevelCounts base;
  std::int64_t corners;
};

/// Elements of the levels 0 to `last`: quads from level 1 on, triangles with Loop.
[[nodiscard]] std::vector<LevelCounts> levels_to(const MeshCounts& mesh, Scheme scheme, int last);

/// Bytes of what rides on a mesh of an asset: as it was given, at the surface's rows, and what its
/// rows are made from meanwhile.
struct RideBytes {
  std::uint64_t given = 0, rows = 0, making = 0;
};

/// `holds_rows`: of each surface, as but levels of Doo-Sabin surfaces do.
[[nodiscard]] RideBytes ride_bytes(const AssetVertices& vertices, const Settings& settings,
                                   std::uint64_t row_count, std::uint64_t corner_count,
                                   bool holds_rows);

/// What the meshes of a job hold at its peak. They are solved one after another beside what is kept
/// of all; then their surfaces are held together. Doo-Sabin surfaces go by blocks to who writes
/// them, but for those who need neighbours: values of vertices.
class HeldBytes {
 public:
  /// `settings` must outlive it.
  explicit HeldBytes(const Settings& settings);

  /// `held_levels`: those whose surfaces are held together. `solve`: bytes of the mesh and its
  /// fits. `ride_on_levels`: what rides on the vertices is written with these levels.
  void add(const RefinedAttributes& attributes, const MeshCounts& counts,
           const std::vector<int>& held_levels, std::uint64_t solve,
           const AssetVertices* rides = nullptr, bool ride_on_levels = true);
  [[nodiscard]] std::uint64_t peak() const;

 private:
  void add_surface(const RefinedAttributes& attributes, const std::vector<LevelCounts>& levels,
                   std::uint64_t corner_count, const AssetVertices* rides);

  const Settings& settings_;
  LastLevel last_;
  std::uint64_t fixed_, kept_ = 0, surfaces_ = 0, solve_ = 0, making_ = 0, packing_ = 0;
};

}  // namespace planish
