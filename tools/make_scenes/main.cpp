#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "make_scenes/scene_list.h"
#include "planish/core/output_file.h"

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
    for (const auto& bad : planish::shapes::bad_files()) {
      write(folder / "bad" / bad.file, bad.bytes);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "planish-make-scenes: %s\n", error.what());
    return 7;
  }
  return 0;
}
