#include "planish/limit/adaptive_tessellation.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/host_scope.h"
#include "planish/core/number_text.h"
#include "planish/core/parallel.h"
#include "planish/limit/adaptive_faces.h"
#include "planish/limit/adaptive_rows.h"
#include "planish/limit/field_at.h"
#include "planish/limit/triangle_turns.h"
#include "planish/limit/used_rows.h"
#include "planish/surface/doo_sabin_blocks.h"
#include "planish/surface/memory_need.h"

namespace planish {
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
  SurfaceMesh& result = surface.mesh;
  if (std::ranges::none_of(cells_.grids, &FaceGrid::exists)) return;
  constexpr auto kVertices = PatchNumbering::Part::Vertices;
  const std::vector<std::int32_t> rows =
      rename_used(result.face_vertices, numbering_.end_row(kVertices),
                  static_cast<std::int64_t>(result.positions.size()));
  keep_only(result.positions, rows);
  keep_only(result.normals, rows);
  keep_only(surface.places, rows);
  if (!result.colors.empty()) keep_only(result.colors, rows);
  for (VertexAttribute& attribute : result.attributes)
    attribute = std::move(attributes_of({&attribute, 1}, rows).front());
  if (!uv_numbering_) return;
  const std::vector<std::int32_t> uvs =
      rename_used(result.face_uvs, uv_numbering_->end_row(kVertices),
                  static_cast<std::int64_t>(result.uvs.size()));
  keep_only(result.uvs, uvs);
  keep_only(surface.uv_places, uvs);
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

}  // namespace planish
