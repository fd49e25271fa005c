// Based on: Catmull & Clark 1978; away from the vertex the masks are those of uniform bicubic
// B-splines, at sharp edges of cubic ones.
#include "planish/brep/star_rings.h"

#include <glm/geometric.hpp>
#include <utility>

namespace planish {
namespace {

std::size_t grid_place(std::size_t a, std::size_t b) { return a + 4 * b; }

// Points 1 to 3 of a line of halved steps, of whose points 0 to 2 are given.
std::array<glm::dvec3, 3> halved(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  return {0.5 * (a + b), 0.125 * (a + 6.0 * b + c), 0.5 * (b + c)};
}

// Bezier points of the segment between the second and the third of four B-spline points.
std::array<glm::dvec3, 4> bezier_of(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c,
                                    const glm::dvec3& d) {
  return {(a + 4.0 * b + c) / 6.0, (2.0 * b + c) / 3.0, (b + 2.0 * c) / 3.0,
          (b + 4.0 * c + d) / 6.0};
}

}  // namespace

void StarRings::set(const VertexStar& star, std::vector<Grid> grids) {
  star_ = star;
  vertex_mask(PrimalScheme::CatmullClark, star_, mask_);
  levels_.clear();
  levels_.push_back(std::move(grids));
  limit_ = weighted(limits_.limit(star_, 0).position);
}

bool StarRings::is_sharp(std::size_t edge) const { return star_.edge_sharpness[edge] > 0; }

glm::dvec3 StarRings::weighted(const StarWeights& weights) const {
  const std::vector<Grid>& grids = levels_.front();
  glm::dvec3 sum = weights.vertex * grids[0][0];
  for (std::size_t i = 0; i < grids.size(); ++i)
    sum += weights.edges[i] * grids[i][grid_place(1, 0)] +
           weights.faces[i] * grids[i][grid_place(1, 1)];
  if (star_.is_boundary()) sum += weights.edges.back() * grids.back()[grid_place(0, 1)];
  return sum;
}

glm::dvec3 StarRings::limit_normal(std::int32_t face) {
  const StarLimit& limit = limits_.limit(star_, sector_of(star_, face));
  return glm::cross(weighted(limit.du), weighted(limit.dv));
}

glm::dvec3 StarRings::next_vertex(const std::vector<Grid>& grids) const {
  glm::dvec3 sum = mask_.vertex(0) * grids[0][0];
  for (std::size_t i = 0; i < grids.size(); ++i) {
    const Grid& grid = grids[i];
    const glm::dvec3 centre =
        0.25 * (grid[0] + grid[grid_place(1, 0)] + grid[grid_place(1, 1)] + grid[grid_place(0, 1)]);
    sum += mask_.edge(static_cast<int>(i)) * grid[grid_place(1, 0)] +
           mask_.face(static_cast<int>(i)) * centre;
  }
  if (star_.is_boundary())
    sum += mask_.edge(star_.edge_count() - 1) * grids.back()[grid_place(0, 1)];
  return sum;
}

void StarRings::halve() {
  const std::vector<Grid>& grids = levels_.back();
  std::vector<Grid> halves(grids.size());
  const glm::dvec3 vertex = next_vertex(grids);
  for (std::size_t f = 0; f < grids.size(); ++f) {
    const Grid& grid = grids[f];
    std::array<std::array<glm::dvec3, 3>, 3> lines;  // along the first edge, then across
    for (std::size_t b = 0; b < 3; ++b)
      lines[b] = halved(grid[grid_place(0, b)], grid[grid_place(1, b)], grid[grid_place(2, b)]);
    Grid& half = halves[f];
    half[0] = vertex;
    for (std::size_t a = 0; a < 3; ++a) {
      const auto column = halved(lines[0][a], lines[1][a], lines[2][a]);
      for (std::size_t b = 0; b < 3; ++b) half[grid_place(a + 1, b + 1)] = column[b];
    }
    std::array<glm::dvec3, 3> edge = lines[0];
    if (!is_sharp(f)) {
      const Grid& before = grids[face_before(f)];
      const auto beyond =
          halved(before[grid_place(1, 0)], before[grid_place(1, 1)], before[grid_place(1, 2)]);
      for (std::size_t a = 0; a < 3; ++a)
        edge[a] = 0.125 * (beyond[a] + 6.0 * lines[0][a] + lines[1][a]);
    }
    for (std::size_t a = 0; a < 3; ++a) half[grid_place(a + 1, 0)] = edge[a];
  }
  for (std::size_t f = 0; f < grids.size(); ++f) {
    for (std::size_t b = 1; b < 4; ++b)
      halves[f][grid_place(0, b)] = halves[face_after(f)][grid_place(b, 0)];
  }
  if (star_.is_boundary()) {
    const Grid& last = grids.back();
    const auto edge =
        halved(last[grid_place(0, 0)], last[grid_place(0, 1)], last[grid_place(0, 2)]);
    for (std::size_t b = 1; b < 4; ++b) halves.back()[grid_place(0, b)] = edge[b - 1];
  }
  levels_.push_back(std::move(halves));
}

PointNet StarRings::square(int halvings, std::int32_t face, int x, int y) {
  while (std::ssize(levels_) <= halvings) halve();
  const std::vector<Grid>& grids = levels_[halvings];
  const auto f = static_cast<std::size_t>(face);
  // The points around, from one step before on; beyond a sharp edge such as make it a spline's end.
  const auto point = [&](int a, int b) {
    const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
    if (a >= 0 && b >= 0) return grids[f][grid_place(i, j)];
    if (b < 0)
      return is_sharp(f) ? 2.0 * grids[f][grid_place(i, 0)] - grids[f][grid_place(i, 1)]
                         : grids[face_before(f)][grid_place(1, i)];
    return is_sharp(edge_after(f)) ? 2.0 * grids[f][grid_place(0, j)] - grids[f][grid_place(1, j)]
                                   : grids[face_after(f)][grid_place(j, 1)];
  };
  std::array<std::array<glm::dvec3, 4>, 4> rows;
  for (int b = 0; b < 4; ++b) {
    const auto in_row = [&](int a) { return point(x - 1 + a, y - 1 + b); };
    rows[b] = bezier_of(in_row(0), in_row(1), in_row(2), in_row(3));
  }
  PointNet net{};
  for (std::size_t i = 0; i < 4; ++i) {
    const auto column = bezier_of(rows[0][i], rows[1][i], rows[2][i], rows[3][i]);
    for (std::size_t j = 0; j < 4; ++j) net[grid_place(i, j)] = column[j];
  }
  return net;
}

}  // namespace planish
