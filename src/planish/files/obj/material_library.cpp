#include "planish/files/obj/material_library.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <set>
#include <span>
#include <utility>

#include "planish/core/output_file.h"
#include "planish/core/raw_vector.h"
#include "planish/core/words.h"
#include "planish/files/read_file.h"
#include "planish/files/shared/ordered_stream.h"

namespace planish {
namespace {

// Based on: Wavefront Technologies, "MTL material format (Lightwave, OBJ)", 1995.

namespace fs = std::filesystem;

constexpr std::size_t kObjHead = std::size_t{1} << 20;  // where libraries are named
constexpr std::string_view kBetweenWords = " \t\r";

std::string_view without_blanks(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBetweenWords);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBetweenWords) - first + 1);
}

std::string_view library_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Takes the first line off the text.
std::string_view take_line(std::string_view& text) {
  const std::string_view line = text.substr(0, text.find('\n'));
  text.remove_prefix(std::min(line.size() + 1, text.size()));
  return line;
}

// Takes the first word off the text.
std::string_view take_word(std::string_view& text) {
  text = without_blanks(text);
  const std::size_t end = std::min(text.find_first_of(kBetweenWords), text.size());
  const std::string_view word = text.substr(0, end);
  text = without_blanks(text.substr(end));
  return word;
}

bool is_number(std::string_view word) {
  return !word.empty() && word.find_first_not_of("+-.eE0123456789") == std::string_view::npos;
}

bool names_a_texture(std::string_view keyword) {
  constexpr std::array<std::string_view, 5> kOthers = {"bump", "disp", "decal", "refl", "norm"};
  return keyword.starts_with("map_") || std::ranges::find(kOthers, keyword) != kOthers.end();
}

// 0 where it is none, or not finite.
double number_of(std::string_view word) {
  double value = 0;
  (void)std::from_chars(word.data(), word.data() + word.size(), value);
  return std::isfinite(value) ? value : 0;
}

// Behind the options of a texture, such as -s 1 1 1 and -clamp on, comes its name with its blanks.
std::string_view texture_of(std::string_view rest, MaterialTexture* texture = nullptr) {
  constexpr std::array<std::string_view, 3> kVectors = {"-s", "-o", "-t"};
  while (rest.starts_with('-')) {
    const std::string_view option = take_word(rest);
    const bool is_vector = std::ranges::find(kVectors, option) != kVectors.end();
    std::vector<std::string_view> words{take_word(rest)};
    for (std::string_view next = rest; is_vector || option == "-mm"; rest = next) {
      const std::string_view word = take_word(next);
      if (!is_number(word)) break;
      words.push_back(word);
    }
    if (texture == nullptr) continue;
    if (option == "-s" || option == "-o") {
      glm::dvec2& vector = option == "-s" ? texture->size : texture->offset;
      vector.x = number_of(words[0]);
      if (words.size() > 1) vector.y = number_of(words[1]);
    }
    if (option == "-bm") texture->scale = number_of(words[0]);
    if (option == "-clamp") texture->clamps = words[0] == "on";
  }
  return rest;
}

// A line with its texture as it is named from another folder.
std::string moved_line(const std::string& line, const fs::path& from, const fs::path& to) {
  std::string_view rest = line;
  if (!names_a_texture(lower_case(take_word(rest)))) return line;
  const std::string_view texture = texture_of(rest);
  std::string name(texture);
  std::ranges::replace(name, '\\', '/');
  const bool has_drive = name.size() > 1 && name[1] == ':';
  if (name.empty() || path_of(name).is_absolute() || has_drive) return line;
  std::error_code error;
  const fs::path moved = fs::relative(from / path_of(name), to, error);
  if (error || moved.empty() || fs::equivalent(from, to, error)) return line;
  const std::size_t at = static_cast<std::size_t>(texture.data() - line.data());
  return line.substr(0, at) + moved.generic_string();
}

fs::path named_folder(const fs::path& folder) { return folder.empty() ? fs::path(".") : folder; }

}  // namespace

MaterialLibrary::MaterialLibrary(const fs::path& path, FileReach reach)
    : obj_(path), reach_(reach) {
  // Its own bytes lie wherever it does.
  read_libraries(library_text(read_named_start(path, path, FileReach::Anywhere, kObjHead).bytes));
}

MaterialLibrary::MaterialLibrary(const FileBytes& obj) : obj_(obj.path), reach_(obj.reach) {
  read_libraries(library_text(obj.bytes.first(std::min(obj.bytes.size(), kObjHead))));
}

void MaterialLibrary::read_libraries(std::string_view text) {
  while (!text.empty()) {
    std::string_view line = take_line(text);
    if (take_word(line) == "mtllib" && !line.empty()) read_line(line);
  }
}

// The specification has several names in a line, programs put one with blanks.
void MaterialLibrary::read_line(std::string_view line) {
  const auto named = [&](std::string_view name) {
    std::string file_name(name);
    std::ranges::replace(file_name, '\\', '/');
    files_.push_back(obj_.parent_path() / path_of(file_name));
    return std::pair(files_.back(), read_named(files_.back(), obj_, reach_));
  };
  std::vector<std::pair<fs::path, NamedFile>> found{named(line)};
  if (!found.front().second.trouble.empty()) {
    std::vector<std::pair<fs::path, NamedFile>> several;
    while (!line.empty()) several.push_back(named(take_word(line)));
    if (std::ranges::any_of(several, [](const auto& one) { return one.second.trouble.empty(); }))
      found = std::move(several);
  }
  for (const auto& [path, file] : found) read(path, file);
}

void MaterialLibrary::read(const fs::path& path, const NamedFile& file) {
  if (!file.trouble.empty()) {
    warnings_.push_back(
        {"missing-materials", visible(obj_) + ": its materials are not there: " + file.trouble +
                                  "; copy that along, or its colours and textures are lost"});
    return;
  }
  Material* material = nullptr;
  std::string_view text = library_text(file.bytes);
  while (!text.empty()) {
    std::string_view line = take_line(text);
    if (line.ends_with('\r')) line.remove_suffix(1);
    std::string_view rest = line;
    const std::string_view keyword = take_word(rest);
    if (keyword == "newmtl") {
      // The first of a name counts.
      const auto [place, is_new] = materials_.try_emplace(std::string(rest));
      material = is_new ? &place->second : nullptr;
      if (is_new) material->folder = named_folder(path.parent_path());
    } else if (material != nullptr && !keyword.empty() && !keyword.starts_with('#')) {
      material->lines.emplace_back(line);
    }
  }
}

std::vector<fs::path> MaterialLibrary::named_files() const {
  std::vector<fs::path> all = files_;
  for (const std::string& name : names())
    for (const MaterialStatement& statement : parsed(name))
      if (!statement.texture.path.empty()) all.push_back(statement.texture.path);
  return all;
}

void MaterialLibrary::add(const std::string& name, const fs::path& folder,
                          std::vector<std::string> lines) {
  materials_.try_emplace(name, Material{named_folder(folder), std::move(lines)});
}

std::vector<std::string> MaterialLibrary::names() const {
  std::vector<std::string> names;
  for (const auto& [name, material] : materials_) names.push_back(name);
  return names;
}

std::vector<MaterialStatement> MaterialLibrary::parsed(const std::string& name) const {
  std::vector<MaterialStatement> all;
  const Material& material = materials_.at(name);
  for (const std::string& line : material.lines) {
    std::string_view rest = line;
    MaterialStatement& statement = all.emplace_back();
    statement.keyword = lower_case(take_word(rest));
    if (names_a_texture(statement.keyword)) {
      std::string file(texture_of(rest, &statement.texture));
      std::ranges::replace(file, '\\', '/');
      if (!file.empty()) statement.texture.path = material.folder / path_of(file);
    } else {
      while (!rest.empty()) {
        const std::string_view word = take_word(rest);
        if (!is_number(word)) break;
        statement.numbers.push_back(number_of(word));
      }
    }
  }
  return all;
}

std::string MaterialLibrary::statements(const std::string& material, const fs::path& folder) const {
  const auto found = materials_.find(material);
  if (found == materials_.end()) return {};
  std::string text;
  for (const std::string& line : found->second.lines)
    text += moved_line(line, found->second.folder, named_folder(folder)) + "\n";
  return text;
}

namespace {

// Based on: Wavefront Technologies, "MTL material format (Lightwave, OBJ)", 1995.

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
