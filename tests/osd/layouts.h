#pragma once

#include <opensubdiv/osd/bufferDescriptor.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "osd/cages.h"
#include "planish/osd/vk_vertex_buffer.h"

namespace planish::testing {

inline constexpr int kDestinations = 6;  ///< value, du, dv, duu, duv, dvv

/// How an evaluation's floats lie: a source and up to six destinations, each a piece of a buffer.
struct Layout {
  std::string name;
  bool one_destination = false;  ///< all destinations lie in one buffer
  bool in_place = false;         ///< the destinations lie in the source's buffer
  OpenSubdiv::Osd::BufferDescriptor source;
  std::array<OpenSubdiv::Osd::BufferDescriptor, kDestinations> destinations;
};

/// Lengths 1 to 7, tight and with gaps, apart and in one buffer.
[[nodiscard]] std::vector<Layout> all_layouts();
/// Three of them: apart, together, in place.
[[nodiscard]] std::vector<Layout> patch_layouts();

/// The floats of all buffers of an evaluation: source first, then each destination's, where it has
/// one of its own. Floats that no descriptor covers count too: they must stay as they are.
struct Floats {
  std::vector<std::vector<float>> buffers;
  std::array<std::size_t, kDestinations> destination{};  ///< place in buffers

  /// Buffers for sources that are the cage's first points and then follow a fixed pattern, and for
  /// `rows` rows of the first `count` destinations, filled with a mark. In place, the sources are
  /// followed by the rows.
  Floats(const Layout& layout, const Cage& cage, int sources, int rows, int count);
};

/// Where element i's float c of a descriptor is.
[[nodiscard]] inline std::size_t place(const OpenSubdiv::Osd::BufferDescriptor& desc, int i,
                                       int c) {
  return static_cast<std::size_t>(desc.offset) + std::size_t(i) * desc.stride + c;
}

/// The same buffers on the device.
struct DeviceFloats {
  std::vector<std::unique_ptr<osd::VkVertexBuffer>> buffers;

  DeviceFloats(const Floats& floats, osd::VkDeviceContext& context);
  [[nodiscard]] osd::VkVertexBuffer* destination(const Floats& floats, int i) const {
    return buffers[floats.destination[i]].get();
  }
  [[nodiscard]] std::vector<std::vector<float>> read(osd::VkDeviceContext& context) const;
};

/// What comparisons found so far.
struct Tally {
  int cages = 0;
  long long evaluations = 0, floats = 0;
  double largest = 0;  ///< difference, as a part of the largest magnitude in its buffer

  /// Expects every float of every buffer to agree to 1e-6 of the largest magnitude in the buffer,
  /// and zeros in their signs.
  void compare(const std::string& name, const std::vector<std::vector<float>>& expected,
               const std::vector<std::vector<float>>& got);
  void print() const;
};

}  // namespace planish::testing
