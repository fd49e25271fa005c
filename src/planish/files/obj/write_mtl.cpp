// Based on: Wavefront Technologies, "MTL material format (Lightwave, OBJ)", 1995.
#include "planish/files/obj/write_mtl.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <set>

#include "planish/core/output_file.h"
#include "planish/core/raw_vector.h"
#include "planish/core/visible_text.h"
#include "planish/files/obj/material_library.h"
#include "planish/files/shared/write_numbers.h"

namespace planish {
namespace {

// Hues that are a golden section apart stay apart, however many there are.
std::array<double, 3> color_of(std::size_t material) {
  constexpr double kGolden = 0.618033988749895, kDullest = 0.35, kBrightest = 0.8;
  const double hue = 6 * std::fmod(static_cast<double>(material) * kGolden, 1.0);
  std::array<double, 3> color{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double k = std::fmod(5 - 2 * static_cast<double>(i) + hue, 6.0);
    const double lack = std::clamp(std::min(k, 4 - k), 0.0, 1.0);
    color[i] = std::round(100 * (kBrightest - (kBrightest - kDullest) * lack)) / 100;
  }
  return color;
}

}  // namespace

std::string obj_line_name(const std::string& name) {
  std::string line = " " + without_controls(name, '_');
  for (std::size_t i = 1; i < line.size(); ++i)
    if (line[i] == '#' && line[i - 1] == ' ') line[i] = '_';
  if (line.ends_with('\\')) line.back() = '_';
  return line;
}

void write_mtl(OutputFile& file, std::span<const std::string> materials,
               const GivenMaterials& given) {
  RawVector<std::byte> bytes;
  FileBuffer out(bytes, [&](std::span<const std::byte> some) { file.write(some); });
  std::set<std::string> written;
  for (std::size_t i = 0; i < materials.size(); ++i) {
    const std::string name = obj_line_name(materials[i]);
    if (!written.insert(name).second) continue;
    const std::string known =
        given.library != nullptr ? given.library->statements(materials[i], given.folder) : "";
    out.text("newmtl").text(name).text("\n").text(known);
    if (!known.empty()) continue;
    out.text("Kd");
    for (const double part : color_of(i)) out.text(" ").number(part);
    out.text("\n");
  }
  out.finish();
}

void write_mtllib(FileBuffer& out, const std::string& file_name) {
  out.text("mtllib").text(obj_line_name(file_name)).text("\n");
}

}  // namespace planish
