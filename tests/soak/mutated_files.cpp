#include "soak/mutated_files.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string_view>

#include "files/gltf/asset_sample.h"
#include "planish/files/mesh_file.h"
#include "planish/job/fit_file.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

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

}  // namespace

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

SeedFile mutated_file(const std::vector<SeedFile>& seeds, std::mt19937& random) {
  SeedFile file = seeds[below(seeds.size(), random)];
  if (random() % 2 && damage_document(file.bytes, random)) return file;
  std::size_t other = below(seeds.size(), random);
  while (seeds[other].extension != file.extension) other = (other + 1) % seeds.size();
  for (std::size_t left = random() % 4; left > 0; --left)
    damage(file.bytes, seeds[other].bytes, random);
  return file;
}

}  // namespace planish::test
