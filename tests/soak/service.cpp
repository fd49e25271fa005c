#include <malloc.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "files/gltf/asset_sample.h"
#include "planish/c/planish.h"
#include "planish/files/mesh_file.h"
#include "planish/job/fit_file.h"
#include "soak/soak.h"
#include "support/files.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

struct SeedFile {
  std::string extension;  // with its dot
  std::string bytes;
};

constexpr std::uintmax_t kLargestSeed = 130'000;

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::size_t below(std::size_t count, std::mt19937& random) {
  return count == 0 ? 0 : random() % count;
}

struct Piece {
  std::size_t first, count;
};

Piece piece_of(const std::string& bytes, std::mt19937& random) {
  const std::size_t first = below(bytes.size(), random);
  return {first, 1 + below(std::min<std::size_t>(200, bytes.size() - first), random)};
}

void replace_number(std::string& bytes, std::mt19937& random) {
  constexpr std::array<std::string_view, 12> kOdd{"nan",        "inf", "1e308", "-1e308",
                                                  "1e-320",     "-1",  "0",     "99999999999",
                                                  "2147483648", "",    "1e",    "0.5.5"};
  const auto is_part = [](char c) {
    return std::isdigit(static_cast<unsigned char>(c)) || c == '.' || c == '-';
  };
  std::size_t at = below(bytes.size(), random);
  while (at < bytes.size() && !is_part(bytes[at])) ++at;
  std::size_t end = at;
  while (end < bytes.size() && is_part(bytes[end])) ++end;
  if (at < end) bytes.replace(at, end - at, kOdd[below(kOdd.size(), random)]);
}

void replace_word(std::string& bytes, std::mt19937& random) {
  // Infinity, NaN, the largest and smallest integers, 1.
  constexpr std::array<std::uint32_t, 6> kOdd{0x7f800000, 0x7fc00000, 0xffffffff,
                                              0x80000000, 0x7fffffff, 1};
  if (bytes.size() < 8) return;
  const std::size_t at = 4 * below(bytes.size() / 4, random);
  std::memcpy(&bytes[at], &kOdd[below(kOdd.size(), random)], 4);
}

void damage(std::string& bytes, const std::string& other, std::mt19937& random) {
  if (bytes.empty()) return;
  const Piece piece = piece_of(bytes, random);
  switch (random() % 8) {
    case 0:
      bytes[piece.first] = static_cast<char>(random());
      break;
    case 1:
      bytes.resize(piece.first);
      break;
    case 2:
      bytes.insert(piece.first, bytes.substr(piece.first, piece.count));
      break;
    case 3:
      bytes.erase(piece.first, piece.count);
      break;
    case 4:
      replace_number(bytes, random);
      break;
    case 5:
      replace_word(bytes, random);
      break;
    case 6: {
      const Piece taken = piece_of(other, random);
      bytes.replace(piece.first, piece.count, other, taken.first, taken.count);
      break;
    }
    default: {
      const std::size_t to = below(bytes.size() - piece.count + 1, random);
      const std::string moved = bytes.substr(piece.first, piece.count);
      bytes.erase(piece.first, piece.count);
      bytes.insert(to, moved);
    }
  }
}

// The JSON of a GLB, whose frame stays whole, for else readers look at no more than that.
bool damage_document(std::string& glb, std::mt19937& random) {
  constexpr std::size_t kHead = 20;
  std::uint32_t length = 0;
  if (glb.size() < kHead || glb.compare(0, 4, "glTF") != 0) return false;
  std::memcpy(&length, &glb[12], sizeof length);
  const std::size_t chunk = kHead + length + 8;
  if (chunk > glb.size()) return false;
  std::string document = glb.substr(kHead, length);
  for (std::size_t left = 1 + random() % 3; left > 0; --left)
    random() % 2 ? replace_number(document, random) : damage(document, document, random);
  glb = glb_of(std::move(document), glb.substr(chunk));
  return true;
}

// Files that a service may be sent: small scenes, random meshes in every format that planish
// writes, and the fuzzers' corpus. `folder` is for files in between.
std::vector<SeedFile> seed_files(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> paths;
  for (const char* root : {PLANISH_SOAK_SCENES, PLANISH_SOAK_CORPUS})
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root))
      if (entry.is_regular_file() && entry.file_size() <= kLargestSeed)
        paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());  // folders come in any order
  std::vector<SeedFile> seeds;
  for (const std::filesystem::path& path : paths) {
    const std::string extension = path.extension().string();
    constexpr std::array<std::string_view, 6> kMeshes{".obj", ".ply", ".off",
                                                      ".stl", ".glb", ".gltf"};
    if (std::find(kMeshes.begin(), kMeshes.end(), extension) != kMeshes.end())
      seeds.push_back({extension, bytes_of(path)});
  }
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    for (const PolygonMesh& mesh : {random_closed_mesh(seed), random_open_mesh(seed),
                                    random_dual(60, seed), laden_mesh(seed)}) {
      for (const char* extension : {".obj", ".ply", ".off"}) {
        const std::filesystem::path path = folder / (std::string("seed") + extension);
        write_mesh(path, *format_of(path), mesh);
        seeds.push_back({extension, bytes_of(path)});
      }
      const std::filesystem::path given = folder / "seed.obj";
      for (const char* extension : {".glb", ".stl"}) {
        const std::filesystem::path path = folder / (std::string("made") + extension);
        write_mesh(given, FileFormat::Obj, mesh);
        (void)fit_file(given, path, {.settings = settings_of({{"levels", "0"}})});
        seeds.push_back({extension, bytes_of(path)});
      }
    }
  }
  seeds.push_back({".glb", AssetSample().glb()});
  return seeds;
}

// One of them, as it is or damaged in up to three places: bytes, numbers and pieces changed,
// repeated, left out, exchanged or taken from another file of the format.
SeedFile mutated_file(const std::vector<SeedFile>& seeds, std::mt19937& random) {
  SeedFile file = seeds[below(seeds.size(), random)];
  if (random() % 2 && damage_document(file.bytes, random)) return file;
  std::size_t other = below(seeds.size(), random);
  while (seeds[other].extension != file.extension) other = (other + 1) % seeds.size();
  for (std::size_t left = random() % 4; left > 0; --left)
    damage(file.bytes, seeds[other].bytes, random);
  return file;
}

// In the half in which no file is new, between its two parts.
constexpr std::uint64_t kServiceMayGrow = 1u << 20;
constexpr double kSlow = 5;  // seconds, that are worth a word

bool is_result(planish_status status) {
  return status == PLANISH_OK || status == PLANISH_NOT_CONVERGED;
}

struct Free {
  void operator()(planish_options* options) const { planish_options_free(options); }
};
using OwnOptions = std::unique_ptr<planish_options, Free>;

OwnOptions options_by_lot(std::mt19937& random) {
  planish_options* made = nullptr;
  if (planish_options_create(&made) != PLANISH_OK) return nullptr;
  OwnOptions options(made);
  const auto set = [&](const char* name, const char* value) {
    if (planish_options_set(made, name, value) != PLANISH_OK) complain(planish_last_error());
  };
  const auto by_lot = [&](std::initializer_list<const char*> values) {
    return values.begin()[random() % values.size()];
  };
  set("interpolation", by_lot({"auto", "progressive", "fair"}));
  set("creases", by_lot({"use", "ignore", "auto", "choose"}));
  set("quads", by_lot({"auto", "on", "off"}));
  if (random() % 2) set("weld", "0");
  set("repair", by_lot({"safe", "safe", "safe", "none"}));
  set("threads", by_lot({"0", "1", "2"}));
  set("levels", by_lot({"0", "1", "2"}));
  if (random() % 4 == 0) set("weights", "averaged");
  if (random() % 8 == 0) set("within", "auto");
  if (random() % 8 == 0) set("scheme", "catmull-clark");
  return options;
}

class Service {
 public:
  void serve(const SeedFile& file, std::mt19937& random) {
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
      std::filesystem::remove(entry.path());
    const std::filesystem::path input = folder_.path() / ("input" + file.extension);
    std::ofstream(input, std::ios::binary) << file.bytes;
    const OwnOptions options = options_by_lot(random);
    fit_file(input, options.get(), random);
    if (random() % 3 == 0) use_handles(input, options.get(), random);
  }

  void print() const {
    for (const auto& [status, count] : counts_) std::printf("status %d: %d\n", status, count);
  }

 private:
  // Whether it is a result. Of anything else there are words, and it is no bug.
  bool check(planish_status status, const std::filesystem::path& input) {
    ++counts_[status];
    if (status == PLANISH_OK) return true;
    const std::string said = planish_last_error();
    if (said.empty()) complain("status " + std::to_string(status) + " without words");
    if (status == PLANISH_INTERNAL_ERROR || status == PLANISH_CANCELLED) {
      const auto kept =
          std::filesystem::temp_directory_path() /
          ("planish-soak-" + std::to_string(complaints()) + input.extension().string());
      std::error_code ignored;
      std::filesystem::copy_file(input, kept, std::filesystem::copy_options::overwrite_existing,
                                 ignored);
      complain("status " + std::to_string(status) + ": " + said + " (" + kept.string() + ")");
    }
    return is_result(status);
  }

  void fit_file(const std::filesystem::path& input, const planish_options* options,
                std::mt19937& random) {
    constexpr std::array<const char*, 7> kFormats{".glb", ".obj",  ".ply", ".off",
                                                  ".stl", ".usda", ".step"};
    const std::filesystem::path output =
        folder_.path() / (std::string("output") + kFormats[random() % kFormats.size()]);
    const bool has_result =
        check(planish_fit_file(input.c_str(), output.c_str(), options, nullptr), input);
    int files = 0;
    for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder_.path()))
      ++files;
    if (has_result != std::filesystem::exists(output))
      complain("the output does not follow the status");
    const bool may_have_mtl = has_result && output.extension() == ".obj";
    if (files != 1 + static_cast<int>(has_result) && !(may_have_mtl && files == 3))
      complain("files are left beside the output");
    if (!has_result) return;
    if (const std::string name = output.extension().string(); name != ".usda" && name != ".step") {
      planish_mesh* mesh = nullptr;
      if (!check(planish_mesh_read(output.c_str(), &mesh), output))
        complain("cannot read " + name + " back: " + planish_last_error());
      planish_mesh_free(mesh);
    }
  }

  void use_handles(const std::filesystem::path& input, const planish_options* options,
                   std::mt19937& random) {
    planish_mesh* mesh = nullptr;
    planish_fit* fit = nullptr;
    planish_surface* surface = nullptr;
    planish_queries* queries = nullptr;
    if (check(planish_mesh_read(input.c_str(), &mesh), input) &&
        check(planish_fit_create(mesh, options, &fit), input)) {
      planish_mesh_free(mesh);
      mesh = nullptr;
      if (random() % 2) {
        check(planish_fit_evaluate(fit, static_cast<std::int32_t>(random() % 3), &surface), input);
      } else {
        check(planish_fit_tessellate(fit, 1e-2, 0, &surface), input);
      }
      if (check(planish_queries_create(fit, &queries), input)) ask(queries, input);
    }
    planish_queries_free(queries);
    planish_surface_free(surface);
    planish_fit_free(fit);
    planish_mesh_free(mesh);
  }

  void ask(const planish_queries* queries, const std::filesystem::path& input) {
    constexpr std::size_t kCount = 8;
    std::array<double, 3 * kCount> points{}, found{};
    for (std::size_t i = 0; i < points.size(); ++i) points[i] = std::sin(static_cast<double>(i));
    std::array<double, kCount> distances{};
    planish_closest_answers answers;
    planish_closest_answers_init(&answers, sizeof answers);
    answers.positions = found.data();
    answers.distances = distances.data();
    if (!check(planish_queries_closest(queries, points.data(), kCount, &answers), input)) return;
    for (std::size_t i = 0; i < kCount; ++i) {
      const double distance =
          std::hypot(points[3 * i] - found[3 * i], points[3 * i + 1] - found[3 * i + 1],
                     points[3 * i + 2] - found[3 * i + 2]);
      if (!(std::abs(distance - std::abs(distances[i])) <= 1e-9 * (1 + distance)))
        complain("a closest point is not at its distance");
    }
  }

  TemporaryFolder folder_;
  std::map<int, int> counts_;
};

}  // namespace

void soak_service(std::uint32_t count, std::uint32_t first) {
  const TemporaryFolder seeds_folder;
  const std::vector<SeedFile> seeds = seed_files(seeds_folder.path());
  std::printf("%zu files to begin with\n", seeds.size());
  Service service;
  Growth growth, resident;
  double slowest = 0;
  std::uint32_t slowest_file = 0;
  for (std::uint32_t served = 0; served < count; ++served) {
    // All again in the second half: what threads keep suffices then, and only a leak grows.
    const std::uint32_t i = first + served % ((count + 1) / 2);
    std::mt19937 random(i);
    const SeedFile file = mutated_file(seeds, random);
    const auto begin = std::chrono::steady_clock::now();
    service.serve(file, random);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (seconds > kSlow)
      std::printf("file %u%s takes %.1f s\n", i, file.extension.c_str(), seconds);
    if (seconds > slowest) {
      slowest = seconds;
      slowest_file = i;
    }
    const struct mallinfo2 info = ::mallinfo2();
    growth.note(info.uordblks + info.hblkhd);
    resident.note(resident_bytes());
  }
  service.print();
  std::printf("slowest: %.2f s, file %u; allocated %s; resident %s\n", slowest, slowest_file,
              growth.text().c_str(), resident.text().c_str());
  if (const std::uint64_t bytes = growth.bytes(2); bytes > kServiceMayGrow)
    complain("memory grows by " + std::to_string(bytes) + " bytes");
}

}  // namespace planish::test
