#include "planish/brep/subdivision_splines.h"

#include <opensubdiv/sdc/crease.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <glm/geometric.hpp>
#include <string>
#include <utility>
#include <vector>

#include "planish/brep/spline_surface.h"
#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/patches/bezier_net.h"
#include "planish/primal/primal_stencils.h"
#include "planish/surface/level_one_mesh.h"
#include "planish/surface/memory_need.h"

namespace planish {
namespace {

// A polynomial of a frame, as the patch around it sees it.
SquarePiece in_patch(const PatchFrame& frame, const BezierNet& net, const glm::dvec3& own) {
  const glm::dvec2 a = frame.at(0, 0), b = frame.at(1, 1);
  SquarePiece piece;
  piece.u = std::min(a.x, b.x);
  piece.v = std::min(a.y, b.y);
  piece.size = frame.size;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      const double du = (piece.u - frame.u) / frame.size + 0.5 * i;
      const double dv = (piece.v - frame.v) / frame.size + 0.5 * j;
      const auto x = static_cast<std::size_t>(std::lround(2 * (frame.c * du + frame.s * dv)));
      const auto y = static_cast<std::size_t>(std::lround(2 * (frame.c * dv - frame.s * du)));
      piece.net[i + 3 * j] = own + net[x + 3 * y];
    }
  }
  return piece;
}

class DooSabinPatch : public SplinePatch {
 public:
  explicit DooSabinPatch(const LimitSurface& surface) : corner_(surface) {}

  void move_to(std::int32_t corner) override { corner_.move_to(corner); }
  Point at(double u, double v) override {
    const PatchPoint point = corner_.at({u, v});
    return {point.position, point.normal};
  }
  void add_pieces(const std::array<int, 2>& depths, std::vector<SquarePiece>& pieces,
                  std::vector<End>& ends) override {
    const PatchForm& form = corner_.form();
    if (form.is_polynomial()) {
      pieces.push_back(in_patch({}, bezier_net(form, corner_.points()), corner_.own()));
      return;
    }
    std::vector<glm::dvec3> points;
    for (const int q : {1, 3, 0, 2}) {
      quarter_points(form, q, corner_.points(), points);
      const PatchForm& inner = *form.quarters[q];
      if (inner.is_polynomial()) {
        pieces.push_back(
            in_patch(PatchFrame().quarter(q), bezier_net(inner, points), corner_.own()));
      } else {
        PLANISH_ASSERT(q == 0 || q == 2);
        ends.push_back({q == 2, add_rings(inner, q, depths[q == 0 ? 0 : 1], points, pieces)});
      }
    }
  }

 private:
  // Of a quarter that is no polynomial; returns its limit point.
  [[nodiscard]] glm::dvec3 add_rings(const PatchForm& end, int quarter, int depth,
                                     std::vector<glm::dvec3> points,
                                     std::vector<SquarePiece>& pieces) const {
    const PatchForm* form = &end;
    PatchFrame frame = PatchFrame().quarter(quarter);
    std::vector<glm::dvec3> next;
    for (int d = 1; d < depth; ++d) {
      for (int q = 1; q < 4; ++q) {
        quarter_points(*form, q, points, next);
        const PatchForm& inner = *form->quarters[q];
        pieces.push_back(in_patch(frame.quarter(q), bezier_net(inner, next), corner_.own()));
      }
      quarter_points(*form, 0, points, next);
      std::swap(points, next);
      form = form->quarters[0];
      frame = frame.quarter(0);
    }
    glm::dvec3 limit = corner_.own();
    for (std::size_t k = 0; k < points.size(); ++k) limit += form->corner[k] * points[k];
    return limit;
  }

  LimitSurface::Corner corner_;
};

}  // namespace

std::unique_ptr<SplinePatch> DooSabinSplines::patch() const {
  return std::make_unique<DooSabinPatch>(surface_);
}

namespace {

// Catmull-Clark around one vertex, halving by halving. Faces follow one another counter-clockwise;
// a place in one is (x, y) from the vertex along the face's first edge and along its second, which
// is the first of the next face.
class StarRings {
 public:
  // Points (a, b) at a + 4 b, a and b from 0 to 3.
  using Grid = std::array<glm::dvec3, 16>;

  // `star`: its sharpness is infinite or none, and beyond its faces all is regular. `grids`: by
  // face its points with a and b to 2.
  void set(const VertexStar& star, std::vector<Grid> grids);

  [[nodiscard]] const glm::dvec3& limit() const { return limit_; }
  // Of the limit in a face; not of unit length.
  [[nodiscard]] glm::dvec3 limit_normal(std::int32_t face);
  // Bezier points of the surface on [x, x + 1] x [y, y + 1], x and y 0 or 1, but not [0, 1]^2, in
  // steps of the grids after so many halvings, at least 1.
  [[nodiscard]] PointNet square(int halvings, std::int32_t face, int x, int y);

 private:
  void halve();
  [[nodiscard]] glm::dvec3 next_vertex(const std::vector<Grid>& grids) const;
  [[nodiscard]] bool is_sharp(std::size_t edge) const;
  [[nodiscard]] std::size_t face_after(std::size_t face) const {
    return face + 1 == levels_.front().size() ? 0 : face + 1;
  }
  [[nodiscard]] std::size_t face_before(std::size_t face) const {
    return (face == 0 ? levels_.front().size() : face) - 1;
  }
  [[nodiscard]] std::size_t edge_after(std::size_t face) const {
    return star_.is_boundary() ? face + 1 : face_after(face);
  }
  [[nodiscard]] glm::dvec3 weighted(const StarWeights& weights) const;

  VertexStar star_;
  SubdivisionMask mask_;  // of the vertex
  StarLimits limits_{PrimalScheme::CatmullClark};
  glm::dvec3 limit_{};
  std::vector<std::vector<Grid>> levels_;  // by halvings and face
};

// Based on: Catmull & Clark 1978; away from the vertex the masks are those of uniform bicubic
// B-splines, at sharp edges of cubic ones.

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

using OpenSubdiv::Sdc::Crease;

// From M_2 on extraordinary points stand apart from one another.
constexpr int kLastLevel = 2;

class CatmullClarkPatch : public SplinePatch {
 public:
  explicit CatmullClarkPatch(const CatmullClarkSplines& surface) : surface_(surface) {}

  void move_to(std::int32_t corner) override {
    if (corner == corner_) return;
    corner_ = corner;
    piece_.size = 0;
    const MeshTopology& topology = surface_.topology();
    has_end_ = {surface_.is_singular_at_vertex(corner), surface_.is_singular_at_face(corner)};
    if (has_end_[0]) take_vertex(topology.vertex_of(corner));
    if (has_end_[1]) take_face(topology.face_of(corner));
  }

  Point at(double u, double v) override {
    for (const std::size_t end : {0u, 1u}) {
      const double x = end == 0 ? u : 1 - u, y = end == 0 ? v : 1 - v;
      if (has_end_[end] && std::max(x, y) <= 0.5) return at_end(end, x, y);
    }
    // Where two hold it always the same one, whatever was asked for before.
    const bool is_whole = !has_end_[0] && !has_end_[1];
    const double low_u = is_whole || u < 0.5 ? 0 : 0.5, low_v = is_whole || v < 0.5 ? 0 : 0.5;
    if (piece_.size == 0 || piece_.u != low_u || piece_.v != low_v) piece_ = regular_piece(u, v);
    return point_on(piece_.net, (u - piece_.u) / piece_.size, (v - piece_.v) / piece_.size);
  }

  void add_pieces(const std::array<int, 2>& depths, std::vector<SquarePiece>& pieces,
                  std::vector<End>& ends) override {
    if (!has_end_[0] && !has_end_[1]) {
      pieces.push_back(regular_piece(0, 0));
      return;
    }
    for (const double v : {0.25, 0.75}) {
      for (const double u : {0.25, 0.75}) {
        const bool is_end = (has_end_[0] && u + v < 1) || (has_end_[1] && u + v > 1);
        if (!is_end || u != v) pieces.push_back(regular_piece(u, v));
      }
    }
    for (const std::size_t end : {0u, 1u}) {
      if (!has_end_[end]) continue;
      for (int halvings = 1; halvings < depths[end]; ++halvings)
        for (const auto& [x, y] : {std::pair(1, 0), {0, 1}, {1, 1}})
          pieces.push_back(ring_piece(end, halvings, x, y));
      ends.push_back({end == 1, stars_[end].rings.limit()});
    }
  }

 private:
  // Around the vertex, or the face's centre, of which the patch is one of the faces.
  struct Star {
    std::int32_t index = -1, face = 0;
    StarRings rings;
  };

  void take_vertex(std::int32_t vertex) {
    const MeshTopology& topology = surface_.topology();
    const auto corners = topology.corners_at(vertex);
    Star& star = stars_[0];
    star.face = static_cast<std::int32_t>(std::ranges::find(corners, corner_) - corners.begin());
    if (std::exchange(star.index, vertex) == vertex) return;
    VertexStar around;
    around.sharpness = surface_.vertex_sharpness(vertex);
    for (const std::int32_t c : corners)
      around.edge_sharpness.push_back(surface_.is_sharp(c) ? kInfiniteSharpness : 0);
    if (topology.is_boundary_vertex(vertex)) around.edge_sharpness.push_back(kInfiniteSharpness);
    set_star(star, std::move(around), corners, false);
  }

  void take_face(std::int32_t face) {
    const MeshTopology& topology = surface_.topology();
    Star& star = stars_[1];
    star.face = topology.place_of(corner_);
    if (std::exchange(star.index, face) == face) return;
    std::vector<std::int32_t> corners;
    for (std::int32_t k = 0; k < topology.face_size(face); ++k)
      corners.push_back(topology.first_corner(face) + k);
    VertexStar around;
    around.edge_sharpness.assign(corners.size(), 0);
    set_star(star, std::move(around), corners, true);
  }

  void set_star(Star& star, VertexStar around, std::span<const std::int32_t> corners,
                bool is_face) const {
    around.face_count = static_cast<std::int32_t>(corners.size());
    around.edge_ends.resize(around.edge_sharpness.size());
    around.face_ends.resize(corners.size());
    std::vector<StarRings::Grid> grids(corners.size());
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const auto points = surface_.points_on(corners[i]);
      for (std::size_t b = 0; b < 3; ++b)
        for (std::size_t a = 0; a < 3; ++a)
          grids[i][a + 4 * b] = points[is_face ? 8 - (a + 3 * b) : a + 3 * b];
    }
    star.rings.set(around, std::move(grids));
  }

  [[nodiscard]] SquarePiece regular_piece(double u, double v) const {
    SquarePiece piece;
    piece.degree = 3;
    if (!has_end_[0] && !has_end_[1]) {
      piece.net = surface_.whole_net(corner_);
      return piece;
    }
    piece.size = 0.5;
    piece.u = u < 0.5 ? 0 : 0.5;
    piece.v = v < 0.5 ? 0 : 0.5;
    piece.net = surface_.quarter_net(corner_, u < 0.5 ? (v < 0.5 ? 0 : 3) : (v < 0.5 ? 1 : 2));
    return piece;
  }

  [[nodiscard]] SquarePiece ring_piece(std::size_t end, int halvings, int x, int y) {
    const PointNet net = stars_[end].rings.square(halvings, stars_[end].face, x, y);
    SquarePiece piece;
    piece.degree = 3;
    piece.size = std::ldexp(1.0, -1 - halvings);
    piece.u = end == 0 ? x * piece.size : 1 - (x + 1) * piece.size;
    piece.v = end == 0 ? y * piece.size : 1 - (y + 1) * piece.size;
    for (std::size_t k = 0; k < 16; ++k) piece.net[k] = net[end == 0 ? k : 15 - k];
    return piece;
  }

  [[nodiscard]] Point at_end(std::size_t end, double x, double y) {
    Star& star = stars_[end];
    const double most = std::max(x, y);
    if (most == 0) return {star.rings.limit(), star.rings.limit_normal(star.face)};
    // The ring of [1, 2] steps; both tangents turn at F, so that the normal stays.
    const int halvings = std::max(-1 - std::ilogb(most), 1);
    x = std::ldexp(x, 1 + halvings);
    y = std::ldexp(y, 1 + halvings);
    const int i = x >= 1 ? 1 : 0, j = y >= 1 ? 1 : 0;
    return point_on(star.rings.square(halvings, star.face, i, j), x - i, y - j);
  }

  [[nodiscard]] static Point point_on(const PointNet& net, double x, double y) {
    std::array<glm::dvec3, 4> row, along;
    for (std::size_t j = 0; j < 4; ++j) {
      row[j] = bezier_blossom<3>(&net[4 * j], same_arguments(x));
      std::array<glm::dvec3, 3> steps;
      for (std::size_t i = 0; i < 3; ++i) steps[i] = net[i + 1 + 4 * j] - net[i + 4 * j];
      along[j] = bezier_blossom<2>(steps.data(), same_arguments(x));
    }
    std::array<glm::dvec3, 3> steps;
    for (std::size_t j = 0; j < 3; ++j) steps[j] = row[j + 1] - row[j];
    const BlossomArguments at_y = same_arguments(y);
    return {bezier_blossom<3>(row.data(), at_y), glm::cross(bezier_blossom<3>(along.data(), at_y),
                                                            bezier_blossom<2>(steps.data(), at_y))};
  }

  const CatmullClarkSplines& surface_;
  std::int32_t corner_ = -1;
  std::array<bool, 2> has_end_{};
  std::array<Star, 2> stars_;  // at V and F
  SquarePiece piece_;          // the regular one that was asked for; of size 0: none
};

}  // namespace

CatmullClarkSplines::CatmullClarkSplines(const PolygonMesh& cage, const EvaluateOptions& options)
    : used_(usable_part(cage, options.prepared)),
      split_(used_.mesh,
             {PrimalScheme::CatmullClark, options.sharp, used_.prepared->topology.get()}),
      placement_(placement_of(used_.mesh)),
      hidden_(hole_flags(used_.mesh)) {
  require_settled();
  require_memory(split_.counts_to(kLastLevel), LastLevel::Full, {}, options.memory_limit_bytes);
  split_.refine(kLastLevel);
  std::vector<glm::dvec3> unit;
  unit.reserve(used_.mesh.positions.size());
  for (const glm::dvec3& p : used_.mesh.positions) unit.push_back(placement_.to_unit(p));
  points_[1] = refined(1, unit);
  points_[2] = refined(2, points_[1]);
  find_singular();
}

// Sharpness falls by 1 a level, and is to be gone on M_1.
void CatmullClarkSplines::require_settled() const {
  const auto& mesh = split_.level(0);
  const auto require = [](float sharpness, const auto& name) {
    if (sharpness <= 1 || Crease::IsInfinite(sharpness)) return;
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", static_cast<double>(sharpness));
    throw Error(ErrorCode::UnusableMesh,
                formatted("{} has sharpness {}; of Catmull-Clark surfaces B-spline faces have such "
                          "up to 1, and 10, which stays sharp: tag it with one of these",
                          name(), text));
  };
  const auto given = [&](int vertex) { return std::to_string(used_.vertices[vertex]); };
  for (int e = 0; e < mesh.GetNumEdges(); ++e) {
    require(mesh.GetEdgeSharpness(e), [&] {
      const auto [first, second] =
          std::minmax({mesh.GetEdgeVertices(e)[0], mesh.GetEdgeVertices(e)[1]});
      return formatted("the edge between vertices {} and {}", given(first), given(second));
    });
  }
  for (int v = 0; v < mesh.GetNumVertices(); ++v)
    require(mesh.GetVertexSharpness(v), [&] { return "vertex " + given(v); });
}

RawVector<glm::dvec3> CatmullClarkSplines::refined(int level,
                                                   std::span<const glm::dvec3> points) const {
  constexpr std::int64_t kSliceRows = 1 << 17;
  const std::int64_t count = split_.level(level).GetNumVertices();
  RawVector<glm::dvec3> result(static_cast<std::size_t>(count));
  for (std::int64_t first = 0; first < count; first += kSliceRows) {
    check_stop();
    const StencilTable table =
        primal_refinement_table(split_, level - 1, {first, std::min(kSliceRows, count - first)});
    parallel_each(table.sizes.size(), 1024, [&](std::size_t row) {
      glm::dvec3 sum(0.0);
      const auto begin = static_cast<std::size_t>(table.offsets[row]);
      for (std::size_t k = begin; k < begin + static_cast<std::size_t>(table.sizes[row]); ++k)
        sum += table.weights[k] * points[table.indices[k]];
      result[static_cast<std::size_t>(first) + row] = sum;
    });
  }
  return result;
}

// A vertex of M_1 is regular, seen from a face, where that lies in a part of a bicubic B-spline.
void CatmullClarkSplines::find_singular() {
  const auto& level = split_.level(1);
  singular_.assign(static_cast<std::size_t>(topology().corner_count()), 0);
  parallel_for(singular_.size(), 1024, [&](std::size_t begin, std::size_t end) {
    VertexStar star;
    for (std::size_t c = begin; c < end; ++c) {
      const std::int32_t vertex = topology().vertex_of(static_cast<std::int32_t>(c));
      gather_star(split_, 1, vertex, star);
      const Crease::Rule rule = level.GetVertexRule(vertex);
      if (sector_count(star) == 1 && !star.is_boundary()) {
        singular_[c] = rule != Crease::RULE_SMOOTH || star.face_count != 4;
        continue;
      }
      const int place = level.GetVertexFaces(vertex).FindIndex(static_cast<int>(c));
      const std::int32_t faces = sector(star, sector_of(star, place)).face_count;
      singular_[c] = faces != (rule == Crease::RULE_CREASE ? 2 : 1);
    }
  });
}

bool CatmullClarkSplines::is_sharp(std::int32_t corner) const {
  const auto& level = split_.level(1);
  return level.GetEdgeSharpness(level.GetFaceEdges(corner)[place_of_vertex(corner)]) > 0;
}

float CatmullClarkSplines::vertex_sharpness(std::int32_t vertex) const {
  return split_.level(1).GetVertexSharpness(vertex);
}

// Vertices of M_1 begin with those of the mesh.
int CatmullClarkSplines::place_of_vertex(std::int32_t corner) const {
  return split_.level(1).GetFaceVertices(corner).FindIndex(topology().vertex_of(corner));
}

PointNet CatmullClarkSplines::whole_net(std::int32_t corner) const {
  return net_of(1, corner, place_of_vertex(corner));
}

PointNet CatmullClarkSplines::quarter_net(std::int32_t corner, int quarter) const {
  const auto& level = split_.level(1);
  const int place = (place_of_vertex(corner) + quarter) % 4;
  const int vertex = level.GetVertexChildVertex(level.GetFaceVertices(corner)[place]);
  const int face = level.GetFaceChildFaces(corner)[place];
  const int there = split_.level(2).GetFaceVertices(face).FindIndex(vertex);
  return net_of(2, face, (there + 4 - quarter) % 4);
}

std::array<glm::dvec3, 9> CatmullClarkSplines::points_on(std::int32_t corner) const {
  const auto& level = split_.level(1);
  const auto vertices = level.GetFaceVertices(corner), edges = level.GetFaceEdges(corner);
  const int first = place_of_vertex(corner);
  // Of vertex k and of the edge behind it, counter-clockwise from V.
  constexpr std::array<std::size_t, 4> kVertices{0, 2, 8, 6}, kEdges{1, 5, 7, 3};
  std::array<glm::dvec3, 9> points;
  const auto point = [&](int vertex) { return points_[2][vertex]; };
  for (int k = 0; k < 4; ++k) {
    const int place = (first + k) % 4;
    points[kVertices[k]] = point(level.GetVertexChildVertex(vertices[place]));
    points[kEdges[k]] = point(level.GetEdgeChildVertex(edges[place]));
  }
  points[4] = point(level.GetFaceChildVertex(corner));
  return points;
}

// Bezier points of a uniform bicubic B-spline: inside by thirds, then means of these.
PointNet CatmullClarkSplines::net_of(int level, int face, int first) const {
  constexpr std::array<std::size_t, 4> kCorner{0, 3, 15, 12}, kInner{5, 6, 10, 9},
      kBehind{1, 7, 14, 8}, kBefore{4, 2, 11, 13};
  const auto vertices = split_.level(level).GetFaceVertices(face);
  PointNet net{};
  for (int k = 0; k < 4; ++k) {
    const int place = (first + k) % 4;
    const auto i = static_cast<std::size_t>(k);
    net[kCorner[i]] = corner_point(level, vertices[place]);
    net[kInner[i]] = inner_point(level, face, place);
    net[kBehind[i]] = edge_point(level, face, place, (place + 1) % 4);
    net[kBefore[i]] = edge_point(level, face, place, (place + 3) % 4);
  }
  return net;
}

glm::dvec3 CatmullClarkSplines::inner_point(int level, int face, int place) const {
  const auto vertices = split_.level(level).GetFaceVertices(face);
  const auto& points = points_[level];
  const auto point = [&](int k) { return points[vertices[k % 4]]; };
  return (4.0 * point(place) + 2.0 * (point(place + 1) + point(place + 3)) + point(place + 2)) /
         9.0;
}

// Of an edge of the face, beside its vertex `place`.
glm::dvec3 CatmullClarkSplines::edge_point(int level, int face, int place, int towards) const {
  const auto& topology = split_.level(level);
  const auto vertices = topology.GetFaceVertices(face);
  const int edge = topology.GetFaceEdges(face)[(place + 1) % 4 == towards ? place : towards];
  if (topology.GetEdgeSharpness(edge) > 0) {
    const auto& points = points_[level];
    return (2.0 * points[vertices[place]] + points[vertices[towards]]) / 3.0;
  }
  const auto faces = topology.GetEdgeFaces(edge);
  const int other = faces[0] == face ? faces[1] : faces[0];
  const int there = topology.GetFaceVertices(other).FindIndex(vertices[place]);
  return 0.5 * (inner_point(level, face, place) + inner_point(level, other, there));
}

glm::dvec3 CatmullClarkSplines::corner_point(int level, int vertex) const {
  const auto& topology = split_.level(level);
  const auto& points = points_[level];
  const glm::dvec3 own = points[vertex];
  const Crease::Rule rule = topology.GetVertexRule(vertex);
  if (rule == Crease::RULE_CORNER) return own;
  glm::dvec3 sum(0.0);
  if (rule == Crease::RULE_CREASE) {
    const auto edges = topology.GetVertexEdges(vertex);
    for (int i = 0; i < edges.size(); ++i) {
      if (!(topology.GetEdgeSharpness(edges[i]) > 0)) continue;
      const auto ends = topology.GetEdgeVertices(edges[i]);
      sum += points[ends[0] == vertex ? ends[1] : ends[0]];
    }
    return (4.0 * own + sum) / 6.0;
  }
  const auto faces = topology.GetVertexFaces(vertex);
  const auto places = topology.GetVertexFaceLocalIndices(vertex);
  for (int i = 0; i < faces.size(); ++i) sum += inner_point(level, faces[i], places[i]);
  return 0.25 * sum;
}

std::unique_ptr<SplinePatch> CatmullClarkSplines::patch() const {
  return std::make_unique<CatmullClarkPatch>(*this);
}

}  // namespace planish
