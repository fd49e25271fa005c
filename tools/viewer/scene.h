#pragma once

// With prototypes, which planish's headers would leave out.
#include <vulkan/vulkan.h>

#include <string>

#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/settings.h"
#include "planish/vulkan/embed.h"

namespace planish::viewer {

/// A mesh to animate and how planish shall interpolate it.
struct Scene {
  std::string name;
  PolygonMesh mesh;  ///< the rest pose; usable, y up
  vulkan::SystemOptions system;
  FitSettings settings;  ///< of the job; what files of it say
  std::string source;    ///< the input's path
};

/// The job of that name of a scene file of the command (*.json; no name: its first), or a mesh in
/// any format that the command reads. Repairs, creases, weights, tolerance and the first level are
/// the job's. Throws Error{InvalidArgument}, Error{UnreadableInput}, Error{UnusableMesh}.
[[nodiscard]] Scene load_scene(const std::string& path, const std::string& job);

}  // namespace planish::viewer
