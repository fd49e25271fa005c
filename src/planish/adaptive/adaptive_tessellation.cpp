#include "planish/adaptive/adaptive_tessellation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "planish/adaptive/adaptive_blocks.h"
#include "planish/adaptive/adaptive_cells.h"
#include "planish/adaptive/adaptive_faces.h"
#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/mesh/face_geometry.h"
#include "planish/patches/chart_field.h"
#include "planish/queries/limit_surface.h"
#include "planish/surface/doo_sabin_blocks.h"
#include "planish/surface/memory_need.h"
#include "planish/surface/surface_blocks.h"

namespace planish {
namespace {

// Values of these rows only; ascending.
template <class T>
void keep_only(RawVector<T>& values, std::span<const std::int32_t> rows) {
  for (std::size_t i = 0; i < rows.size(); ++i) values[i] = values[rows[i]];
  values.resize(rows.size());
}

// The same of values that only the first rows have.
void keep_first(std::vector<std::int32_t>& values, std::span<const std::int32_t> rows) {
  std::size_t count = 0;
  for (; count < rows.size() && rows[count] < std::ssize(values); ++count)
    values[count] = values[rows[count]];
  values.resize(count);
}

// The rows, of `count`, that are named or among the first so many, which stay; ascending. Names
// become places in that list.
std::vector<std::int32_t> rename_used(RawVector<std::int32_t>& names, std::int64_t first,
                                      std::int64_t count) {
  std::vector<std::int32_t> place(static_cast<std::size_t>(count), 0);
  std::fill(place.begin(), place.begin() + first, 1);
  for (const std::int32_t row : names) place[row] = 1;
  std::vector<std::int32_t> rows;
  for (std::size_t row = 0; row < place.size(); ++row) {
    if (place[row] == 0) continue;
    place[row] = static_cast<std::int32_t>(rows.size());
    rows.push_back(static_cast<std::int32_t>(row));
  }
  for (std::int32_t& row : names) row = place[row];
  return rows;
}

// Triangles whose normals differ by more than an angle from corner to corner.
struct TriangleTurns {
  std::int64_t count = 0, first = -1;
  std::int64_t worst = -1;  // the first that turns by the most
  double largest = 0;       // by that, degrees
};

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

// Of a mesh of triangles, by `degrees` and what float32 normals lose. The same for every thread
// count.
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

// u or v of a place, 0 to 1.
double share_of_side(std::uint16_t parts) { return static_cast<double>(parts) / kCellSide; }

// What a field of a surface has at any place, for one thread; places of a corner come fastest
// together.
template <class Vector>
class FieldAt {
 public:
  FieldAt(const LimitSurface& surface, const ChartField<Vector>& field)
      : surface_(surface), field_(field) {}

  // At (u, v) of the corner's square.
  [[nodiscard]] Vector operator()(std::int32_t corner, const glm::dvec2& at) {
    if (at == glm::dvec2(0.0)) return field_.given(corner);
    if (corner != corner_) take(corner);
    Vector value = values_[0];
    for (int first = 0; first < Vector::length(); first += 3) {
      const PatchPoint point =
          patch_point(surface_.form(corner), points_[static_cast<std::size_t>(first / 3)],
                      {at.x, at.y}, scratch_);
      for (int d = first; d < std::min(first + 3, Vector::length()); ++d)
        value[d] += point.position[d - first];
    }
    return field_.row(value);
  }

 private:
  // Three numbers make a point.
  void take(std::int32_t corner) {
    corner_ = corner;
    field_.columns(surface_.surface().patches().corner_patch(corner), corner, indices_, values_);
    for (auto& points : points_) points.assign(values_.size(), glm::dvec3(0.0));
    for (std::size_t k = 0; k < values_.size(); ++k)
      for (int d = 0; d < Vector::length(); ++d)
        points_[static_cast<std::size_t>(d / 3)][k][d % 3] = values_[k][d] - values_[0][d];
  }

  const LimitSurface& surface_;
  const ChartField<Vector>& field_;
  std::int32_t corner_ = -1;
  std::vector<std::int32_t> indices_;
  std::vector<Vector> values_;
  std::array<std::vector<glm::dvec3>, (Vector::length() + 2) / 3> points_;
  PatchScratch scratch_;
};

// result(i, value) at each place, on all threads: what a field of the surface has there, as levels
// have it.
template <class Vector, class Result>
void field_at(const LimitSurface& surface, const ChartField<Vector>& field,
              std::span<const AdaptivePlace> places, const Result& result) {
  constexpr std::size_t kPlaces = std::size_t{1} << 12;
  parallel_for(places.size(), kPlaces, [&](std::size_t begin, std::size_t end) {
    FieldAt<Vector> at(surface, field);
    for (std::size_t i = begin; i < end; ++i)
      result(i, at(places[i].corner, {share_of_side(places[i].u), share_of_side(places[i].v)}));
  });
}

}  // namespace

void drop_unnamed(AdaptiveSurface& surface, std::int64_t first_rows, std::int64_t first_uvs) {
  SurfaceMesh& mesh = surface.mesh;
  const auto rows =
      rename_used(mesh.face_vertices, first_rows, static_cast<std::int64_t>(mesh.positions.size()));
  keep_only(mesh.positions, rows);
  keep_only(mesh.normals, rows);
  keep_only(surface.places, rows);
  keep_first(mesh.base_vertices, rows);
  if (!mesh.colors.empty()) keep_only(mesh.colors, rows);
  for (VertexAttribute& attribute : mesh.attributes)
    attribute = std::move(attributes_of({&attribute, 1}, rows).front());
  if (mesh.uvs.empty()) return;
  const auto uvs =
      rename_used(mesh.face_uvs, first_uvs, static_cast<std::int64_t>(mesh.uvs.size()));
  keep_only(mesh.uvs, uvs);
  keep_only(surface.uv_places, uvs);
  keep_first(surface.base_uvs, uvs);
}

std::vector<float> attribute_at(const LimitSurface& surface, std::size_t index,
                                std::span<const SurfaceParameter> places) {
  constexpr std::size_t kGrain = 1024;
  const MeshTopology& topology = surface.topology();
  const PolygonMesh& mesh = surface.surface().mesh();
  const VertexAttribute& given = mesh.attributes[index];
  VertexAttribute made = attribute_of_size(given.name, given.width, places.size());
  for (const NumberRun& run : runs_of(mesh.attributes, index)) {
    const ChartField<glm::dvec4>& field = surface.surface().number_field(run.four);
    parallel_for(places.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      FieldAt<glm::dvec4> value(surface, field);
      for (std::size_t i = begin; i < end; ++i) {
        const CornerParameter at = corner_parameter(topology, places[i]);
        made.set_run(i, run, glm::vec4(value(at.corner, {at.u, at.v})));
      }
    });
  }
  return std::move(made.values);
}

namespace {

constexpr std::size_t kCornersAtOnce = 64;

void require_options(const AdaptiveOptions& options) {
  const auto refuse = [](const std::string& what) {
    throw Error(ErrorCode::InvalidArgument, "tessellate: " + what);
  };
  if (!(options.chord_error >= 0) || !std::isfinite(options.chord_error))
    refuse("a chord error of " + shortest(options.chord_error) + " is none; 1e-3 is a good one");
  if (!(options.angle >= 0) || !(options.angle <= 180))
    refuse("an angle of " + shortest(options.angle) + " degrees is none; 10 is a good one");
  if (options.chord_error == 0 && options.angle == 0)
    refuse("neither a chord error nor an angle is given");
  if (!(options.diagonal > 0) || !std::isfinite(options.diagonal))
    refuse("a diagonal of " + shortest(options.diagonal) + " is none");
}

class Tessellation {
 public:
  Tessellation(const LimitSurface& surface, const AdaptiveOptions& options, std::uint64_t limit)
      : surface_(surface),
        base_(surface.surface()),
        topology_(surface.topology()),
        options_(options),
        limit_(limit),
        cells_(make_cells(
            surface,
            {options.chord_error * options.diagonal / surface.surface().placement().diagonal,
             options.angle * std::numbers::pi / 180},
            limit, share_of(options.callbacks, 0, 0.4))),
        sides_(topology_, cells_),
        faces_(topology_, cells_, sides_),
        numbering_(base_.patches(), 1, base_.hidden()) {
    if (base_.mesh().face_uvs.empty()) return;
    const CornerUvs& uvs = base_.corner_uvs();
    uv_numbering_.emplace(topology_, uvs.indices, uvs.count, 1, base_.hidden());
  }

  [[nodiscard]] AdaptiveSurface run() {
    count();
    const AdaptiveRows rows(topology_, cells_, sides_, numbering_, inside_);
    require_counts(rows);
    Callbacks of_level = share_of(options_.callbacks, 0.5, 0.6);
    of_level.warning = {};
    AdaptiveSurface surface;
    surface.mesh = collect(*base_.level(1, options_.memory_limit_bytes), of_level);
    SurfaceMesh& result = surface.mesh;
    fill_rows(rows, result);
    fill_places(rows, numbering_, surface.places);
    std::optional<AdaptiveRows> uv_rows;
    if (uv_numbering_) {
      uv_rows.emplace(topology_, cells_, sides_, *uv_numbering_, inside_);
      fill_places(*uv_rows, *uv_numbering_, surface.uv_places);
      surface.base_uvs.resize(base_.mesh().uvs.size());
      std::iota(surface.base_uvs.begin(), surface.base_uvs.end(), 0);
    }
    carry(surface, result);
    fill_faces(rows, uv_rows ? &*uv_rows : nullptr, result);
    drop_unused(surface);
    finish(surface);
    warn_of_turns(result);
    options_.callbacks.report("evaluate", 1);
    return surface;
  }

 private:
  [[nodiscard]] std::int64_t triangle_count() const { return first_triangle_.back(); }

  // What a task uses again from corner to corner.
  struct Worker {
    CornerGrid grid;
    LimitSurface::Corner at;
    AdaptiveFaces::Scratch faces;
  };

  template <class Body>
  void for_corners(double from, double to, const Body& body) const {
    LoopProgress progress(options_.callbacks, "evaluate", from, to, topology_.corner_count());
    parallel_for(static_cast<std::size_t>(topology_.corner_count()), kCornersAtOnce,
                 [&](std::size_t begin, std::size_t end) {
                   Worker worker{{}, LimitSurface::Corner(surface_), {}};
                   for (std::size_t c = begin; c < end; ++c) {
                     if (cells_.hidden[c] != 0) continue;
                     const auto corner = static_cast<std::int32_t>(c);
                     worker.grid.build(cells_.of(corner), sides_.sides(corner));
                     body(corner, worker);
                   }
                   progress.add(static_cast<std::int64_t>(end - begin));
                 });
  }

  void count();
  void require_counts(const AdaptiveRows& rows) const;
  void fill_rows(const AdaptiveRows& rows, SurfaceMesh& result) const;
  void fill_corner(std::int32_t corner, const AdaptiveRows& rows, Worker& worker,
                   SurfaceMesh& result) const;
  void carry(const AdaptiveSurface& surface, SurfaceMesh& result) const;
  void fill_faces(const AdaptiveRows& rows, const AdaptiveRows* uv_rows, SurfaceMesh& result) const;
  void fill_places(const AdaptiveRows& rows, const PatchNumbering& level_one,
                   RawVector<AdaptivePlace>& places) const;
  void drop_unused(AdaptiveSurface& surface) const;
  void finish(AdaptiveSurface& surface) const;
  void warn_of_turns(const SurfaceMesh& result) const;
  template <class Place>
  void own_places(std::int32_t corner, const CornerGrid& grid, bool with_trailing,
                  const Place& place) const;

  const LimitSurface& surface_;
  const DooSabinSurface& base_;
  const MeshTopology& topology_;
  const AdaptiveOptions& options_;
  std::uint64_t limit_;
  AdaptiveCells cells_;
  SidePlaces sides_;
  AdaptiveFaces faces_;
  PatchNumbering numbering_;
  std::optional<PatchNumbering> uv_numbering_;
  std::vector<std::int32_t> inside_;          // places within each corner
  std::vector<std::int64_t> first_triangle_;  // corner_count + 1
};

void Tessellation::count() {
  const auto corners = static_cast<std::size_t>(topology_.corner_count());
  inside_.assign(corners, 0);
  std::vector<std::int64_t> triangles(corners, 0);
  for_corners(0.4, 0.5, [&](std::int32_t corner, Worker& worker) {
    const auto c = static_cast<std::size_t>(corner);
    const AdaptiveFaces::Counts counts = faces_.counts(corner, worker.grid);
    inside_[c] = counts.inside;
    triangles[c] = counts.triangles;
  });
  first_triangle_.assign(1, 0);
  for (const std::int64_t count : triangles)
    first_triangle_.push_back(first_triangle_.back() + count);
}

// Before rows and triangles are made.
void Tessellation::require_counts(const AdaptiveRows& rows) const {
  const PolygonMesh& mesh = base_.mesh();
  const bool has_uvs = !mesh.face_uvs.empty();
  const auto vertices = static_cast<std::uint64_t>(rows.count());
  const auto triangles = static_cast<std::uint64_t>(triangle_count());
  const std::uint64_t bytes = vertices * (36 + (mesh.colors.empty() ? 0 : 16) + (has_uvs ? 16 : 0) +
                                          4 * numbers_of(mesh.attributes)) +
                              triangles * (12 + 4 + 4 + (has_uvs ? 12 : 0) + 4);
  const std::string what =
      formatted("the tessellation has {} vertices and {} triangles", vertices, triangles);
  if (3 * triangles > std::numeric_limits<std::int32_t>::max()) {
    throw Error(ErrorCode::OutOfMemory,
                what + ", more than 32-bit indices reach; allow a larger chord error or angle");
  }
  if (bytes > limit_) {
    throw Error(
        ErrorCode::OutOfMemory,
        formatted(
            "{} and needs {} MiB of memory where {} are free; allow a larger chord error or angle",
            what, bytes >> 20, limit_ >> 20));
  }
}

// In the order of AdaptiveRows: place(corner, u, v, is_trailing).
template <class Place>
void Tessellation::own_places(std::int32_t corner, const CornerGrid& grid, bool with_trailing,
                              const Place& place) const {
  const auto share = [](std::uint16_t t) { return static_cast<double>(t) / kCellSide; };
  for (const std::uint16_t t : sides_.leading(corner)) place(corner, share(t), 0, false);
  for (const std::uint16_t t : sides_.spoke(corner)) place(corner, 1, share(t), false);
  for (const CellPlace& at : grid.places()) {
    if (at.u > 0 && at.u < kCellSide && at.v > 0 && at.v < kCellSide)
      place(corner, share(at.u), share(at.v), false);
  }
  if (const FaceGrid* const whole = faces_.grid_at(corner)) {
    for (int j = 1; j < whole->v; ++j) {
      for (int i = 1; i < whole->u; ++i) {
        const double s = share(even_place(i, whole->u)), t = share(even_place(j, whole->v));
        if (t <= 1 && s <= 1) place(corner, s, t, false);
        if (t <= 1 && s > 1) place(corner + 1, t, 2 - s, false);
        if (t > 1 && s > 1) place(corner + 2, 2 - s, 2 - t, false);
        if (t > 1 && s <= 1) place(corner + 3, 2 - t, s, false);
      }
    }
  }
  if (!with_trailing) return;
  for (const std::uint16_t t : sides_.trailing(corner)) place(corner, 0, share(t), true);
}

void Tessellation::fill_corner(std::int32_t corner, const AdaptiveRows& rows, Worker& worker,
                               SurfaceMesh& result) const {
  auto row = static_cast<std::size_t>(rows.first_of(corner));
  const auto add = [&](std::int32_t at, double u, double v, bool is_trailing) {
    worker.at.move_to(at);
    const PatchPoint point = worker.at.at({u, v});
    const double length = glm::length(point.normal);
    const bool is_known = length > 1e-6 * glm::length(point.du) * glm::length(point.dv);
    const glm::dvec3 normal =
        is_known ? point.normal / length
                 : surface_.evaluate(surface_parameter(topology_, at, u, v)).normal;
    glm::dvec3 position = point.position;
    if (const std::int32_t across = sides_.across(at); is_trailing && across >= 0) {
      worker.at.move_to(across);  // to the bit where the other side has it
      position = worker.at.at({v, 0}).position;
    }
    result.positions[row] = base_.placement().to_model(position);
    result.normals[row] = glm::vec3(normal);
    ++row;
  };
  own_places(corner, worker.grid, rows.owns_trailing(corner), add);
}

void Tessellation::fill_rows(const AdaptiveRows& rows, SurfaceMesh& result) const {
  const auto count = static_cast<std::size_t>(rows.count());
  result.positions.resize(count);
  result.normals.resize(count);
  for_corners(0.6, 0.8, [&](std::int32_t corner, Worker& worker) {
    fill_corner(corner, rows, worker, result);
  });
}

void Tessellation::fill_places(const AdaptiveRows& rows, const PatchNumbering& level_one,
                               RawVector<AdaptivePlace>& places) const {
  places = level_one_places(topology_, cells_, level_one, rows.count());
  const auto parts = [](double share) {
    return static_cast<std::uint16_t>(std::lround(share * kCellSide));
  };
  for_corners(0.8, 0.8, [&](std::int32_t corner, Worker& worker) {
    auto row = static_cast<std::size_t>(rows.first_of(corner));
    own_places(corner, worker.grid, rows.owns_trailing(corner),
               [&](std::int32_t at, double u, double v, bool) {
                 places[row++] = {at, parts(u), parts(v)};
               });
  });
}

// Those of level 1 are there already.
void Tessellation::carry(const AdaptiveSurface& surface, SurfaceMesh& result) const {
  const PolygonMesh& mesh = base_.mesh();
  const auto level_one = static_cast<std::size_t>(numbering_.row_count());
  const auto places = std::span(surface.places).subspan(level_one);
  if (!mesh.colors.empty()) {
    result.colors.resize(surface.places.size());
    field_at(surface_, base_.color_field(), places, [&](std::size_t i, const glm::dvec4& color) {
      result.colors[level_one + i] = glm::vec4(color);
    });
  }
  for (std::size_t k = 0; k < result.attributes.size(); ++k) {
    const VertexAttribute& given = mesh.attributes[k];
    VertexAttribute& made = result.attributes[k];
    made.values.resize(static_cast<std::size_t>(given.width) * surface.places.size());
    for (const NumberRun& run : runs_of(mesh.attributes, k))
      field_at(surface_, base_.number_field(run.four), places,
               [&](std::size_t i, const glm::dvec4& four) {
                 made.set_run(level_one + i, run, glm::vec4(four));
               });
  }
  if (!uv_numbering_) return;
  const auto uvs = static_cast<std::size_t>(uv_numbering_->row_count());
  result.uvs.resize(surface.uv_places.size());
  field_at(surface_, base_.uv_field(), std::span(surface.uv_places).subspan(uvs),
           [&](std::size_t i, const glm::dvec2& uv) { result.uvs[uvs + i] = uv; });
}

void Tessellation::fill_faces(const AdaptiveRows& rows, const AdaptiveRows* uv_rows,
                              SurfaceMesh& result) const {
  result.face_vertices.resize(static_cast<std::size_t>(3 * triangle_count()));
  result.face_uvs.resize(uv_rows != nullptr ? result.face_vertices.size() : 0);
  for_corners(0.85, 0.95, [&](std::int32_t corner, Worker& worker) {
    const auto c = static_cast<std::size_t>(corner);
    const auto first = static_cast<std::size_t>(3 * first_triangle_[c]);
    const auto count = static_cast<std::size_t>(3 * first_triangle_[c + 1]) - first;
    faces_.cut(corner, worker.grid, rows, result.positions, worker.faces,
               std::span(result.face_vertices).subspan(first, count));
    if (uv_rows == nullptr) return;
    faces_.name(corner, worker.grid, *uv_rows, worker.faces,
                std::span(result.face_uvs).subspan(first, count));
  });
}

// Grids need not name the middles of edges and faces.
void Tessellation::drop_unused(AdaptiveSurface& surface) const {
  if (std::ranges::none_of(cells_.grids, &FaceGrid::exists)) return;
  constexpr auto kVertices = PatchNumbering::Part::Vertices;
  drop_unnamed(surface, numbering_.end_row(kVertices),
               uv_numbering_ ? uv_numbering_->end_row(kVertices) : 0);
}

// What follows from the triangles' corners.
void Tessellation::finish(AdaptiveSurface& surface) const {
  SurfaceMesh& result = surface.mesh;
  const std::vector<std::int32_t>& groups = base_.mesh().face_groups;
  const auto count = static_cast<std::size_t>(triangle_count());
  result.level = 1;
  result.face_offsets.resize(count + 1);
  for (std::size_t t = 0; t <= count; ++t)
    result.face_offsets[t] = static_cast<std::int32_t>(3 * t);
  surface.ancestors.resize(count);
  result.face_groups.resize(groups.empty() ? 0 : count);
  for (std::int32_t c = 0; c < topology_.corner_count(); ++c) {
    const std::int32_t face = topology_.face_of(c);
    for (std::int64_t t = first_triangle_[c]; t < first_triangle_[c + 1]; ++t) {
      const auto at = static_cast<std::size_t>(t);
      surface.ancestors[at] = face;
      if (!groups.empty()) result.face_groups[at] = groups[face];
    }
  }
}

void Tessellation::warn_of_turns(const SurfaceMesh& result) const {
  if (options_.angle == 0) return;
  const TriangleTurns turns = turns_beyond(result, options_.angle);
  if (turns.count == 0) return;
  glm::dvec3 middle(0.0);
  for (std::int64_t k = 0; k < 3; ++k)
    middle += result.positions[result.face_vertices[3 * turns.worst + k]] / 3.0;
  options_.callbacks.warn(
      {.code = kAngleNotKept,
       .message = formatted(
           "an angle of {} degrees is not kept beneath {} of {} triangles: the surface turns by up "
           "to {} degrees between their corners, most near ({}, {}, {}), where it folds or has a "
           "tip; mend the mesh there, allow a larger angle, or take a chord error instead",
           shortest(options_.angle), turns.count, triangle_count(), short_number(turns.largest),
           short_number(middle.x), short_number(middle.y), short_number(middle.z)),
       .count = turns.count,
       .first = turns.first});
}

}  // namespace

AdaptiveSurface tessellate(const LimitSurface& surface, const AdaptiveOptions& options) {
  require_options(options);
  const HostScope host(options.callbacks);
  options.callbacks.report("evaluate", 0);
  const std::uint64_t limit =
      options.memory_limit_bytes > 0 ? options.memory_limit_bytes : available_memory_bytes();
  return Tessellation(surface, options, limit).run();
}

namespace {

// Those of the mesh come first, also where no corner names them.
template <class Vector, class Stored>
void write_corner_rows(const LimitSurface& surface, const ChartField<Vector>& field,
                       const AdaptiveSurface& made, std::span<const Stored> given,
                       std::span<Stored> values) {
  field_at(surface, field, made.uv_places,
           [&](std::size_t i, const Vector& value) { values[i] = Stored(value); });
  for (std::size_t i = 0; i < made.base_uvs.size(); ++i) values[i] = given[made.base_uvs[i]];
}

}  // namespace

bool AdaptiveBlocks::uvs_of(std::span<const glm::dvec2> given, std::span<glm::dvec2> values) const {
  write_corner_rows(lies_on_, lies_on_.surface().uv_field_of(given), adaptive_, given, values);
  return true;
}

bool AdaptiveBlocks::corners_of(std::span<const glm::vec4> given,
                                std::span<glm::vec4> values) const {
  write_corner_rows(lies_on_, lies_on_.surface().corner_field_of(given), adaptive_, given, values);
  return true;
}

bool AdaptiveBlocks::rows_of(std::span<const glm::vec4> given, std::span<glm::vec4> values) const {
  std::vector<glm::vec4> used;
  for (const std::int32_t vertex : lies_on_.surface().used().vertices)
    used.push_back(given[vertex]);
  field_at(lies_on_, lies_on_.surface().vertex_field_of(used), adaptive_.places,
           [&](std::size_t i, const glm::dvec4& value) { values[i] = glm::vec4(value); });
  return true;
}

SurfaceMesh AdaptiveBlocks::rows_on(const LimitSurface& other) const {
  constexpr std::size_t kAtOnce = std::size_t{1} << 14;
  const std::size_t count = adaptive_.places.size();
  SurfaceMesh made;
  made.positions.resize(count);
  made.normals.resize(count);
  std::vector<SurfaceParameter> places;
  std::vector<SurfacePoint> points;
  for (std::size_t first = 0; first < count; first += kAtOnce) {
    check_stop();
    places.clear();
    const std::size_t end = std::min(count, first + kAtOnce);
    for (std::size_t row = first; row < end; ++row) {
      const AdaptivePlace& at = adaptive_.places[row];
      places.push_back(
          surface_parameter(other.topology(), at.corner, share_of_side(at.u), share_of_side(at.v)));
    }
    points.resize(places.size());
    other.evaluate(places, points);
    for (std::size_t row = first; row < end; ++row) {
      made.positions[row] = points[row - first].position;
      made.normals[row] = glm::vec3(points[row - first].normal);
    }
  }
  return made;
}

}  // namespace planish
