// planish-mpi-bench --generate torus:N: fits a torus of about N vertices, 3-, 4- and 6-gons, which
// every rank makes its slice of, so that no file and no machine has to hold it. Prints what each
// phase took, and bytes a vertex.
#include <mpi.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "planish/core/error.h"
#include "planish/distributed/fit_distributed.h"

namespace planish {
namespace {

// The same bits wherever a vertex is made.
double noise_of(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return static_cast<double>((x ^ (x >> 31)) >> 11) * 0x1p-52 - 1;
}

class TorusSlices {
 public:
  // Rounded to whole cells of 4 x 2 vertices.
  explicit TorusSlices(std::int64_t vertices)
      : side_(std::max<std::int64_t>(
            8, std::llround(std::sqrt(static_cast<double>(vertices)) / 4) * 4)) {}

  [[nodiscard]] MeshSlice make(const Ranks& ranks) const {
    MeshSlice slice;
    slice.vertices = slice.faces = even_layout(side_ * side_, ranks.size);
    for (std::int64_t v = slice.vertices[ranks.rank]; v < slice.vertices[ranks.rank + 1]; ++v)
      slice.positions.push_back(position(v));
    for (std::int64_t f = slice.faces[ranks.rank]; f < slice.faces[ranks.rank + 1]; ++f)
      add_face(f, slice);
    return slice;
  }

 private:
  [[nodiscard]] std::int64_t id(std::int64_t i, std::int64_t j) const {
    return i % side_ * side_ + j % side_;
  }
  [[nodiscard]] glm::dvec3 position(std::int64_t v) const {
    const double turn = 2 * std::numbers::pi / static_cast<double>(side_);
    const double around = turn * static_cast<double>(v / side_);
    const double across = turn * static_cast<double>(v % side_);
    const double ring = 1 + 0.4 * std::cos(across), step = 0.3 * 0.4 * turn;
    const auto noise = [&](std::int64_t c) {
      return step * noise_of(static_cast<std::uint64_t>(3 * v + c));
    };
    return {ring * std::cos(around) + noise(0), ring * std::sin(around) + noise(1),
            0.4 * std::sin(across) + noise(2)};
  }
  // Cells of 4 x 2 hold a hexagon, two triangles and five quads.
  void add_face(std::int64_t face, MeshSlice& slice) const {
    const std::int64_t cell = face / 8, k = face % 8;
    const std::int64_t i = cell / (side_ / 2) * 4, j = cell % (side_ / 2) * 2;
    const auto quad = [&](std::int64_t a, std::int64_t b) {
      const std::int64_t corners[] = {id(a, b), id(a + 1, b), id(a + 1, b + 1), id(a, b + 1)};
      slice.add_face(corners);
    };
    if (k == 0) {
      const std::int64_t corners[] = {id(i, j),         id(i + 1, j),     id(i + 2, j),
                                      id(i + 2, j + 1), id(i + 1, j + 1), id(i, j + 1)};
      slice.add_face(corners);
    } else if (k == 1) {
      quad(i + 2, j);
    } else if (k == 2) {
      const std::int64_t corners[] = {id(i + 3, j), id(i + 4, j), id(i + 4, j + 1)};
      slice.add_face(corners);
    } else if (k == 3) {
      const std::int64_t corners[] = {id(i + 3, j), id(i + 4, j + 1), id(i + 3, j + 1)};
      slice.add_face(corners);
    } else {
      quad(i + k - 4, j + 1);
    }
  }

  std::int64_t side_;
};

std::int64_t wanted_vertices(int argc, char** argv) {
  constexpr std::string_view kTorus = "torus:";
  std::int64_t count = 0;
  if (argc >= 3 && std::string_view(argv[1]) == "--generate" &&
      std::string_view(argv[2]).starts_with(kTorus)) {
    const std::string_view text = std::string_view(argv[2]).substr(kTorus.size());
    (void)std::from_chars(text.data(), text.data() + text.size(), count);
  }
  if (count < 64)
    throw Error(ErrorCode::InvalidArgument,
                "usage: planish-mpi-bench --generate torus:N [CAGE.ply], N from 64");
  return count;
}

void print(const DistributedFit& fit) {
  std::printf("%lld vertices, %lld faces, %lld entries, %d iterations, error %.3g\n",
              static_cast<long long>(fit.vertices), static_cast<long long>(fit.faces),
              static_cast<long long>(fit.entries), fit.solution.iterations, fit.solution.error.max);
  std::int64_t peak = 0, halo = 0, ghosts = 0;
  for (const RankFigures& rank : fit.ranks) {
    peak += rank.peak_bytes;
    halo += rank.halo;
    ghosts += rank.ghosts;
  }
  double total = 0;
  for (std::size_t p = 0; p < std::size(kPhases); ++p) {
    double slowest = 0;
    for (const RankFigures& rank : fit.ranks) slowest = std::max(slowest, rank.milliseconds[p]);
    total += slowest / 1000;
    std::printf("  %-6s %8.3f s\n", std::string(kPhases[p]).c_str(), slowest / 1000);
  }
  std::printf(
      "  all    %8.3f s; peak of all ranks %lld MB, %.0f bytes a vertex; halo %lld, ghosts "
      "with the second ring %lld\n",
      total, static_cast<long long>(peak / 1000000),
      static_cast<double>(peak) / static_cast<double>(fit.vertices), static_cast<long long>(halo),
      static_cast<long long>(ghosts));
}

}  // namespace
}  // namespace planish

int main(int argc, char** argv) {
  using namespace planish;
  int provided = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  const Ranks ranks(MPI_COMM_WORLD);
  int status = 0;
  try {
    const PetscSession petsc;
    const TorusSlices torus(wanted_vertices(argc, argv));
    JobWatch watch(ranks.rank);
    DistributedOptions options;
    if (argc > 3) options.cage = argv[3];
    const DistributedFit fit = fit_distributed(
        ranks, [&] { return torus.make(ranks); }, options, watch);
    if (ranks.rank == 0) print(fit);
  } catch (const std::exception& error) {
    if (ranks.rank == 0) std::fprintf(stderr, "planish-mpi-bench: %s\n", error.what());
    status = 2;
  }
  MPI_Finalize();
  return status;
}
