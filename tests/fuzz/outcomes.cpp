// outcomes CORPUS CHANGES [COPY]: what readers make of every file of the corpus
// (tests/fuzz/corpus), and of CHANGES damaged copies of each, in a line apiece: what
// tests/wasm/corpus.py compares of two builds. Names are written before files are read, so that the
// last tells where a program ended; COPY is what it read last. Without arguments: a document whose
// streams stand for more than 32 bits of memory.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "fuzz/fuzz_read.h"
#include "planish/files/gltf/gltf_payload.h"
#include "planish/files/read_file.h"

namespace planish {
namespace {

using Bytes = std::vector<std::byte>;
using Read = std::string (*)(std::span<const std::byte>, FileFormat);

// As fuzzers do: bytes that differ, parts that are gone, doubled or of another place.
Bytes damaged(Bytes bytes, std::mt19937& random) {
  const auto below = [&](std::size_t end) { return end > 0 ? random() % end : 0; };
  for (std::size_t count = 1 + below(4); count > 0 && !bytes.empty(); --count) {
    const std::size_t at = below(bytes.size());
    const std::size_t length = std::min<std::size_t>(1 + below(16), bytes.size() - at);
    const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    const auto end = place + static_cast<std::ptrdiff_t>(length);
    const Bytes part(place, end);
    switch (below(6)) {
      case 0:
        *place ^= static_cast<std::byte>(1u << below(8));
        break;
      case 1:
        *place = static_cast<std::byte>(below(256));
        break;
      case 2:
        bytes.erase(place, end);
        break;
      case 3:
        bytes.insert(place, part.begin(), part.end());
        break;
      case 4:
        std::ranges::copy(part, bytes.data() + below(bytes.size() - length + 1));
        break;
      default:
        std::fill(place, end, static_cast<std::byte>(below(2) * 255));
    }
  }
  return bytes;
}

class Teller {
 public:
  Teller(std::filesystem::path corpus, int changes, std::filesystem::path copy)
      : corpus_(std::move(corpus)), copy_(std::move(copy)), changes_(changes) {}

  void tell(const std::string& folder, FileFormat format, Read read) const {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(corpus_ / folder))
      files.push_back(entry.path());
    std::ranges::sort(files);
    for (std::size_t i = 0; i < files.size(); ++i) {
      const auto given = read_file(files[i]);
      std::mt19937 random(static_cast<std::uint32_t>(i));
      for (int change = 0; change <= changes_; ++change) {
        Bytes bytes(given.begin(), given.end());
        if (change > 0) bytes = damaged(std::move(bytes), random);
        std::printf("%s/%s %d: ", folder.c_str(), files[i].filename().c_str(), change);
        std::fflush(stdout);
        keep(bytes);
        std::printf("%s\n", read(bytes, format).c_str());
      }
    }
  }

 private:
  void keep(const Bytes& bytes) const {
    if (copy_.empty()) return;
    std::ofstream(copy_, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  }

  std::filesystem::path corpus_, copy_;
  int changes_;
};

void tell_all(const Teller& teller) {
  for (const FormatInfo& info : formats()) {
    const std::string name(info.name);
    if (info.read_mesh) teller.tell(name, info.format, test::fuzz_read_mesh);
    if (info.read_points) teller.tell("points_" + name, info.format, test::fuzz_read_points);
  }
  teller.tell("meshopt", FileFormat::Glb, test::fuzz_read_meshopt);
  teller.tell("lzf", FileFormat::Pcd, test::fuzz_read_lzf);
}

std::string large_document() {
  constexpr std::uint64_t kGibibyte = std::uint64_t{1} << 30;
  GltfPayload surface;
  surface.primitives.push_back({.attributes = {{"POSITION", 0}, {"NORMAL", 1}}, .indices = 2});
  surface.extensions = {"EXT_meshopt_compression"};
  for (std::uint64_t i = 0; i < 3; ++i)
    surface.arrays.push_back({.type = i < 2 ? "VEC3" : "SCALAR",
                              .count = 1u << 28,
                              .is_indices = i == 2,
                              .offset = i * 3 * kGibibyte,
                              .bytes = (i < 2 ? 3 : 1) * kGibibyte,
                              .stream = GltfStream{1000 * i, 1000, "ATTRIBUTES"}});
  surface.buffer_bytes = 3000;
  surface.decoded_bytes = 7 * kGibibyte;
  return plain_document(std::span(&surface, 1), {}).text({});
}

}  // namespace
}  // namespace planish

int main(int argc, char** argv) {
  if (argc == 1) std::puts(planish::large_document().c_str());
  if (argc < 3) return argc == 1 ? 0 : 2;
  planish::tell_all({argv[1], std::atoi(argv[2]), argc > 3 ? argv[3] : ""});
}
