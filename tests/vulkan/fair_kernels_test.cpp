#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include "fair/cure_meshes.h"
#include "planish/fair/bending.h"
#include "planish/fair/fair_topology.h"
#include "planish/fair/fold_cure.h"
#include "planish/fair/perpendicular_polygon.h"
#include "planish/fair/vertex_polygon.h"
#include "planish/vulkan/device/bindings.h"
#include "planish/vulkan/device/commands.h"
#include "vulkan/fair_machine.h"

namespace planish::testing {
namespace {

// Every kernel of the fair construction against its twin, the function of fair/ that does the same
// in double, given what the kernel was given; reading storage buffers and texel buffers.

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

// The cure's kernels together against their twin, fair/fold_cure.h, given what they were given;
// reading storage buffers and texel buffers.

// A net before its cure, and what its twin is given.
struct Uncured {
  std::vector<dvec3> face_normals, normals, state;

  [[nodiscard]] CureInput input(const DeviceNet& net) {
    return {net.topology, net.given, face_normals, normals, state};
  }
};

// The curve points at darts, between the corners beside them.
void set_dart_points(const FairTopology& topology, std::span<dvec3> state) {
  for (std::size_t s = 0; s < topology.curve_points.size(); ++s) {
    const FairTopology::CurvePoint& place = topology.curve_points[s];
    if (topology.kind(place.vertex) != VertexKind::Dart) continue;
    state[static_cast<std::size_t>(topology.corner_count) + s] =
        (state[place.corner_after] + state[place.corner_before]) / 2.0;
  }
}

class FairCure : public FairReads {
 protected:
  // All before the cure.
  void make(const DeviceNet& net) {
    using enum vulkan::FairPart;
    record(net, {Clear, Prepare, Build, RepairBuilt, Polish, RepairPolished});
  }
  void cure(const DeviceNet& net) { record(net, {vulkan::FairPart::Cure}); }
  Uncured uncured(const DeviceNet& net) {
    Uncured before{face_normals(net), normals(net), result(net)};
    set_dart_points(net.topology, before.state);
    return before;
  }
  FairDecisions decisions(const DeviceNet& net) {
    return vulkan::unpack_decisions(
        download<std::uint32_t>(net.fair.buffers().decisions, net.given.size()),
        download<float>(net.fair.buffers().planes, 4 * net.given.size()));
  }
};

std::vector<test::NamedMesh> all_cure_meshes() {
  std::vector<test::NamedMesh> meshes = device_meshes();
  for (test::NamedMesh& mesh : test::cure_meshes()) meshes.push_back(std::move(mesh));
  PolygonMesh drum = test::prism(40);
  for (std::size_t v = 0; v < drum.positions.size(); v += 3) drum.positions[v].z *= 1.3;
  meshes.push_back({"large faces", drum});
  // Around which a work group walks.
  meshes.push_back({"creased rod of 70", test::creased_rod(70, 6)});
  meshes.push_back({"slit of 100", test::slit_fan(100, 0.999)});
  meshes.push_back({"wound fan of 100", test::slit_fan(100, 1.1)});
  PolygonMesh sharp_slit = test::slit_fan(100, 0.999);
  sharp_slit.creases.push_back({0, 40, kInfiniteSharpness});
  sharp_slit.creases.push_back({0, 60, kInfiniteSharpness});
  meshes.push_back({"slit of 100 in three sectors", sharp_slit});
  for (PolygonMesh corner : {test::slit_fan(100, 0.8), test::slit_fan(99, 1)}) {
    for (std::size_t v = 1; v < corner.positions.size(); v += 5) corner.positions[v] *= 0.1;
    corner.corners.push_back({0, kInfiniteSharpness});
    for (const std::int32_t spoke : {10, 30, 70})
      corner.creases.push_back({0, spoke, kInfiniteSharpness});
    meshes.push_back({"corner of 100", corner});
  }
  return meshes;
}

// By how much the control points around a vertex differ, as a part of the farthest one's distance.
double difference_at(const FairTopology& topology, std::int32_t vertex, std::span<const dvec3> a,
                     std::span<const dvec3> b) {
  double size = 0, off = 0;
  const auto compare = [&](std::int32_t point) {
    size = std::max(size, glm::length(b[point]));
    off = std::max(off, glm::distance(a[point], b[point]));
  };
  for (std::int32_t i = topology.ring_offsets[vertex]; i < topology.ring_offsets[vertex + 1]; ++i) {
    const std::int32_t corner = topology.ring_corners[i];
    compare(corner);
    for (const std::int32_t beside : {topology.corner_cw[corner], topology.corner_ccw[corner]}) {
      if (beside >= topology.corner_count) compare(beside);
    }
  }
  return off == 0 ? 0 : off / size;
}

// Several roundings of single precision, of directions that face normals leave nearly open too.
constexpr double kPart = 1e-4;

// And where a polygon's plane leans as far as it must: what single precision knows of a cosine,
// over that which is left to the face seen worst, once for how far it turns, once for the polygon.
double part_at(const DeviceNet& net, const Uncured& before, std::int32_t vertex, glm::vec2 lean) {
  if (!net.topology.has_polygon(vertex) || !is_chosen(lean) || lean == glm::vec2(0.0F))
    return kPart;
  const dvec3 plane = leaning_normal(net.topology, net.given, vertex, before.normals[vertex], lean);
  const double cosine = least_face_cosine(net.topology, before.face_normals, vertex, plane);
  return kPart + 0x1p-24 / (cosine * cosine);
}

TEST_P(FairCure, EqualsItsTwin) {
  std::int64_t cured[4] = {}, large[4] = {}, repeated = 0, leaning = 0, vertices = 0, different = 0;
  for (const test::NamedMesh& mesh : all_cure_meshes()) {
    SCOPED_TRACE(mesh.name);
    const test::FairCase c(mesh.mesh);
    DeviceNet net(*machine_, c, 8);
    make(net);
    Uncured before = uncured(net);
    cure(net);
    std::vector<std::uint8_t> cures(net.given.size(), 0);
    std::vector<glm::vec2> leans(net.given.size(), glm::vec2(kNoLean));
    const FoldCount left = cure_folds(before.input(net), cures, leans);
    const std::vector<dvec3> made = result(net);
    const FairDecisions decided = decisions(net);
    const std::vector<std::uint8_t>& made_cures = decided.cures;
    std::int64_t different_here = 0;
    for (std::size_t v = 0; v < cures.size(); ++v) {
      cured[net.topology.kinds[v]] += cures[v] > 0;
      large[net.topology.kinds[v]] +=
          cures[v] > 0 && net.records.vertices[v].count >= vulkan::shared::kLargeRing;
      repeated += cures[v] > 1;
      different_here += made_cures[v] != cures[v];
      if (made_cures[v] != cures[v]) continue;
      EXPECT_LT(difference_at(net.topology, std::int32_t(v), made, before.state),
                part_at(net, before, std::int32_t(v), leans[v]))
          << v;
      EXPECT_EQ(is_chosen(decided.leans[v]), is_chosen(leans[v])) << v;
      leaning += is_chosen(leans[v]) && leans[v] != glm::vec2(0.0F);
    }
    const auto counts =
        download<std::uint32_t>(net.fair.buffers().counts, vulkan::shared::kFairCounts);
    EXPECT_NEAR(counts[vulkan::shared::kEndCounts], left.edges, 3.0 * double(different_here));
    EXPECT_NEAR(counts[vulkan::shared::kEndCounts + 1], left.faces, 3.0 * double(different_here));
    vertices += net.topology.vertex_count;
    different += different_here;
  }
  for (const std::int64_t of_kind : cured) EXPECT_GT(of_kind, 20);
  for (const VertexKind kind : {VertexKind::Smooth, VertexKind::Crease, VertexKind::Corner})
    EXPECT_GT(large[static_cast<int>(kind)], 0) << static_cast<int>(kind);
  EXPECT_GT(repeated, 100);
  EXPECT_GT(leaning, 100);
  // Where a look decides by less than single precision knows, it may decide otherwise.
  EXPECT_LT(double(different), 1e-3 * double(vertices)) << different << " of " << vertices;
}

// Rounds at vertices of every kind that no look would ask for, as other poses have decided them;
// with leans that no choice would make, and at every fifth vertex a choice to make.
TEST_P(FairCure, RepeatsDecisionsAsItsTwin) {
  std::int64_t compared = 0, different = 0;
  for (const test::NamedMesh& mesh : all_cure_meshes()) {
    SCOPED_TRACE(mesh.name);
    const std::vector<std::uint8_t> none(mesh.mesh.positions.size(), 0);
    FairDecisions decided{none, none, none, none, {}, {}};
    for (std::size_t v = 0; v < none.size(); ++v) {
      decided.cures[v] = (7 * v + 3) % 4;
      decided.leans.emplace_back(v % 5 ? glm::vec2(float(v % 3), 0.1F * float(v % 7))
                                       : glm::vec2(kNoLean));
      decided.ellipses.push_back(v % 3 ? glm::vec4(0.0F)
                                       : glm::vec4(0.9F, 0.2F, -0.3F, 0.1F * float(v % 8 + 1)));
    }
    const test::FairCase c(mesh.mesh);
    DeviceNet net(*machine_, c, 8, &decided);
    make(net);
    Uncured before = uncured(net);
    cure(net);
    EXPECT_EQ(decisions(net).cures, decided.cures);
    CureInput input = before.input(net);
    input.ellipses = decided.ellipses;
    const FoldCount left = repeat_cure(input, decided.cures, decided.leans);
    const std::vector<dvec3> made = result(net);
    for (std::size_t v = 0; v < none.size(); ++v) {
      if (decided.cures[v] == 0) continue;
      ++compared;
      different += !(difference_at(net.topology, std::int32_t(v), made, before.state) <= kPart);
    }
    const auto counts =
        download<std::uint32_t>(net.fair.buffers().counts, vulkan::shared::kFairCounts);
    EXPECT_NEAR(counts[vulkan::shared::kEndCounts], left.edges, 2);
    EXPECT_NEAR(counts[vulkan::shared::kEndCounts + 1], left.faces, 2);
  }
  EXPECT_GT(compared, 4000);
  EXPECT_EQ(different, 0);
}

TEST_P(FairCure, LooksOnlyAsLongAsSomethingIsFound) {
  const auto counts = [&](const PolygonMesh& mesh) {
    const test::FairCase c(mesh);
    DeviceNet net(*machine_, c, 8);
    make(net);
    cure(net);
    std::vector<std::uint32_t> rounds;
    const auto words =
        download<std::uint32_t>(net.fair.buffers().counts, vulkan::shared::kFairCounts);
    for (std::uint32_t round = 0; round < vulkan::shared::kCureRounds; ++round)
      rounds.push_back(words[vulkan::shared::kCureCounts + 2 * round]);
    const auto groups = download<std::uint32_t>(net.fair.buffers().arguments, 9);
    EXPECT_EQ(groups[6] > 0, rounds.back() > 0);
    return rounds;
  };
  EXPECT_EQ(counts(test::icosphere(2)),
            (std::vector<std::uint32_t>(vulkan::shared::kCureRounds, 0)));
  const std::vector<std::uint32_t> of_rod = counts(test::needle_rod(48, 10));
  EXPECT_GT(of_rod[0], 0u);
  EXPECT_EQ(of_rod.back(), 0u);
}

INSTANTIATE_TEST_SUITE_P(Reads, FairCure, both_reads(), name_of_reads);

// The small kernels of the polish by themselves, with numbers that no net drives them to: sums that
// are infinite or none, diagonals of nothing.

using vulkan::shared::FairParameters;
using vulkan::shared::FairScalars;

constexpr float kInfinite = std::numeric_limits<float>::infinity();
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

class FairScalarKernels : public FairReads {
 protected:
  // Runs one work group of `kernel` on both arrays, whose new contents they get; the other arrays
  // that it binds are not read.
  void run(vulkan::Kernel kernel, const FairParameters& parameters, std::vector<float>& floats,
           FairScalars& scalars) {
    vulkan::Context& context = machine_->context;
    const auto bytes_of = [](auto& items) { return std::as_bytes(std::span(items)); };
    vulkan::Buffer first = vulkan::make_bindable(context, 4 * floats.size(), "floats"),
                   second = vulkan::make_bindable(context, sizeof scalars, "scalars");
    std::vector<FairScalars> one{scalars};
    machine_->submitter.upload({first.handle(), 0, 4 * floats.size()}, bytes_of(floats));
    machine_->submitter.upload({second.handle(), 0, sizeof scalars}, bytes_of(one));
    const vulkan::Buffer other = vulkan::make_bindable(context, 64, "not read");
    const auto a = vulkan::whole(first), b = vulkan::whole(second), none = vulkan::whole(other);
    std::vector<vulkan::BoundKernel> bound{{kernel, {a, b}}};
    if (kernel == vulkan::Kernel::FairLines)
      bound[0].buffers = {none, none, none, none, b, none, a};
    if (kernel == vulkan::Kernel::FairDescend)
      bound[0].buffers = {none, none, none, none, none, b, none, a};
    const vulkan::DescriptorSets sets(context, bound);
    const vulkan::Pipeline pipeline = context.pipelines().specialised(kernel, {});
    machine_->submitter.run([&](VkCommandBuffer commands) {
      vulkan::record_dispatch(context, commands, pipeline, sets[0], &parameters, 1);
    });
    floats = download<float>(first, floats.size());
    scalars = download<FairScalars>(second, 1).front();
  }

  FairScalars total(vulkan::Kernel kernel, std::vector<float> partials, FairScalars scalars,
                    bool start = false) {
    // The last work group, which has no elements itself.
    scalars.parts = static_cast<std::uint32_t>(partials.size());
    partials.push_back(kNone);
    FairParameters parameters{};
    parameters.start = start ? 1 : 0;
    parameters.first_partial = scalars.parts;
    parameters.partial_count = scalars.parts + 1;
    run(kernel, parameters, partials, scalars);
    EXPECT_EQ(scalars.parts, 0u);
    return scalars;
  }
};

// Fewer than a work group has lanes, as many, and more.
std::vector<std::vector<float>> some_partials() {
  std::vector<std::vector<float>> all;
  std::mt19937 random(7);
  std::uniform_real_distribution<float> any(0.5f, 2.0f);
  for (const std::size_t count : {1u, 63u, 64u, 65u, 1024u}) {
    std::vector<float>& partials = all.emplace_back(count);
    for (float& partial : partials) partial = any(random);
  }
  return all;
}

double sum_of(std::span<const float> partials) {
  double sum = 0;
  for (const float partial : partials) sum += double{partial};
  return sum;
}

// Others write no scalars, and leave the sum to the last one.
TEST_P(FairScalarKernels, WorkGroupsBeforeTheLastOneWaitForNothing) {
  for (const vulkan::Kernel kernel : {vulkan::Kernel::FairLines, vulkan::Kernel::FairDescend}) {
    std::vector<float> partials = {3, kNone, 5};
    FairScalars scalars{9, 8, 7, 6, 5, 1};
    FairParameters parameters{};
    parameters.first_partial = 1;
    parameters.partial_count = 3;
    run(kernel, parameters, partials, scalars);
    EXPECT_EQ(partials[1], 0.0f);
    EXPECT_EQ(scalars.parts, 2u);
    EXPECT_EQ(scalars.square, 9.0f);
    EXPECT_EQ(scalars.step, 7.0f);
    EXPECT_EQ(scalars.momentum, 6.0f);
  }
}

TEST_P(FairScalarKernels, MomentumIsTheChangeOfTheSquare) {
  for (const std::vector<float>& partials : some_partials()) {
    const double sum = sum_of(partials);
    const FairScalars begun =
        total(vulkan::Kernel::FairDescend, partials, {9, 9, 9, 9, 9, 0}, /*start=*/true);
    EXPECT_NEAR(begun.square, sum, 1e-6 * sum);
    EXPECT_NEAR(begun.enough, 1e-12 * sum, 1e-18 * sum);
    EXPECT_EQ(begun.step, 0.0f);
    EXPECT_EQ(begun.momentum, 0.0f);
    EXPECT_EQ(begun.largest_bits, 9u);
    const FairScalars next = total(vulkan::Kernel::FairDescend, partials, {3, 4, 5, 6, 7, 0});
    EXPECT_NEAR(next.square, sum, 1e-6 * sum);
    EXPECT_NEAR(next.momentum, sum / 3, 1e-6 * sum);
    EXPECT_EQ(next.enough, 4.0f);
    EXPECT_EQ(next.step, 5.0f);
    EXPECT_EQ(next.largest_bits, 7u);
  }
}

TEST_P(FairScalarKernels, MomentumOfWhatIsNoNumberIsNone) {
  const auto momentum = [&](float square, float before) {
    return total(vulkan::Kernel::FairDescend, {1, square, 1}, {before, 0, 0, 9, 0, 0}).momentum;
  };
  EXPECT_EQ(momentum(kInfinite, 1), 0.0f);
  EXPECT_EQ(momentum(kInfinite, kInfinite), 0.0f);
  EXPECT_EQ(momentum(kNone, 1), 0.0f);
  EXPECT_EQ(momentum(1, kNone), 0.0f);
  EXPECT_EQ(momentum(1, kInfinite), 0.0f);
  EXPECT_EQ(momentum(1, 0), 0.0f);
  EXPECT_EQ(momentum(3e38f, 1e-10f), 0.0f);  // the quotient alone is too large
  EXPECT_EQ(momentum(1, 6), 0.5f);
}

TEST_P(FairScalarKernels, StepIsTheSquareByTheCurvature) {
  for (const std::vector<float>& partials : some_partials()) {
    const FairScalars made = total(vulkan::Kernel::FairLines, partials, {3, 1, 9, 6, 7, 0});
    const double step = 3 / sum_of(partials);
    EXPECT_NEAR(made.step, step, 1e-6 * step);
    EXPECT_EQ(made.square, 3.0f);
    EXPECT_EQ(made.momentum, 6.0f);
    const FairScalars begun =
        total(vulkan::Kernel::FairLines, partials, {3, 1, 9, 6, 7, 0}, /*start=*/true);
    EXPECT_EQ(begun.step, 1.0f);
  }
}

TEST_P(FairScalarKernels, NoStepWhereConvergedOrNoNumber) {
  const auto step = [&](float curvature, float square, float enough) {
    return total(vulkan::Kernel::FairLines, {curvature}, {square, enough, 9, 0, 0, 0}).step;
  };
  EXPECT_EQ(step(2, 1, 0), 0.5f);
  EXPECT_EQ(step(2, 1, 1), 0.0f);
  EXPECT_EQ(step(0, 1, 0), 0.0f);
  EXPECT_EQ(step(-2, 1, 0), 0.0f);
  EXPECT_EQ(step(kNone, 1, 0), 0.0f);
  EXPECT_EQ(step(kInfinite, 1, 0), 0.0f);
  EXPECT_EQ(step(kInfinite, kInfinite, 0), 0.0f);
  EXPECT_EQ(step(2, kNone, 0), 0.0f);
  EXPECT_EQ(step(2, kInfinite, 0), 0.0f);
  EXPECT_EQ(step(1e-10f, 3e38f, 0), 0.0f);
}

// Floored at 1e-14 of the largest, on more elements than lanes.
TEST_P(FairScalarKernels, PreconditionIsOneOverTheDiagonal) {
  constexpr float kLargest = 4e6f;
  std::vector<float> diagonals{0, -1, kLargest, 1, 4e-8f, 3e-8f, 1e-20f, kNone, kInfinite};
  while (diagonals.size() < 200) diagonals.push_back(0.37f * float(diagonals.size()));
  const std::vector<float> given = diagonals;
  FairParameters parameters{};
  parameters.count = 199;
  FairScalars scalars{1, 2, 3, 4, std::bit_cast<std::uint32_t>(kLargest), 0};
  run(vulkan::Kernel::FairPrecondition, parameters, diagonals, scalars);
  for (std::size_t i = 0; i < 199; ++i) {
    const double floored = std::max(double{given[i]}, 1e-14 * double{kLargest});
    const double expected = given[i] > 0 ? 1 / floored : 0;  // of NaN, too
    EXPECT_NEAR(diagonals[i], expected, 1e-6 * expected) << i << ": " << given[i];
  }
  EXPECT_EQ(diagonals[199], given[199]);  // beyond the count
  EXPECT_EQ(scalars.square, 1.0f);
}

INSTANTIATE_TEST_SUITE_P(Reads, FairScalarKernels, both_reads(), name_of_reads);

}  // namespace
}  // namespace planish::testing
