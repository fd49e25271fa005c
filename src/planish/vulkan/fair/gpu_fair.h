#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/fair/fair_net.h"
#include "planish/fair/fair_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/vulkan/device/bindings.h"
#include "planish/vulkan/device/commands.h"
#include "shaders/fair/shared_fair.h"

namespace planish::vulkan {

/// A FairTopology in the records that the kernels read.
struct FairRecords {
  RawVector<shared::FairVertex> vertices;
  RawVector<shared::FairPlace> places;
  RawVector<shared::FairLinks> links;
  RawVector<shared::FairFace> faces;
  RawVector<shared::FairEdge> edges;
  std::vector<shared::FairCrease> creases;
  std::vector<shared::FairSector> sectors;
  std::vector<shared::FairCurvePoint> curve_points;
  std::vector<float> circle;             ///< x and y of the points of regular polygons
  std::vector<std::uint32_t> owners;     ///< the vertex of each point of the state
  Placement placement;                   ///< of the unit coordinates
  std::vector<std::uint32_t> decisions;  ///< packed, per vertex; empty: every frame makes its own
  /// Of them: four floats per vertex, two of them its lean; then four per vertex, its ellipse.
  std::vector<float> leans;
  /// How many records are of kLargeRing corners and more, which the first records' words list.
  std::uint32_t large_vertices = 0, large_faces = 0, large_creases = 0, large_sectors = 0;
  bool has_regular_vertices = false;  ///< some vertex may have a share of the tensor product
};
/// `planes`: those of the decisions, or without any those that are kept.
[[nodiscard]] FairRecords fair_records(const FairTopology& topology,
                                       const FairDecisions* decisions = nullptr,
                                       std::span<const KeptPlane> planes = {});

/// FairDecisions as kernels keep them, a word per vertex, and leans with ellipses apart.
[[nodiscard]] std::vector<std::uint32_t> pack_decisions(const FairDecisions& decisions);
[[nodiscard]] std::vector<float> pack_leans(const FairDecisions& decisions);
/// `planes`: four floats per vertex, the first two its lean; or none. Ellipses stay none.
[[nodiscard]] FairDecisions unpack_decisions(std::span<const std::uint32_t> words,
                                             std::span<const float> planes = {});

/// FairRecords on a device. Read-only after its upload ran.
struct FairTables {
  /// Throws Error{OutOfMemory} naming the limit that a table exceeds.
  FairTables(const Maker& on, const FairRecords& records);

  std::uint32_t vertex_count, corner_count, face_count, edge_count, crease_count, sector_count,
      curve_point_count, state_size;
  /// Of kLargeRing corners and more, each of which a work group walks around.
  std::uint32_t large_vertex_count, large_face_count, large_crease_count, large_sector_count;
  bool has_regular_vertices, is_decided;
  Placement placement;
  Buffer vertices, places, links, faces, edges, creases, sectors, curve_points, circle, owners,
      decisions, leans;

  /// Calls take(buffer, bytes) for all of them, in one order.
  template <class Take>
  void for_each(const FairRecords& records, const Take& take) const {
    const auto bytes = [](const auto& items) { return std::as_bytes(std::span(items)); };
    take(vertices, bytes(records.vertices));
    take(places, bytes(records.places));
    take(links, bytes(records.links));
    take(faces, bytes(records.faces));
    take(edges, bytes(records.edges));
    take(creases, bytes(records.creases));
    take(sectors, bytes(records.sectors));
    take(curve_points, bytes(records.curve_points));
    take(circle, bytes(records.circle));
    take(owners, bytes(records.owners));
    take(decisions, bytes(records.decisions));
    take(leans, bytes(records.leans));
  }
};

struct GpuFairOptions {
  std::uint32_t polish_steps = 8;
  bool cures_folds = true;      ///< as FairOptions has it
  bool counts_folds = false;    ///< edges and faces turned over in the end, in Buffers::counts
  std::uint64_t sum_count = 0;  ///< room for large rings' sums behind Buffers::state_offsets
};

/// What a construction consists of, in this order.
enum class FairPart { Clear, Prepare, Build, RepairBuilt, Polish, RepairPolished, Cure, Finish };
inline constexpr std::size_t kFairParts = 8;

/// Work buffers, pipelines and written descriptor sets of one fair construction on the device: all
/// of it in one command buffer, each step a sequence of kernels; the scalars of the polish stay in
/// a buffer, and rounds of repair with nothing to do are empty. Where the tables hold decisions
/// these are taken instead of made. Externally synchronised; tables and points outlive it.
/// Recording only records.
class GpuFair {
 public:
  /// `model_points`: the points to pass through, shared::kPointFloats floats per vertex.
  /// Throws Error{OutOfMemory} naming the limit.
  GpuFair(const Maker& on, const FairTables& tables, const Buffer& model_points,
          const GpuFairOptions& options);

  /// All of it; begins and ends within kEntryScope and kExitScope.
  void record(VkCommandBuffer commands) const noexcept;
  /// One part; the same scopes. Without polish steps the two parts that follow from them are empty.
  void record(VkCommandBuffer commands, FairPart part) const noexcept;
  /// All of it round by round. The first one only clears buffers of this construction's own.
  Wait record_round(VkCommandBuffer commands, std::size_t round) const noexcept;

  // What they leave; points are of shared::kPointFloats floats, all but state() in unit
  // coordinates.
  struct Buffers {
    Buffer given;                  // per vertex
    Buffer face_normals, normals;  // per face, vertex
    Buffer shares;                 // float per vertex
    // Per corner: of one step of given points, in the cure of the net, and of P.
    Buffer given_offsets, offsets;
    Buffer points, next_points;       // P per vertex
    Buffer sector_normals, shifts;    // per sector, crease
    Buffer result;                    // per point of the state: relative to its given point
    Buffer flags, decisions, counts;  // words: per vertex, per vertex, shared::kFairCounts
    Buffer arguments;                 // of the dispatches of a round of repair
    Buffer directions;                // per vertex, of the polish
    Buffer rows1, rows2;              // per corner: four floats
    Buffer lines;                     // per corner: two floats
    Buffer motions[2];                // of the polish, per point of the state; in turn
    Buffer gradient;                  // float per corner
    Buffer precondition;              // float per vertex
    Buffer partials, scalars;         // floats; shared::FairScalars
    Buffer heights, planes;           // of the cure: float per face; per vertex, lean and size
    Buffer state;                     // per point of the state, model coordinates
    Buffer state_offsets;             // the same as corner patches take it
    Buffer status;                    // shared::SolveStatus
  };
  [[nodiscard]] const Buffers& buffers() const { return buffers_; }
  /// Those that the polish ends with.
  [[nodiscard]] const Buffer& motions() const {
    return buffers_.motions[options_.polish_steps % 2];
  }
  /// Where the masked iteration is left out, the given points' stand for P's.
  [[nodiscard]] const Buffer& offsets() const {
    return tables_.has_regular_vertices ? buffers_.offsets : buffers_.given_offsets;
  }

 private:
  /// One kernel over all its elements.
  struct Pass {
    Pipeline pipeline;
    std::size_t set;
    shared::FairParameters parameters;
    std::uint32_t groups;
    std::uint32_t arguments = 0;  // of repair and cure: which of the device's own
    Pipeline large{};             // the same kernel, a work group an element
    std::uint32_t large_count = 0, large_groups = 0;
  };
  using Passes = std::vector<Pass>;
  enum class Action { Clear, ClearFlags, Dispatch, DispatchIndirect };
  struct Round {
    Action action;
    const Pass* pass;     // of dispatches; in a vector that does not change any more
    std::uint32_t place;  // added to the pass's own
    Wait wait;
  };
  struct Binder;

  void make_buffers(const Maker& on);
  void plan_prepare(Binder& binder, const Buffer& model_points);
  void plan_build(Binder& binder);
  void plan_repair(Binder& binder);
  void plan_polish(Binder& binder);
  void plan_polish_step(Binder& binder, Passes& passes, const Buffer& from, const Buffer& to);
  void plan_cure(Binder& binder);
  void plan_fold_looks(Binder& binder, Passes& passes, Kernel edges, Kernel faces);
  void plan_looks(Binder& binder, Passes& passes);
  void plan_finish(Binder& binder, const Buffer& model_points);
  void plan_rounds();
  void add_rounds(const Passes& passes, std::uint32_t place = 0, Action action = Action::Dispatch);
  void add_repair(std::uint32_t which);
  void add_cure();
  void record_clear(VkCommandBuffer commands) const noexcept;

  Context& context_;
  const FairTables& tables_;
  GpuFairOptions options_;
  Buffers buffers_;
  Passes prepare_, build_, curve_points_, find_folds_, next_round_, shrink_[2], start_polish_,
      step_polish_[2], end_polish_, look_[2], decide_, cure_, darts_, count_, finish_;
  std::vector<Round> rounds_;
  std::array<std::size_t, kFairParts + 1> part_starts_{};
  DescriptorSets sets_;
};

}  // namespace planish::vulkan
