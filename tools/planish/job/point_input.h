#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "job/input.h"
#include "planish/reconstruct/reconstruct.h"

namespace planish::command {

/// A point cloud with what a report says of its file.
struct PointInput {
  std::string name;
  PointCloud cloud;
  std::string sha256;
  FileFormat format = FileFormat::Ply;
};

/// Whether the extension is one that only points have: .xyz, .pts, .pcd.
[[nodiscard]] bool is_point_path(const std::string& path, std::optional<FileFormat> format);

/// Throws what reading the path will throw for its extension and for a missing mesher; reads
/// nothing.
void require_readable(const std::string& path, std::optional<FileFormat> format);

/// Reads points by their extension. Throws Error{UnreadableInput}; Error{InvalidArgument} for an
/// extension that is not read.
[[nodiscard]] PointInput read_point_input(const std::string& path);

/// The points of a PLY file that has no faces; empty for a mesh.
[[nodiscard]] std::optional<PointInput> points_of(const Input& input);

/// The mesher that this installation has. Throws Error{InvalidArgument} where there is none.
[[nodiscard]] Mesher require_mesher();

/// reconstruct() with errors that name the file.
[[nodiscard]] Reconstruction reconstruct_input(const PointInput& input,
                                               const ReconstructOptions& options);

/// The "reconstruction" of a report.
[[nodiscard]] nlohmann::ordered_json reconstruction_json(const PointInput& input,
                                                         const Reconstruction& result);

/// Two aligned lines for people.
[[nodiscard]] std::string reconstruction_summary(const PointInput& input,
                                                 const Reconstruction& result);

}  // namespace planish::command
