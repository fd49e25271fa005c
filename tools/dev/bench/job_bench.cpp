#include <fcntl.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bench/benchmarks.h"
#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/files/obj/read_obj.h"
#include "planish/pipeline/fit.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/solve/backend.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/kept_rows.h"
#include "support/meshes.h"

extern char** environ;

namespace planish::bench {
namespace {

namespace fs = std::filesystem;

// A run takes seconds: its share of noise is small and fewer runs do.
constexpr int kJobRuns = 3;
constexpr int kJobLevel = 2;

// The files of a job, removed with the bench.
class JobFolder {
 public:
  JobFolder() {
    std::string name = (fs::temp_directory_path() / "planish-bench-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ~JobFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  JobFolder(const JobFolder&) = delete;
  JobFolder& operator=(const JobFolder&) = delete;
  [[nodiscard]] std::string file(const char* name) const { return (path_ / name).string(); }

 private:
  fs::path path_;
};

// Runs a program without a word; it must end with 0.
void run_program(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&actions, stream, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  const int failed =
      ::posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  int status = 0;
  if (failed != 0 || ::waitpid(child, &status, 0) != child || status != 0)
    throw std::runtime_error(words[0] + " failed");
}

bool is_installed(const std::string& program) {
  const char* folders = std::getenv("PATH");
  std::string_view left = folders == nullptr ? "" : folders;
  while (!left.empty()) {
    const std::size_t end = std::min(left.find(':'), left.size());
    if (::access((fs::path(left.substr(0, end)) / program).c_str(), X_OK) == 0) return true;
    left.remove_prefix(std::min(end + 1, left.size()));
  }
  return false;
}

// What any program has to do that writes so many bytes.
void set_and_write(const std::string& path, std::uint64_t bytes) {
  std::vector<char> piece(1 << 20);
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  if (file < 0) throw std::runtime_error(path + " cannot be written");
  for (std::uint64_t written = 0; written < bytes; written += piece.size()) {
    std::memset(piece.data(), static_cast<int>(written >> 20), piece.size());
    if (::write(file, piece.data(), std::min<std::uint64_t>(piece.size(), bytes - written)) < 0)
      throw std::runtime_error(path + " cannot be written");
  }
  ::close(file);
}

struct Rows {
  explicit Rows(std::int64_t count)
      : positions(static_cast<std::size_t>(count)), normals(positions.size()) {}

  void store() {
    parallel_each(positions.size(), 1 << 14, [&](std::size_t i) {
      const auto value = static_cast<double>(i & 7);
      positions[i] = {value, value + 1, value + 2};
      normals[i] = {1.0f, static_cast<float>(value), 0.0f};
    });
  }
  void evaluate(const SurfaceBlocks& blocks) {
    RowTarget all;
    all.positions = positions;
    all.normals = normals;
    (void)make_all_rows(blocks, all, {});
  }

  RawVector<glm::dvec3> positions;
  RawVector<glm::vec3> normals;
};

void write_text(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  if (!file.flush()) throw std::runtime_error(path + " cannot be written");
}

std::vector<std::string> fit_command(const JobFolder& folder,
                                     std::initializer_list<std::string> flags) {
  const std::string program = (fs::read_symlink("/proc/self/exe").parent_path() / "planish");
  std::vector<std::string> words = {
      program, "fit",    folder.file("in.obj"), "-o", folder.file("out.glb"), "--device",
      "cpu",   "--force"};
  words.insert(words.end(), flags);
  return words;
}

std::vector<std::string> progressive_command(const JobFolder& folder, int level) {
  return fit_command(folder, {"--levels", std::to_string(level), "--interpolation", "progressive",
                              "--report", folder.file("report.json")});
}

// Adds gltfpack as the baseline, where it is.
void add_gltfpack(Group& group, const JobFolder& folder) {
  if (!is_installed("gltfpack")) {
    std::fprintf(stderr, "%s: gltfpack is not installed and left out\n", group.name.c_str());
    return;
  }
  group.baseline = "gltfpack";
  group.peers.push_back(
      {"gltfpack", [&folder] {
         run_program({"gltfpack", "-i", folder.file("in.obj"), "-o", folder.file("packed.glb")});
       }});
}

// What everybody gets who gives triangles and no flag.
std::vector<Row> bench_triangles_job(const Options& options) {
  const PolygonMesh mesh = irregular_triangles(options.quad_count);
  const JobFolder folder;
  write_text(folder.file("in.obj"), obj_text(mesh));
  Group group;
  group.name = "job-triangles";
  group.size = formatted("{} irregular triangles", mesh.face_count());
  group.baseline = "planish-default-level-0";
  group.peers = {
      {"planish-default-level-0",
       [&] {
         run_program(fit_command(folder, {"--levels", "0", "--quiet"}));
       }},
      {"planish-quads-off-level-0", [&] {
         run_program(fit_command(folder, {"--levels", "0", "--quiet", "--quads", "off"}));
       }}};
  add_gltfpack(group, folder);
  return run_group(group, std::min(options.repetitions, kJobRuns));
}

}  // namespace

std::vector<Row> bench_job(const Options& options) {
  const auto backend = make_cpu_backend();
  const std::string text = obj_text(torus_grid(options.quad_count));
  const JobFolder folder;
  write_text(folder.file("in.obj"), text);
  const auto read = [&] {
    return read_obj({.bytes = std::as_bytes(std::span(text)), .name = "bench.obj", .path = {}});
  };
  const MeshFile file = read();
  const Fit fitted = fit(file.mesh, *backend);
  const DooSabinSurface base(fitted.cage, {});
  const auto blocks = base.level(kJobLevel);
  Rows rows(blocks->info().row_count);
  rows.evaluate(*blocks);
  require_agreement("job",
                    std::span<const glm::dvec3>(rows.positions).first(file.mesh.positions.size()),
                    file.mesh.positions);
  run_program(progressive_command(folder, kJobLevel));
  const std::uint64_t level_bytes = fs::file_size(folder.file("out.glb"));

  Group group;
  group.name = "job";
  group.size = formatted("{} quads, {} bytes of OBJ", file.mesh.face_count(), text.size());
  group.baseline = "planish-level-0";
  group.peers = {
      {"planish-level-0", [&] { run_program(progressive_command(folder, 0)); }},
      {"planish-level-2", [&] { run_program(progressive_command(folder, kJobLevel)); }},
      {"set-and-write-level-2", [&] { set_and_write(folder.file("plain"), level_bytes); }},
      {"read", [&] { (void)read(); }},
      {"fit", [&] { (void)fit(file.mesh, *backend); }},
      {"store-level-2", [&] { rows.store(); }},
      {"evaluation-level-2", [&] { rows.evaluate(*blocks); }},
      {"kept-rows-level-2", [&] { (void)keep_rows(*blocks, {}); }},
      {"planish-tables-level-2",
       [&] { apply_table_chain(fitted.cage, kJobLevel, rows.positions, rows.normals); }},
  };
  add_gltfpack(group, folder);
  std::vector<Row> rows_of_all = run_group(group, std::min(options.repetitions, kJobRuns));
  for (Row& row : bench_triangles_job(options)) rows_of_all.push_back(std::move(row));
  return rows_of_all;
}

namespace {

constexpr int kWorstLevel = 2;
constexpr int kWorstRuns = 5;
// Two 30,000-gons: of larger ones check() finds that limit masks would have too many entries.
constexpr std::int32_t kMostWorstQuads = 45'000;

// A ring of quads between two fans.
PolygonMesh two_fans(int n) {
  const PolygonMesh drum = test::prism(n);
  PolygonMesh mesh;
  mesh.positions = drum.positions;
  for (std::int32_t f = 0; f < drum.face_count(); ++f) {
    const auto face = drum.face(f);
    if (face.size() == 4) {
      mesh.add_face(face);
      continue;
    }
    glm::dvec3 middle(0.0);
    for (const std::int32_t v : face) middle += drum.positions[v] / static_cast<double>(n);
    const std::int32_t hub = mesh.vertex_count();
    mesh.positions.push_back(1.2 * middle);
    for (std::size_t i = 0; i < face.size(); ++i)
      mesh.add_face(std::array{face[i], face[(i + 1) % face.size()], hub});
  }
  return mesh;
}

// Every second corner of both polygons turns inward.
PolygonMesh star_drum(int n) {
  PolygonMesh mesh = test::prism(n);
  for (std::size_t v = 0; v < mesh.positions.size(); v += 2) {
    mesh.positions[v].x *= 0.6;
    mesh.positions[v].y *= 0.6;
  }
  return mesh;
}

PolygonMesh creased_bipyramid(int n) {
  PolygonMesh mesh = test::bipyramid(n);
  for (const std::int32_t edge : {0, n / 3, n / 2})
    for (const std::int32_t hub : {mesh.vertex_count() - 2, mesh.vertex_count() - 1})
      mesh.creases.push_back({edge, hub, kInfiniteSharpness});
  return mesh;
}

// Both polygons are a band along a spiral: one half of their corners turn inward by next to
// nothing.
PolygonMesh spiral_drum(int n) {
  PolygonMesh mesh = test::prism(n);
  constexpr double kTurns = 3;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const int i = v % n, half = n / 2;
    const bool is_outer = i < half;
    const double turns = kTurns * (is_outer ? i : n - 1 - i) / (half - 1);
    const double radius = 1 + 0.5 * turns - (is_outer ? 0 : 0.3);
    const double angle = 2 * std::numbers::pi * turns;
    mesh.positions[v].x = radius * std::cos(angle);
    mesh.positions[v].y = radius * std::sin(angle);
  }
  return mesh;
}

// Closed parts through one another, two hubs and slivers in each.
PolygonMesh crossing_cones(int n) {
  PolygonMesh mesh;
  for (int part = 0; part < 3; ++part) {
    const PolygonMesh cone = test::bipyramid(n);
    const std::int32_t first = mesh.vertex_count();
    for (const glm::dvec3& p : cone.positions) {
      const glm::dvec3 moved = glm::dvec3(1, 1, 3) * p + 0.1 * part;
      mesh.positions.push_back({moved[part], moved[(part + 1) % 3], moved[(part + 2) % 3]});
    }
    for (std::int32_t f = 0; f < cone.face_count(); ++f) {
      std::vector<std::int32_t> face;
      for (const std::int32_t v : cone.face(f)) face.push_back(first + v);
      mesh.add_face(face);
    }
  }
  return mesh;
}

}  // namespace

std::vector<Row> bench_worst(const Options& options) {
  const std::int32_t quads = std::min(options.quad_count, kMostWorstQuads);
  const auto backend = make_cpu_backend();
  Group group;
  group.name = "worst";
  group.baseline = "torus";
  const auto add = [&](const std::string& name, const PolygonMesh& mesh) {
    group.peers.push_back({name, [&backend, mesh] {
                             const FittedMesh fitted = fit_mesh(mesh, "bench", *backend);
                             const EvaluateOptions at = fitted.evaluate_options(kWorstLevel);
                             (void)evaluate(fitted.mesh, fitted.fit, *backend, at);
                           }});
  };
  const PolygonMesh torus = torus_grid(quads);
  const auto corners = static_cast<std::int32_t>(torus.face_vertices.size());
  group.size = std::to_string(corners) + " corners each, level " + std::to_string(kWorstLevel);
  add("torus", torus);
  add("drum", test::prism(corners / 6));
  add("star-drum", star_drum(corners / 12 * 2));
  add("spiral-drum", spiral_drum(corners / 12 * 2));
  add("two-fans", two_fans(corners / 10));
  add("bipyramid", test::bipyramid(corners / 6));
  add("creased-bipyramid", creased_bipyramid(corners / 6));
  add("crossing-cones", crossing_cones(corners / 18));
  add("open-fan", test::open_fan(std::min(corners / 3, 65'000)));
  return run_group(group, std::min(options.repetitions, kWorstRuns));
}

}  // namespace planish::bench
