#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <span>

#include "planish/core/callbacks.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// Gets positions and normals at the corners of faces, 4 each. Called for every piece of
/// swept_pieces() once, from many threads at a time; they are the thread's own, so a visit that
/// waits for other threads copies them first.
using QuadVisit = std::function<void(RowRange faces, std::span<const glm::dvec3> positions,
                                     std::span<const glm::vec3> normals)>;

/// Faces of a surface of quads in pieces whose corners stay in a core's cache.
[[nodiscard]] std::vector<RowRange> swept_pieces(const SurfaceInfo& info);

struct KeepOptions {
  glm::dvec3 origin{0.0};  ///< that rows will be stored about
  QuadVisit visit;         ///< from level 1 on; may be empty
  /// Rows that take more are not kept but made anew each time.
  std::uint64_t row_bytes = std::uint64_t{1} << 30;
  Callbacks callbacks{};  ///< step "evaluate", warning "degenerate-normals"
};

/// A surface whose rows and quads are made once, together, for one who reads them several times and
/// in other orders, as the writer of a file does: 24 bytes a row and a byte a face are kept (36 at
/// levels 0 and 1), then positions about `origin` and normals cost a copy, cuts nothing. All else
/// is asked of `surface`, which must outlive the result; the same bits.
/// Throws Error{Cancelled}.
[[nodiscard]] std::unique_ptr<SurfaceBlocks> keep_rows(const SurfaceBlocks& surface,
                                                       const KeepOptions& options);

}  // namespace planish
