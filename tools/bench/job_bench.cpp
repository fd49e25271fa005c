#include <fcntl.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bench/agreement.h"
#include "bench/bench_meshes.h"
#include "bench/benchmarks.h"
#include "bench/table_chain.h"
#include "planish/backend/cpu_backend.h"
#include "planish/core/formatted.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/files/obj/read_obj.h"
#include "planish/pipeline/fit.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/kept_rows.h"

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

}  // namespace planish::bench
