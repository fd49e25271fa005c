// Based on: directions of u in the plane of du and dv, a derivation of our own: a patch's
// derivatives are linear maps of the tangents that its row is evaluated from, the same for all
// patches of a class.
#include "planish/core/portable_math.h"
#include "planish/vulkan/evaluate/patch_tables.h"

#include <algorithm>
#include <bit>
#include <glm/geometric.hpp>
#include <glm/mat2x2.hpp>
#include <map>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/patches/patch_form.h"
#include "planish/patches/patch_plan.h"

namespace planish::vulkan {

namespace {

using Part = PatchNumbering::Part;

constexpr std::size_t kItemsAtOnce = 1 << 12;
// Of squares: what is no plane.
constexpr double kNoPlane = 1e-12;

// A direction by two tangents, and twice an area in the texture.
struct Direction {
  glm::dvec2 along{0.0};
  double area = 0;

  void add(const Direction& other) {
    const double size = glm::length(other.along);
    if (size > 0) along += other.along / size;
    area += other.area;
  }
  /// The same by tangents of which `of` makes these: du and dv are its columns' sums.
  [[nodiscard]] Direction by(const glm::dmat2& of) const { return {of * along, area}; }
  /// By tangents that are turned by a right angle: where du was, dv is.
  [[nodiscard]] Direction turned() const { return {{-along.y, along.x}, area}; }
  [[nodiscard]] Direction turned_back() const { return {{along.y, -along.x}, area}; }
};

// Of tangents that are turned by `place` of so many equal parts of a circle.
glm::dmat2 turned_by(std::int32_t place, std::int32_t parts) {
  const double angle = 2 * std::numbers::pi * place / parts;
  const double cosine = portable::cos(angle), sine = portable::sin(angle);
  return {cosine, sine, -sine, cosine};
}

RowFrame packed(const Direction& direction) {
  const glm::vec2 along(direction.along);
  const std::uint32_t is_mirrored = direction.area < 0 ? 1 : 0;
  return {{std::bit_cast<std::uint32_t>(along.x),
           (std::bit_cast<std::uint32_t>(along.y) & ~1u) | is_mirrored}};
}

// Calls visit(row, corner, a, b) for the rows of an item, whose samples' side is n.
template <class Visit>
void for_item(const PatchNumbering& numbering, Part part, std::int64_t item, const Visit& visit) {
  const std::int32_t corner = numbering.item_corner(part, item), n = numbering.samples().side();
  std::int64_t row = numbering.first_row(part) + item;
  if (part == Part::Corners) {
    row = numbering.corner_row(corner);
    for (std::int32_t b = 0; b < n; ++b)
      for (std::int32_t a = 1; a < (b == 0 ? n : n + 1); ++a) visit(row++, corner, a, b);
  } else if (part == Part::Trailing) {
    row = numbering.first_row(part) + item * numbering.samples().trailing_count();
    for (std::int32_t b = 1; b < n; ++b) visit(row++, corner, 0, b);
  } else {
    const bool is_edge =
        part == Part::Edges || (part == Part::Further && numbering.is_further_edge(item));
    visit(row, corner, is_edge || part == Part::Faces ? n : 0, part == Part::Faces ? n : 0);
  }
}

// Of all parts; visit(part, item) from several threads.
template <class Visit>
void for_all_items(const PatchNumbering& numbering, const Visit& visit) {
  for (const Part part :
       {Part::Vertices, Part::Faces, Part::Edges, Part::Corners, Part::Trailing, Part::Further})
    parallel_each(static_cast<std::size_t>(numbering.item_count(part)), kItemsAtOnce,
                  [&](std::size_t i) { visit(part, static_cast<std::int64_t>(i)); });
}

// The map that takes a direction by `rows`, two rows of weights, to one by `tangents`, by least
// squares; none where these span no plane.
std::optional<glm::dmat2> in_terms_of(std::span<const double> tangents,
                                      std::span<const double> rows) {
  const std::size_t count = tangents.size() / 2;
  const auto product = [&](std::span<const double> a, std::size_t i, std::span<const double> b,
                           std::size_t j) {
    double sum = 0;
    for (std::size_t k = 0; k < count; ++k) sum += a[i * count + k] * b[j * count + k];
    return sum;
  };
  const double uu = product(tangents, 0, tangents, 0), uv = product(tangents, 0, tangents, 1),
               vv = product(tangents, 1, tangents, 1), area = uu * vv - uv * uv;
  if (!(area > kNoPlane * uu * vv)) return {};
  glm::dmat2 result;
  for (const int i : {0, 1}) {
    const auto row = static_cast<std::size_t>(i);
    const double u = product(rows, row, tangents, 0), v = product(rows, row, tangents, 1);
    result[i] = glm::dvec2(u * vv - v * uv, v * uu - u * uv) / area;
  }
  return result;
}

class FrameMaker {
 public:
  FrameMaker(const PatchSurface& surface, Weights weights, const ChartField<glm::dvec2>& field)
      : surface_(surface),
        mesh_(surface.mesh()),
        topology_(mesh_.topology()),
        numbering_(surface.numbering()),
        field_(field),
        n_(numbering_.samples().side()),
        forms_(weights) {
    make_classes(weights);
  }

  std::vector<RowFrame> make() const {
    std::vector<RowFrame> frames(static_cast<std::size_t>(numbering_.row_count()));
    for_all_items(numbering_, [&](Part part, std::int64_t item) {
      Seen seen;
      for_item(numbering_, part, item,
               [&](std::int64_t row, std::int32_t corner, std::int32_t a, std::int32_t b) {
                 frames[row] = packed(direction_of(part, item, corner, a, b, seen));
               });
    });
    return frames;
  }

 private:
  // What all corners of a class have in common: maps to the tangents of rows at E2 and F, and to
  // those of the samples; weights of control points behind the own one, in two rows: those of the
  // tangents at V, and for each (a, b) of the derivatives by u and v.
  struct OfClass {
    std::optional<glm::dmat2> trailing_edge, face;
    std::vector<std::optional<glm::dmat2>> samples;
    std::vector<double> vertex, derivatives;
  };
  // Control values of the field as the corner that was asked for last sees them, from its own on.
  struct Seen {
    std::int32_t corner = -1;
    std::vector<std::int32_t> indices;
    std::vector<glm::dvec2> values;
  };

  void make_classes(Weights weights);
  [[nodiscard]] OfClass make_class(const PatchForm& form, PatchTemplates& templates) const;

  [[nodiscard]] bool is_cut(std::int32_t corner) const {
    return mesh_.is_sharp(corner) || is_uv_seam(topology_, field_.indices(), corner);
  }
  [[nodiscard]] const OfClass& class_of(std::int32_t corner) const {
    return classes_[class_of_corner_[corner]];
  }
  void look_from(std::int32_t corner, Seen& seen) const;
  // Where u grows by two tangents, whose weights of the control points these are.
  [[nodiscard]] static Direction by_rows(std::span<const double> rows, const Seen& seen);
  // By the derivatives of the corner's patch, at sample (a, b).
  [[nodiscard]] Direction own(std::int32_t corner, std::int32_t a, std::int32_t b,
                              Seen& seen) const;
  [[nodiscard]] Direction by(const std::optional<glm::dmat2>& map, const Direction& own) const {
    return map ? own.by(*map) : Direction{glm::dvec2(0.0), own.area};
  }
  [[nodiscard]] Direction direction_of(Part part, std::int64_t item, std::int32_t corner,
                                       std::int32_t a, std::int32_t b, Seen& seen) const;
  [[nodiscard]] Direction at_vertex(std::int32_t corner, Seen& seen) const;
  [[nodiscard]] Direction at_face(std::int32_t corner, Seen& seen) const;
  [[nodiscard]] Direction at_edge(std::int32_t corner, std::int32_t evaluated, Seen& seen) const;
  [[nodiscard]] std::vector<double> tangents_of(const PatchPlace& point, std::int32_t corner) const;

  const PatchSurface& surface_;
  const PatchMesh& mesh_;
  const MeshTopology& topology_;
  const PatchNumbering& numbering_;
  const ChartField<glm::dvec2>& field_;
  std::int32_t n_;
  PatchForms forms_;
  std::vector<OfClass> classes_;
  std::vector<std::uint32_t> class_of_corner_;
};

void FrameMaker::make_classes(Weights weights) {
  std::map<PatchClass, std::uint32_t> known;
  PatchTemplates templates(weights);
  for (std::int32_t c = 0; c < topology_.corner_count(); ++c) {
    const PatchClass patch = mesh_.corner_patch(c).patch;
    const auto [entry, is_new] =
        known.try_emplace(patch, static_cast<std::uint32_t>(classes_.size()));
    if (is_new) classes_.push_back(make_class(forms_.of(patch), templates));
    class_of_corner_.push_back(entry->second);
  }
}

FrameMaker::OfClass FrameMaker::make_class(const PatchForm& form, PatchTemplates& templates) const {
  // The own point's weights follow from the others.
  const auto map_at = [&](const PatchTemplate& of, std::int32_t sample, double u, double v) {
    const std::vector<double> weights = patch_weights(form, u, v);
    const auto count = static_cast<std::size_t>(form.column_count);
    std::vector<double> rows;
    for (const std::size_t r : {std::size_t{1}, std::size_t{2}})
      rows.insert(rows.end(), weights.begin() + static_cast<std::ptrdiff_t>(r * count + 1),
                  weights.begin() + static_cast<std::ptrdiff_t>((r + 1) * count));
    return in_terms_of(of.rows(sample).subspan(count - 1), rows);
  };
  OfClass result;
  const PatchSamples coarse(1);
  const PatchTemplate points = templates.make(form.patch, 1);
  const auto count = static_cast<std::ptrdiff_t>(form.column_count);
  const std::span<const double> at_vertex = points.rows(coarse.index(0, 0)).subspan(count - 1);
  result.vertex.assign(at_vertex.begin(), at_vertex.end());
  result.trailing_edge = map_at(points, coarse.index(0, 1), 0, 1);
  result.face = map_at(points, coarse.index(1, 1), 1, 1);
  for (std::int32_t b = 0; b <= n_; ++b)
    for (std::int32_t a = 0; a <= n_; ++a) {
      const std::vector<double> weights = patch_weights(form, double(a) / n_, double(b) / n_);
      for (const std::ptrdiff_t row : {1, 2})
        result.derivatives.insert(result.derivatives.end(), weights.begin() + row * count + 1,
                                  weights.begin() + (row + 1) * count);
    }
  if (numbering_.level() < 2) return result;
  const PatchSamples& samples = numbering_.samples();
  const PatchTemplate all = templates.make(form.patch, numbering_.level());
  result.samples.resize(static_cast<std::size_t>(samples.count()));
  for (std::int32_t b = 0; b <= n_; ++b)
    for (std::int32_t a = 0; a <= n_; ++a) {
      const std::int32_t sample = samples.index(a, b);
      result.samples[sample] = map_at(all, sample, double(a) / n_, double(b) / n_);
    }
  return result;
}

void FrameMaker::look_from(std::int32_t corner, Seen& seen) const {
  if (seen.corner == corner) return;
  seen.corner = corner;
  field_.columns(mesh_.corner_patch(corner), corner, seen.indices, seen.values);
  for (std::size_t k = 1; k < seen.values.size(); ++k) seen.values[k] -= seen.values[0];
}

Direction FrameMaker::by_rows(std::span<const double> rows, const Seen& seen) {
  const std::size_t count = seen.values.size() - 1;
  glm::dvec2 by_u(0.0), by_v(0.0);
  for (std::size_t k = 0; k < count; ++k) {
    by_u += rows[k] * seen.values[k + 1];
    by_v += rows[count + k] * seen.values[k + 1];
  }
  const double area = by_u.x * by_v.y - by_u.y * by_v.x;
  const glm::dvec2 along(by_v.y, -by_u.y);
  return {area < 0 ? -along : area > 0 ? along : glm::dvec2(0.0), area};
}

Direction FrameMaker::own(std::int32_t corner, std::int32_t a, std::int32_t b, Seen& seen) const {
  look_from(corner, seen);
  const std::size_t size = 2 * (seen.values.size() - 1);
  return by_rows(std::span(class_of(corner).derivatives)
                     .subspan(size * static_cast<std::size_t>(b * (n_ + 1) + a), size),
                 seen);
}

Direction FrameMaker::direction_of(Part part, std::int64_t item, std::int32_t corner,
                                   std::int32_t a, std::int32_t b, Seen& seen) const {
  switch (part) {
    case Part::Vertices:
      return at_vertex(corner, seen);
    case Part::Faces:
      return at_face(corner, seen);
    case Part::Edges:
      return at_edge(corner, corner, seen);
    case Part::Further:
      if (!numbering_.is_further_edge(item)) return at_vertex(corner, seen);
      return at_edge(corner, mesh_.is_sharp(corner) ? corner : numbering_.further_first(item),
                     seen);
    default:
      break;
  }
  const std::int32_t sample = numbering_.samples().index(a, b);
  Direction sum;
  if (part == Part::Trailing) {
    const std::int32_t other = topology_.ccw(corner);
    sum.add(own(corner, a, b, seen));
    if (other < 0 || mesh_.is_sharp(topology_.prev(corner)))
      return by(class_of(corner).samples[sample], sum);
    // Evaluated by the other side's patch, whose leading edge it is.
    return by(class_of(other).samples[numbering_.samples().index(b, a)], sum.turned_back());
  }
  sum.add(own(corner, a, b, seen));
  if (b == 0 && !is_cut(corner)) sum.add(own(topology_.cw(corner), 0, a, seen).turned_back());
  if (a == n_) sum.add(own(topology_.next(corner), b, n_, seen).turned());
  return by(class_of(corner).samples[sample], sum);
}

// Tangents of a limit point's row, by points that both name, behind the corner's own; none where it
// lacks some.
std::vector<double> FrameMaker::tangents_of(const PatchPlace& point, std::int32_t corner) const {
  const PatchPlace place = mesh_.corner_patch(corner);
  const auto count = static_cast<std::size_t>(place.patch.column_count());
  std::vector<std::int32_t> columns(count),
      others(static_cast<std::size_t>(point.patch.column_count()));
  mesh_.gather(place, columns.data(), 1);
  mesh_.gather(point, others.data(), 1);
  const std::span<const double> known =
      surface_.classes().weights(surface_.classes().index_of(point.patch)).rows(0);
  std::vector<double> tangents(2 * (count - 1), 0.0);
  const auto add = [&](std::size_t row, std::size_t column, double weight) {
    if (column > 0) tangents[row * (count - 1) + column - 1] += weight;
  };
  const auto column_of = [&](std::int32_t index) {
    return static_cast<std::size_t>(std::ranges::find(columns, index) - columns.begin());
  };
  const std::size_t origin = column_of(others[0]);
  for (std::size_t k = 1; k < others.size(); ++k) {
    const std::size_t column = column_of(others[k]);
    if (column == count || origin == count) return {};
    for (std::size_t r = 0; r < 2; ++r) {
      const double weight = known[(r + 1) * (others.size() - 1) + k - 1];
      add(r, column, weight);
      add(r, origin, -weight);
    }
  }
  return tangents;
}

// Of the corners whose row the corner's is.
Direction FrameMaker::at_vertex(std::int32_t corner, Seen& seen) const {
  const PatchPlace point = mesh_.vertex_point(mesh_.sector_corner(corner));
  const bool is_even =
      !point.patch.has_sharp_edges() &&
      mesh_.features().vertex_kinds[topology_.vertex_of(corner)] != VertexKind::Dart;
  const std::int32_t row = numbering_.vertex_row(corner);
  std::int32_t place = 0;
  for (std::int32_t c = point.corner; is_even && c != corner; c = topology_.ccw(c)) ++place;
  Direction sum;
  std::int32_t c = corner;
  do {
    look_from(c, seen);
    if (is_even) {
      sum.add(by_rows(class_of(c).vertex, seen).by(turned_by(place, point.patch.ring_size)));
    } else if (!point.patch.has_ring_sums || c == point.corner) {
      if (const std::vector<double> tangents = tangents_of(point, c); !tangents.empty())
        sum.add(by_rows(tangents, seen));
    }
    c = topology_.ccw(c);
    ++place;
  } while (c >= 0 && c != corner && numbering_.vertex_row(c) == row);
  return sum;
}

Direction FrameMaker::at_face(std::int32_t corner, Seen& seen) const {
  const std::int32_t m = topology_.face_size(topology_.face_of(corner));
  Direction sum;
  for (std::int32_t i = 0; i < m; ++i) {
    sum.add(by(class_of(corner + i).face, own(corner + i, n_, n_, seen)).by(turned_by(i, m)));
  }
  return sum;
}

// At the midpoint of the corner's leading edge; the row is evaluated as the corner `evaluated` of
// the same edge sees it: by the tangents of the next corner's E2.
Direction FrameMaker::at_edge(std::int32_t corner, std::int32_t evaluated, Seen& seen) const {
  const auto add_side = [&](std::int32_t side, Direction& sum) {
    sum.add(own(topology_.next(side), 0, n_, seen));
    sum.add(own(side, n_, 0, seen).turned_back());
  };
  const auto opposite = [](Direction direction) {
    direction.along = -direction.along;
    return direction;
  };
  Direction sum;
  add_side(corner, sum);
  if (corner != evaluated) sum = opposite(sum);
  if (!is_cut(corner)) {
    Direction other;
    add_side(topology_.twin(corner), other);
    // Both sides have two squares, so that this is the mean of all four.
    sum = {sum.along - other.along, sum.area + other.area};
  }
  return by(class_of(topology_.next(evaluated)).trailing_edge, sum);
}

}  // namespace

std::vector<SurfacePlace> row_places(const PatchSurface& surface) {
  const PatchNumbering& numbering = surface.numbering();
  std::vector<SurfacePlace> places(static_cast<std::size_t>(numbering.row_count()));
  const double n = numbering.samples().side();
  for_all_items(numbering, [&](Part part, std::int64_t item) {
    for_item(numbering, part, item,
             [&](std::int64_t row, std::int32_t corner, std::int32_t a, std::int32_t b) {
               const SurfaceParameter at =
                   surface_parameter(surface.mesh().topology(), corner, a / n, b / n);
               places[row] = {static_cast<std::uint32_t>(at.face), static_cast<float>(at.u),
                              static_cast<float>(at.v)};
             });
  });
  return places;
}

std::vector<glm::vec2> row_uvs(const PatchSurface& surface, const ChartField<glm::dvec2>& field) {
  const PatchNumbering& numbering = surface.numbering();
  std::vector<glm::vec2> uvs(static_cast<std::size_t>(numbering.row_count()));
  const auto put = [&](std::int64_t row, const glm::dvec2& uv) {
    uvs[row] = {static_cast<float>(uv.x), static_cast<float>(1 - uv.y)};
  };
  for (std::int64_t v = 0; v < numbering.item_count(Part::Vertices); ++v)
    put(v, field.given(numbering.item_corner(Part::Vertices, v)));
  ChartRows<glm::dvec2>(field, numbering, surface.classes()).write({0, numbering.row_count()}, put);
  return uvs;
}

std::vector<RowFrame> row_frames(const PatchSurface& surface, Weights weights,
                                 const ChartField<glm::dvec2>& field) {
  return FrameMaker(surface, weights, field).make();
}

}  // namespace planish::vulkan
