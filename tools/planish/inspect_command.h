#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "planish/core/json_fwd.h"
#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/files/readers.h"
#include "planish/job/input.h"
#include "planish/mend/faults.h"
#include "planish/mesh/check.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/mesh/statistics.h"

namespace planish::command {

/// What a file holds, and what is wrong with it.
struct Inspection {
  Input input;  ///< of a mesh; else only its name and digest
  FileFormat format = FileFormat::Obj;
  std::vector<MeshProblem> problems;             ///< of a mesh
  bool is_mended = false;                        ///< fit mends the problems, with warnings
  std::optional<MeshStatistics> statistics;      ///< of a mesh without problems
  std::optional<FoldedEdges> folds;              ///< the same
  TornVertices torn;                             ///< the same
  std::optional<AssetContents> asset;            ///< of a glTF with triangles
  std::string asset_problem;                     ///< why it cannot stay one; empty: it can
  std::optional<PointInput> points;              ///< of a file without faces
  std::optional<ScanContents> scan;              ///< of a scanner's format
  std::optional<std::array<glm::dvec3, 2>> box;  ///< least and largest coordinates, where any are
  double diagonal = 0;
  double spacing = 0;  ///< median distance of a point to its nearest neighbour
};

/// Whether fit would refuse the file.
[[nodiscard]] inline bool is_refused(const Inspection& inspection) {
  return !inspection.problems.empty() && !inspection.is_mended;
}

/// Reads a mesh or points. Throws what the readers throw.
[[nodiscard]] Inspection inspect(const InputFile& file);

/// Schema planish.inspect/1.
[[nodiscard]] nlohmann::ordered_json inspection_json(const Inspection& inspection);
/// Aligned lines for people.
[[nodiscard]] std::string inspection_text(const Inspection& inspection);

}  // namespace planish::command
