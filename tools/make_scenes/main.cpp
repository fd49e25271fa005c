#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "make_scenes/obj_text.h"
#include "make_scenes/scan.h"
#include "make_scenes/scene_list.h"
#include "planish/core/output_file.h"
#include "planish/reconstruct/mesher_process.h"

namespace {

void write(const std::filesystem::path& path, const std::string& bytes) {
  planish::OutputFile file(path);
  file.write(bytes);
  file.commit();
}

}  // namespace

// Writes every generated scene into a folder: planish-make-scenes OUTDIR
int main(int argument_count, char** arguments) {
  if (argument_count != 2) {
    std::fputs("usage: planish-make-scenes OUTDIR\n", stderr);
    return 2;
  }
  try {
    const std::filesystem::path folder = arguments[1];
    std::filesystem::create_directories(folder / "bad");
    for (const auto& scene : planish::shapes::scenes()) {
      write(folder / scene.file, planish::shapes::scene_text(scene));
    }
    if (const auto mesher = planish::find_mesher_program()) {
      const auto mesh = planish::shapes::scanned_rocker_arm(planish::mesher_process(*mesher));
      write(folder / planish::shapes::kScanFile,
            planish::shapes::obj_text(mesh, "Rocker arm of an engine, scanned and simplified"));
    } else {
      std::fprintf(stderr, "planish-make-scenes: without planish-reconstruct %s is not made\n",
                   planish::shapes::kScanFile);
    }
    for (const auto& bad : planish::shapes::bad_files()) {
      write(folder / "bad" / bad.file, bad.bytes);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "planish-make-scenes: %s\n", error.what());
    return 7;
  }
  return 0;
}
