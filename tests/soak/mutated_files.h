#pragma once

#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

namespace planish::test {

struct SeedFile {
  std::string extension;  ///< with its dot
  std::string bytes;
};

/// Files that a service may be sent: small scenes, random meshes in every format that planish
/// writes, and the fuzzers' corpus. `folder` is for files in between.
[[nodiscard]] std::vector<SeedFile> seed_files(const std::filesystem::path& folder);

/// One of them, as it is or damaged in up to three places: bytes, numbers and pieces changed,
/// repeated, left out, exchanged or taken from another file of the format.
[[nodiscard]] SeedFile mutated_file(const std::vector<SeedFile>& seeds, std::mt19937& random);

}  // namespace planish::test
