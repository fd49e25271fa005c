#include "planish/limit/adaptive_cells.h"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <span>
#include <string>

#include "planish/core/error.h"
#include "planish/core/host_scope.h"
#include "planish/core/number_text.h"
#include "planish/core/parallel.h"
#include "planish/limit/fewest_cells.h"

namespace planish {
namespace {

// Faces a task: their cells are kept together until all are counted.
constexpr std::size_t kFaceGrain = 64;
// A grid has no places of neighbours on its sides that its own do not fit: so it may take this many
// times as many parts as there are cells.
constexpr double kGridShare = 1.1;
// What a cell takes with its share of vertices and triangles while a tessellation is made.
constexpr std::uint64_t kCellBytes = 150;
// Two triangles a cell and some beside finer ones; their corners are counted in 32 bits.
constexpr std::uint64_t kMostCells = std::uint64_t{1} << 28;

// Twice as much as would be refused, and two digits: what surely is enough.
std::string larger_error(double distance, double cells, std::uint64_t most) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1e", 2 * distance * cells / static_cast<double>(most));
  return text;
}

void require_count(double cells, const CellLimits& limits, std::uint64_t most) {
  if (!(cells > static_cast<double>(most))) return;
  char count[32];
  std::snprintf(count, sizeof count, "%.1e", 2 * cells);
  throw Error(ErrorCode::OutOfMemory,
              formatted("a chord error of {} of the diagonal takes at least {} triangles, but "
                        "memory and 32-bit indices take {}; allow an error of {} or more",
                        shortest(limits.distance), count, 2 * most,
                        larger_error(limits.distance, cells, most)));
}

// The cells of faces, one block of them after the other.
class FaceCells {
 public:
  FaceCells(const LimitSurface& surface, const CellLimits& limits, std::uint64_t most,
            const PatchReaches& reaches, AdaptiveCells& result)
      : surface_(surface),
        topology_(surface.topology()),
        limits_(limits),
        result_(result),
        splitter_(surface, reaches, limits, most),
        finder_(surface) {}

  // Appends a face's cells, and tells how many a corner has; or sets its grid.
  void run(std::int32_t face, std::vector<AdaptiveCell>& cells, std::span<std::int64_t> sizes) {
    const std::int32_t first = topology_.first_corner(face), size = topology_.face_size(face);
    const std::size_t before = cells.size();
    for (std::int32_t c = first; c < first + size; ++c) {
      const std::size_t start = cells.size();
      splitter_.run(c, {.leading = is_border(c), .trailing = is_border(topology_.prev(c))}, cells);
      sizes[c] = static_cast<std::int64_t>(cells.size() - start);
    }
    const FaceGrid grid = grid_of(face, cells.size() - before);
    if (!grid.exists()) return;
    result_.grids[face] = grid;
    cells.resize(before);
    std::ranges::fill(
        sizes.subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(size)), 0);
  }

 private:
  // Whether a corner's leading edge ends the surface or is sharp.
  [[nodiscard]] bool is_border(std::int32_t corner) const {
    const std::int32_t other = topology_.twin(corner);
    return other < 0 || result_.hidden[other] != 0 || surface_.surface().patches().is_sharp(corner);
  }
  [[nodiscard]] FaceGrid grid_of(std::int32_t face, std::size_t cells) {
    if (topology_.face_size(face) != 4) return {};
    GridFinder::Limits limits{.distance = limits_.distance, .turn = limits_.turn};
    for (std::int32_t i = 0; i < 4; ++i)
      limits.borders[i] = is_border(topology_.first_corner(face) + i);
    limits.most = static_cast<int>(std::min(kGridShare * static_cast<double>(cells), 1e6));
    return finder_.find(face, limits);
  }

  const LimitSurface& surface_;
  const MeshTopology& topology_;
  const CellLimits& limits_;
  AdaptiveCells& result_;
  CellSplitter splitter_;
  GridFinder finder_;
};

std::vector<std::uint8_t> hidden_corners(const LimitSurface& surface) {
  const MeshTopology& topology = surface.topology();
  const std::span<const std::uint8_t> faces = surface.surface().hidden();
  std::vector<std::uint8_t> hidden(static_cast<std::size_t>(topology.corner_count()), 0);
  for (std::size_t c = 0; c < hidden.size() && !faces.empty(); ++c)
    hidden[c] = faces[topology.face_of(static_cast<std::int32_t>(c))];
  return hidden;
}

}  // namespace

AdaptiveCells make_cells(const LimitSurface& surface, const CellLimits& limits,
                         std::uint64_t memory_limit_bytes, const Callbacks& callbacks) {
  const MeshTopology& topology = surface.topology();
  const auto count = static_cast<std::size_t>(topology.face_count());
  AdaptiveCells result;
  result.hidden = hidden_corners(surface);
  result.grids.resize(count);
  PatchReaches reaches;
  for (const PatchForm* form : surface.forms()) reaches.add(*form);
  const std::size_t blocks = (count + kFaceGrain - 1) / kFaceGrain;
  std::vector<std::vector<AdaptiveCell>> of_block(blocks);
  std::vector<std::int64_t> sizes(result.hidden.size(), 0);
  const std::uint64_t most = std::min(memory_limit_bytes / kCellBytes, kMostCells);
  // Before cells are made: they would be as many as memory takes by the time that it is known.
  if (limits.distance > 0)
    require_count(fewest_cells(surface, result.hidden, limits.distance), limits, most);
  std::atomic<std::uint64_t> total{0};
  LoopProgress progress(callbacks, "evaluate", 0.1, 0.9, static_cast<std::int64_t>(blocks));
  parallel_for(blocks, 1, [&](std::size_t begin, std::size_t end) {
    FaceCells faces(surface, limits, most, reaches, result);
    for (std::size_t b = begin; b < end; ++b) {
      std::vector<AdaptiveCell>& cells = of_block[b];
      for (std::size_t i = b * kFaceGrain; i < std::min(count, (b + 1) * kFaceGrain); ++i) {
        const auto face = static_cast<std::int32_t>(i);
        if (result.hidden[topology.first_corner(face)] != 0) continue;
        const std::size_t before = cells.size();
        faces.run(face, cells, sizes);
        const FaceGrid& grid = result.grids[i];
        const std::uint64_t more =
            cells.size() - before + static_cast<std::uint64_t>(grid.u) * grid.v;
        if (total.fetch_add(more) + more > most) refuse_count(most);
      }
      progress.add();
    }
  });
  result.first.assign(1, 0);
  for (const std::int64_t size : sizes) result.first.push_back(result.first.back() + size);
  result.cells.resize(static_cast<std::size_t>(result.first.back()));
  auto to = result.cells.begin();
  for (std::vector<AdaptiveCell>& cells : of_block) {
    to = std::copy(cells.begin(), cells.end(), to);
    cells = {};
  }
  return result;
}

}  // namespace planish
