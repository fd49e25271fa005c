#include "planish/vulkan/fair/gpu_fair.h"

#include <atomic>
#include <bit>

#include "planish/core/parallel.h"
#include "planish/doosabin/subdivision.h"
#include "planish/fair/fair_topology.h"

namespace planish::vulkan {

namespace {

static_assert(shared::kSmooth == static_cast<std::uint32_t>(VertexKind::Smooth) &&
              shared::kDart == static_cast<std::uint32_t>(VertexKind::Dart) &&
              shared::kCrease == static_cast<std::uint32_t>(VertexKind::Crease) &&
              shared::kCorner == static_cast<std::uint32_t>(VertexKind::Corner));

static_assert(shared::kLargeRing == kSummedRing);
static_assert(std::bit_cast<float>(std::uint32_t{shared::kNoLeanBits}) == kNoLean);

std::uint32_t word(std::int32_t index) { return static_cast<std::uint32_t>(index); }

// 0 where there is none.
std::uint32_t plane_word(std::int32_t face) { return word(face + 1); }

void add_vertices(const FairTopology& topology, const PlanePlaces& planes, FairRecords& records) {
  records.vertices.resize(static_cast<std::size_t>(topology.vertex_count));
  std::atomic<bool> has_regular_vertices = false;
  parallel_each(records.vertices.size(), [&](std::int32_t v) {
    shared::FairVertex& vertex = records.vertices[v];
    vertex = {word(topology.ring_offsets[v]),
              word(topology.valence(v)),
              topology.kinds[v],
              topology.is_regular[v],
              0,
              0,
              0,
              0,
              word(topology.unit_circle.offsets[topology.valence(v)]),
              topology.is_near_curve[v],
              0,  // listed when all are known
              plane_word(planes.of(v))};
    const VertexKind kind = topology.kind(v);
    if (topology.is_regular[v] && kind != VertexKind::Corner) has_regular_vertices = true;
    if (kind != VertexKind::Crease) return;
    const auto [before, after] = topology.crease_neighbours(v);
    const FairTopology::Sector& sector =
        topology.sectors[topology.sector_offsets[topology.crease_of_vertex[v]]];
    vertex.before = word(before);
    vertex.after = word(after);
    vertex.curve0 = word(sector.curve0);
    vertex.curve1 = word(sector.curve1);
  });
  records.has_regular_vertices = has_regular_vertices;
}

void add_corners(const FairTopology& topology, FairRecords& records) {
  const auto count = static_cast<std::size_t>(topology.corner_count);
  records.places.resize(count);
  records.links.resize(count);
  parallel_each(count, [&](std::size_t i) {
    const std::int32_t corner = topology.ring_corners[i];
    records.places[i] = {word(corner), word(topology.ring_next[i]), word(topology.ring_previous[i]),
                         word(topology.corner_faces[corner])};
  });
  records.faces.resize(static_cast<std::size_t>(topology.face_count));
  parallel_each(records.faces.size(), [&](std::int32_t f) {
    const std::int32_t first = topology.face_offsets[f], m = topology.face_size(f);
    records.faces[f] = {word(first), word(m), word(topology.unit_circle.offsets[m]), 0};
    for (std::int32_t c = first; c < first + m; ++c) {
      records.links[c] = {word(c + 1 == first + m ? first : c + 1),
                          word(c == first ? first + m - 1 : c - 1), word(topology.corner_ccw[c]),
                          word(topology.corner_cw[c])};
    }
  });
}

void add_edges(const FairTopology& topology, FairRecords& records) {
  records.edges.resize(topology.edge_corners.size());
  parallel_each(records.edges.size(), [&](std::size_t e) {
    const FairTopology::Edge edge = topology.edge(e);
    records.edges[e] = {word(edge.corners[0]),
                        word(edge.corners[1]),
                        word(edge.corners[2]),
                        word(edge.corners[3]),
                        word(edge.faces[0]),
                        word(edge.faces[1]),
                        0,
                        0};
  });
}

// Sectors at corner vertices are left out: their control points are those of one step.
void add_creases(const FairTopology& topology, const PlanePlaces& planes, FairRecords& records) {
  for (const std::int32_t v : topology.crease_vertices) {
    if (topology.kind(v) != VertexKind::Crease) continue;
    const shared::FairVertex& vertex = records.vertices[v];
    const std::int32_t crease = topology.crease_of_vertex[v];
    std::uint32_t kept[2] = {};
    std::size_t kept_count = 0;
    for (std::int32_t s = topology.sector_offsets[crease]; s < topology.sector_offsets[crease + 1];
         ++s) {
      const FairTopology::Sector& sector = topology.sectors[s];
      const std::uint32_t plane = plane_word(planes.of_sector_at(s));
      if (plane != 0 && kept_count < 2) kept[kept_count++] = plane;
      records.sectors.push_back({word(v), word(sector.first), word(sector.count),
                                 static_cast<std::uint32_t>(records.creases.size()), vertex.curve0,
                                 0, plane});
    }
    records.creases.push_back({word(v), vertex.before, vertex.after, vertex.curve0, vertex.curve1,
                               vertex.first, vertex.count, 0, kept[0], kept[1]});
  }
  for (const FairTopology::CurvePoint& point : topology.curve_points) {
    records.curve_points.push_back({word(point.vertex), word(point.other),
                                    topology.kinds[point.vertex], word(point.corner_after),
                                    word(point.corner_before)});
  }
}

void add_owners(const FairTopology& topology, FairRecords& records) {
  records.owners.reserve(static_cast<std::size_t>(topology.state_size));
  for (const std::int32_t vertex : topology.corner_vertices) records.owners.push_back(word(vertex));
  for (const FairTopology::CurvePoint& point : topology.curve_points)
    records.owners.push_back(word(point.vertex));
  for (const std::int32_t vertex : topology.corner_points) records.owners.push_back(word(vertex));
}

// Lists the large ones in the words of the first; returns how many there are.
template <class Records>
std::uint32_t list_large(Records& records) {
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < records.size(); ++i)
    if (records[i].count >= shared::kLargeRing)
      records[count++].large = static_cast<std::uint32_t>(i);
  return count;
}

template <class Items>
Buffer make_fair_table(const Maker& on, const Items& items, const char* name) {
  return make_bindable(on, std::as_bytes(std::span(items)).size(), name);
}

template <class Items>
std::uint32_t count_of(const Items& items) {
  return static_cast<std::uint32_t>(items.size());
}

}  // namespace

FairRecords fair_records(const FairTopology& topology, const FairDecisions* decisions,
                         std::span<const KeptPlane> kept) {
  const PlanePlaces planes = plane_places(topology, kept);
  FairRecords records;
  if (decisions) {
    records.decisions = pack_decisions(*decisions);
    records.leans = pack_leans(*decisions);
  }
  add_vertices(topology, planes, records);
  add_corners(topology, records);
  add_edges(topology, records);
  add_creases(topology, planes, records);
  add_owners(topology, records);
  records.large_vertices = list_large(records.vertices);
  records.large_faces = list_large(records.faces);
  records.large_creases = list_large(records.creases);
  records.large_sectors = list_large(records.sectors);
  for (const glm::dvec2& point : topology.unit_circle.points) {
    records.circle.push_back(static_cast<float>(point.x));
    records.circle.push_back(static_cast<float>(point.y));
  }
  return records;
}

std::vector<std::uint32_t> pack_decisions(const FairDecisions& decisions) {
  std::vector<std::uint32_t> words(decisions.reversed.size());
  for (std::size_t v = 0; v < words.size(); ++v) {
    words[v] = decisions.halvings[v] |
               std::uint32_t{decisions.late_halvings[v]} << shared::kLateShift |
               (decisions.reversed[v] ? shared::kReversed : 0) |
               std::uint32_t{decisions.cures[v]} << shared::kCureShift;
  }
  return words;
}

std::vector<float> pack_leans(const FairDecisions& decisions) {
  std::vector<float> floats(8 * decisions.reversed.size(), 0.0F);
  for (std::size_t v = 0; v < decisions.reversed.size(); ++v) {
    const glm::vec2 lean = decisions.leans.empty() ? glm::vec2(kNoLean) : decisions.leans[v];
    floats[4 * v] = lean.x;
    floats[4 * v + 1] = lean.y;
  }
  auto place = floats.begin() + std::ssize(floats) / 2;
  for (const glm::vec4& ellipse : decisions.ellipses)
    for (const int i : {0, 1, 2, 3}) *place++ = ellipse[i];
  return floats;
}

FairDecisions unpack_decisions(std::span<const std::uint32_t> words,
                               std::span<const float> planes) {
  FairDecisions decisions;
  for (std::size_t v = 0; v < planes.size() / 4; ++v) {
    decisions.leans.emplace_back(planes[4 * v], planes[4 * v + 1]);
  }
  for (const std::uint32_t word : words) {
    decisions.reversed.push_back(word & shared::kReversed ? 1 : 0);
    decisions.halvings.push_back(static_cast<std::uint8_t>(word & shared::kHalvingsMask));
    decisions.late_halvings.push_back(
        static_cast<std::uint8_t>(word >> shared::kLateShift & shared::kHalvingsMask));
    decisions.cures.push_back(static_cast<std::uint8_t>(word >> shared::kCureShift));
  }
  return decisions;
}

FairTables::FairTables(const Maker& on, const FairRecords& records)
    : vertex_count(count_of(records.vertices)),
      corner_count(count_of(records.links)),
      face_count(count_of(records.faces)),
      edge_count(count_of(records.edges)),
      crease_count(count_of(records.creases)),
      sector_count(count_of(records.sectors)),
      curve_point_count(count_of(records.curve_points)),
      state_size(count_of(records.owners)),
      large_vertex_count(records.large_vertices),
      large_face_count(records.large_faces),
      large_crease_count(records.large_creases),
      large_sector_count(records.large_sectors),
      has_regular_vertices(records.has_regular_vertices),
      is_decided(!records.decisions.empty()),
      placement(records.placement),
      vertices(make_fair_table(on, records.vertices, "planish fair vertices")),
      places(make_fair_table(on, records.places, "planish fair rings")),
      links(make_fair_table(on, records.links, "planish fair corners")),
      faces(make_fair_table(on, records.faces, "planish fair faces")),
      edges(make_fair_table(on, records.edges, "planish fair edges")),
      creases(make_fair_table(on, records.creases, "planish fair creases")),
      sectors(make_fair_table(on, records.sectors, "planish fair sectors")),
      curve_points(make_fair_table(on, records.curve_points, "planish fair curve points")),
      circle(make_fair_table(on, records.circle, "planish fair circle")),
      owners(make_fair_table(on, records.owners, "planish fair owners")),
      decisions(make_fair_table(on, records.decisions, "planish fair decisions")),
      leans(make_fair_table(on, records.leans, "planish fair leans")) {}

}  // namespace planish::vulkan
