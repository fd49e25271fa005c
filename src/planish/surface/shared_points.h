#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "planish/core/raw_vector.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/patches/patch_numbering.h"

namespace planish {

/// The rows of level 1 that some faces of the mesh need: of their vertices, centres and midpoints
/// of edges, each once where faces that share it are added one after another in the order of the
/// mesh. Topology and numbering must outlive it.
class SharedPoints {
 public:
  /// Room for faces of so many corners together.
  SharedPoints(const MeshTopology& topology, const PatchNumbering& numbering,
               std::int64_t corner_count);

  /// Adds a visible face. What was added before one that does not follow it is no longer shared.
  void add_face(std::int32_t face);

  /// All of them.
  [[nodiscard]] std::span<const std::int32_t> rows() const { return {rows_.data(), row_count_}; }
  /// Places in rows(), of corners of the last face: their vertex, the midpoint of the leading edge.
  [[nodiscard]] std::int32_t vertex(std::int32_t corner) const {
    return vertices_[corner - begin_];
  }
  [[nodiscard]] std::int32_t midpoint(std::int32_t corner) const {
    return midpoints_[corner - begin_];
  }
  /// Of the last face's centre.
  [[nodiscard]] std::int32_t centre() const { return centre_; }

 private:
  [[nodiscard]] std::int32_t add(std::int32_t row) {
    rows_[row_count_] = row;
    return static_cast<std::int32_t>(row_count_++);
  }
  [[nodiscard]] std::int32_t find_or_add(std::int32_t row, std::int32_t place) {
    return place >= 0 && rows_[place] == row ? place : add(row);
  }

  const MeshTopology& topology_;
  const PatchNumbering& numbering_;
  RawVector<std::int32_t> rows_, vertices_, midpoints_;
  std::size_t row_count_ = 0;
  std::int32_t begin_ = 0, end_ = 0;  // the corners whose places are known
  std::int32_t centre_ = -1;
};

}  // namespace planish
