#include <charconv>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

#include "make_scenes/models.h"
#include "make_scenes/sample_points.h"
#include "make_scenes/scene_list.h"
#include "planish/core/output_file.h"
#include "planish/files/mesh_file.h"
#include "planish/reconstruct/mesher_process.h"

namespace {

constexpr const char* kUsage =
    "usage: planish-make-scenes OUTDIR                   every generated scene\n"
    "       planish-make-scenes --cloud MESH COUNT OUT.ply   a Poisson-disk sampling of a mesh\n";

void write(const std::filesystem::path& path, const std::string& bytes) {
  planish::OutputFile file(path);
  file.write(bytes);
  file.commit();
}

void write_scan(const std::filesystem::path& folder) {
  const auto mesher = planish::find_mesher_program();
  if (!mesher) {
    std::fprintf(stderr, "planish-make-scenes: without planish-reconstruct %s is not made\n",
                 planish::shapes::kScanFile);
    return;
  }
  const auto mesh = planish::shapes::scanned_rocker_arm(planish::mesher_process(*mesher));
  write(folder / planish::shapes::kScanFile,
        planish::shapes::obj_text(mesh, "Rocker arm of an engine, scanned and simplified"));
}

void write_scenes(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder / "bad");
  for (const auto& scene : planish::shapes::scenes())
    write(folder / scene.file, planish::shapes::scene_text(scene));
  for (const auto& bad : planish::shapes::bad_files()) write(folder / "bad" / bad.file, bad.bytes);
  write_scan(folder);
}

void write_cloud(const std::string& mesh_path, std::string_view count_text,
                 const std::filesystem::path& path) {
  std::int32_t count = 0;
  const auto [end, error] =
      std::from_chars(count_text.data(), count_text.data() + count_text.size(), count);
  if (error != std::errc() || end != count_text.data() + count_text.size() || count < 1)
    throw std::invalid_argument("COUNT: a whole number from 1 is wanted");
  const planish::PolygonMesh mesh = planish::read_mesh(mesh_path).mesh;
  write(path, planish::shapes::ply_text(planish::shapes::sample_poisson_disk(mesh, count, 1)));
}

}  // namespace

int main(int argument_count, char** arguments) {
  const bool wants_cloud = argument_count == 5 && std::string_view(arguments[1]) == "--cloud";
  const bool wants_scenes = argument_count == 2 && arguments[1][0] != '-';
  if (!wants_scenes && !wants_cloud) {
    std::fputs(kUsage, stderr);
    return 2;
  }
  try {
    if (wants_cloud) {
      write_cloud(arguments[2], arguments[3], arguments[4]);
    } else {
      write_scenes(arguments[1]);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "planish-make-scenes: %s\n", error.what());
    return 7;
  }
  return 0;
}
