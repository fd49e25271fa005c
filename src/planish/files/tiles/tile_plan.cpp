#include "planish/files/tiles/tile_plan.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "planish/core/parallel.h"

namespace planish {
namespace {

constexpr std::size_t kPlanGrain = std::size_t{1} << 13;

RawVector<std::int32_t> places_of_faces(const MeshTopology& topology,
                                        std::span<const std::uint8_t> hidden,
                                        std::span<const std::int32_t> places) {
  RawVector<std::int32_t> face_places(static_cast<std::size_t>(topology.face_count()));
  parallel_each(face_places.size(), kPlanGrain, [&](std::int32_t f) {
    std::int32_t first = std::numeric_limits<std::int32_t>::max();
    for (const std::int32_t vertex : topology.face(f)) first = std::min(first, places[vertex]);
    face_places[f] = !hidden.empty() && hidden[f] != 0 ? -1 : first;
  });
  return face_places;
}

// Ascending faces of each place: a counting sort.
void sort_faces(std::size_t place_count, TilePlan& plan) {
  plan.face_begins.resize(place_count + 1);
  std::ranges::fill(plan.face_begins, 0);
  const auto is_ours = [&](std::int32_t place) {
    return place >= 0 && static_cast<std::size_t>(place) < place_count;
  };
  for (const std::int32_t place : plan.face_places)
    if (is_ours(place)) ++plan.face_begins[place + 1];
  for (std::size_t i = 0; i < place_count; ++i) plan.face_begins[i + 1] += plan.face_begins[i];
  plan.faces.resize(static_cast<std::size_t>(plan.face_begins.back()));
  RawVector<std::int32_t> next(plan.face_begins);
  for (std::size_t f = 0; f < plan.face_places.size(); ++f)
    if (is_ours(plan.face_places[f]))
      plan.faces[next[plan.face_places[f]]++] = static_cast<std::int32_t>(f);
}

void add_tiles(PlannedTile tile, int level, TilePlan& plan) {
  if (plan.faces_of(tile).empty()) return;
  const auto index = static_cast<std::int32_t>(plan.tiles.size());
  plan.tiles.push_back(tile);
  if (tile.level == level) return;
  for (std::int64_t k = 0; k < 4; ++k) {
    const std::int64_t begin = tile.run.first + tile.run.count * k / 4;
    const std::int64_t end = tile.run.first + tile.run.count * (k + 1) / 4;
    add_tiles({.level = tile.level + 1,
               .block = tile.block,
               .quarter = 4 * tile.quarter + static_cast<std::int32_t>(k),
               .run = {begin, end - begin},
               .parent = index},
              level, plan);
  }
}

}  // namespace

TilePlan plan_tiles(const MeshTopology& topology, std::span<const std::uint8_t> hidden,
                    std::span<const std::int32_t> places, const TileCut& cut) {
  return plan_tiles(places_of_faces(topology, hidden, places), cut);
}

TilePlan plan_tiles(RawVector<std::int32_t> face_places, const TileCut& cut) {
  TilePlan plan;
  plan.face_places = std::move(face_places);
  sort_faces(static_cast<std::size_t>(cut.place_count), plan);
  for (std::int64_t first = 0; first < cut.place_count;
       first += cut.block_vertices, ++plan.block_count) {
    add_tiles({.block = plan.block_count,
               .run = {first, std::min(cut.block_vertices, cut.place_count - first)}},
              cut.level, plan);
  }
  return plan;
}

}  // namespace planish
