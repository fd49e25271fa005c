#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "planish/patches/patch_surface.h"
#include "planish/vulkan/embed.h"
#include "planish/vulkan/evaluate/gpu_patches.h"
#include "planish/vulkan/evaluate/patch_tables.h"
#include "planish/vulkan/host/file_rows.h"

namespace planish::vulkan {

struct SurfaceRecords;

/// The surface at one of the levels that a Tessellation chooses from.
struct LevelRecords {
  LevelRecords(const SurfaceRecords& surface, int level);

  PatchSurface patches;
  std::vector<RowFrame> frames;                  // of textured rows
  std::size_t first_index = 0, index_count = 0;  // of LevelSet::triangles
  /// Between its triangles and the surface in the rest pose, for a sphere of radius 1 around the
  /// control points.
  double chord = 0;
};

/// All of them, ascending.
struct LevelSet {
  std::deque<LevelRecords> levels;
  std::vector<std::uint32_t> triangles;
  double radius = 0;  ///< of the rest pose's sphere
};

/// The sphere around a box of points, as choose_levels makes it.
[[nodiscard]] double sphere_radius(std::span<const glm::dvec3> points);

/// `hull`: points whose hull holds the surface in the rest pose, in the coordinates of its state.
/// `radius` is in these.
[[nodiscard]] LevelSet make_levels(const PolygonMesh& mesh, const SurfaceRecords& surface,
                                   std::span<const glm::dvec3> hull, const PosedSurface& rest,
                                   std::span<const int> levels);

/// The surface at one level on a device; its links are those of the System's own level.
struct LevelTables {
  int level;
  PatchTables patches;
  std::uint32_t vertex_count, first_index, index_count;
  float chord;  ///< LevelRecords::chord
};

/// A LevelSet on a device, likewise.
struct LevelSetTables {
  /// `records` are of its levels. Throws Error{OutOfMemory} naming the limit that a table exceeds.
  LevelSetTables(const Maker& on, const LevelSet& set, std::span<const PatchRecords> records);

  std::deque<LevelTables> levels;
  Buffer indices;

  template <class Take>
  void for_each(const LevelSet& set, std::span<const PatchRecords> records,
                const Take& take) const {
    for (std::size_t i = 0; i < records.size(); ++i) levels[i].patches.for_each(records[i], take);
    take(indices, std::as_bytes(std::span(set.triangles)));
  }
};

/// What levels are chosen by and evaluated from: what a solve left.
struct ChosenParts {
  const PatchTables& patches;  ///< of the System's own level
  const StepTables* steps;     ///< of the progressive method, with `step`
  const LevelSetTables& set;
  const Buffer& hull;        ///< points around the surface, instance by instance
  std::uint64_t hull_count;  ///< of one instance
  std::uint64_t hull_stride;
  const Buffer &given, &state;
  std::uint64_t vertex_count;
  Instances instances;
  const Buffer* displacement;  ///< of the progressive method
};

/// Of positions alone: where TessellationOptions::previous_positions go.
[[nodiscard]] VertexLayout previous_layout(const TessellationOptions& options);

/// Chooses a level for each instance, and evaluates those that are seen. Externally synchronised;
/// all that it was made of outlives it.
class GpuLevels {
 public:
  /// `options` are whole: a number of places for each level. Throws Error{OutOfMemory} naming the
  /// limit.
  GpuLevels(const Maker& on, const ChosenParts& parts, const TessellationOptions& options);

  [[nodiscard]] bool writes_previous() const { return kept_.has_value(); }
  /// Within kEntryScope, behind the displacement that previous positions are then of; fills and
  /// copies, to be waited for.
  void record_reset(VkCommandBuffer commands) const noexcept;
  /// Within kEntryScope, behind the points of the hull; ends in kExitScope.
  void record(VkCommandBuffer commands, const TessellateParameters& view) const noexcept;

  /// Words: of each instance the level that the view wants, then those that there was room for.
  [[nodiscard]] VkBuffer levels() const { return levels_.handle(); }
  [[nodiscard]] VkBuffer draws() const { return draws_.handle(); }
  [[nodiscard]] LevelDraw level_draw(std::size_t level) const;

 private:
  enum Set { Choose, PlaceAll };
  struct Words;
  /// Points that a surface follows from, of all instances.
  struct Points {
    const Buffer *given, *displacement, *state;
  };
  /// What evaluates the surface of what is seen.
  struct Surface {
    std::optional<GpuFirstStep> step;
    std::optional<GpuRingSums> sums;
    std::deque<GpuPatches> patches;  // of each level
  };
  /// Where the points of the view before are kept.
  struct Kept {
    Buffer given, moving;  // the displacement, or the state where there is none
    Surface surface;
  };

  void make_work(const Maker& on, const TessellationOptions& options);
  void make_surface(const Maker& on, const Points& points, const VertexLayout& vertices,
                    const Words& words, Surface& surface) const;
  void make_kept(const Maker& on, const VertexLayout& vertices, const Words& words);
  void make_template(const Maker& on, const Words& words);
  [[nodiscard]] const Buffer& moving() const {
    return parts_.displacement ? *parts_.displacement : parts_.state;
  }
  void record_surface(VkCommandBuffer commands, const Surface& surface) const noexcept;
  void record_keep(VkCommandBuffer commands) const noexcept;
  void record_choice(VkCommandBuffer commands, const TessellateParameters& view) const noexcept;
  [[nodiscard]] IndirectGroups groups_of(std::size_t segment) const noexcept {
    return {work_.handle(),
            first_segment_ + segment * shared::kChosenWords * sizeof(std::uint32_t)};
  }
  void wait(VkCommandBuffer commands) const noexcept;

  Context& context_;
  ChosenParts parts_;
  shared::ChooseParameters choose_{};
  shared::PlaceInstancesParameters place_{};
  Pipeline choose_pipeline_, place_pipeline_;
  VkDeviceSize first_segment_ = 0;  // bytes
  Buffer template_, work_, levels_, draws_;
  Surface surface_;
  std::optional<Kept> kept_;                // where previous positions are written
  std::vector<VkDeviceSize> first_listed_;  // bytes, of each level's list
  bool numbers_draws_;
  DescriptorSets sets_;
};

}  // namespace planish::vulkan
