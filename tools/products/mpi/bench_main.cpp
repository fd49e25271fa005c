// planish-mpi-bench --generate torus:N: fits a torus of about N vertices, 3-, 4- and 6-gons, which
// every rank makes its slice of, so that no file and no machine has to hold it. Prints what each
// phase took, CPU time without waiting for others, and bytes a vertex.
#include <mpi.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/platform/machine.h"
#include "planish/distributed/fit_distributed.h"

namespace planish {
namespace {

double seconds(std::int64_t nanoseconds) { return 1e-9 * static_cast<double>(nanoseconds); }

// CPU time of this thread inside MPI, where it waits by looking again and again.
double seconds_in_mpi = 0;

}  // namespace

class MpiTimer {
 public:
  MpiTimer() : begin_(seconds(platform::thread_nanoseconds())) {}
  ~MpiTimer() { seconds_in_mpi += seconds(platform::thread_nanoseconds()) - begin_; }
  MpiTimer(const MpiTimer&) = delete;
  MpiTimer& operator=(const MpiTimer&) = delete;

 private:
  double begin_;
};

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
    throw Error(
        ErrorCode::InvalidArgument,
        "usage: planish-mpi-bench --generate torus:N [fair] [CAGE.ply] [TILES.json [LEVEL]], N "
        "from 64");
  return count;
}

void take_outputs(const std::vector<std::string>& arguments, DistributedOptions& options) {
  for (const std::string& argument : arguments) {
    if (argument.ends_with(".ply")) {
      options.cage = argument;
    } else if (argument.ends_with(".json")) {
      options.tiles = argument;
      options.tiles_options.gltf.name = "torus";
    } else if (argument == "fair") {
      options.method = InterpolationMethod::Fair;
    } else {
      options.tiles_options.level = std::stoi(argument);
    }
  }
}

// What each rank worked, on all of its threads: what a core of a quiet machine would take.
void print_work(const Ranks& ranks, const DistributedFit& fit) {
  const double work = seconds(platform::process_nanoseconds()) - seconds_in_mpi;
  const double most = max_over(ranks, work), least = min_over(ranks, work);
  const double share = static_cast<double>(fit.vertices) / ranks.size / 1e6;
  if (ranks.rank == 0)
    std::printf("  CPU a rank without MPI %.2f to %.2f s, at most %.2f s a million vertices\n",
                least, most, most / share);
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

// MPI's profiling interface: whoever calls these, PETSc too, comes here first.
#define PLANISH_TIMED(name, parameters, arguments) \
  extern "C" int MPI_##name parameters {           \
    const planish::MpiTimer timer;                 \
    return PMPI_##name arguments;                  \
  }
PLANISH_TIMED(Allreduce, (const void* a, void* b, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c),
              (a, b, n, t, o, c))
PLANISH_TIMED(Exscan, (const void* a, void* b, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c),
              (a, b, n, t, o, c))
PLANISH_TIMED(Allgather,
              (const void* a, int n, MPI_Datatype t, void* b, int m, MPI_Datatype u, MPI_Comm c),
              (a, n, t, b, m, u, c))
PLANISH_TIMED(Allgatherv,
              (const void* a, int n, MPI_Datatype t, void* b, const int* m, const int* p,
               MPI_Datatype u, MPI_Comm c),
              (a, n, t, b, m, p, u, c))
PLANISH_TIMED(Alltoall,
              (const void* a, int n, MPI_Datatype t, void* b, int m, MPI_Datatype u, MPI_Comm c),
              (a, n, t, b, m, u, c))
PLANISH_TIMED(Alltoallv,
              (const void* a, const int* n, const int* p, MPI_Datatype t, void* b, const int* m,
               const int* q, MPI_Datatype u, MPI_Comm c),
              (a, n, p, t, b, m, q, u, c))
PLANISH_TIMED(Bcast, (void* a, int n, MPI_Datatype t, int r, MPI_Comm c), (a, n, t, r, c))
PLANISH_TIMED(Recv, (void* a, int n, MPI_Datatype t, int r, int g, MPI_Comm c, MPI_Status* s),
              (a, n, t, r, g, c, s))
PLANISH_TIMED(Barrier, (MPI_Comm c), (c))
PLANISH_TIMED(Wait, (MPI_Request * r, MPI_Status* s), (r, s))
PLANISH_TIMED(Waitall, (int n, MPI_Request r[], MPI_Status s[]), (n, r, s))
PLANISH_TIMED(Waitany, (int n, MPI_Request r[], int* i, MPI_Status* s), (n, r, i, s))
#undef PLANISH_TIMED

int main(int argc, char** argv) {
  using namespace planish;
  int provided = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  const Ranks ranks(MPI_COMM_WORLD);
  int status = 0;
  try {
    const PetscSession petsc;
    const TorusSlices torus(wanted_vertices(argc, argv));
    RankWatch watch(ranks.rank);
    DistributedOptions options;
    take_outputs(std::vector<std::string>(argv + 3, argv + argc), options);
    const DistributedFit fit = fit_distributed(
        ranks, [&] { return torus.make(ranks); }, options, watch);
    if (ranks.rank == 0) print(fit);
    print_work(ranks, fit);
  } catch (const std::exception& error) {
    if (ranks.rank == 0) std::fprintf(stderr, "planish-mpi-bench: %s\n", error.what());
    status = 2;
  }
  MPI_Finalize();
  return status;
}
