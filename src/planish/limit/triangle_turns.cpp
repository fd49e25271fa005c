#include "planish/limit/triangle_turns.h"

#include <algorithm>
#include <numbers>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/mesh/angle_between.h"

namespace planish {
namespace {

constexpr std::size_t kTurnGrain = 4096;
constexpr double kNormalRounding = 1e-4;  // degrees

double turn_within(const SurfaceMesh& surface, std::size_t triangle) {
  const auto normal = [&](std::size_t k) {
    const std::int32_t vertex = surface.face_vertices[3 * triangle + k % 3];
    return glm::dvec3(surface.normals[vertex]);
  };
  double turn = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    turn = std::max(turn, angle_between(normal(k), normal(k + 1)));
  }
  return turn * 180 / std::numbers::pi;
}

}  // namespace

TriangleTurns turns_beyond(const SurfaceMesh& surface, double degrees) {
  const std::size_t count = surface.face_vertices.size() / 3;
  std::vector<TriangleTurns> of_block((count + kTurnGrain - 1) / kTurnGrain);
  parallel_for(of_block.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      for (std::size_t t = b * kTurnGrain; t < std::min(count, (b + 1) * kTurnGrain); ++t) {
        const double turn = turn_within(surface, t);
        if (!(turn > degrees + kNormalRounding)) continue;
        TriangleTurns& turns = of_block[b];
        if (turns.count++ == 0) turns.first = static_cast<std::int64_t>(t);
        if (!(turn > turns.largest)) continue;
        turns.largest = turn;
        turns.worst = static_cast<std::int64_t>(t);
      }
    }
  });
  TriangleTurns all;
  for (const TriangleTurns& turns : of_block) {
    if (all.count == 0) all.first = turns.first;
    all.count += turns.count;
    if (!(turns.largest > all.largest)) continue;
    all.largest = turns.largest;
    all.worst = turns.worst;
  }
  return all;
}

}  // namespace planish
