#pragma once

#include <opensubdiv/far/patchTableFactory.h>
#include <opensubdiv/far/stencilTable.h>

#include <set>

#include "osd/cages.h"
#include "osd/layouts.h"
#include "planish/osd/vk_device_context.h"

namespace planish::testing {

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

struct RefineOptions {
  int level = 1;
  bool adaptive = false;
  OpenSubdiv::Far::PatchTableFactory::Options patches;
};

[[nodiscard]] Refined refine(const Cage& cage, const RefineOptions& options);

}  // namespace planish::testing
