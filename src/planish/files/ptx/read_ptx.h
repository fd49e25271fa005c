#pragma once

#include <cstddef>

#include "planish/files/formats.h"
#include "planish/files/scan_contents.h"
#include "planish/files/shared/text_lines.h"
#include "planish/mesh/point_cloud.h"

namespace planish {

/// Scans of a PTX one after another, each point moved by its scan's matrix; points at the scanner
/// (0 0 0), where it saw nothing, are counted as missing. Colours are read where all points of all
/// scans have them. The result does not depend on `part_bytes`, which a thread reads at a time.
/// Exceptions as read_points().
[[nodiscard]] PointCloud read_ptx(const FileBytes& file, std::size_t part_bytes = kTextPartBytes);

/// Scans by their number, size and place. Exceptions as read_points().
[[nodiscard]] ScanContents ptx_contents(const FileBytes& file);

}  // namespace planish
