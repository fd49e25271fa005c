#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "planish/files/gltf/write_gltf.h"
#include "planish/job/job_surface.h"
#include "planish/job/report.h"
#include "planish/surface/doo_sabin_surface.h"

namespace planish {

/// What every surface output of a job has in common.
struct SurfaceOutputOptions {
  GltfOptions gltf;
  std::span<const glm::dvec3> vertices;        ///< the input's
  std::span<const glm::dvec3> given;           ///< what the surface passes through in their place
  double diagonal = 1.0;                       ///< that errors are relative to
  bool digests = true;                         ///< of what is written
  double tolerance = 0;                        ///< relative, that compression keeps
  const MaterialLibrary* materials = nullptr;  ///< of the input
  bool may_be_scaled = true;                   ///< whether nodes may carry the grid of compression
};

/// Options for writing a surface as glTF, and how far it is off as written: known once it is.
struct MeasuredGltf {
  GltfOptions options;
  double distance = 0;  ///< in model units
};
/// Of one surface of a file. All that is given must outlive what is measured.
void measure_gltf(const PlannedOutput& planned, const SurfaceBlocks& surface,
                  const SurfaceOutputOptions& options, MeasuredGltf& measured);

/// What is known of a file of that surface before it is written.
[[nodiscard]] WrittenOutput counted_output(const PlannedOutput& planned, const SurfaceInfo& info);

/// Writes `surface` to `target` in the format of `planned` and measures what was written; a
/// planned stdout goes to `stdout_bytes` instead. Throws Error{UnwritableOutput}.
[[nodiscard]] WrittenOutput write_surface_output(const PlannedOutput& planned,
                                                 const std::filesystem::path& target,
                                                 JobLevel& surface,
                                                 const SurfaceOutputOptions& options,
                                                 std::vector<std::byte>& stdout_bytes);

/// Writes `surface` as a set of 3D Tiles, whose document is `target`, and measures what was
/// written. `settings` has the sizes of tiles.
[[nodiscard]] WrittenOutput write_tiles_output(const PlannedOutput& planned,
                                               const std::filesystem::path& target,
                                               const DooSabinSurface& surface,
                                               const Settings& settings,
                                               const SurfaceOutputOptions& options);

/// Writes the cage of a fitted mesh, with the materials of an OBJ's input, and measures how far its
/// limit surface, recomputed in double, is from the mesh's vertices.
[[nodiscard]] WrittenOutput write_cage_output(const PlannedOutput& planned,
                                              const std::filesystem::path& target,
                                              const FittedMesh& whole,
                                              const MaterialLibrary& materials,
                                              const JobReport& report, bool digests);

}  // namespace planish
