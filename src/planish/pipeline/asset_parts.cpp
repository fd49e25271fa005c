#include "planish/pipeline/asset_parts.h"

#include <algorithm>

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

}  // namespace planish
