// An own method: progressive interpolation solves for base control points, whose limit points are
// those of uniform knots; on uneven rings that folds. Here the control points of level 1 are the
// unknowns. They split into one polygon per vertex, and the surface interpolates exactly when each
// polygon's centroid is its vertex, so that every polygon can be built by itself.
#include "planish/fair/fair_net.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/fair/bending.h"
#include "planish/fair/fair_topology.h"
#include "planish/fair/fold_cure.h"
#include "planish/fair/vertex_polygon.h"

namespace planish {

namespace {

using glm::dvec3;

constexpr std::size_t kNetGrain = 1024;
// Square of the sine between planes: below it they have no line in common.
constexpr double kParallelPlanes = 1e-4;

// Calls body(vertex) for every vertex on all threads.
template <class MakeBody>
void for_vertices(const FairTopology& topology, const MakeBody& make_body,
                  LoopProgress* progress = nullptr) {
  parallel_for(static_cast<std::size_t>(topology.vertex_count), kNetGrain,
               [&](std::size_t begin, std::size_t end) {
                 auto body = make_body();
                 for (std::size_t v = begin; v < end; ++v) body(static_cast<std::int32_t>(v));
                 if (progress) progress->add(static_cast<std::int64_t>(end - begin));
               });
}

std::vector<double> tensor_shares(const FairTopology& topology, std::span<const dvec3> given,
                                  std::span<const dvec3> normals, std::span<const dvec3> offsets,
                                  const PlanePlaces& planes) {
  std::vector<double> shares(given.size());
  const GivenErrors errors(topology, given, offsets);
  for_vertices(topology, [&] {
    return [&, ring = PlanarRing{}](std::int32_t v) mutable {
      shares[v] = planes.of(v) >= 0 ? 0 : tensor_share(errors, normals[v], v, ring);
    };
  });
  return shares;
}

}  // namespace

// The net in the making.
struct NetBuilder {
  const FairTopology& topology;
  std::span<const dvec3> given;
  FairHalo* halo = nullptr;
  PlanePlaces planes{};
  GivenStep step{topology, given};
  std::vector<dvec3> face_normals{}, normals{};
  std::vector<double> shares{};
  std::vector<dvec3> points{};  // of the masked iteration; empty where no vertex has a share
  /// The state relative to the given points.
  std::vector<dvec3> offsets{};

  void prepare();
  /// Takes the decisions that are there, makes them where there are none.
  void build_polygons(std::vector<std::uint8_t>& reversed, const Callbacks& callbacks);
  void build_crease(std::int32_t vertex);
  [[nodiscard]] dvec3 in_planes(std::int32_t begin, std::int32_t end, const dvec3& handle) const;
  void build_curve_points();
  void build_dart_points();
  void exchange_state() {
    if (halo) halo->exchange_state(offsets);
  }
};

void NetBuilder::prepare() {
  face_normals = unit_face_normals(topology, given);
  normals = vertex_normals(topology, given, face_normals, planes);
  offsets.resize(static_cast<std::size_t>(topology.state_size));
  corner_offsets(topology, given, given, offsets);
  shares = tensor_shares(topology, given, normals, offsets, planes);
  if (halo) halo->exchange_vertices(shares);
  const bool any =
      std::any_of(shares.begin(), shares.end(), [](double share) { return share > 0; });
  if (is_in_any_part(halo, any)) points = masked_iteration(topology, given, shares, offsets, halo);
}

void NetBuilder::build_polygons(std::vector<std::uint8_t>& reversed, const Callbacks& callbacks) {
  LoopProgress progress(callbacks, "solve", 0, 1, topology.vertex_count);
  const bool decided = !reversed.empty();
  if (!decided) reversed.assign(given.size(), 0);
  for_vertices(
      topology,
      [&] {
        return [&, scratch = PolygonScratch{}](std::int32_t v) mutable {
          if (topology.has_polygon(v)) {
            PolygonShape shape{normals[v], shares[v]};
            shape.is_flat = planes.of(v) >= 0;
            if (decided) shape.reversed = reversed[v] != 0;
            reversed[v] = build_vertex_polygon(topology, given, step, v, shape, scratch, offsets);
          } else if (topology.kind(v) == VertexKind::Crease) {
            build_crease(v);
          }
        };
      },
      &progress);
}

void NetBuilder::build_crease(std::int32_t vertex) {
  const CreaseArms arms = crease_arms(topology, given, vertex);
  SectorShape shape{crease_handle(arms), shares[vertex], dvec3(0.0)};
  if (shape.share > 0) {
    const auto [before, after] = topology.crease_neighbours(vertex);
    shape.handle =
        shape.share * (points[before] - points[after]) / 8.0 + (1 - shape.share) * shape.handle;
    shape.tensor_shift =
        (given[vertex] - points[vertex]) -
        ((points[before] - points[vertex]) + (points[after] - points[vertex])) / 8.0;
  }
  const std::int32_t crease = topology.crease_of_vertex[vertex];
  const std::int32_t begin = topology.sector_offsets[crease],
                     end = topology.sector_offsets[crease + 1];
  shape.handle = in_planes(begin, end, shape.handle);
  shape.handle *= corridor_factor(topology, given, step, face_normals, vertex, shape.handle);
  for (std::int32_t s = begin; s < end; ++s) {
    const std::int32_t face = planes.of_sector_at(s);
    shape.normal = face < 0 ? std::nullopt : std::optional(face_normals[face]);
    build_sector(topology, given, step, face_normals, topology.sectors[s], shape, offsets);
  }
  const FairTopology::Sector& first = topology.sectors[topology.sector_offsets[crease]];
  offsets[first.curve0] = shape.handle;
  offsets[first.curve1] = -shape.handle;
}

// A handle in the planes of its vertex's sectors.
dvec3 NetBuilder::in_planes(std::int32_t begin, std::int32_t end, const dvec3& handle) const {
  std::optional<dvec3> first;
  dvec3 result = handle;
  for (std::int32_t s = begin; s < end; ++s) {
    const std::int32_t face = planes.of_sector_at(s);
    if (face < 0) continue;
    const dvec3& normal = face_normals[face];
    if (first) {
      const dvec3 line = glm::cross(*first, normal);
      const double square = glm::dot(line, line);
      return square > kParallelPlanes ? glm::dot(handle, line) / square * line : result;
    }
    first = normal;
    result = handle - glm::dot(handle, normal) * normal;
  }
  return result;
}

// Those of corner vertices; crease vertices have theirs, darts take the mean of their neighbours.
void NetBuilder::build_curve_points() {
  for (std::size_t s = 0; s < topology.curve_points.size(); ++s) {
    const FairTopology::CurvePoint& place = topology.curve_points[s];
    if (topology.kind(place.vertex) != VertexKind::Corner) continue;
    const dvec3& end = points.empty() ? given[place.other] : points[place.other];
    offsets[static_cast<std::size_t>(topology.corner_count) + s] =
        (end - given[place.vertex]) / 4.0;
  }
  build_dart_points();
  exchange_state();
}

void NetBuilder::build_dart_points() {
  for (std::size_t s = 0; s < topology.curve_points.size(); ++s) {
    const FairTopology::CurvePoint& place = topology.curve_points[s];
    if (topology.kind(place.vertex) != VertexKind::Dart) continue;
    offsets[static_cast<std::size_t>(topology.corner_count) + s] =
        (offsets[place.corner_after] + offsets[place.corner_before]) / 2.0;
  }
}

namespace {

// Repairs the folds, or halves what was halved before. Returns the rounds of repair.
std::int32_t settle_folds(NetBuilder& builder, bool decided, std::vector<std::uint8_t>& halvings) {
  if (decided) {
    halve_polygons(builder.topology, halvings, builder.offsets);
    builder.exchange_state();
    return 0;
  }
  halvings.assign(builder.given.size(), 0);
  return repair_folds(builder.topology, builder.given, builder.face_normals, builder.offsets,
                      halvings, builder.halo)
      .rounds;
}

// What no halving cures; or as it was cured before.
FoldCount settle_cure(NetBuilder& builder, const FairOptions& options, FairDecisions& decisions) {
  const CureInput input{builder.topology, builder.given,      builder.face_normals, builder.normals,
                        builder.offsets,  decisions.ellipses, builder.halo};
  std::vector<std::uint8_t>& cures = decisions.cures;
  if (!options.decisions || !options.cures_folds) cures.assign(builder.given.size(), 0);
  decisions.leans.resize(builder.given.size(), glm::vec2(kNoLean));
  if (options.decisions || !options.cures_folds) return repeat_cure(input, cures, decisions.leans);
  return cure_folds(input, cures, decisions.leans);
}

void count_decisions(FairNet& net, FairHalo* halo) {
  const FairDecisions& decisions = net.decisions;
  for (std::size_t v = 0; v < decisions.reversed.size(); ++v) {
    if (!owns_vertex(halo, static_cast<std::int32_t>(v))) continue;
    net.reversed_vertices += decisions.reversed[v];
    net.cured_vertices += decisions.cures[v] > 0;
    net.shrunk_vertices += decisions.halvings[v] + decisions.late_halvings[v] > 0;
  }
  for (auto* count : {&net.reversed_vertices, &net.cured_vertices, &net.shrunk_vertices})
    *count = sum_of_parts(halo, *count);
}

void add_given_points(const FairTopology& topology, std::span<const dvec3> given,
                      std::span<dvec3> state) {
  for (std::int32_t c = 0; c < topology.corner_count; ++c) {
    state[c] += given[topology.corner_vertices[c]];
  }
  auto index = static_cast<std::size_t>(topology.corner_count);
  for (const FairTopology::CurvePoint& place : topology.curve_points) {
    state[index++] += given[place.vertex];
  }
  for (const std::int32_t vertex : topology.corner_points) state[index++] += given[vertex];
}

}  // namespace

void require_valid(const FairOptions& options) {
  if (options.polish_steps >= 0 && options.polish_steps <= kMostPolishSteps) return;
  throw Error(ErrorCode::InvalidArgument, formatted("polish steps {} are outside 0 to {}",
                                                    options.polish_steps, kMostPolishSteps));
}

void require_valid(const FairDecisions& decisions, std::int32_t vertex_count,
                   std::int32_t face_count) {
  const auto require = [&](const char* what, std::size_t size) {
    if (size == static_cast<std::size_t>(vertex_count)) return;
    throw Error(ErrorCode::InvalidArgument,
                formatted("fair_decisions {} {} vertices, but faces name {}; take those of a fair "
                          "net of the same mesh",
                          what, size, vertex_count));
  };
  for (const auto* flags :
       {&decisions.reversed, &decisions.halvings, &decisions.late_halvings, &decisions.cures})
    require("are of", flags->size());
  if (!decisions.leans.empty()) require("have leans of", decisions.leans.size());
  if (!decisions.ellipses.empty()) require("have ellipses of", decisions.ellipses.size());
  for (const auto& [vertex, face] : decisions.planes)
    if (vertex < 0 || vertex >= vertex_count || face < 0 || face >= face_count)
      throw Error(
          ErrorCode::InvalidArgument,
          formatted("fair_decisions keep the plane of face {} at vertex {}, of {} faces and "
                    "{} vertices; take those of a fair net of the same mesh",
                    face, vertex, face_count, vertex_count));
}

namespace {

// All but the cure. Returns the rounds of repair.
std::int32_t build_uncured(NetBuilder& builder, const FairOptions& options,
                           FairDecisions& decisions) {
  const FairTopology& topology = builder.topology;
  const bool decided = options.decisions != nullptr;
  options.callbacks.report("solve", 0.1);
  const auto planes = planes_of(options);
  decisions.planes.assign(planes.begin(), planes.end());
  builder.planes = plane_places(topology, decisions.planes);
  builder.prepare();
  builder.build_polygons(decisions.reversed, share_of(options.callbacks, 0.3, 0.6));
  builder.build_curve_points();
  options.callbacks.report("solve", 0.6);

  std::int32_t repairs = settle_folds(builder, decided, decisions.halvings);
  options.callbacks.report("solve", 0.7);
  if (options.polish_steps > 0) {
    builder.build_curve_points();
    const std::vector<dvec3> directions =
        polish_directions(topology, builder.normals, builder.shares, builder.planes);
    BendingRows bending =
        make_bending_rows(topology, builder.given, directions, builder.offsets, options.halo);
    apply_heights(topology, directions,
                  polish_heights(topology, std::move(bending), options.polish_steps, options.halo),
                  builder.offsets);
    builder.exchange_state();
    repairs += settle_folds(builder, decided, decisions.late_halvings);
  } else if (!decided) {
    decisions.late_halvings.assign(builder.given.size(), 0);
  }
  options.callbacks.report("solve", 0.9);
  builder.build_curve_points();
  return repairs;
}

// Takes the builder's offsets.
FairNet cured(NetBuilder& builder, const FairOptions& options, FairDecisions decisions) {
  FairNet net;
  net.decisions = std::move(decisions);
  const FoldCount folds = settle_cure(builder, options, net.decisions);
  builder.build_dart_points();
  builder.exchange_state();
  net.rounds.repair = 0;
  net.rounds.cure = folds.rounds;
  net.flagged_edges = folds.edges;
  net.flagged_faces = folds.faces;
  count_decisions(net, options.halo);
  net.state = std::move(builder.offsets);
  add_given_points(builder.topology, builder.given, net.state);
  options.callbacks.report("solve", 1);
  return net;
}

}  // namespace

FairNet fair_net(const PolygonMesh& mesh, const Subdivision& subdivision,
                 std::span<const dvec3> given, const FairOptions& options) {
  require_valid(options);
  PLANISH_ASSERT(given.size() == mesh.positions.size());
  if (options.decisions) require_valid(*options.decisions, mesh.vertex_count(), mesh.face_count());
  const HostScope host(options.callbacks);
  options.callbacks.report("solve", 0);
  const FairTopology topology = make_fair_topology(mesh, subdivision, options.halo);
  NetBuilder builder{topology, given, options.halo};
  FairDecisions decisions = options.decisions ? *options.decisions : FairDecisions{};
  const std::int32_t repairs = build_uncured(builder, options, decisions);
  FairNet net = cured(builder, options, std::move(decisions));
  net.rounds.repair = repairs;
  return net;
}

struct CuredNets::Parts {
  Parts(const PolygonMesh& mesh, const Subdivision& subdivision, std::span<const dvec3> given,
        const FairOptions& of)
      : options(of),
        topology(make_fair_topology(mesh, subdivision, of.halo)),
        builder{topology, given, of.halo} {}

  FairOptions options;
  FairTopology topology;
  NetBuilder builder;
  std::optional<std::vector<dvec3>> uncured;  // a part of a mesh may have none
};

CuredNets::CuredNets(const PolygonMesh& mesh, const Subdivision& subdivision,
                     std::span<const dvec3> given, const FairOptions& options) {
  require_valid(options);
  PLANISH_ASSERT(given.size() == mesh.positions.size());
  parts_ = std::make_unique<Parts>(mesh, subdivision, given, options);
}
CuredNets::~CuredNets() = default;

FairNet CuredNets::net(const FairDecisions& decisions, const Callbacks& callbacks) {
  Parts& parts = *parts_;
  require_valid(decisions, parts.topology.vertex_count, parts.topology.face_count);
  const HostScope host(callbacks);
  FairOptions options = parts.options;
  options.callbacks = callbacks;
  options.decisions = &decisions;
  FairDecisions own = decisions;
  if (parts.uncured) {
    parts.builder.offsets = *parts.uncured;
  } else {
    build_uncured(parts.builder, options, own);
    parts.uncured = parts.builder.offsets;
    parts.builder.shares = {};
    parts.builder.points = {};
  }
  return cured(parts.builder, options, std::move(own));
}

}  // namespace planish
