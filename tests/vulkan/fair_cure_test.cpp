// The cure's kernels together against their twin, fair/fold_cure.h, given what they were given;
// reading storage buffers and texel buffers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "fair/cure_meshes.h"
#include "planish/fair/fair_topology.h"
#include "planish/fair/fold_cure.h"
#include "planish/fair/perpendicular_polygon.h"
#include "vulkan/fair_machine.h"

namespace planish::testing {
namespace {

using glm::dvec3;

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

}  // namespace
}  // namespace planish::testing
