#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "planish/doosabin/subdivision.h"
#include "planish/patches/chart_field.h"
#include "planish/patches/patch_mesh.h"
#include "planish/patches/patch_surface.h"
#include "planish/solve/stencil_table.h"
#include "planish/vulkan/device/bindings.h"
#include "planish/vulkan/device/driver.h"
#include "planish/vulkan/host/solve_options.h"
#include "shaders/shared.h"

namespace planish::vulkan {

/// The place of each row of a surface; of those that several corners share, one of them.
[[nodiscard]] std::vector<SurfacePlace> row_places(const PatchSurface& surface);

/// Of each row, in single precision; v turned over, as images count their rows. The surface's rows
/// are cut at the seams.
[[nodiscard]] std::vector<glm::vec2> row_uvs(const PatchSurface& surface,
                                             const ChartField<glm::dvec2>& field);

/// Where u grows at a row: along tangents[0] times a patch's du and tangents[1] times its dv, as
/// evaluated by the patch that makes the row's normal; in the lowest bit of tangents[1] whether v
/// grows to the right of that. Zeros where the texture has no extent.
struct RowFrame {
  std::uint32_t tangents[2] = {0, 0};  ///< bits of floats
};

/// Of each row. Within a square of Q_1 it is the surface's own derivative by the field's u; rows
/// that faces share have the mean of theirs, each of unit length in the tangent plane of the rings
/// that evaluate it.
[[nodiscard]] std::vector<RowFrame> row_frames(const PatchSurface& surface, Weights weights,
                                               const ChartField<glm::dvec2>& field);

/// Where the points of the state of level 1 are seen from: the vertex of a corner; of a curve point
/// the end of its edge that it lies next to; a corner vertex itself.
[[nodiscard]] std::vector<std::int32_t> state_owners(const PatchMesh& mesh);

/// Points of the state of level 1 that one dispatch makes.
struct StepPart {
  std::uint32_t kind = shared::kStepFaces;
  std::uint32_t count = 0;        ///< of points, or of large faces
  std::uint32_t first_point = 0;  ///< where the points are no large faces'
  std::uint32_t first_word = 0;   ///< of the sharp points or large faces
};

/// The first step as its kernel takes it, beside PatchRecords::links.
struct StepRecords {
  std::vector<std::uint32_t> vertices;  ///< per corner
  /// The place of each small face size's weights, the weights; of each large face its
  /// kLargeFaceWords, and what they name; then of each sharp point its vertex and where its pairs
  /// begin, and pairs of a vertex and a weight.
  std::vector<std::uint32_t> words;
  FaceSumRule rule{};
  std::vector<StepPart> parts;
};

/// `sharp_rows`: the rows of the first step behind those of the corners.
[[nodiscard]] StepRecords step_records(const PatchMesh& mesh, Weights weights,
                                       const StencilView<double>& sharp_rows);

/// Indices [first, first + count); none where count is 0.
struct IndexWindow {
  std::int64_t first = 0, count = 0;
  /// The smallest that holds both.
  [[nodiscard]] IndexWindow joined(const IndexWindow& other) const;
};

/// Patches that one dispatch does, with what its bindings of tables and output must span. Windows
/// of tables begin at multiples of 64.
struct PatchSlice {
  std::uint32_t gather = 0;   ///< shared::kGatherCorner, ...
  std::uint32_t samples = 1;  ///< that a lane evaluates at once, chunk_count times
  std::uint32_t chunk_count = 1;
  std::uint32_t first_group = 0, group_count = 0;
  IndexWindow words, weights;
  IndexWindow rows;  ///< of the output
};

struct PatchLimits {
  BindingLimit range;
  std::uint64_t max_groups = 0;   ///< work groups of one dispatch
  std::uint64_t max_units = 0;    ///< groups times chunks in one dispatch
  std::uint64_t row_stride = 24;  ///< bytes from one row of the output to the next, at most
  bool joins_ways = false;        ///< one slice of shared::kGatherAny, where all of it fits
};

/// The surface's patches as kernels take them; see shaders/shared.h.
struct PatchRecords {
  using Link = std::array<std::uint32_t, 2>;
  using Weight = std::array<float, 4>;

  std::vector<Link> links;  ///< per corner: ccw, shared::kNone at boundaries; next
  std::vector<shared::PatchGroup> groups;
  std::vector<std::uint32_t> words;
  std::vector<Weight> weights;  ///< of point, du, dv; a float unused
  std::vector<PatchSlice> slices;
  std::vector<std::uint32_t> rings;  ///< shared::kRingWords each, and what they name
  std::uint32_t ring_count = 0;
  bool has_frames = false;     ///< groups have those of textured rows
  std::int64_t first_sum = 0;  ///< the place behind the state
  /// Per lane of each group the vertex whose faces have all points of its patch, -1 in lanes
  /// without one; empty where they were not asked for.
  std::vector<std::int32_t> owners;
};

/// All but the rings, see add_rings(). Throws Error{OutOfMemory}, naming the limit that the points
/// of level 1 exceed, or one patch alone. `frames`: one a row where tangents can be asked for, else
/// none.
[[nodiscard]] PatchRecords patch_records(const PatchSurface& surface, const PatchLimits& limits,
                                         bool with_owners = false,
                                         std::span<const RowFrame> frames = {});

/// The mesh's large rings, for a device that makes their sums.
void add_rings(const PatchMesh& mesh, PatchRecords& records);

/// What patches must keep to on a device. `row_stride`: bytes from one row of the output to the
/// next, at most.
[[nodiscard]] PatchLimits patch_limits(const Context& context, std::uint32_t row_stride);

/// PatchRecords on a device. Read-only after its upload ran.
struct PatchTables {
  /// Throws Error{OutOfMemory} naming the limit that a table exceeds.
  PatchTables(const Maker& on, const PatchRecords& records, std::int64_t point_count);

  std::int64_t point_count;  ///< of the state of level 1 and its sums
  std::uint32_t ring_count;
  bool has_frames;  ///< rows can have tangents
  std::int64_t first_sum;
  std::vector<PatchSlice> slices;
  Buffer links, groups, words, weights, rings;

  /// Calls take(buffer, bytes) for all of them, in one order.
  template <class Take>
  void for_each(const PatchRecords& records, const Take& take) const {
    const auto bytes = [](const auto& items) { return std::as_bytes(std::span(items)); };
    take(links, bytes(records.links));
    take(groups, bytes(records.groups));
    take(words, bytes(records.words));
    take(weights, bytes(records.weights));
    take(rings, bytes(records.rings));
  }
};

/// StepRecords on a device, likewise.
struct StepTables {
  StepTables(const Maker& on, const StepRecords& records);

  std::vector<StepPart> parts;
  FaceSumRule rule;
  Buffer vertices, words;

  template <class Take>
  void for_each(const StepRecords& records, const Take& take) const {
    const auto bytes = [](const auto& items) { return std::as_bytes(std::span(items)); };
    take(vertices, bytes(records.vertices));
    take(words, bytes(records.words));
  }
};

/// The part of a buffer of items that a window spans, at least one item: a binding may not be
/// empty.
[[nodiscard]] BufferRange window_range(const Buffer& items, const IndexWindow& window,
                                       std::uint64_t item_bytes);

}  // namespace planish::vulkan
