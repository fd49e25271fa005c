// Fields on a surface by affine maps around its vertices, a derivation of our own. The gradient of
// a face's values is that of Gauss's theorem, and weights of faces around a vertex are those of N.
// Max, "Weights for Computing Vertex Normals from Facet Normals", Journal of Graphics Tools 4(2),
// 1999: inverse to the squares of both edges.
#include "planish/patches/chart_field.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <numeric>

#include "planish/core/parallel.h"

namespace planish {

namespace {

constexpr std::size_t kVertexGrain = 1024;
// 1 + the cosine between two planes, below which nothing is turned further.
constexpr double kLeastTurn = 0.1;
// Of what values change by along a seam, up to which both sides are one chart, moved: what numbers
// of 32 bits leave, and much less than what is seen.
constexpr double kMoved = 1e-4;
// Of the largest value: what numbers of 32 bits leave.
constexpr double kValueRounding = 1e-7;
// Of a triangle, of the squares of its sides, above which it has two sides.
constexpr double kLeastArea = 1e-9;

// A direction of the plane, as long as it was.
glm::dvec3 laid_flat(const glm::dvec3& edge, const glm::dvec3& normal) {
  const glm::dvec3 flat = edge - glm::dot(edge, normal) * normal;
  const double length = glm::length(flat);
  return length > 0 ? flat * (glm::length(edge) / length) : flat;
}

// How far towards a line a step leads from a triangle's corner at the origin: 1 on the line through
// its other two corners. 0 where the triangle is as good as a line, and says nothing.
double reach(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& step) {
  const auto cross = [](const glm::dvec2& p, const glm::dvec2& q) { return p.x * q.y - p.y * q.x; };
  const double area = cross(a, b), size = glm::dot(a, a) + glm::dot(b, b);
  return std::abs(area) > kLeastArea * size ? cross(step, b - a) / area : 0.0;
}

// Whether that is farther than the line.
bool is_past(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& step) {
  const auto cross = [](const glm::dvec2& p, const glm::dvec2& q) { return p.x * q.y - p.y * q.x; };
  const double area = cross(a, b), size = glm::dot(a, a) + glm::dot(b, b);
  if (std::abs(area) <= kLeastArea * size) return false;
  const double reached = cross(step, b - a);
  return area > 0 ? reached > area : reached < area;
}

// How far, seen along a normal.
double reach(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& step,
             const glm::dvec3& normal) {
  const double area = glm::dot(glm::cross(a, b), normal), size = glm::dot(a, a) + glm::dot(b, b);
  return std::abs(area) > kLeastArea * size ? glm::dot(glm::cross(step, b - a), normal) / area
                                            : 0.0;
}

// The curve's control point at the vertex towards the other end of a sharp edge.
std::int32_t curve_point(const PatchMesh& mesh, std::int32_t vertex, std::int32_t edge) {
  const MeshTopology& topology = mesh.topology();
  const std::int32_t end = topology.vertex_of(topology.corner_of(edge)) == vertex ? 0 : 1;
  return mesh.first_sharp() + 2 * mesh.features().sharp_of_edge[edge] + end;
}

glm::dvec3 limit_of(const PatchMesh& mesh, std::int32_t vertex,
                    std::span<const glm::dvec3> points) {
  const MeshTopology& topology = mesh.topology();
  const auto corners = topology.corners_at(vertex);
  if (corners.empty()) return glm::dvec3(0.0);
  const VertexKind kind = mesh.features().vertex_kinds[vertex];
  if (kind == VertexKind::Corner)
    return points[mesh.first_corner_vertex() + mesh.features().corner_of_vertex[vertex]];
  glm::dvec3 sum(0.0);
  std::int32_t count = 0;
  const glm::dvec3 origin = points[corners.front()];
  const auto add = [&](std::int32_t point) { sum += points[point] - origin, ++count; };
  for (const std::int32_t c : corners) {
    if (kind != VertexKind::Crease) {
      add(c);
      continue;
    }
    if (mesh.is_sharp(c)) add(curve_point(mesh, vertex, topology.edge_of(c)));
    if (topology.ccw(c) < 0) add(curve_point(mesh, vertex, topology.edge_of(topology.prev(c))));
  }
  return origin + sum / static_cast<double>(std::max(count, 1));
}

}  // namespace

RawVector<glm::dvec3> vertex_limits(const PatchMesh& mesh, std::span<const glm::dvec3> points) {
  RawVector<glm::dvec3> limits(static_cast<std::size_t>(mesh.topology().vertex_count()));
  parallel_each(limits.size(), kVertexGrain, [&](std::size_t v) {
    limits[v] = limit_of(mesh, static_cast<std::int32_t>(v), points);
  });
  return limits;
}

// The corners at a vertex and their pieces.
template <class Vector>
struct ChartField<Vector>::Around {
  std::span<const std::int32_t> corners;
  std::size_t first = 0;             // the corner behind a cut, where there is one
  std::vector<std::int32_t> piece;   // of each corner in the order of `corners`
  std::vector<std::int32_t> sector;  // likewise
  std::int32_t sector_count = 1, fan_count = 1;
  std::vector<Piece> pieces;
  // Of fans and of pieces: the first of those that differ by translations.
  std::vector<std::int32_t> fan_link, piece_link;
  std::vector<glm::dvec3> normals;  // of sectors

  // Scratch.
  std::vector<std::uint8_t> is_seam, is_sharp, is_moved;
  std::vector<double> weights, shares;  // of pieces
  std::vector<Vector> value_shares;     // likewise, of each number
  std::vector<Gradient> gradients;      // likewise
  std::vector<double> face_shares;      // of corners

  [[nodiscard]] std::size_t place_of(std::int32_t corner) const {
    return static_cast<std::size_t>(std::ranges::find(corners, corner) - corners.begin());
  }
  [[nodiscard]] std::int32_t fan_of(std::int32_t corner) const {
    return pieces[piece[place_of(corner)]].fan;
  }
};

// Between a corner and the one behind it around their vertex. Where both sides have the same values
// by indices of their own, there is a seam if they are mirrored.
template <class Vector>
bool ChartField<Vector>::is_seam(std::int32_t corner, std::int32_t next, bool is_mirrored) const {
  const auto differs = [&](std::int32_t a, std::int32_t b) {
    return indices_[a] != indices_[b] && (is_mirrored || given(a) != given(b));
  };
  return differs(corner, next) || differs(topology_.prev(corner), topology_.next(next));
}

// Whether the values behind a seam are those before it, moved.
template <class Vector>
bool ChartField<Vector>::is_moved(std::int32_t corner, std::int32_t next) const {
  const Vector before = given(topology_.prev(corner)) - given(corner),
               behind = given(topology_.next(next)) - given(next);
  return glm::distance(before, behind) <= kMoved * (glm::length(before) + glm::length(behind));
}

// Whether from the face of a corner to that of the one behind it, across a seam, the values change
// by no more than within the charts that the faces are of: a chart of one affine map stays that.
template <class Vector>
bool ChartField<Vector>::goes_on(std::int32_t corner, std::int32_t next,
                                 std::span<const Integral> faces) const {
  // The lengths of two faces' mean gradients and of their difference, laid flat; and what that
  // leaves open, in parts of the lengths.
  struct Change {
    double size = 0, difference = 0, bend = 0;
  };
  const auto length_of = [](const Gradient& gradient) {
    double square = 0;
    for (const Vector& of_axis : gradient) square += glm::dot(of_axis, of_axis);
    return std::sqrt(square);
  };
  const auto change = [&](const Integral& a, const Integral& b) {
    const glm::dvec3 sum = glm::dvec3(a.normal) + glm::dvec3(b.normal);
    const double length = glm::length(sum);
    if (!(length > 0 && a.area > 0 && b.area > 0)) return Change{};
    Gradient of_a = turned(a, sum / length), of_b = turned(b, sum / length), apart;
    for (std::size_t k = 0; k < 3; ++k) {
      of_a[k] /= double{a.area};
      of_b[k] /= double{b.area};
      apart[k] = of_a[k] - of_b[k];
    }
    return Change{length_of(of_a) + length_of(of_b), length_of(apart), 1 - length / 2};
  };
  const auto within = [&](std::int32_t face) {
    double largest = 0;
    const std::int32_t first = topology_.first_corner(face);
    for (std::int32_t c = first; c < first + topology_.face_size(face); ++c) {
      const std::int32_t across = topology_.ccw(c);
      if (across < 0 || mesh_.is_sharp(across) || is_seam(c, across, false)) continue;
      largest = std::max(largest, change(faces[face], faces[topology_.face_of(across)]).difference);
    }
    return largest;
  };
  const std::int32_t before = topology_.face_of(corner), behind = topology_.face_of(next);
  const Change across = change(faces[before], faces[behind]);
  return across.difference <=
         within(before) + within(behind) + (kMoved + across.bend) * across.size;
}

// The integral of a face's gradient, turned into the plane of a unit normal.
template <class Vector>
auto ChartField<Vector>::turned(const Integral& face, const glm::dvec3& normal) -> Gradient {
  Gradient gradient = {Vector(face.gradient[0]), Vector(face.gradient[1]),
                       Vector(face.gradient[2])};
  const glm::dvec3 own(face.normal);
  const Vector turn = times(gradient, normal) / std::max(1 + glm::dot(own, normal), kLeastTurn);
  for (int k = 0; k < 3; ++k) gradient[static_cast<std::size_t>(k)] -= (own + normal)[k] * turn;
  return gradient;
}

template <class Vector>
auto ChartField<Vector>::integral_over(std::int32_t face) const -> Integral {
  Integral made;
  const std::int32_t first = topology_.first_corner(face), size = topology_.face_size(face);
  const auto at = [&](std::int32_t i) {
    return limits_[topology_.vertex_of(first + (i == size ? 0 : i))];
  };
  const glm::dvec3 origin = at(0);
  glm::dvec3 normal(0.0);
  for (std::int32_t i = 1; i + 1 < size; ++i)
    normal += 0.5 * glm::cross(at(i) - origin, at(i + 1) - origin);
  const double area = glm::length(normal);
  const Vector value = given(first);
  for (std::int32_t i = 1; kIsCoordinates && i + 1 < size; ++i) {
    const Vector a = given(first + i) - value, b = given(first + i + 1) - value;
    made.turn += static_cast<typename Integral::Real>(a.x * b.y - a.y * b.x);
  }
  if (!(area > 0)) return {};
  normal /= area;
  Gradient gradient{};
  for (std::int32_t i = 0; i < size; ++i) {
    const Vector mean =
        0.5 * ((given(first + i) - value) + (given(first + (i + 1 == size ? 0 : i + 1)) - value));
    const glm::dvec3 outward = glm::cross(at(i + 1) - at(i), normal);
    for (int k = 0; k < 3; ++k) gradient[static_cast<std::size_t>(k)] += outward[k] * mean;
  }
  made.normal = normal;
  made.area = static_cast<typename Integral::Real>(area);
  for (std::size_t k = 0; k < 3; ++k) made.gradient[k] = Stored(gradient[k]);
  return made;
}

// Of what a face has at its corners, seen from an origin.
template <class Vector>
template <class Value, class At>
Value ChartField<Vector>::face_mean(std::int32_t face, const Value& origin, const At& at) const {
  const std::int32_t first = topology_.first_corner(face), size = topology_.face_size(face);
  Value sum(0.0);
  for (std::int32_t k = first; k < first + size; ++k) sum += at(k) - origin;
  return sum / static_cast<double>(size);
}

template <class Vector>
std::int32_t ChartField<Vector>::curve_at(std::int32_t vertex, std::int32_t edge) const {
  return curve_point(mesh_, vertex, edge);
}

template <class Vector>
void ChartField<Vector>::cut(std::int32_t vertex, std::span<const Integral> faces,
                             Around& around) const {
  const auto corners = around.corners = topology_.corners_at(vertex);
  const std::size_t n = corners.size();
  const VertexKind kind = mesh_.features().vertex_kinds[vertex];
  const bool has_sectors = kind == VertexKind::Crease || kind == VertexKind::Corner;
  around.is_seam.assign(n, 0);
  around.is_sharp.assign(n, 0);
  around.is_moved.assign(n, 0);
  around.piece.assign(n, 0);
  around.sector.assign(n, 0);
  around.pieces.clear();
  std::int32_t seams = 0, sharps = 0;
  std::size_t first = 0;
  bool begins_at_seam = false;
  for (std::size_t i = 0; i < n; ++i) {  // between i and the corner behind it
    const std::size_t next = i + 1 < n ? i + 1 : 0;
    const bool joined = topology_.ccw(corners[i]) == corners[next] && n > 1;
    // Mirrored charts go on the other way.
    const bool is_mirrored =
        faces[topology_.face_of(corners[i])].turn * faces[topology_.face_of(corners[next])].turn <
        0;
    if (!joined || is_seam(corners[i], corners[next], is_mirrored)) {
      around.is_seam[next] = 1, ++seams;
      around.is_moved[next] = joined && !is_mirrored && !mesh_.is_sharp(corners[next]) &&
                              is_moved(corners[i], corners[next]) &&
                              goes_on(corners[i], corners[next], faces);
      if (!begins_at_seam) first = next, begins_at_seam = true;
    }
    if (!joined || (has_sectors && mesh_.is_sharp(corners[next]))) {
      around.is_sharp[next] = 1, ++sharps;
      if (!begins_at_seam) first = next;
    }
  }
  around.first = first;
  around.fan_count = std::max(seams, 1);
  around.sector_count = std::max(sharps, 1);
  std::int32_t sector = 0, fan = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t i = (first + k) % n;
    const bool is_seam = around.is_seam[i] != 0, is_sharp = around.is_sharp[i] != 0;
    if (k > 0 && is_sharp) sector = (sector + 1) % around.sector_count;
    if (k == 0 || is_seam) fan = static_cast<std::int32_t>(around.pieces.size());
    if (k == 0 || is_seam || is_sharp) {
      Piece& piece = around.pieces.emplace_back();
      piece.vertex = vertex;
      piece.fan = fan;
      piece.at = limits_[vertex];
      piece.value = given(corners[i]);
    }
    around.piece[i] = static_cast<std::int32_t>(around.pieces.size()) - 1;
    around.sector[i] = sector;
  }
  // Links of what differs by translations.
  around.fan_link.resize(around.pieces.size());
  std::iota(around.fan_link.begin(), around.fan_link.end(), 0);
  around.piece_link = around.fan_link;
  const auto join = [](std::vector<std::int32_t>& links, std::int32_t a, std::int32_t b) {
    const auto [low, high] = std::minmax(links[a], links[b]);
    std::ranges::replace(links, std::int32_t{high}, std::int32_t{low});
  };
  for (std::size_t i = 0; i < n; ++i) {
    if (around.is_moved[i] == 0) continue;
    const std::int32_t before = around.piece[i > 0 ? i - 1 : n - 1], behind = around.piece[i];
    join(around.fan_link, around.pieces[before].fan, around.pieces[behind].fan);
    join(around.piece_link, before, behind);
  }
}

// The gradients of pieces: those of their faces, turned into the plane of the sector.
template <class Vector>
void ChartField<Vector>::fit(std::span<const Integral> faces, Around& around) const {
  const std::size_t n = around.corners.size();
  around.face_shares.resize(n);
  around.normals.assign(static_cast<std::size_t>(around.sector_count), glm::dvec3(0.0));
  around.weights.assign(around.pieces.size(), 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    const std::int32_t c = around.corners[i];
    const Integral& face = faces[topology_.face_of(c)];
    const glm::dvec3& at = around.pieces.front().at;
    const glm::dvec3 next = limits_[topology_.vertex_of(topology_.next(c))] - at;
    const glm::dvec3 prev = limits_[topology_.vertex_of(topology_.prev(c))] - at;
    const double square = glm::dot(next, next) * glm::dot(prev, prev), area = face.area;
    // Areas, but of large polygons no more than beside the vertex.
    const double share =
        area > 0 && square > 0 ? std::min(1.0, std::sqrt(square) / area) / square : 0.0;
    around.face_shares[i] = share;
    around.weights[around.piece_link[around.piece[i]]] += share * area;
    around.normals[around.sector[i]] += share * area * glm::dvec3(face.normal);
  }
  for (glm::dvec3& normal : around.normals) {
    const double length = glm::length(normal);
    if (length > 0) normal /= length;
  }
  around.gradients.assign(around.pieces.size(), Gradient{});
  for (std::size_t i = 0; i < n; ++i) {
    const Integral& face = faces[topology_.face_of(around.corners[i])];
    const glm::dvec3& normal = around.normals[around.sector[i]];
    const std::int32_t link = around.piece_link[around.piece[i]];
    const double weight = around.weights[link];
    const double share = weight > 0 ? around.face_shares[i] / weight : 0.0;
    const Gradient of_face = turned(face, normal);
    Gradient& gradient = around.gradients[link];
    for (std::size_t k = 0; k < 3; ++k) gradient[k] += share * of_face[k];
  }
  for (std::size_t p = 0; p < around.pieces.size(); ++p)
    around.pieces[p].gradient = around.gradients[around.piece_link[p]];
  if (around.pieces.size() == 1) {
    around.pieces[0].of_fan = around.pieces[0].gradient;
    return;
  }
  // The mean of those of fans that are linked.
  around.gradients.assign(around.pieces.size(), Gradient{});
  around.weights.assign(around.pieces.size(), 0.0);
  for (const Piece& piece : around.pieces) {
    const std::int32_t link = around.fan_link[piece.fan];
    for (std::size_t k = 0; k < 3; ++k) around.gradients[link][k] += piece.gradient[k];
    ++around.weights[link];
  }
  for (Piece& piece : around.pieces) {
    const std::int32_t link = around.fan_link[piece.fan];
    for (std::size_t k = 0; k < 3; ++k)
      piece.of_fan[k] = around.gradients[link][k] / around.weights[link];
  }
}

// Of crease vertices: what a chart has at the curve points, by its values along the curve.
template <class Vector>
void ChartField<Vector>::find_handles(std::int32_t vertex, std::span<const glm::dvec3> points,
                                      Around& around) const {
  // The curve's two edges, with corners at the vertex that they belong to, and at the other end.
  struct Side {
    std::int32_t corner, other;
  };
  struct Arm {
    std::int32_t curve = -1;
    glm::dvec3 edge{0.0};
    std::vector<Side> sides;
  };
  std::vector<Arm> arms;
  const auto add = [&](std::int32_t edge, std::int32_t other) -> Arm& {
    arms.push_back(
        {curve_at(vertex, edge), limits_[topology_.vertex_of(other)] - limits_[vertex], {}});
    return arms.back();
  };
  for (const std::int32_t c : around.corners) {
    if (mesh_.is_sharp(c)) {
      Arm& arm = add(topology_.edge_of(c), topology_.next(c));
      arm.sides.push_back({c, topology_.next(c)});
      if (const std::int32_t before = topology_.cw(c); before >= 0)
        arm.sides.push_back({before, topology_.prev(before)});
    }
    if (topology_.ccw(c) < 0)
      add(topology_.edge_of(topology_.prev(c)), topology_.prev(c))
          .sides.push_back({c, topology_.prev(c)});
  }
  if (arms.size() != 2) return;
  const glm::dvec3 handle = points[arms[0].curve] - limits_[vertex];
  std::vector<Vector> sums(around.pieces.size(), Vector(0.0));
  std::vector<std::int32_t> count(around.pieces.size(), 0);
  for (std::size_t i = 0; i < around.corners.size(); ++i) {
    const std::size_t p = static_cast<std::size_t>(around.piece[i]);
    if (i != around.first &&
        around.piece[(i + around.corners.size() - 1) % around.corners.size()] == around.piece[i])
      continue;  // once a piece
    const Piece& piece = around.pieces[p];
    const std::int32_t link = around.fan_link[piece.fan];
    const glm::dvec3& normal = around.normals[around.sector[i]];
    glm::dvec3 along(0.0);
    Vector change(0.0);
    for (std::size_t a = 0; a < 2; ++a) {
      for (const Side& side : arms[a].sides) {
        if (around.fan_link[around.fan_of(side.corner)] != link) continue;
        const double sign = a == 0 ? 1 : -1;
        along += sign * laid_flat(arms[a].edge, normal);
        change += sign * (given(side.other) - given(side.corner));
        break;
      }
    }
    const glm::dvec3 flat = handle - glm::dot(handle, normal) * normal;
    const double square = glm::dot(along, along);
    const double share = square > 0 ? glm::dot(flat, along) / square : 0.0;
    sums[link] += share * change + times(piece.gradient, flat - share * along);
    ++count[link];
  }
  for (Piece& piece : around.pieces) {
    piece.curve0 = arms[0].curve;
    const std::int32_t link = around.fan_link[piece.fan];
    piece.handle = sums[link] / static_cast<double>(std::max(count[link], 1));
  }
}

template <class Vector>
void ChartField<Vector>::shrink(std::span<const glm::dvec3> points, std::span<const Integral> faces,
                                Around& around) const {
  if constexpr (kIsCoordinates) {
    shrink_to_faces(points, faces, around);
  } else {
    shrink_to_ranges(points, around);
  }
}

// Each control value reaches no further than the line from the middle of its face to that of an
// edge, as it does by far on regular meshes; one share for all that a chart has here, so that it
// stays one map.
template <class Vector>
void ChartField<Vector>::shrink_to_faces(std::span<const glm::dvec3> points,
                                         std::span<const Integral> faces,
                                         Around& around) const requires kIsCoordinates {
  around.shares.assign(around.pieces.size(), 1.0);
  bool shrinks = false;
  for (std::size_t i = 0; i < around.corners.size(); ++i) {
    const std::int32_t c = around.corners[i], face = topology_.face_of(c);
    const Piece& piece = around.pieces[around.piece[i]];
    const glm::dvec3 step = points[c] - piece.at;
    const Vector change = times(piece.gradient, step);
    const Vector middle =
        face_mean<Vector>(face, piece.value, [&](std::int32_t k) { return given(k); });
    for (const std::int32_t other : {topology_.next(c), topology_.prev(c)}) {
      const Vector half = 0.5 * (given(other) - piece.value);
      if (!is_past(half, middle, change)) continue;
      const double reached = reach(half, middle, change);
      const auto limit_at = [&](std::int32_t k) { return limits_[topology_.vertex_of(k)]; };
      const double of_point =
          reach(0.5 * (limit_at(other) - piece.at), face_mean<glm::dvec3>(face, piece.at, limit_at),
                step, faces[face].normal);
      double& share = around.shares[around.fan_link[piece.fan]];
      share = std::min(share, std::max(1.0, of_point) / reached);
      shrinks = true;
    }
  }
  if (!shrinks) return;
  for (Piece& piece : around.pieces) {
    const double share = around.shares[around.fan_link[piece.fan]];
    for (Vector& of_axis : piece.gradient) of_axis *= share;
    for (Vector& of_axis : piece.of_fan) of_axis *= share;
    piece.handle *= share;
  }
}

// What a step from a corner's vertex changes values by where they change linearly along both of the
// corner's edges.
template <class Vector>
Vector ChartField<Vector>::along_edges(std::int32_t corner, const glm::dvec3& step) const {
  const std::int32_t vertex = topology_.vertex_of(corner);
  const auto to = [&](std::int32_t other) {
    return limits_[topology_.vertex_of(other)] - limits_[vertex];
  };
  const std::int32_t next = topology_.next(corner), prev = topology_.prev(corner);
  const glm::dvec3 a = to(next), b = to(prev);
  const double aa = glm::dot(a, a), ab = glm::dot(a, b), bb = glm::dot(b, b),
               area = aa * bb - ab * ab;
  if (!(area > kLeastArea * aa * bb)) return Vector(0.0);
  const double along_a = glm::dot(step, a), along_b = glm::dot(step, b);
  return (along_a * bb - along_b * ab) / area * (given(next) - given(corner)) +
         (along_b * aa - along_a * ab) / area * (given(prev) - given(corner));
}

// To what the face has at its other corners, or as far as its own map goes; one share for all that
// a chart has here, so that it stays one map.
template <class Vector>
void ChartField<Vector>::shrink_to_ranges(std::span<const glm::dvec3> points, Around& around) const
    requires(!kIsCoordinates) {
  around.value_shares.assign(around.pieces.size(), Vector(1.0));
  bool shrinks = false;
  const auto keep = [&](std::int32_t corner, const Piece& piece, const glm::dvec3& step,
                        const Vector& change) {
    const Vector value = piece.value + change;
    Vector lowest = piece.value, highest = piece.value;
    const auto may_be = [&](const Vector& other) {
      lowest = glm::min(lowest, other);
      highest = glm::max(highest, other);
    };
    const Vector slack = kValueRounding * glm::max(glm::abs(lowest_), glm::abs(highest_));
    const auto excess = [&] { return glm::abs(value - glm::clamp(value, lowest, highest)); };
    const auto is_within = [&] { return glm::all(glm::lessThanEqual(excess(), slack)); };
    const std::int32_t face = topology_.face_of(corner), first = topology_.first_corner(face);
    for (std::int32_t k = first; k < first + topology_.face_size(face); ++k) may_be(given(k));
    if (is_within()) return;
    may_be(piece.value + along_edges(corner, step));
    if (is_within()) return;
    const Vector bound = glm::clamp(value, lowest, highest) - piece.value, beyond = excess();
    Vector& shares = around.value_shares[around.fan_link[piece.fan]];
    for (int k = 0; k < Vector::length(); ++k) {
      if (beyond[k] <= slack[k]) continue;
      for (int other = 0; other < Vector::length(); ++other)
        if (attributes_[static_cast<std::size_t>(other)] ==
            attributes_[static_cast<std::size_t>(k)])
          shares[other] = std::min(shares[other], bound[k] / change[k]);
    }
    shrinks = true;
  };
  for (std::size_t i = 0; i < around.corners.size(); ++i) {
    const std::int32_t c = around.corners[i];
    const Piece& piece = around.pieces[around.piece[i]];
    const glm::dvec3 step = points[c] - piece.at;
    keep(c, piece, step, times(piece.gradient, step));
    if (piece.curve0 < 0) continue;
    const auto keep_curve = [&](std::int32_t edge) {
      const std::int32_t curve = curve_at(piece.vertex, edge);
      keep(c, piece, points[curve] - piece.at,
           curve == piece.curve0 ? piece.handle : -piece.handle);
    };
    const std::int32_t behind = topology_.ccw(c);
    if (mesh_.is_sharp(c)) keep_curve(topology_.edge_of(c));
    if (behind < 0 || mesh_.is_sharp(behind)) keep_curve(topology_.edge_of(topology_.prev(c)));
  }
  if (!shrinks) return;
  for (Piece& piece : around.pieces) {
    const Vector& shares = around.value_shares[around.fan_link[piece.fan]];
    for (Vector& of_axis : piece.gradient) of_axis *= shares;
    for (Vector& of_axis : piece.of_fan) of_axis *= shares;
    piece.handle *= shares;
  }
}

// At corner vertices by the value at the edge's other end, where the chart has it.
template <class Vector>
template <class FanOf>
Vector ChartField<Vector>::curve_value(const Piece& piece, std::int32_t curve,
                                       const glm::dvec3& point, const FanOf& fan_of) const {
  const VertexKind kind = mesh_.features().vertex_kinds[piece.vertex];
  if (kind == VertexKind::Crease)
    return piece.value + (curve == piece.curve0 ? piece.handle : -piece.handle);
  const glm::dvec3 offset = point - piece.at;
  const auto by_edge = [&](std::int32_t corner, std::int32_t other, Vector& value) {
    if (fan_of(corner) != piece.fan) return false;
    const glm::dvec3 edge = limits_[topology_.vertex_of(other)] - piece.at;
    const double square = glm::dot(edge, edge);
    const double share = square > 0 ? glm::dot(offset, edge) / square : 0.0;
    value = piece.value + share * (given(other) - piece.value) +
            times(piece.of_fan, offset - share * edge);
    return true;
  };
  if (kind == VertexKind::Corner) {
    const std::int32_t place = curve - mesh_.first_sharp();
    const std::int32_t tail = topology_.corner_of(edge_of_sharp_[place / 2]),
                       head = topology_.next(tail), twin = topology_.twin(tail);
    const bool at_tail = place % 2 == 0;
    Vector value(0.0);
    if (by_edge(at_tail ? tail : head, at_tail ? head : tail, value)) return value;
    if (twin >= 0) {
      const std::int32_t across = topology_.next(twin);
      if (by_edge(at_tail ? across : twin, at_tail ? twin : across, value)) return value;
    }
  }
  return piece.value + times(piece.of_fan, offset);
}

// Control values as they are seen from where there is no seam.
template <class Vector>
void ChartField<Vector>::write_own(std::int32_t vertex, std::span<const glm::dvec3> points,
                                   const Around& around) {
  for (std::size_t i = 0; i < around.corners.size(); ++i) {
    const std::int32_t c = around.corners[i];
    const Piece& piece = around.pieces[around.piece[i]];
    own_[c] = Stored(piece.map(points[c]));
    const auto write = [&](std::int32_t edge) {
      const std::int32_t curve = curve_at(vertex, edge);
      own_[curve] = Stored(curve_value(piece, curve, points[curve],
                                       [&](std::int32_t corner) { return around.fan_of(corner); }));
    };
    if (mesh_.is_sharp(c)) write(topology_.edge_of(c));
    if (topology_.ccw(c) < 0) write(topology_.edge_of(topology_.prev(c)));
  }
  if (mesh_.features().vertex_kinds[vertex] == VertexKind::Corner)
    own_[mesh_.first_corner_vertex() + mesh_.features().corner_of_vertex[vertex]] =
        Stored(around.pieces.front().value);
}

template <class Vector>
ChartField<Vector>::ChartField(const PatchMesh& mesh, std::span<const glm::dvec3> points,
                               std::span<const std::int32_t> indices,
                               std::span<const Stored> values, std::span<const glm::dvec3> limits,
                               const std::array<int, 4>& attributes,
                               std::span<const Stored> elsewhere)
    : mesh_(mesh),
      topology_(mesh.topology()),
      indices_(indices),
      values_(values),
      attributes_(attributes) {
  if (!values.empty()) lowest_ = highest_ = Vector(values.front());
  for (const std::span<const Stored> all : {values, elsewhere})
    for (const Stored& value : all) {
      lowest_ = glm::min(lowest_, Vector(value));
      highest_ = glm::max(highest_, Vector(value));
    }
  edge_of_sharp_.resize(static_cast<std::size_t>(mesh.features().sharp_edge_count));
  for (std::size_t e = 0; e < mesh.features().sharp_of_edge.size(); ++e)
    if (const std::int32_t sharp = mesh.features().sharp_of_edge[e]; sharp >= 0)
      edge_of_sharp_[sharp] = static_cast<std::int32_t>(e);
  const auto vertices = static_cast<std::size_t>(topology_.vertex_count());
  if (limits.empty()) {
    limits_ = vertex_limits(mesh, points);
  } else {
    limits_.resize(vertices);
    std::ranges::copy(limits, limits_.begin());
  }
  RawVector<Integral> faces(static_cast<std::size_t>(topology_.face_count()));
  parallel_each(faces.size(), kVertexGrain,
                [&](std::size_t f) { faces[f] = integral_over(static_cast<std::int32_t>(f)); });
  own_.resize(static_cast<std::size_t>(mesh.point_count()));
  RawVector<std::int32_t> first_piece(vertices + 1);
  std::ranges::fill(first_piece, 0);
  // Their pieces are made again, where there are any to be kept.
  const auto around_all = [&](const auto& is_wanted, const auto& visit) {
    parallel_for(vertices, kVertexGrain, [&](std::size_t begin, std::size_t end) {
      Around around;
      for (auto v = static_cast<std::int32_t>(begin); v < static_cast<std::int32_t>(end); ++v) {
        if (topology_.corners_at(v).empty() || !is_wanted(v)) continue;
        cut(v, faces, around);
        fit(faces, around);
        if (mesh_.features().vertex_kinds[v] == VertexKind::Crease) find_handles(v, points, around);
        shrink(points, faces, around);
        visit(v, around);
      }
    });
  };
  around_all([](std::int32_t) { return true; },
             [&](std::int32_t v, const Around& around) {
               write_own(v, points, around);
               if (around.fan_count > 1)
                 first_piece[v + 1] = static_cast<std::int32_t>(around.pieces.size());
             });
  for (std::size_t v = 0; v < vertices; ++v) first_piece[v + 1] += first_piece[v];
  if (first_piece[vertices] > 0) {
    pieces_.resize(static_cast<std::size_t>(first_piece[vertices]));
    piece_of_corner_.resize(static_cast<std::size_t>(topology_.corner_count()));
    std::ranges::fill(piece_of_corner_, -1);
    points_.resize(points.size());
    std::ranges::copy(points, points_.begin());
    around_all([&](std::int32_t v) { return first_piece[v + 1] > first_piece[v]; },
               [&](std::int32_t v, const Around& around) {
                 for (std::size_t p = 0; p < around.pieces.size(); ++p) {
                   Piece& piece = pieces_[first_piece[v] + static_cast<std::int32_t>(p)];
                   piece = around.pieces[p];
                   piece.fan += first_piece[v];
                 }
                 for (std::size_t i = 0; i < around.corners.size(); ++i)
                   piece_of_corner_[around.corners[i]] = first_piece[v] + around.piece[i];
               });
  } else {
    limits_ = {};
  }
  if (mesh_.has_sums()) add_sums();
}

template <class Vector>
void ChartField<Vector>::add_sums() {
  RawVector<glm::dvec3> three(own_.size());
  for (int first = 0; first < Vector::length(); first += 3) {
    const int count = std::min(3, Vector::length() - first);
    for (std::size_t i = 0; i < three.size(); ++i)
      for (int k = 0; k < 3; ++k) three[i][k] = k < count ? own_[i][first + k] : 0.0;
    mesh_.update_sums(three);
    for (auto i = static_cast<std::size_t>(mesh_.state_size()); i < three.size(); ++i)
      for (int k = 0; k < count; ++k)
        own_[i][first + k] = static_cast<typename Stored::value_type>(three[i][k]);
  }
}

template <class Vector>
Vector ChartField<Vector>::on_piece(std::int32_t piece, std::int32_t point) const {
  const Piece& of = pieces_[piece];
  if (point < topology_.corner_count()) return of.map(points_[point]);
  if (point < mesh_.first_corner_vertex())
    return curve_value(of, point, points_[point],
                       [&](std::int32_t corner) { return pieces_[piece_of_corner_[corner]].fan; });
  if (point < mesh_.state_size()) return of.value;
  return sum_on_piece(piece, point);
}

template <class Vector>
Vector ChartField<Vector>::sum_on_piece(std::int32_t piece, std::int32_t sum) const {
  const LargeRing& ring = mesh_.ring_of_sum(sum);
  // Weights of a sum add up to 1.
  if (!ring.is_sector()) return pieces_[piece].map(points_[sum]);
  std::vector<std::int32_t> points;
  mesh_.ring_points(ring, points);
  const std::vector<double> weights = sum_weights(ring, sum - ring.first_sum);
  Vector value(0.0);
  for (std::size_t k = 0; k < points.size(); ++k) value += weights[k] * on_piece(piece, points[k]);
  return value;
}

// Of a point that the face of a corner asks for, whose patch it is or whose edge's.
template <class Vector>
Vector ChartField<Vector>::column(std::int32_t point, std::int32_t corner) const {
  std::int32_t vertex = topology_.vertex_of(corner);
  if (point < topology_.corner_count()) {
    vertex = topology_.vertex_of(point);
  } else if (point < mesh_.first_corner_vertex()) {
    const std::int32_t place = point - mesh_.first_sharp();
    const std::int32_t tail = topology_.corner_of(edge_of_sharp_[place / 2]);
    vertex = topology_.vertex_of(place % 2 == 0 ? tail : topology_.next(tail));
  } else if (point >= mesh_.state_size() && mesh_.is_face_ring(mesh_.ring_of_sum(point))) {
    return Vector(own_[point]);
  }
  for (const std::int32_t seen : {corner, topology_.next(corner), topology_.prev(corner)}) {
    if (topology_.vertex_of(seen) != vertex) continue;
    const std::int32_t piece = piece_of_corner_[seen];
    const bool is_own =
        piece < 0 || (point < topology_.corner_count() && piece_of_corner_[point] == piece);
    return is_own ? Vector(own_[point]) : on_piece(piece, point);
  }
  return Vector(own_[point]);
}

template <class Vector>
void ChartField<Vector>::columns(const PatchPlace& place, std::int32_t corner,
                                 std::vector<std::int32_t>& indices,
                                 std::vector<Vector>& values) const {
  indices.resize(static_cast<std::size_t>(place.patch.column_count()));
  values.resize(indices.size());
  mesh_.gather(place, indices.data(), 1);
  const bool at_seam =
      !piece_of_corner_.empty() &&
      (piece_of_corner_[corner] >= 0 || piece_of_corner_[topology_.next(corner)] >= 0 ||
       piece_of_corner_[topology_.prev(corner)] >= 0);
  for (std::size_t k = 0; k < indices.size(); ++k)
    values[k] = at_seam ? column(indices[k], corner) : Vector(own_[indices[k]]);
}

template class ChartField<glm::dvec2>;
template class ChartField<glm::dvec4>;

}  // namespace planish
