#pragma once

#include <optional>
#include <string>

#include "planish/job/input.h"
#include "planish/job/report.h"
#include "planish/reconstruct/reconstruct.h"

namespace planish {

/// A point cloud with what a report says of its file.
struct PointInput {
  std::string name;
  PointCloud cloud;
  std::string sha256;
  FileFormat format = FileFormat::Ply;
};

/// Whether the format, or the extension where none is given, is one that only points have: xyz,
/// pts, pcd, las, ptx.
[[nodiscard]] bool is_point_path(const std::string& path, std::optional<FileFormat> format);

/// Throws what the path alone says is wrong (require_input()), and Error{NoDevice} for points
/// without a mesher; reads nothing.
void require_readable(const std::string& path, std::optional<FileFormat> format);

/// The points in a loaded file. Throws Error{UnreadableInput}; Error{InvalidArgument} for a format
/// that holds no points.
[[nodiscard]] PointInput points_of(const InputFile& file, const Callbacks& callbacks = {});

/// The points of a PLY file that has no faces; empty for a mesh.
[[nodiscard]] std::optional<PointInput> points_of(const Input& input);

/// The mesher that this installation has. Throws Error{NoDevice} where there is none.
[[nodiscard]] Mesher require_mesher();

/// reconstruct() with errors that name the file.
[[nodiscard]] Reconstruction reconstruct_input(const PointInput& input, const Mesher& mesher,
                                               const ReconstructOptions& options);

/// For reports.
[[nodiscard]] PointFacts facts_of(const PointInput& input, const Reconstruction& result);

/// Two aligned lines for people.
[[nodiscard]] std::string points_text(const PointFacts& points);

}  // namespace planish
