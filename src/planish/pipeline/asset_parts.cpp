#include "planish/pipeline/asset_parts.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace planish {

std::vector<MeshShare> mesh_shares(const GltfAsset& asset) {
  std::vector<double> corners;
  double all = 0;
  for (const std::int64_t number : asset.surfaces()) {
    corners.push_back(static_cast<double>(std::max<std::int64_t>(asset.corner_count(number), 1)));
    all += corners.back();
  }
  std::vector<MeshShare> shares;
  double done = 0;
  for (const double count : corners) {
    shares.push_back({done / all, (done + count) / all});
    done += count;
  }
  if (!shares.empty()) shares.back().end = 1;
  return shares;
}

std::vector<double> least_coverages(std::span<const double> left_out) {
  std::vector<double> coverages;
  for (std::size_t i = 1; i < left_out.size(); ++i)
    coverages.push_back(std::pow(left_out.front() / left_out[i], 2));
  coverages.push_back(0);
  return coverages;
}

void refuse_levels_of_detail(const std::string& output, const std::string& remedy) {
  throw Error(ErrorCode::InvalidArgument,
              output +
                  ": levels of detail in one file are of a glTF with meshes that becomes a glTF "
                  "by itself" +
                  remedy);
}

}  // namespace planish
