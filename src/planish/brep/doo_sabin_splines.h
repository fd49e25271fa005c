#pragma once

#include "planish/brep/spline_surface.h"
#include "planish/limit/limit_surface.h"

namespace planish {

/// A Doo-Sabin surface, of degree 2. The limit surface must outlive it.
class DooSabinSplines : public SplineSurface {
 public:
  explicit DooSabinSplines(const LimitSurface& surface) : surface_(surface) {}

  [[nodiscard]] std::size_t degree() const override { return 2; }
  [[nodiscard]] const MeshTopology& topology() const override { return surface_.topology(); }
  [[nodiscard]] const Placement& placement() const override {
    return surface_.surface().placement();
  }
  [[nodiscard]] std::span<const std::uint8_t> hidden() const override {
    return surface_.surface().hidden();
  }
  [[nodiscard]] bool is_sharp(std::int32_t corner) const override {
    return surface_.surface().patches().is_sharp(corner);
  }
  [[nodiscard]] bool is_singular_at_vertex(std::int32_t corner) const override {
    return surface_.form(corner).is_singular_at_vertex();
  }
  [[nodiscard]] std::unique_ptr<SplinePatch> patch() const override;

 private:
  const LimitSurface& surface_;
};

}  // namespace planish
