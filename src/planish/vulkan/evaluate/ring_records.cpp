#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <utility>
#include <vector>

#include "planish/patches/ring_sums.h"
#include "planish/vulkan/evaluate/patch_records.h"

namespace planish::vulkan {

void add_rings(const PatchMesh& mesh, PatchRecords& records) {
  std::vector<std::uint32_t>& words = records.rings;
  const auto next_word = [&] { return static_cast<std::uint32_t>(words.size()); };
  const auto add_float = [&](double value) {
    words.push_back(std::bit_cast<std::uint32_t>(static_cast<float>(value)));
  };
  records.ring_count = static_cast<std::uint32_t>(mesh.large_rings().size());
  records.first_sum = mesh.state_size();
  words.resize(std::size_t{shared::kRingWords} * records.ring_count);
  // Rings of one kind and size share their weights.
  std::map<std::pair<PatchKind, std::int32_t>, std::uint32_t> weights;
  std::vector<std::int32_t> points;
  std::size_t head = 0;
  for (const LargeRing& ring : mesh.large_rings()) {
    mesh.ring_points(ring, points);
    const std::uint32_t first_point = next_word();
    words.insert(words.end(), points.begin(), points.end());
    const auto [place, is_new] = weights.try_emplace({ring.kind, ring.size}, next_word());
    if (is_new) {
      for (const glm::dvec3& row : ring_weights(ring))
        for (int i = 0; i < 3; ++i) add_float(row[i]);
      const auto [first, step] = ring_angles(ring.kind, ring.size);
      for (std::int32_t i = 0; i < ring.size; ++i) {
        add_float(std::cos(first + step * i));
        add_float(std::sin(first + step * i));
      }
    }
    for (const auto word :
         {first_point, static_cast<std::uint32_t>(points.size()),
          static_cast<std::uint32_t>(ring.size), static_cast<std::uint32_t>(ring.first_sum),
          static_cast<std::uint32_t>(mesh.topology().vertex_of(ring.start)), place->second})
      words[head++] = word;
  }
}

}  // namespace planish::vulkan
