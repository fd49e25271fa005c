#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "planish/doosabin/subdivision.h"
#include "planish/patches/patch_mesh.h"
#include "planish/vulkan/evaluate/patch_tables.h"
#include "planish/vulkan/host/solve_options.h"

namespace planish::vulkan {

/// What the kernel of places knows of a mesh beside PatchRecords::links; see shaders/shared.h.
struct PlaceRecords {
  std::vector<std::uint32_t> words;
  std::vector<std::array<float, 4>> weights;
  std::uint32_t face_count = 0;
  std::uint32_t corner_count = 0;
};

/// Throws Error{OutOfMemory}, naming the limit, before memory is taken for the weights.
[[nodiscard]] PlaceRecords place_records(const PatchMesh& mesh, Weights weights,
                                         const PatchLimits& limits);

/// PlaceRecords on a device. Read-only after its upload ran.
struct PlaceTables {
  /// Throws Error{OutOfMemory} naming the limit that a table exceeds.
  PlaceTables(const Maker& on, const PlaceRecords& records);

  std::uint32_t face_count, corner_count;
  Buffer words, weights;

  /// Calls take(buffer, bytes) for all of them, in one order.
  template <class Take>
  void for_each(const PlaceRecords& records, const Take& take) const {
    take(words, std::as_bytes(std::span(records.words)));
    take(weights, std::as_bytes(std::span(records.weights)));
  }
};

/// Bytes from the start of a place's results to the end of the last one that is written; 0: none
/// is.
[[nodiscard]] std::uint64_t result_bytes(const PlaceLayout& layout);

/// The surface at the places of a list, into a host's layout. Externally synchronised; tables and
/// points outlive it.
class GpuPlaces {
 public:
  /// `given`, `state` as GpuPatches takes them. List and layout have been checked. Throws
  /// Error{OutOfMemory} naming the limit that control points exceed.
  GpuPlaces(Context& context, const PatchTables& patches, const PlaceTables& tables,
            const BufferRange& given, const BufferRange& state, const PlaceList& list,
            const PlaceLayout& layout);

  /// The first `count` places. Only records, within kEntryScope and kExitScope.
  void record(VkCommandBuffer commands, std::uint32_t count) const noexcept;

 private:
  struct Dispatch {
    std::uint32_t first;  // place
    shared::PlaceParameters parameters;
  };

  Context& context_;
  Pipeline pipeline_;
  std::vector<Dispatch> dispatches_;
  DescriptorSets sets_;
};

}  // namespace planish::vulkan
