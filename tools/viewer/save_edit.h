#pragma once

#include <filesystem>
#include <string>

#include "edit_session.h"
#include "planish/pipeline/settings.h"

namespace planish::viewer {

/// What files of an edited scene say of it.
struct SaveOptions {
  FitSettings settings;  ///< of the scene; files have the axes of its input
  std::string source;    ///< the input's file
  int level = 2;         ///< of surfaces
};
[[nodiscard]] SaveOptions save_options(const Scene& scene);

enum class SavedPart { Mesh, Cage, Surface };

/// Writes the mesh with its moved points and tags (.obj, .ply, .off, .usda), the cage, which
/// `planish verify` takes against such a mesh, or the surface (.glb, .gltf). Throws
/// Error{InvalidArgument} for another extension, Error{UnwritableOutput}.
void save(const EditSession& session, SavedPart part, const std::filesystem::path& path,
          const SaveOptions& options);

/// All three: PREFIX.obj, PREFIX_cage.obj and PREFIX.glb. Returns what was written, for people.
std::string save_all(const EditSession& session, const std::string& prefix,
                     const SaveOptions& options);

}  // namespace planish::viewer
