#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/files/gltf/asset/write_asset.h"

namespace planish {

/// What of the work on an asset one of its meshes is: from `begin` to `end`, of 0 to 1.
struct MeshShare {
  double begin = 0, end = 1;
};

/// The shares of meshes of an asset, by the corners that the file says they have. In order.
[[nodiscard]] std::vector<MeshShare> mesh_shares(const GltfAsset& asset);

/// What is done with each mesh of an asset; `Part` is what is known of it meanwhile.
template <class Part>
struct MeshSteps {
  /// Reads a mesh, by its number, and makes it ready for its fit.
  std::function<void(Part& part, std::int64_t number, MeshShare share)> prepare;
  /// Of all that are ready, before the first is fitted: what they take together is known.
  std::function<void(std::list<Part>& parts)> require;
  std::function<void(Part& part, MeshShare share)> fit;
  std::function<void(const Warning&)> warn;
};

/// The meshes of an asset, ready and fitted, in order: first all are read and made ready, then one
/// after another is fitted. One of several that no surface can be made of is left out, with the
/// warning "kept-mesh". Throws Error{UnusableMesh} where none is left, and what else the steps
/// throw.
template <class Part>
std::list<Part> fit_meshes(const GltfAsset& asset, const MeshSteps<Part>& steps) {
  const std::vector<std::int64_t>& numbers = asset.surfaces();
  const std::vector<MeshShare> shares = mesh_shares(asset);
  const std::string file(asset.file().name);
  std::list<Part> parts;
  std::vector<std::size_t> places;  // of the parts, in `numbers`
  const auto is_done = [&](std::size_t place, const std::function<void()>& step) {
    try {
      step();
      return true;
    } catch (const Error& error) {
      if (numbers.size() == 1 || error.code() != ErrorCode::UnusableMesh) throw;
      steps.warn({"kept-mesh",
                  formatted("{}: meshes[{}] stays as it is, no surface can be made of it: {}", file,
                            numbers[place], error.what()),
                  1, numbers[place]});
      return false;
    }
  };
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    Part& part = parts.emplace_back();
    if (is_done(i, [&] { steps.prepare(part, numbers[i], shares[i]); })) {
      places.push_back(i);
    } else {
      parts.pop_back();
    }
  }
  const auto require_any = [&] {
    if (parts.empty())
      throw Error(ErrorCode::UnusableMesh, file + ": no surface can be made of any mesh");
  };
  require_any();
  if (steps.require) steps.require(parts);
  auto part = parts.begin();
  for (const std::size_t i : places) {
    const auto next = std::next(part);
    if (!is_done(i, [&] { steps.fit(*part, shares[i]); })) parts.erase(part);
    part = next;
  }
  require_any();
  return parts;
}

/// Levels of detail of an asset's file, finest first, each of all its parts in their order.
template <class Level>
using AssetDetails = std::list<std::list<Level>>;

/// Of the screen, down to which each of several levels of detail is shown. A mesh is as large on
/// the screen as it is seen there, and what is left out of a coarser level, too: that takes over
/// where it looks no larger than what the finest leaves out does in full. `left_out`: lengths, of
/// each level, finest first. The coarsest never vanishes.
[[nodiscard]] std::vector<double> least_coverages(std::span<const double> left_out);

/// The surfaces of an asset's file: surface(part, level) for each part of each level, with how far
/// down it is shown.
template <class Part, class Level, class Surface>
std::vector<AssetSurface> surfaces_of(std::list<Part>& parts, AssetDetails<Level>& details,
                                      std::span<const double> left_out, const Surface& surface) {
  const std::vector<double> coverages = least_coverages(left_out);
  std::vector<AssetSurface> surfaces;
  auto coverage = coverages.begin();
  for (std::list<Level>& levels : details) {
    auto part = parts.begin();
    for (Level& level : levels) {
      surfaces.push_back(surface(*part++, level));
      surfaces.back().least_coverage = *coverage;
    }
    ++coverage;
  }
  return surfaces;
}

/// What keeps no asset has no levels of detail: throws Error{InvalidArgument}. `remedy` ends the
/// message: "; take ..."
[[noreturn]] void refuse_levels_of_detail(const std::string& output, const std::string& remedy);

}  // namespace planish
