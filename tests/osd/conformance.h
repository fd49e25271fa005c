#pragma once

#include <opensubdiv/far/patchTableFactory.h>
#include <opensubdiv/far/stencilTable.h>
#include <opensubdiv/osd/bufferDescriptor.h>
#include <opensubdiv/osd/types.h>

#include <array>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "osd/cages.h"
#include "planish/osd/vk_device_context.h"
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

struct Refined;
enum class PatchKind { Vertex, Varying, FaceVarying };

/// Runs Osd::CpuEvaluator and VkComputeEvaluator on the same things and compares what they wrote.
struct Conformance {
  osd::VkDeviceContext& context;
  Tally tally;
  std::set<int> patch_types{};  ///< Far::PatchDescriptor::Type of all patches evaluated
  int sharp_patches = 0;        ///< single-crease patches among them
  int boundary_patches = 0;

  /// Stencils without derivatives.
  void stencils(const std::string& name, const Cage& cage,
                const OpenSubdiv::Far::StencilTable& table, const Layout& layout);
  /// Values and the derivatives that the table has.
  void limit_stencils(const std::string& name, const Cage& cage,
                      const OpenSubdiv::Far::LimitStencilTable& table, const Layout& layout);
  /// Value, first and second derivatives at several places of every patch.
  void patches(const std::string& name, const Cage& cage, const Refined& refined, PatchKind kind,
               const Layout& layout);
};

/// A cage refined, and all tables that OpenSubdiv makes of it.
struct Refined {
  std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner;
  /// Refined vertices, and after them the points that patches need.
  std::unique_ptr<const OpenSubdiv::Far::StencilTable> vertices;
  std::unique_ptr<const OpenSubdiv::Far::StencilTable> varying;
  std::unique_ptr<const OpenSubdiv::Far::StencilTable> face_varying;  ///< null without channels
  std::unique_ptr<const OpenSubdiv::Far::LimitStencilTable> limits;
  std::unique_ptr<const OpenSubdiv::Far::PatchTable> patches;
};

/// One of a table's patches, which are numbered through its arrays.
struct Patch {
  OpenSubdiv::Far::PatchTable::PatchHandle handle;
  OpenSubdiv::Far::PatchParam param;
  int type;  ///< Far::PatchDescriptor::Type

  [[nodiscard]] bool is_triangle() const;
  /// Where u, v of the patch are on its face.
  [[nodiscard]] OpenSubdiv::Osd::PatchCoord coord(float u, float v) const;
};
[[nodiscard]] std::vector<Patch> patches_of(const OpenSubdiv::Far::PatchTable& table);

struct RefineOptions {
  int level = 1;
  bool adaptive = false;
  OpenSubdiv::Far::PatchTableFactory::Options patches;
};

[[nodiscard]] Refined refine(const Cage& cage, const RefineOptions& options);

}  // namespace planish::testing
