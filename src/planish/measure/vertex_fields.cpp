#include "planish/measure/vertex_fields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <numbers>
#include <span>
#include <tuple>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/group_by.h"
#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/core/raw_vector.h"
#include "planish/core/work.h"
#include "planish/measure/figures.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/patches/patch_form.h"
#include "planish/patches/patch_plan.h"
#include "planish/surface/level_faces.h"
#include "planish/surface/surface_blocks.h"

namespace planish {
namespace {

// Based on: Rusinkiewicz, "Estimating Curvatures and Their Derivatives on Triangle Meshes", 2004:
// a symmetric 2 x 2 form in the tangent plane, fitted to finite differences of normals. Here per
// vertex over the edges that leave it, since the normals are exact at vertices.

// Below this the edges around a vertex leave the form open: two directions only, or none. Rows are
// of unit size, so the determinant of a full set is of order 1.
constexpr double kOpenForm = 1e-9;

// Of a large face's other corners so many are asked, evenly spaced: all of them for each of them
// would take the square of its size.
constexpr std::size_t kMostOthers = 32;

struct FaceCorner {
  std::int32_t face, place;
};

Groups<FaceCorner> corners_by_vertex(const SurfaceMesh& surface) {
  return group_by<FaceCorner>(surface.positions.size(), [&](const auto& take) {
    for (std::int64_t f = 0; f < surface.face_count(); ++f) {
      std::int32_t place = 0;
      for (const std::int32_t v : surface.face(f))
        take(v, FaceCorner{static_cast<std::int32_t>(f), place++});
    }
  });
}

struct Tangents {
  glm::dvec3 u, v;
};

Tangents tangents_of(const glm::dvec3& normal) {
  const glm::dvec3 axis = std::abs(normal.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 u = glm::normalize(glm::cross(normal, axis));
  return {u, glm::cross(normal, u)};
}

// Normal equations of E x^2 + 2 F x y + G y^2 = curvature.
struct FormFit {
  std::array<double, 6> matrix{};  // upper triangle by rows
  std::array<double, 3> right{};

  void add(double x, double y, double curvature) {
    const std::array<double, 3> row{x * x, 2 * x * y, y * y};
    int at = 0;
    for (int r = 0; r < 3; ++r) {
      for (int c = r; c < 3; ++c) matrix[at++] += row[r] * row[c];
      right[r] += row[r] * curvature;
    }
  }

  // {E, F, G}; zeros where the form is open.
  [[nodiscard]] std::array<double, 3> solve() const {
    const auto& [a, b, c, d, e, f] = matrix;
    const auto& [p, q, r] = right;
    const double determinant = a * (d * f - e * e) - b * (b * f - e * c) + c * (b * e - d * c);
    if (std::abs(determinant) < kOpenForm) return {};
    return {(p * (d * f - e * e) - b * (q * f - e * r) + c * (q * e - d * r)) / determinant,
            (a * (q * f - e * r) - p * (b * f - e * c) + c * (b * r - q * c)) / determinant,
            (a * (d * r - q * e) - b * (b * r - q * c) + p * (b * e - d * c)) / determinant};
  }
};

std::array<double, 3> form_at(const SurfaceMesh& surface, std::size_t vertex,
                              std::span<const FaceCorner> corners, std::int64_t& asked) {
  const glm::dvec3 normal(surface.normals[vertex]);
  const Tangents tangents = tangents_of(normal);
  FormFit fit;
  const auto add = [&](std::int32_t other) {
    const glm::dvec3 along = surface.positions[other] - surface.positions[vertex];
    const double square = glm::dot(along, along);
    double x = glm::dot(along, tangents.u), y = glm::dot(along, tangents.v);
    const double length = portable::hypot(x, y);
    if (!(length > 0)) return;
    x /= length;
    y /= length;
    fit.add(x, y, glm::dot(glm::dvec3(surface.normals[other]) - normal, along) / square);
  };
  for (const auto& [f, place] : corners) {
    // The other corners of a quad: both neighbours, and the diagonal, without which a grid's two
    // directions would leave the mixed term open.
    const auto face = surface.face(f);
    const std::size_t others = face.size() - 1;
    asked += static_cast<std::int64_t>(std::min(others, kMostOthers));
    if (others <= kMostOthers) {
      for (const std::int32_t other : face) add(other);
      continue;
    }
    for (std::size_t k = 0; k < kMostOthers; ++k) {
      const std::size_t way = 1 + k * (others - 1) / (kMostOthers - 1);
      add(face[(static_cast<std::size_t>(place) + way) % face.size()]);
    }
  }
  return fit.solve();
}

}  // namespace

Curvatures curvatures_of_normals(const SurfaceMesh& surface) {
  const Groups<FaceCorner> corners = corners_by_vertex(surface);
  Curvatures result;
  result.mean.resize(surface.positions.size());
  result.gaussian.resize(surface.positions.size());
  parallel_for(surface.positions.size(), 1024, [&](std::size_t begin, std::size_t end) {
    std::int64_t asked = 0;
    for (std::size_t v = begin; v < end; ++v) {
      const auto [e, f, g] = form_at(surface, v, corners.of(v), asked);
      result.mean[v] = static_cast<float>((e + g) / 2);
      result.gaussian[v] = static_cast<float>(e * g - f * f);
    }
    count_work(Work::Pairs, asked);
  });
  return result;
}

namespace {

constexpr std::int64_t kCornersAPiece = 256;

struct Sum {
  double mean = 0, gaussian = 0;
  std::int32_t count = 0;
};

class CurvatureSums {
 public:
  CurvatureSums(const DooSabinSurface& surface, const SurfaceMesh& tessellation)
      : surface_(surface),
        topology_(surface.topology()),
        numbering_(surface.patches(), tessellation.level, surface.hidden()),
        forms_(surface.weights()),
        side_(1 << (std::max(tessellation.level, 1) - 1)),
        sums_(tessellation.positions.size()) {
    PLANISH_ASSERT(numbering_.row_count() == static_cast<std::int64_t>(sums_.size()));
    for (std::int32_t c = 0; c < topology_.corner_count(); ++c)
      (void)forms_.of(surface.patches().corner_patch(c).patch);
  }

  const std::vector<Sum>& run() {
    in_order<Piece>(
        ranges_of(topology_.corner_count(), kCornersAPiece),
        [&](RowRange corners, Piece& piece) {
          piece.sums.clear();
          for (std::int64_t c = corners.first; c < corners.first + corners.count; ++c)
            add_corner(static_cast<std::int32_t>(c), piece);
        },
        [&](RowRange, const Piece& piece) {
          for (const auto& [row, sum] : piece.sums) {
            sums_[row].mean += sum.mean;
            sums_[row].gaussian += sum.gaussian;
            sums_[row].count += sum.count;
          }
        });
    return sums_;
  }

 private:
  struct Piece {
    std::vector<std::pair<std::size_t, Sum>> sums;
    std::vector<std::int32_t> indices, rows;
    std::vector<glm::dvec3> points;
    PatchScratch scratch;
  };

  void add_corner(std::int32_t corner, Piece& piece) const {
    if (numbering_.is_hidden(topology_.face_of(corner))) return;
    const PatchPlace place = surface_.patches().corner_patch(corner);
    piece.indices.resize(static_cast<std::size_t>(place.patch.column_count()));
    surface_.patches().gather(place, piece.indices.data(), 1);
    piece.points.clear();
    const glm::dvec3 own = surface_.state()[piece.indices[0]];
    for (const std::int32_t i : piece.indices) piece.points.push_back(surface_.state()[i] - own);
    const PatchForm& form = forms_.known(place.patch);
    const bool only_vertex = numbering_.level() == 0;
    if (only_vertex) {
      piece.rows = {numbering_.vertex_row(corner)};
    } else {
      const auto row_count = static_cast<std::size_t>(side_) + 1;
      piece.rows.resize(row_count * row_count);
      numbering_.grid(corner, piece.rows.data());
    }
    for (std::int32_t b = 0; b <= (only_vertex ? 0 : side_); ++b) {
      for (std::int32_t a = 0; a <= (only_vertex ? 0 : side_); ++a) {
        const auto row = static_cast<std::size_t>(piece.rows[b * (side_ + 1) + a]);
        piece.sums.emplace_back(row, around(form, piece, a, b));
      }
    }
  }

  // Over the cells of the corner's grid that meet at a sample, each seen from its own quarter at
  // the sample, which lies in one polynomial.
  Sum around(const PatchForm& form, Piece& piece, std::int32_t a, std::int32_t b) const {
    Sum sum;
    for (const std::int32_t i : {-1, 1}) {
      for (const std::int32_t j : {-1, 1}) {
        if (a + i < 0 || a + i > side_ || b + j < 0 || b + j > side_) continue;
        const PatchParameter at(double(a) / side_, double(b) / side_, (a + 0.25 * i) / side_,
                                (b + 0.25 * j) / side_);
        const PointCurvature curvature =
            curvature_of(patch_point(form, piece.points, at, piece.scratch));
        if (!curvature.is_known) continue;
        sum.mean += curvature.mean;
        sum.gaussian += curvature.gaussian;
        ++sum.count;
      }
    }
    return sum;
  }

  const DooSabinSurface& surface_;
  const MeshTopology& topology_;
  PatchNumbering numbering_;
  PatchForms forms_;
  std::int32_t side_;  // cells along a patch
  std::vector<Sum> sums_;
};

}  // namespace

Curvatures curvatures_of_derivatives(const DooSabinSurface& surface,
                                     const SurfaceMesh& tessellation, Curvatures elsewhere) {
  Curvatures result = std::move(elsewhere);
  CurvatureSums sums(surface, tessellation);
  const double unit = surface.placement().diagonal;
  const std::vector<Sum>& rows = sums.run();
  for (std::size_t v = 0; v < rows.size(); ++v) {
    if (rows[v].count == 0) continue;
    result.mean[v] = static_cast<float>(rows[v].mean / rows[v].count / unit);
    result.gaussian[v] = static_cast<float>(rows[v].gaussian / rows[v].count / (unit * unit));
  }
  return result;
}

namespace {

// A face of the surface with the mesh's face that it should follow.
struct FacePair {
  std::int64_t face;
  std::int32_t ancestor;
  std::span<const std::int32_t> vertices;
  glm::dvec3 wanted;   // area vector of the ancestor
  double corner_area;  // share of the face's area for each corner
};

template <class Visit>
void for_faces(const SurfaceMesh& surface, const PolygonMesh& mesh, const Visit& visit) {
  const std::vector<std::int32_t> ancestors = ancestor_faces(surface, mesh);
  std::int32_t last = -1;
  glm::dvec3 wanted(0.0);
  for (std::int64_t f = 0; f < surface.face_count(); ++f) {
    const std::int32_t ancestor = ancestors[f];
    if (ancestor != last) wanted = area_vector(mesh.positions, mesh.face(ancestor));
    last = ancestor;
    const auto vertices = surface.face(f);
    const double area = glm::length(area_vector(surface.positions, vertices));
    visit(FacePair{f, ancestor, vertices, wanted, area / static_cast<double>(vertices.size())});
  }
}

void compare_normals(const SurfaceMesh& surface, const PolygonMesh& mesh, VertexFields& fields) {
  const std::size_t count = surface.positions.size();
  fields.normal_deviation.assign(count, 0.0f);
  fields.folded.assign(count, 0.0f);
  std::vector<double> whole(count, 0.0), folded(count, 0.0);
  for_faces(surface, mesh, [&](const FacePair& pair) {
    for (const std::int32_t v : pair.vertices) {
      const glm::dvec3 normal(surface.normals[v]);
      const double angle = angle_between(normal, pair.wanted) * 180 / std::numbers::pi;
      fields.normal_deviation[v] = std::max(fields.normal_deviation[v], static_cast<float>(angle));
      whole[v] += pair.corner_area;
      if (glm::dot(normal, pair.wanted) < 0) folded[v] += pair.corner_area;
    }
  });
  for (std::size_t v = 0; v < count; ++v) {
    if (folded[v] > 0) fields.folded[v] = static_cast<float>(folded[v] / whole[v]);
  }
}

// Errors of level 0, copies of vertices included.
void note_given_errors(const SurfaceMesh& surface, const PolygonMesh& mesh, const LevelFaces& faces,
                       double diagonal, std::vector<float>& error) {
  const auto note = [&](std::int32_t row, std::int32_t vertex) {
    const glm::dvec3 off = surface.positions[row] - mesh.positions[vertex];
    error[row] = static_cast<float>(glm::length(off) / diagonal);
  };
  for (std::size_t i = 0; i < surface.base_vertices.size(); ++i)
    note(static_cast<std::int32_t>(i), surface.base_vertices[i]);
  const std::vector<std::uint8_t> is_hole = hole_flags(mesh);
  std::size_t face = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (is_hole[f]) continue;
    const auto rows = faces.face(face++);
    for (std::size_t k = 0; k < rows.size(); ++k) note(rows[k], mesh.face(f)[k]);
  }
}

// Each new vertex of a level takes the mean of the edge or face that it halves.
void spread(const LevelFaces& coarse, const LevelFaces& fine, std::vector<float>& values) {
  std::size_t child = 0;
  for (std::size_t f = 0; f < coarse.face_count(); ++f) {
    const auto face = coarse.face(f);
    const std::size_t n = face.size();
    double sum = 0;
    for (const std::int32_t v : face) sum += values[v];
    for (std::size_t k = 0; k < n; ++k) {
      const auto corners = fine.face(child + k);
      const ChildCorners places = child_corners(n, corners.size(), static_cast<int>(k));
      const double edge = 0.5 * (double{values[face[k]]} + values[face[(k + 1) % n]]);
      values[corners[places.edge]] = static_cast<float>(edge);
      if (places.middle >= 0)
        values[corners[places.middle]] = static_cast<float>(sum / static_cast<double>(n));
    }
    child += fine.face(child).size() == 3 ? 4 : n;
  }
}

}  // namespace

const char* name_of(CurvatureSource source) {
  switch (source) {
    case CurvatureSource::Normals:
      return "normals";
    case CurvatureSource::Derivatives:
      return "second derivatives";
  }
  return "";
}

VertexFields vertex_fields(const SurfaceMesh& surface, const PolygonMesh& mesh, double diagonal,
                           const DooSabinSurface* exact) {
  VertexFields fields;
  fields.error.assign(surface.positions.size(), 0.0f);
  {
    const std::vector<LevelFaces> levels = level_faces(surface, mesh);
    note_given_errors(surface, mesh, levels[0], diagonal, fields.error);
    for (std::size_t l = 1; l < levels.size(); ++l) spread(levels[l - 1], levels[l], fields.error);
  }
  compare_normals(surface, mesh, fields);
  fields.curvatures = curvatures_of_normals(surface);
  if (exact != nullptr) {
    fields.curvatures = curvatures_of_derivatives(*exact, surface, std::move(fields.curvatures));
    fields.curvature_source = CurvatureSource::Derivatives;
  }
  return fields;
}

std::vector<NamedField> named_fields(const VertexFields& fields, const FieldChoice& choice) {
  std::vector<NamedField> named;
  if (choice.error) named.push_back({"error", fields.error});
  if (choice.deviation) named.push_back({"deviation", fields.normal_deviation});
  if (choice.fold) named.push_back({"fold", fields.folded});
  if (choice.curvature) {
    named.push_back({"mean_curvature", fields.curvatures.mean});
    named.push_back({"gaussian_curvature", fields.curvatures.gaussian});
  }
  return named;
}

std::vector<FoldedFace> folded_faces(const SurfaceMesh& surface, const PolygonMesh& mesh) {
  std::vector<FoldedFace> folds;
  for_faces(surface, mesh, [&](const FacePair& pair) {
    const auto count = std::ranges::count_if(pair.vertices, [&](std::int32_t v) {
      return glm::dot(glm::dvec3(surface.normals[v]), pair.wanted) < 0;
    });
    if (count == 0) return;
    folds.push_back({pair.face, pair.ancestor, pair.corner_area * static_cast<double>(count)});
  });
  std::ranges::sort(folds, [](const FoldedFace& a, const FoldedFace& b) {
    return std::tuple(-a.area, a.face) < std::tuple(-b.area, b.face);
  });
  return folds;
}

namespace {

// Based on: C. Ericson, "Real-Time Collision Detection", Morgan Kaufmann 2005, section 5.1.5: the
// place of a triangle that is nearest to a point.

constexpr std::int64_t kSlideFaces = 1 << 12;
// Of a triangle, of the squares of its sides in the texture, below which no way across it is known.
constexpr double kLeastTextureArea = 1e-9;

// Of b and c in the nearest place of a triangle with corners 0, b and c.
glm::dvec2 nearest_weights(const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& p) {
  const double d1 = glm::dot(b, p), d2 = glm::dot(c, p);
  if (d1 <= 0 && d2 <= 0) return {0, 0};
  const double bb = glm::dot(b, b), bc = glm::dot(b, c), cc = glm::dot(c, c);
  const double d3 = d1 - bb, d4 = d2 - bc;
  if (d3 >= 0 && d4 <= d3) return {1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {d1 / bb, 0};
  const double d5 = d1 - bc, d6 = d2 - cc;
  if (d6 >= 0 && d5 <= d6) return {0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {0, d2 / cc};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {1 - w, w};
  }
  const double sum = va + vb + vc;
  return {vb / sum, vc / sum};
}

double texture_cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

// A triangle of a face, from its first corner.
struct FaceTriangle {
  glm::dvec3 at, b, c;
  glm::dvec2 uv, uv_b, uv_c;

  // How far a step in the texture leads on the triangle; below 0: nobody knows.
  [[nodiscard]] double length_of(const glm::dvec2& step) const {
    const double area = texture_cross(uv_b, uv_c);
    if (std::abs(area) <= kLeastTextureArea * (glm::dot(uv_b, uv_b) + glm::dot(uv_c, uv_c)))
      return -1;
    return glm::length((texture_cross(step, uv_c) * b + texture_cross(uv_b, step) * c) / area);
  }
};

struct SlideSums {
  double area = 0, squares = 0, largest = 0;
  double known_area = 0, distance_squares = 0, largest_distance = 0;
  std::int32_t face = -1;

  void add(const SlideSums& later) {
    area += later.area, squares += later.squares;
    largest = std::max(largest, later.largest);
    known_area += later.known_area, distance_squares += later.distance_squares;
    if (later.largest_distance > largest_distance)
      largest_distance = later.largest_distance, face = later.face;
  }
};

class SlideMeter {
 public:
  SlideMeter(const SurfaceBlocks& surface, const PolygonMesh& mesh)
      : surface_(surface), mesh_(mesh) {
    uvs_.resize(static_cast<std::size_t>(surface.info().uv_count));
    parallel_for(uvs_.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
      surface.uvs({static_cast<std::int64_t>(begin), static_cast<std::int64_t>(end - begin)},
                  std::span(uvs_).subspan(begin, end - begin));
    });
  }

  [[nodiscard]] SlideSums operator()(RowRange faces) const {
    const SurfaceInfo& info = surface_.info();
    const std::int64_t first = info.first_corner(faces.first);
    const auto count =
        static_cast<std::size_t>(info.first_corner(faces.first + faces.count) - first);
    RawVector<glm::dvec3> positions(count);
    RawVector<glm::vec3> normals(count);
    RawVector<std::int32_t> uvs(count), ancestors(static_cast<std::size_t>(faces.count));
    surface_.corners(faces, positions, normals);
    surface_.face_uvs(faces, uvs);
    surface_.ancestors(faces, ancestors);
    std::vector<FaceTriangle> triangles;
    std::int32_t ancestor = -1;
    SlideSums sums;
    for (std::int64_t f = 0; f < faces.count; ++f) {
      if (ancestors[f] != ancestor) cut(ancestor = ancestors[f], triangles);
      if (triangles.empty()) continue;
      const auto begin = static_cast<std::size_t>(info.first_corner(faces.first + f) - first);
      const auto end = static_cast<std::size_t>(info.first_corner(faces.first + f + 1) - first);
      const auto corners = std::span(positions).subspan(begin, end - begin);
      const double share = area_of(corners) / static_cast<double>(end - begin);
      for (std::size_t k = begin; k < end; ++k)
        add(triangles, ancestor, positions[k], uvs_[uvs[k]], share, sums);
    }
    return sums;
  }

 private:
  // None where a corner has no texture coordinate.
  void cut(std::int32_t face, std::vector<FaceTriangle>& triangles) const {
    triangles.clear();
    const std::int32_t first = mesh_.face_offsets[face], end = mesh_.face_offsets[face + 1];
    for (std::int32_t c = first; c < end; ++c)
      if (mesh_.face_uvs[c] < 0) return;
    const auto at = [&](std::int32_t c) { return mesh_.positions[mesh_.face_vertices[c]]; };
    const auto uv = [&](std::int32_t c) { return mesh_.uvs[mesh_.face_uvs[c]]; };
    for (std::int32_t c = first + 1; c + 1 < end; ++c)
      triangles.push_back({at(first), at(c) - at(first), at(c + 1) - at(first), uv(first),
                           uv(c) - uv(first), uv(c + 1) - uv(first)});
  }

  static double area_of(std::span<const glm::dvec3> corners) {
    glm::dvec3 sum(0.0);
    for (std::size_t k = 1; k + 1 < corners.size(); ++k)
      sum += glm::cross(corners[k] - corners[0], corners[k + 1] - corners[0]);
    return 0.5 * glm::length(sum);
  }

  static void add(std::span<const FaceTriangle> triangles, std::int32_t face, const glm::dvec3& p,
                  const glm::dvec2& uv, double area, SlideSums& sums) {
    const FaceTriangle* nearest = nullptr;
    glm::dvec2 weights(0.0);
    double least = std::numeric_limits<double>::infinity();
    for (const FaceTriangle& one : triangles) {
      const glm::dvec3 seen = p - one.at;
      const glm::dvec2 of = nearest_weights(one.b, one.c, seen);
      const glm::dvec3 apart = seen - of.x * one.b - of.y * one.c;
      if (const double square = glm::dot(apart, apart); square < least)
        least = square, nearest = &one, weights = of;
    }
    if (nearest == nullptr) return;
    const glm::dvec2 step =
        uv - nearest->uv - weights.x * nearest->uv_b - weights.y * nearest->uv_c;
    const double length = glm::length(step);
    sums.area += area;
    sums.squares += area * length * length;
    sums.largest = std::max(sums.largest, length);
    const double distance = nearest->length_of(step);
    if (distance < 0) return;
    sums.known_area += area;
    sums.distance_squares += area * distance * distance;
    if (distance > sums.largest_distance) sums.largest_distance = distance, sums.face = face;
  }

  const SurfaceBlocks& surface_;
  const PolygonMesh& mesh_;
  RawVector<glm::dvec2> uvs_;
};

}  // namespace

TextureSlide texture_slide(const SurfaceBlocks& surface, const PolygonMesh& mesh,
                           const Callbacks& callbacks) {
  const HostScope host(callbacks);
  const SlideMeter measure(surface, mesh);
  const std::vector<RowRange> pieces = ranges_of(surface.info().face_count, kSlideFaces);
  std::vector<SlideSums> of_pieces(pieces.size());
  parallel_each(pieces.size(), 1, [&](std::size_t i) { of_pieces[i] = measure(pieces[i]); });
  SlideSums all;
  for (const SlideSums& part : of_pieces) all.add(part);
  const auto mean = [](double squares, double area) {
    return area > 0 ? std::sqrt(squares / area) : 0.0;
  };
  return {.largest = all.largest,
          .rms = mean(all.squares, all.area),
          .largest_distance = all.largest_distance,
          .rms_distance = mean(all.distance_squares, all.known_area),
          .face = all.face};
}

}  // namespace planish
