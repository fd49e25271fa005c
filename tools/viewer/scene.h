#pragma once

// With prototypes, which planish's headers would leave out.
#include <vulkan/vulkan.h>

#include <memory>
#include <optional>
#include <string>

#include "planish/fair/fair_net.h"
#include "planish/fair/interpolation_method.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/settings.h"
#include "planish/vulkan/embed.h"

namespace planish::viewer {

/// A mesh to animate and how planish shall interpolate it.
struct Scene {
  std::string name;
  PolygonMesh mesh;  ///< the rest pose; usable, y up
  vulkan::SystemOptions system;
  /// Of the fair method: what the rest pose's fit decided, which `system` names.
  std::shared_ptr<const FairDecisions> decisions;
  FitSettings settings;  ///< of the job; what files of it say
  std::string source;    ///< the input's path
};

/// The job of that name of a scene file of the command (*.json; no name: its first), or a mesh in
/// any format that the command reads. It is fitted as the command does: repairs, creases, weights,
/// tolerance, the first level and the method are the job's, or those that measurement takes;
/// `method`: no other than this. Throws Error{InvalidArgument}, Error{UnreadableInput},
/// Error{UnusableMesh}.
[[nodiscard]] Scene load_scene(const std::string& path, const std::string& job,
                               std::optional<InterpolationMethod> method = {});

}  // namespace planish::viewer
