#pragma once

#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/make_ready.h"

namespace planish {

/// Every warning once, to the caller and into the list. Both must outlive it.
class WarningList {
 public:
  WarningList(std::vector<Warning>& list, const Callbacks& caller) : list_(list), caller_(caller) {}
  void add(const Warning& warning) const;

 private:
  std::vector<Warning>& list_;
  const Callbacks& caller_;
};

/// What make_ready() is to do of a mesh with these options. `may_join` must outlive it.
[[nodiscard]] Preparation preparation_of(const MeshFitOptions& options, InterpolationMethod method,
                                         std::span<const std::uint8_t> may_join = {});

/// Puts what make_ready() made into a fit, and says what was changed.
void take(FittedMesh& result, ReadyMesh&& ready, std::string_view name,
          const WarningList& warnings);

/// Of another mesh with the same options, of which nothing is made yet.
[[nodiscard]] FittedMesh without_fit(const FittedMesh& fitted);

/// What take() took, once more. What was said of it was said.
[[nodiscard]] ReadyMesh ready_again(const FittedMesh& fitted);

}  // namespace planish
