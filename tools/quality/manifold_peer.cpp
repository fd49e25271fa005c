#include "quality/manifold_peer.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "planish/files/mesh_file.h"
#include "planish/mesh/statistics.h"

namespace planish::quality {

namespace {

namespace fs = std::filesystem;

class WorkFolder {
 public:
  WorkFolder() {
    std::string name = (fs::temp_directory_path() / "planish-quality-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ~WorkFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  [[nodiscard]] fs::path file(const char* name) const { return path_ / name; }

 private:
  fs::path path_;
};

// What node says on its output goes into a file.
void run_node(std::vector<std::string> words, const fs::path& said) {
  words.insert(words.begin(), "node");
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, said.c_str(), O_WRONLY | O_CREAT, 0600);
  pid_t child = 0;
  const int failed =
      ::posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  int status = 0;
  if (failed != 0) throw std::runtime_error("--manifold needs node, which is not installed");
  if (::waitpid(child, &status, 0) != child || status != 0)
    throw std::runtime_error("manifold-3d failed; is it in the folder (npm install manifold-3d)?");
}

}  // namespace

std::optional<PeerSurface> smoothed_by_manifold(const PolygonMesh& mesh, int n,
                                                const fs::path& folder) {
  if (statistics(mesh).boundary_loop_count > 0) return std::nullopt;
  const WorkFolder work;
  const fs::path given = work.file("given.obj"), made = work.file("made.obj"),
                 said = work.file("said.txt");
  write_mesh(given, FileFormat::Obj, mesh);
  run_node({PLANISH_QUALITY_SOURCES "/manifold_smooth.mjs", folder.string(), given.string(),
            std::to_string(n), made.string()},
           said);
  PeerSurface surface;
  surface.facets = read_mesh(made).mesh;
  std::ifstream(said) >> surface.milliseconds;
  return surface;
}

}  // namespace planish::quality
