#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "planish/distributed/fit_distributed.h"
#include "planish/distributed/ranks.h"
#include "planish/files/formats.h"
#include "planish/mesh/polygon_mesh.h"

// Every rank of the test program runs every test, and calls these together.
namespace planish::test {

/// How many ranks jobs are run on: also more than blocks, and than faces.
inline constexpr int kRankCounts[] = {1, 2, 3, 5, 8};

/// Calls `body` on the first `count` ranks, which see no others. The test is skipped where the
/// program runs on fewer.
void on_ranks(int count, const std::function<void(const Ranks&)>& body);

/// Of the job's first rank; removed at its end. The same path on all.
[[nodiscard]] const std::filesystem::path& shared_folder();
/// Writes a file there by the first rank, and returns its path.
[[nodiscard]] std::string shared_file(const std::string& name, const std::string& content);
/// The path of a file there.
[[nodiscard]] std::string shared_path(const std::string& name);

[[nodiscard]] bool is_first_rank();
[[nodiscard]] std::string content_of(const std::string& path);

/// The message of the Error that all ranks throw together, or "no error"; with its code.
struct Outcome {
  std::string message = "no error";
  int code = -1;
};
[[nodiscard]] Outcome outcome_of(const std::function<void()>& action);

/// The whole mesh on every rank of the job.
[[nodiscard]] PolygonMesh gathered(const Ranks& ranks, const MeshSlice& slice);

/// Expects the same colours, texture coordinates and groups, numbers of them too.
void expect_same_attributes(const PolygonMesh& a, const PolygonMesh& b, const std::string& what);

/// The path of a file there that the first rank writes with all that the format holds.
[[nodiscard]] std::string written(const std::string& name, FileFormat format,
                                  const PolygonMesh& mesh);

/// A mesh as OBJ text with its tags, and as binary PLY.
[[nodiscard]] std::string obj_of(const PolygonMesh& mesh);
[[nodiscard]] std::string ply_of(const PolygonMesh& mesh);

/// As binary PLY with texture coordinates and colours of 8 bits, made up of the vertices' numbers.
[[nodiscard]] std::string ply_with_attributes(const PolygonMesh& mesh);

/// Closed: a torus of 3-, 4- and 6-gons, `around` a multiple of 4 and `across` of 2, with noise.
[[nodiscard]] PolygonMesh mixed_torus(int around, int across);

}  // namespace planish::test
