#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/fair/fair_net.h"
#include "planish/fair/fair_topology.h"
#include "planish/mesh/placement.h"
#include "planish/vulkan/device/buffer.h"
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

}  // namespace planish::vulkan
