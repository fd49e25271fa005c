#pragma once

#include <vector>

#include "bench/group.h"
#include "bench/options.h"

namespace planish::bench {

/// A tolerance that no step reaches.
inline constexpr double kNoStop = -1;

// Each prepares its meshes and tables, throws when peers disagree, then measures.

/// One application of the limit masks.
[[nodiscard]] std::vector<Row> bench_update(const Options& options);
/// The whole solve to 1e-6 of the diagonal.
[[nodiscard]] std::vector<Row> bench_solve(const Options& options);
/// The fair net, and one plain step beside it.
[[nodiscard]] std::vector<Row> bench_fair(const Options& options);
/// Topology and limit masks.
[[nodiscard]] std::vector<Row> bench_masks(const Options& options);
/// Tessellation of the limit surface.
[[nodiscard]] std::vector<Row> bench_surface(const Options& options);
/// Rows and faces of a level by patches, and what they are made from.
[[nodiscard]] std::vector<Row> bench_patches(const Options& options);
/// From the bytes of a file to the bytes of a file.
[[nodiscard]] std::vector<Row> bench_job(const Options& options);
#ifdef PLANISH_HAS_VULKAN
/// From displaced points to a host's vertices on the best Vulkan device, by patches and by tables;
/// nothing without one, as with the two that follow.
[[nodiscard]] std::vector<Row> bench_evaluate(const Options& options);
/// Copies, and each kernel of a frame beside them: bytes and times.
[[nodiscard]] std::vector<Row> bench_kernels(const Options& options);
/// Whole frames of moving points.
[[nodiscard]] std::vector<Row> bench_frame(const Options& options);
/// Many small solves and evaluations in one submission against one as large; nothing without a
/// Vulkan device.
[[nodiscard]] std::vector<Row> bench_many(const Options& options);
#endif
/// Places of a limit surface, closest points and rays; Bfr's Catmull-Clark beside them.
[[nodiscard]] std::vector<Row> bench_query(const Options& options);
/// Moves of a few vertices, and of all, of meshes of several sizes.
[[nodiscard]] std::vector<Row> bench_edit(const Options& options);
/// From a mesh to a level 2 by default, of hubs and large faces beside a torus of as many corners.
[[nodiscard]] std::vector<Row> bench_worst(const Options& options);
/// Catmull-Clark stencils that make a level 2.
[[nodiscard]] std::vector<Row> bench_osd(const Options& options);

}  // namespace planish::bench
