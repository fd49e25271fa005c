// Every kernel of the fair construction against its twin, the function of fair/ that does the same
// in double, given what the kernel was given; reading storage buffers and texel buffers.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/fair/bending.h"
#include "planish/fair/fair_topology.h"
#include "planish/fair/fold_cure.h"
#include "planish/fair/vertex_polygon.h"
#include "vulkan/fair_machine.h"

namespace planish::testing {
namespace {

using glm::dvec3;

// Coordinates are of unit diagonal: some roundings of single precision.
constexpr double kRounding = 2e-6;
// Of unit vectors: differences of coordinates lose more, the nearer vertices are to each other.
constexpr double kDirection = 1e-4;

class FairKernels : public FairReads {
 protected:
  // Runs all before the polygons are built.
  void prepare(const DeviceNet& net) {
    record(net, {vulkan::FairPart::Clear, vulkan::FairPart::Prepare});
  }
  void build(const DeviceNet& net) {
    prepare(net);
    record(net, {vulkan::FairPart::Build});
  }
  // Every mesh's net in the making, with the steps that it will be polished with.
  void for_each_net(std::uint32_t polish_steps, const std::function<void(DeviceNet&)>& body) {
    for (const test::NamedMesh& mesh : device_meshes()) {
      SCOPED_TRACE(mesh.name);
      const test::FairCase c(mesh.mesh);
      DeviceNet net(*machine_, c, polish_steps);
      body(net);
    }
  }
  std::vector<double> shares(const DeviceNet& net) {
    const auto floats = download<float>(net.fair.buffers().shares, net.given.size());
    return {floats.begin(), floats.end()};
  }
};

double worst(std::span<const dvec3> a, std::span<const dvec3> b) {
  double largest = a.size() == b.size() ? 0 : HUGE_VAL;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double distance = glm::distance(a[i], b[i]);
    if (!(distance <= largest)) largest = distance;
  }
  return largest;
}

// Length of the sum of a vertex's corner normals, weighted by angles, by the sum of the angles:
// what cancels makes roundings larger.
double agreement(const DeviceNet& net, std::int32_t v) {
  dvec3 sum(0.0);
  double angles = 0;
  for (std::int32_t i = net.topology.ring_offsets[v]; i < net.topology.ring_offsets[v + 1]; ++i) {
    const dvec3 a = net.given[net.topology.ring_next[i]] - net.given[v];
    const dvec3 b = net.given[net.topology.ring_previous[i]] - net.given[v];
    const dvec3 turn = glm::cross(a, b);
    const double length = glm::length(turn), angle = std::atan2(length, glm::dot(a, b));
    angles += angle;
    if (length > 0) sum += angle / length * turn;
  }
  const double part = glm::length(sum) / angles;
  return part > 1e-4 ? part : 1.0;  // below, face normals stand in
}

TEST_P(FairKernels, NormalsAndOffsetsEqualTheirTwins) {
  for_each_net(0, [&](DeviceNet& net) {
    prepare(net);
    const FairTopology& topology = net.topology;
    const auto& buffers = net.fair.buffers();
    const std::vector<dvec3> face_normals = this->face_normals(net);
    EXPECT_LT(worst(face_normals, unit_face_normals(topology, net.given)), kDirection);
    const std::vector<dvec3> normals = this->normals(net);
    for (std::int32_t v = 0; v < topology.vertex_count; ++v) {
      const dvec3 normal =
          angle_weighted_normal(topology, net.given, face_normals, v, topology.ring(v));
      EXPECT_LT(glm::distance(normals[v], normal), kDirection / agreement(net, v)) << v;
    }
    std::vector<dvec3> offsets(static_cast<std::size_t>(topology.corner_count));
    corner_offsets(topology, net.given, net.given, offsets);
    EXPECT_LT(worst(download_points(buffers.given_offsets, offsets.size()), offsets), kRounding);
  });
}

TEST_P(FairKernels, SharesAndMaskedIterationEqualTheirTwins) {
  for_each_net(0, [&](DeviceNet& net) {
    prepare(net);
    const FairTopology& topology = net.topology;
    const auto& buffers = net.fair.buffers();
    const auto corners = static_cast<std::size_t>(topology.corner_count);
    const std::vector<double> shares = this->shares(net);
    const std::vector<dvec3> normals = this->normals(net);
    auto offsets = download_points(buffers.given_offsets, corners);
    PlanarRing ring;
    const GivenErrors errors(topology, net.given, offsets);
    for (std::int32_t v = 0; v < topology.vertex_count; ++v) {
      const double share = tensor_share(errors, normals[v], v, ring);
      EXPECT_NEAR(shares[v], share, 1e-3) << v;
    }
    if (!net.tables.has_regular_vertices) return;
    const auto points = masked_iteration(topology, net.given, shares, offsets);
    EXPECT_LT(worst(download_points(buffers.points, points.size()), points), kRounding);
    EXPECT_LT(worst(download_points(buffers.offsets, corners), offsets), kRounding);
  });
}

// What the kernels that build polygons were given.
struct Prepared {
  std::vector<dvec3> normals, face_normals, points, offsets;
  std::vector<double> shares;
};

// The twin of fair_handles and fair_corridor.
SectorShape crease_shape(const DeviceNet& net, const GivenStep& step, const Prepared& from,
                         std::int32_t v) {
  const CreaseArms arms = crease_arms(net.topology, net.given, v);
  SectorShape shape{crease_handle(arms), from.shares[v], dvec3(0.0)};
  if (shape.share > 0) {
    const auto [before, after] = net.topology.crease_neighbours(v);
    const std::vector<dvec3>& points = from.points;
    shape.handle =
        shape.share * (points[before] - points[after]) / 8.0 + (1 - shape.share) * shape.handle;
    shape.tensor_shift =
        net.given[v] - points[v] - (points[before] + points[after] - 2.0 * points[v]) / 8.0;
  }
  shape.handle *=
      corridor_factor(net.topology, net.given, step, from.face_normals, v, shape.handle);
  return shape;
}

// The twins of fair_polygons, fair_reversed, fair_handles, fair_corridor and fair_sectors.
std::vector<dvec3> built(const DeviceNet& net, const Prepared& from) {
  const FairTopology& topology = net.topology;
  std::vector<dvec3> result = from.offsets;
  result.resize(static_cast<std::size_t>(topology.state_size));
  PolygonScratch scratch;
  const GivenStep step(topology, net.given);
  for (std::int32_t v = 0; v < topology.vertex_count; ++v) {
    if (topology.has_polygon(v))
      build_vertex_polygon(topology, net.given, step, v, {from.normals[v], from.shares[v]}, scratch,
                           result);
    if (topology.kind(v) != VertexKind::Crease) continue;
    const SectorShape shape = crease_shape(net, step, from, v);
    const std::int32_t crease = topology.crease_of_vertex[v];
    const std::int32_t first = topology.sector_offsets[crease];
    for (std::int32_t s = first; s < topology.sector_offsets[crease + 1]; ++s)
      build_sector(topology, net.given, step, from.face_normals, topology.sectors[s], shape,
                   result);
    result[topology.sectors[first].curve0] = shape.handle;
    result[topology.sectors[first].curve1] = -shape.handle;
  }
  return result;
}

// What is left of the curve points: those of darts and corners.
void expect_curve_points(const DeviceNet& net, const Prepared& from, std::span<const dvec3> made,
                         std::span<const dvec3> expected) {
  const auto corners = static_cast<std::size_t>(net.topology.corner_count);
  for (std::size_t s = 0; s < net.topology.curve_points.size(); ++s) {
    const FairTopology::CurvePoint& place = net.topology.curve_points[s];
    dvec3 own = expected[corners + s];
    if (net.topology.kind(place.vertex) == VertexKind::Corner)
      own = (from.points[place.other] - net.given[place.vertex]) / 4.0;
    if (net.topology.kind(place.vertex) == VertexKind::Dart)
      own = (made[place.corner_after] + made[place.corner_before]) / 2.0;
    EXPECT_LT(glm::distance(made[corners + s], own), kRounding) << s;
  }
}

TEST_P(FairKernels, PolygonsAndCreasesEqualTheirTwins) {
  std::size_t compared = 0, different = 0;
  for_each_net(0, [&](DeviceNet& net) {
    build(net);
    const FairTopology& topology = net.topology;
    const auto& buffers = net.fair.buffers();
    const auto corners = static_cast<std::size_t>(topology.corner_count);
    const Prepared from{normals(net), face_normals(net),
                        net.tables.has_regular_vertices
                            ? download_points(buffers.points, net.given.size())
                            : net.given,
                        download_points(net.fair.offsets(), corners), shares(net)};
    const std::vector<dvec3> made = result(net), expected = built(net, from);
    for (std::size_t i = 0; i < corners; ++i) {
      ++compared;
      if (!(glm::distance(made[i], expected[i]) <= 1e-5)) ++different;
    }
    expect_curve_points(net, from, made, expected);
  });
  // Where a test decides by less than single precision knows, it may decide otherwise.
  EXPECT_GT(compared, 10000u);
  EXPECT_LT(double(different), 1e-3 * double(compared)) << different << " of " << compared;
}

TEST_P(FairKernels, RepairEqualsItsTwin) {
  std::int64_t halved = 0;
  const auto halvings_of = [&](DeviceNet& net) {
    build(net);
    std::vector<dvec3> expected = result(net);
    const std::vector<dvec3> face_normals = this->face_normals(net);
    record(net, {vulkan::FairPart::RepairBuilt});
    std::vector<std::uint8_t> halvings(net.given.size(), 0);
    const FoldCount left = repair_folds(net.topology, net.given, face_normals, expected, halvings);
    EXPECT_LT(worst(result(net), expected), kRounding);
    const auto counts =
        download<std::uint32_t>(net.fair.buffers().counts, vulkan::shared::kFairCounts);
    EXPECT_EQ(counts[6], left.edges);
    EXPECT_EQ(counts[7], left.faces);
    const auto words = download<std::uint32_t>(net.fair.buffers().decisions, halvings.size());
    EXPECT_EQ(vulkan::unpack_decisions(words).halvings, halvings);
    for (const std::uint8_t count : halvings) halved += count;
    return halvings;
  };
  for_each_net(0, halvings_of);
  EXPECT_GT(halved, 10);
  // All lanes that share a hub's ring must see that it is turned over.
  PolygonMesh hub = hub_of(40, 3, 2 * std::numbers::pi);
  for (std::size_t i = 8; i < hub.positions.size(); i += 8) hub.positions[i].z += 2.4;
  const test::FairCase c(hub);
  DeviceNet net(*machine_, c, 0);
  EXPECT_GT(halvings_of(net).front(), 0);
}

TEST_P(FairKernels, RepairRunsOnlyWhereSomethingIsTurnedOver) {
  const auto groups = [&](const PolygonMesh& mesh) {
    const test::FairCase c(mesh);
    DeviceNet net(*machine_, c, 0);
    build(net);
    record(net, {vulkan::FairPart::RepairBuilt});
    return download<std::uint32_t>(net.fair.buffers().arguments, 9);
  };
  EXPECT_EQ(groups(test::icosphere(2)), (std::vector<std::uint32_t>{0, 1, 1, 0, 1, 1, 0, 1, 1}));
  // 642 vertices, 1920 edges, 1280 faces by 64; some are beyond repair.
  EXPECT_EQ(groups(test::jittered(test::icosphere(3), 0.5, 1)),
            (std::vector<std::uint32_t>{30, 1, 1, 20, 1, 1, 11, 1, 1}));
}

// By `part` of the largest magnitude of `expected`, and `rounding`.
void expect_near(std::span<const float> a, std::span<const float> expected, double part,
                 double rounding) {
  ASSERT_EQ(a.size(), expected.size());
  double largest = 0, off = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    largest = std::max(largest, std::abs(double(expected[i])));
    const double difference = std::abs(double(a[i]) - expected[i]);
    if (!(difference <= off)) off = difference;
  }
  EXPECT_LE(off, part * largest + rounding);
}

TEST_P(FairKernels, RowsAndHeightsEqualTheirTwins) {
  // Few steps: conjugate gradients double what rounding does with every one.
  for_each_net(2, [&](DeviceNet& net) {
    build(net);
    std::vector<dvec3> moved = result(net);
    const std::vector<dvec3> normals = this->normals(net);
    record(net, {vulkan::FairPart::Polish});
    const auto directions = polish_directions(net.topology, normals, shares(net));
    EXPECT_LT(worst(download_points(net.fair.buffers().directions, directions.size()), directions),
              kRounding);
    BendingRows bending = make_bending_rows(net.topology, net.given, directions, moved);
    const auto corners = static_cast<std::size_t>(net.topology.corner_count);
    const auto rows1 = download<glm::vec4>(net.fair.buffers().rows1, corners);
    const auto rows2 = download<glm::vec4>(net.fair.buffers().rows2, corners);
    std::vector<float> made, expected;
    for (std::size_t i = 0; i < corners; ++i) {
      const BendingRows::Row& row = bending.rows[i];
      made.insert(made.end(), {rows1[i].x, rows1[i].y, rows1[i].z});
      made.insert(made.end(), {rows2[i].x, rows2[i].y, rows2[i].z});
      expected.insert(expected.end(), {row.next, row.own1, row.after});
      expected.insert(expected.end(), {row.previous, row.own2, row.before});
    }
    expect_near(made, expected, 1e-4, 0);
    const auto motions = download<glm::vec4>(net.fair.motions(), corners);
    std::vector<float> heights(corners);
    for (std::size_t i = 0; i < corners; ++i) heights[i] = motions[net.topology.ring_corners[i]].z;
    const auto twin = polish_heights(net.topology, std::move(bending), 2);
    // Symmetric nets have nothing to polish but rounding.
    expect_near(heights, twin, 1e-3, kRounding);
    apply_heights(net.topology, directions, heights, moved);
    EXPECT_LT(worst(result(net), moved), kRounding);
  });
}

INSTANTIATE_TEST_SUITE_P(Reads, FairKernels, both_reads(), name_of_reads);

}  // namespace
}  // namespace planish::testing
