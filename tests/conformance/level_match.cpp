#include "conformance/level_match.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <set>

namespace planish::test {

using glm::dvec3;
using std::int32_t;

namespace {

// Far above rounding, far below the distances of neighbouring limit points at level 4.
constexpr double kClose = 1e-9;

// A ring of two has tangents on one line; its second one is rounding noise of no direction.
bool is_degenerate(const QuadSplitOracle& oracle, int32_t vertex, std::size_t sector) {
  const QuadSplitOracle::Sector& around = oracle.sectors(vertex)[sector];
  if (around.is_ring && around.faces.size() == 2) return true;
  const auto& [t1, t2] = oracle.tangents(vertex, sector);
  return glm::length(glm::cross(t1, t2)) < 1e-5 * glm::length(t1) * glm::length(t2);
}

}  // namespace

LevelMatch::Match LevelMatch::find(const SurfaceMesh& surface, const QuadSplitOracle& oracle,
                                   std::int64_t library_face) const {
  const auto corners = surface.face(library_face);
  const auto fits = [&](int32_t candidate, int32_t rotation) {
    for (int32_t i = 0; i < 4; ++i) {
      const int32_t vertex = oracle.faces()[candidate][(i + rotation) % 4];
      const dvec3 position = surface.positions[corners[i]];
      if (glm::distance(position, oracle.limit_point(vertex)) > kClose) return false;
    }
    return true;
  };
  // Level 1: one child a corner of the input, in the same order on both sides.
  const bool first = surface.level == 1;
  const auto from = int32_t(first ? library_face : 4 * faces_[library_face / 4].face);
  for (int32_t candidate = from; candidate < from + (first ? 1 : 4); ++candidate) {
    for (int32_t rotation = 0; rotation < 4; ++rotation) {
      if (fits(candidate, rotation)) return {candidate, rotation};
    }
  }
  ADD_FAILURE() << "face " << library_face << " of level " << surface.level
                << " has no counterpart";
  return {from, 0};
}

void LevelMatch::advance(const SurfaceMesh& surface, const QuadSplitOracle& oracle) {
  ASSERT_EQ(surface.face_count(), std::int64_t(oracle.faces().size()));
  std::vector<Match> matches;
  for (std::int64_t f = 0; f < surface.face_count(); ++f) {
    matches.push_back(find(surface, oracle, f));
  }
  faces_ = matches;
  std::set<int32_t> taken;
  for (const Match& match : faces_) taken.insert(match.face);
  EXPECT_EQ(taken.size(), faces_.size()) << "two faces have the same counterpart";
  compare(surface, oracle);
}

void LevelMatch::compare(const SurfaceMesh& surface, const QuadSplitOracle& oracle) {
  worst_position_ = worst_normal_ = 0;
  std::map<int32_t, int32_t> vertex_of;
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    const auto corners = surface.face(std::int64_t(f));
    for (int32_t i = 0; i < 4; ++i) {
      const int32_t q = faces_[f].face, v = oracle.faces()[q][(i + faces_[f].rotation) % 4];
      EXPECT_EQ(vertex_of.try_emplace(corners[i], v).first->second, v);
      worst_position_ = std::max(
          worst_position_, glm::distance(surface.positions[corners[i]], oracle.limit_point(v)));
      const std::size_t sector = oracle.sector_of(v, q);
      if (is_degenerate(oracle, v, sector)) continue;
      const dvec3 normal(surface.normals[corners[i]]);
      worst_normal_ = std::max(worst_normal_, glm::distance(normal, oracle.normal(v, sector)));
    }
  }
}

}  // namespace planish::test
