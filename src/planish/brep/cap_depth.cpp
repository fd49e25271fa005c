#include "planish/brep/cap_depth.h"

#include <algorithm>

#include "planish/brep/cap_measure.h"
#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"

namespace planish {
namespace {

// What was chosen for a place.
struct Choice {
  int depth = 1;
  CapError error;
  std::vector<CapMove> moves;
};

Choice choose(CapMeasure& measure, std::span<const std::int32_t> corners, bool is_face,
              const CapLimits& limits) {
  // Moves bring no more.
  constexpr double kMostPart = 16;
  Choice choice;
  for (int depth = 1;; ++depth) {
    choice.depth = depth;
    const bool is_final = depth == kDeepestCap;
    choice.error = measure.of(corners, is_face, depth, limits, is_final);
    const double part = choice.error.part_of(limits);
    if (part <= 1) return choice;
    CapError moved;
    if ((part <= kMostPart || is_final) && measure.move(limits, is_final, moved)) {
      const double moved_part = moved.part_of(limits);
      if (moved_part <= 1 || (is_final && moved_part < part)) {
        choice.error = moved;
        choice.moves.assign(measure.moves().begin(), measure.moves().end());
        return choice;
      }
    }
    if (is_final) return choice;
  }
}

}  // namespace

CapDepths cap_depths(const SplineSurface& surface, const QuadLayout& layout,
                     const CapLimits& limits, const Callbacks& callbacks) {
  const MeshTopology& topology = surface.topology();
  const std::int32_t first_face = topology.vertex_count() + topology.edge_count();
  // Faces first, which vertices' choices take for given.
  std::vector<std::int32_t> places;
  for (std::int32_t v = 0; v < layout.vertex_count(); ++v) {
    if (layout.is_extraordinary(v) &&
        !(v >= first_face && layout.is_hidden(topology.first_corner(v - first_face))))
      places.push_back(v);
  }
  std::ranges::stable_partition(places, [&](std::int32_t v) { return v >= first_face; });
  const auto face_count = static_cast<std::size_t>(
      std::ranges::count_if(places, [&](std::int32_t v) { return v >= first_face; }));
  CapDepths depths;
  depths.of_vertex.assign(static_cast<std::size_t>(layout.vertex_count()), 1);
  depths.of_corner.assign(static_cast<std::size_t>(topology.corner_count()), {-1, -1});
  depths.count = static_cast<std::int64_t>(places.size());
  std::vector<Choice> choices(places.size());
  LoopProgress progress(callbacks, "faces", 0, 1, std::ssize(places));

  const auto corners_of = [&](std::int32_t place, std::vector<std::int32_t>& around) {
    around.clear();
    if (place >= first_face) {
      const std::int32_t face = place - first_face;
      for (std::int32_t k = 0; k < topology.face_size(face); ++k)
        around.push_back(topology.first_corner(face) + k);
    } else {
      const auto corners = topology.corners_at(place);
      around.assign(corners.begin(), corners.end());
    }
  };
  const auto choose_all = [&](std::size_t first, std::size_t count) {
    parallel_for(count, 16, [&](std::size_t begin, std::size_t end) {
      CapMeasure measure(surface, layout, depths);
      std::vector<std::int32_t> around;
      for (std::size_t i = first + begin; i < first + end; ++i) {
        corners_of(places[i], around);
        choices[i] = choose(measure, around, places[i] >= first_face, limits);
        progress.add();
      }
    });
    std::vector<std::int32_t> around;
    for (std::size_t i = first; i < first + count; ++i) {
      const Choice& choice = choices[i];
      depths.worst.add(choice.error);
      depths.of_vertex[places[i]] = static_cast<std::int8_t>(choice.depth);
      depths.deepest = std::max(depths.deepest, choice.depth);
      if (choice.moves.empty()) continue;
      ++depths.moved;
      corners_of(places[i], around);
      for (std::size_t k = 0; k < around.size(); ++k) {
        depths.of_corner[around[k]][places[i] >= first_face ? 1 : 0] =
            static_cast<std::int32_t>(depths.moves.size());
        depths.moves.push_back(choice.moves[k]);
      }
    }
  };
  choose_all(0, face_count);
  choose_all(face_count, places.size() - face_count);
  return depths;
}

}  // namespace planish
