// Based on: "Smooth Surface Reconstruction using Doo-Sabin Subdivision Surfaces", section 3, of a
// mesh that no machine has to hold: each phase ends in an exchange, everything between is local.
#include "planish/distributed/fit_distributed.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <optional>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/platform/machine.h"
#include "planish/core/words.h"
#include "planish/distributed/part_tiles.h"
#include "planish/distributed/read_slices.h"
#include "planish/distributed/write_cage.h"
#include "planish/fair/fair_net.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/fit_steps.h"

namespace planish {

namespace {

void warn_of_semi_sharp(const Ranks& ranks, const MeshSlice& slice,
                        std::vector<Warning>& warnings) {
  std::int64_t count = 0;
  for (const SliceCrease& crease : slice.creases)
    count += crease.sharpness > 0 && crease.sharpness < kInfiniteSharpness ? 1 : 0;
  count = sum_over(ranks, count);
  if (count == 0) return;
  warnings.push_back(
      {.code = "semi-sharp-creases",
       .message = formatted(
           "creases of a sharpness below 10, taken as smooth: {}; give 10 for a sharp edge", count),
       .count = count});
}

void warn_of_bare_cage(const SliceAttributes& attributes, std::vector<Warning>& warnings) {
  if (!attributes.has_colors && !attributes.has_uvs) return;
  warnings.push_back({.code = "bare-cage",
                      .message =
                          "ranks write the cage of a fair surface without the mesh's colours and "
                          "texture coordinates; planish on one machine writes them",
                      .count = 1});
}

// Of the vertices that faces name, as on one machine; `points` are at least the owned ones.
Placement placement_over(const Ranks& ranks, const MeshPart& part,
                         std::span<const glm::dvec3> points) {
  glm::dvec3 low(std::numeric_limits<double>::max());
  glm::dvec3 high(std::numeric_limits<double>::lowest());
  for (std::int32_t v = 0; v < part.owned_count(); ++v) {
    if (part.around(v).empty()) continue;
    low = glm::min(low, points[v]);
    high = glm::max(high, points[v]);
  }
  MPI_Allreduce(MPI_IN_PLACE, &low.x, 3, MPI_DOUBLE, MPI_MIN, ranks.comm);
  MPI_Allreduce(MPI_IN_PLACE, &high.x, 3, MPI_DOUBLE, MPI_MAX, ranks.comm);
  const glm::dvec3 corners[2] = {low, high};
  return placement_of(std::span<const glm::dvec3>(corners));
}

std::vector<glm::dvec3> unit_points(const Placement& placement,
                                    std::span<const glm::dvec3> positions) {
  std::vector<glm::dvec3> points(positions.size());
  parallel_each(points.size(), 4096,
                [&](std::size_t v) { points[v] = placement.to_unit(positions[v]); });
  return points;
}

class DistributedJob {
 public:
  DistributedJob(const Ranks& ranks, const DistributedOptions& options, RankWatch& watch)
      : ranks_(ranks), options_(options), watch_(watch) {}

  void read(const std::function<MeshSlice()>& read_slice) {
    watch_.begin("read");
    slice_ = read_slice();
    fit_.vertices = slice_.vertex_total();
    fit_.faces = slice_.face_total();
    fit_.warnings = slice_.warnings;
    vertices_ = slice_.vertices;
    add_tags(ranks_, options_.crease_edges, options_.corner_vertices, slice_);
    if (!options_.sharp.use_tags) clear_tags(slice_);
    if (options_.sharp.use_tags) warn_of_semi_sharp(ranks_, slice_, fit_.warnings);
    if (!options_.cage.empty() && is_fair()) {
      corners_ = corner_starts_of(ranks_, slice_);
      warn_of_bare_cage(slice_.attributes, fit_.warnings);
    }
    if (!options_.cage.empty() && !is_fair()) cage_faces_ = encode_cage_faces(ranks_, slice_);
    if (options_.tiles.empty()) slice_.attributes = {};
    watch_.fault_point();
  }

  void distribute() {
    watch_.begin("sort");
    CurveOrder order = order_along_curve(ranks_, slice_, block_vertices());
    watch_.fault_point();
    watch_.begin("faces");
    FaceStream first_ring = send_first_ring(ranks_, slice_, order);
    watch_.fault_point();
    watch_.begin("rings");
    part_ = make_part(ranks_, std::move(first_ring), slice_, std::move(order));
    slice_ = {};
    watch_.fault_point();
  }

  PartRows make_part_rows() {
    watch_.begin("rows", block_count());
    const RowOptions options{options_.weights, options_.sharp, block_vertices(),
                             [&] { watch_.tick(); }};
    PartRows rows = make_rows(ranks_, part_, options_.name, fit_.faces, options);
    fit_.placement = placement_over(ranks_, part_, part_.positions);
    std::int64_t used = 0;
    for (std::size_t kind = 0; kind < rows.kinds.size(); ++kind) {
      used += fit_.kinds[kind] = sum_over(ranks_, rows.kinds[kind]);
    }
    fit_.unused_vertices = fit_.vertices - used;
    fit_.entries =
        sum_over(ranks_, static_cast<std::int64_t>(rows.columns.size() + rows.sums.columns.size()));
    fit_.spectral_bound = rows.spectral_bound;
    fit_.has_boundary = rows.has_boundary;
    note_figures(rows);
    leave_points(rows);
    // The solve needs rows and owned vertices only.
    if (options_.tiles.empty() && !is_fair()) drop_rings();
    watch_.fault_point();
    return rows;
  }

  void find_points(PartRows rows) {
    watch_.begin("solve");
    if (is_fair()) {
      rows = {};
      build_fair();
    } else {
      solve(std::move(rows));
    }
    watch_.fault_point();
  }

  void place_cage() {
    const std::vector<glm::dvec3>& points = is_fair() ? part_.positions : solve_points();
    cage_.assign(points.begin(), points.begin() + part_.owned_count());
    if (is_fair()) return;
    const std::vector<glm::dvec3>& moves = fit_.solution.displacement;
    for (std::size_t v = 0; v < cage_.size(); ++v) cage_[v] += fit_.placement.diagonal * moves[v];
  }

  void write_tiles() {
    if (options_.tiles.empty()) return;
    watch_.begin("tiles", block_count());
    staged_tiles_.emplace(ranks_, options_.tiles, options_.resume, options_.replaces);
    PartTilesOptions options;
    options.tiles = options_.tiles_options;
    options.tiles.gltf.double_sided = fit_.has_boundary;
    options.tiles.gltf.extras = extras();
    options.weights = options_.weights;
    options.sharp = options_.sharp;
    options.placement = is_fair() ? fit_.placement : placement_over(ranks_, part_, cage_);
    options.fair = fit_.fair ? &*fit_.fair : nullptr;
    options.points = points_;
    options.records = staged_tiles_->records();
    options.after_block = [&] {
      watch_.tick();
      watch_.fault_point();
    };
    fetch_tags();
    std::vector<glm::dvec3> cage = cage_;
    const auto ghosts = fetch<glm::dvec3>(ranks_, part_.ghosts, part_.layout,
                                          [&](std::int64_t place) { return cage_[place]; });
    cage.insert(cage.end(), ghosts.begin(), ghosts.end());
    fit_.tiles = write_part_tiles(ranks_, staged_tiles_->document(), part_, cage, options);
    warn_of_tiles(*fit_.tiles);
    if (!is_fair() || options_.cage.empty()) drop_rings();
  }

  DistributedFit finish(const std::function<void(const DistributedFit&)>& before_commit) {
    watch_.begin("write");
    std::optional<StagedFile> cage;
    if (!options_.cage.empty()) write_cage_to(cage);
    watch_.fault_point();
    watch_.end();
    if (fit_.fair) {
      fit_.fair->state = {};
      fit_.fair->keys = {};
    }
    gather_figures();
    part_.file_ids.resize(static_cast<std::size_t>(part_.owned_count()));
    fit_.file_ids = std::move(part_.file_ids);
    if (before_commit) before_commit(fit_);
    if (staged_tiles_) staged_tiles_->commit();
    if (cage) cage->commit();
    return std::move(fit_);
  }

 private:
  [[nodiscard]] bool is_fair() const { return options_.method == InterpolationMethod::Fair; }

  void write_cage_to(std::optional<StagedFile>& file) {
    if (is_fair()) {
      const FairCage cage = make_fair_cage(ranks_, part_, *fit_.fair, corners_, options_.sharp);
      file.emplace(ranks_, options_.cage, options_.replaces);
      write_cage(ranks_, cage.vertices, cage.face_total, cage.positions, cage.faces,
                 options_.cage_header, *file);
      return;
    }
    const std::vector<glm::dvec3> points = in_file_order(ranks_, vertices_, part_.file_ids, cage_);
    cage_ = {};
    file.emplace(ranks_, options_.cage, options_.replaces);
    write_cage(ranks_, vertices_, fit_.faces, points, cage_faces_, options_.cage_header, *file);
  }

  // What the surface passes through, by local vertex.
  [[nodiscard]] const std::vector<glm::dvec3>& solve_points() const {
    return points_.empty() ? part_.positions : points_;
  }

  [[nodiscard]] PartFairOptions part_options() {
    PartFairOptions options;
    options.fit.weights = options_.weights;
    options.fit.sharp = options_.sharp;
    options.fit.tolerance = options_.tolerance;
    options.fit.within = options_.within;
    options.fit.polish_steps = options_.polish_steps;
    options.placement = fit_.placement;
    options.points = points_;
    options.block_vertices = block_vertices();
    options.after_exchange = [&] { watch_.tick(); };
    return options;
  }

  void fetch_tags() {
    if (!std::exchange(has_ghost_tags_, true)) fetch_ghost_tags(ranks_, part_);
  }

  void leave_points(PartRows& rows) {
    if (options_.within == 0) return;
    fetch_tags();
    PartWithin within = bend_part_least(ranks_, part_, part_options());
    fit_.within = within.figures;
    points_ = std::move(within.points);
    if (points_.empty()) return;
    for (std::size_t i = 0; i < rows.ghosts.size(); ++i)
      rows.ghost_points[i] = points_[part_.local_of(rows.ghosts[i])];
  }

  void solve(PartRows rows) {
    const PetscSolveOptions options{options_.solver, options_.tolerance, options_.max_iterations,
                                    block_vertices(), [&] { watch_.tick(); }};
    const auto owned = static_cast<std::size_t>(part_.owned_count());
    const auto given = unit_points(fit_.placement, std::span(solve_points()).first(owned));
    const auto ghosts = unit_points(fit_.placement, rows.ghost_points);
    fit_.solution = petsc_solve(ranks_, part_.layout, rows, given, ghosts,
                                fit_.vertices - fit_.unused_vertices, options);
    own_.peers = fit_.solution.peers;
  }

  void build_fair() {
    fetch_tags();
    const PartFair& fair = fit_.fair.emplace(make_part_fair(ranks_, part_, part_options()));
    fit_.solution.converged = fair.converged;
    fit_.solution.stop_reason = fair.converged ? StopReason::Converged : StopReason::Stagnated;
    fit_.solution.error = fair.error;
    if (fair.flagged_edges + fair.flagged_faces > 0)
      fit_.warnings.push_back(folds_left_warning(fair.flagged_edges, fair.flagged_faces));
    if (fair.concave_faces > 0) fit_.warnings.push_back(concave_faces_warning(fair.concave_faces));
  }

  // As planish fit warns; rank 0 alone knows.
  void warn_of_tiles(const PartTiles& tiles) {
    const std::int64_t degenerate = tiles.file.degenerate.count;
    if (degenerate > 0)
      fit_.warnings.push_back(
          {.code = "degenerate-normals",
           .message =
               counted(degenerate, "vertex") +
               (degenerate == 1 ? " has parallel tangents; its normal is that of the facets"
                                : " have parallel tangents; their normals are those of the facets"),
           .count = degenerate});
    const double rounded = tiles.file.largest_distance / fit_.placement.diagonal;
    if (fit_.solution.converged && rounded > options_.tolerance)
      fit_.warnings.push_back(
          {.code = "rounded-output",
           .message =
               formatted("{}: rounding for the file leaves an error of {}, above the "
                         "tolerance {}; --cage keeps every digit",
                         options_.tiles, short_number(rounded), short_number(options_.tolerance))});
    constexpr double kFoldedAreaLimit = 1e-4;  // as planish fit
    const SurfaceQuality& quality = tiles.quality;
    if (quality.folded_area > kFoldedAreaLimit)
      fit_.warnings.push_back(
          {.code = "folded-area",
           .message = formatted("{} of the surface is folded (turned by more than 90 degrees "
                                "from its face), first at face {}",
                                percent(quality.folded_area), tiles.folded_faces.front()),
           .count = 1,
           .first = tiles.folded_faces.front()});
  }

  [[nodiscard]] FileExtras extras() const {
    FitOptions fitted;
    fitted.method = options_.method;
    fitted.weights = options_.weights;
    fitted.solver = options_.solver;
    fitted.tolerance = options_.tolerance;
    fitted.sharp = options_.sharp;
    Interpolation result;
    result.converged = fit_.solution.converged;
    result.iterations = fit_.solution.iterations;
    result.error = fit_.solution.error;
    return fit_extras(fitted, options_.creases, result);
  }

  void note_figures(const PartRows& rows) {
    own_.rank = ranks_.rank;
    own_.vertices = part_.owned_count();
    own_.faces = part_.face_count();
    own_.ghosts = static_cast<std::int64_t>(part_.ghosts.size());
    own_.halo = static_cast<std::int64_t>(rows.ghosts.size());
    const std::string host = platform::host_name();
    host.copy(own_.host.data(), own_.host.size() - 1);
  }

  [[nodiscard]] std::int64_t block_vertices() const {
    return options_.tiles.empty() ? options_.block_vertices
                                  : options_.tiles_options.tile_vertices / 4;
  }

  [[nodiscard]] std::int64_t block_count() const {
    return (part_.owned_count() + block_vertices() - 1) / block_vertices();
  }

  // All but the owned vertices.
  void drop_rings() {
    MeshPart kept;
    kept.layout = part_.layout;
    kept.rank = part_.rank;
    const auto owned = static_cast<std::size_t>(part_.owned_count());
    kept.file_ids.assign(part_.file_ids.begin(), part_.file_ids.begin() + owned);
    kept.positions.assign(part_.positions.begin(), part_.positions.begin() + owned);
    part_ = std::move(kept);
  }

  void gather_figures() {
    own_.peak_bytes = static_cast<std::int64_t>(platform::peak_memory());
    for (const PhaseFigures& phase : watch_.phases()) {
      const auto place = std::ranges::find(kPhases, phase.name) - std::begin(kPhases);
      own_.milliseconds[place] += 1000 * phase.seconds;
    }
    const auto all = gather(ranks_, std::span<const RankFigures>(&own_, 1));
    fit_.ranks.assign(all.begin(), all.end());
  }

  const Ranks& ranks_;
  const DistributedOptions& options_;
  RankWatch& watch_;
  MeshSlice slice_;
  Layout vertices_;
  CageFaces cage_faces_;
  CornerStarts corners_;
  MeshPart part_;
  bool has_ghost_tags_ = false;
  std::vector<glm::dvec3> points_;  // as PartWithin has them
  std::vector<glm::dvec3> cage_;    // of owned vertices
  std::optional<StagedTileset> staged_tiles_;
  RankFigures own_;
  DistributedFit fit_;
};

}  // namespace

DistributedFit fit_distributed(const Ranks& ranks, const std::function<MeshSlice()>& read,
                               const DistributedOptions& options, RankWatch& watch,
                               const std::function<void(const DistributedFit&)>& before_commit) {
  agree(ranks, [&] {
    if (options.block_vertices < 1 || options.block_vertices > std::int64_t{1} << 24)
      throw Error(
          ErrorCode::InvalidArgument,
          formatted("blocks of {} vertices; 1 to 16777216 are wanted", options.block_vertices));
    FairOptions fair;
    fair.polish_steps = options.polish_steps;
    require_valid(fair);
  });
  DistributedJob job(ranks, options, watch);
  job.read(read);
  job.distribute();
  PartRows rows = job.make_part_rows();
  job.find_points(std::move(rows));
  job.place_cage();
  job.write_tiles();
  return job.finish(before_commit);
}

}  // namespace planish
