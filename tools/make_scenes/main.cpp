#include <charconv>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

#include "make_scenes/sample_points.h"
#include "make_scenes/scene_list.h"
#include "planish/core/output_file.h"
#include "planish/mesh/mesh_file.h"

namespace {

constexpr const char* kUsage =
    "usage: planish-make-scenes OUTDIR                   every generated scene\n"
    "       planish-make-scenes --cloud MESH COUNT OUT.ply   a Poisson-disk sampling of a mesh\n";

void write(const std::filesystem::path& path, const std::string& bytes) {
  planish::OutputFile file(path);
  file.write(bytes);
  file.commit();
}

void write_scenes(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder / "bad");
  for (const auto& scene : planish::shapes::scenes())
    write(folder / scene.file, planish::shapes::scene_text(scene));
  for (const auto& bad : planish::shapes::bad_files()) write(folder / "bad" / bad.file, bad.bytes);
}

void write_cloud(const std::string& mesh_path, std::string_view count_text,
                 const std::filesystem::path& path) {
  std::int32_t count = 0;
  const auto [end, error] =
      std::from_chars(count_text.data(), count_text.data() + count_text.size(), count);
  if (error != std::errc() || end != count_text.data() + count_text.size() || count < 1)
    throw std::invalid_argument("COUNT: a whole number from 1 is wanted");
  const auto format = planish::format_of(mesh_path);
  if (!format) throw std::invalid_argument(mesh_path + ": unknown mesh format");
  const planish::PolygonMesh mesh =
      planish::read_mesh(planish::read_file(mesh_path), mesh_path, *format).mesh;
  write(path, planish::shapes::ply_text(planish::shapes::sample_poisson_disk(mesh, count, 1)));
}

}  // namespace

int main(int argument_count, char** arguments) {
  const bool wants_cloud = argument_count == 5 && std::string_view(arguments[1]) == "--cloud";
  if (argument_count != 2 && !wants_cloud) {
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
