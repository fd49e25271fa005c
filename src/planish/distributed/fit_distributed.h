#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/distributed/part_fair.h"
#include "planish/distributed/part_tiles.h"
#include "planish/distributed/petsc_solve.h"
#include "planish/distributed/ranks.h"
#include "planish/distributed/read_slices.h"
#include "planish/fair/fair_net.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

struct DistributedOptions {
  InterpolationMethod method = InterpolationMethod::Progressive;
  std::int32_t polish_steps = 8;  ///< of the fair method
  Weights weights = Weights::DooSabin;
  SharpFeatureOptions sharp;
  /// Besides those of the input, whose vertices they name; use_tags holds for them, too.
  std::vector<CreaseEdge> crease_edges;
  std::vector<CornerVertex> corner_vertices;
  Solver solver = Solver::Chebyshev;  ///< or Plain
  double tolerance = 1e-6;
  double within = 0;  ///< as FitOptions has it
  std::int32_t max_iterations = 200;
  std::int64_t block_vertices = kBlockVertices;
  std::string name = "mesh";  ///< of the input, in messages
  /// Path of a .ply; empty: none. That of the fair method is its mesh of level 1.
  std::string cage;
  std::vector<std::string> cage_header;  ///< comment lines of it
  /// Path of a document of 3D Tiles; empty: none. Its blocks are then a quarter of tile_vertices,
  /// and block_vertices does not count.
  std::string tiles;
  /// gltf.double_sided and gltf.extras are what the fit says.
  TilesOptions tiles_options;
  std::string creases = "use";  ///< what the document says of them
  /// What an ended job of the same input and options has left of its tiles is not made again.
  bool resume = false;
  /// Otherwise what stands at the cage's or the tiles' place by the time that they are renamed
  /// there stays, and AgreedError{UnwritableOutput} is thrown.
  bool replaces = true;
};

/// What one rank did; a plain struct, so that rank 0 can gather them.
struct RankFigures {
  std::int32_t rank = 0, peers = 0;
  std::int64_t vertices = 0, faces = 0, ghosts = 0, halo = 0, peak_bytes = 0;
  std::array<double, std::size(kPhases)> milliseconds{};
  std::array<char, 64> host{};
};

struct DistributedFit {
  std::int64_t vertices = 0, faces = 0, unused_vertices = 0, entries = 0;
  std::array<std::int64_t, 4> kinds{};  ///< vertices by VertexKind
  Placement placement;
  double spectral_bound = 0;
  bool has_boundary = false;
  std::optional<PartTiles> tiles;      ///< where they were asked for
  PetscSolution solution;              ///< the displacement is of this rank's vertices
  std::optional<WithinFit> within;     ///< where vertices may be left
  std::optional<PartFair> fair;        ///< with that method: its figures, also in `solution`
  std::vector<std::int64_t> file_ids;  ///< of those: numbers in the file
  std::vector<Warning> warnings;
  std::vector<RankFigures> ranks;  ///< on rank 0
};

/// Reads by `read`, finds the control points and writes the tiles and the cage, all ranks together.
/// Called before they are renamed into place, `before_commit` may prepare what belongs to it (all
/// ranks). Throws AgreedError as its parts.
[[nodiscard]] DistributedFit fit_distributed(
    const Ranks& ranks, const std::function<MeshSlice()>& read, const DistributedOptions& options,
    RankWatch& watch, const std::function<void(const DistributedFit&)>& before_commit = {});

}  // namespace planish
