#include "planish/distributed/record_chains.h"

#include <algorithm>
#include <map>

namespace planish {

RecordChains::RecordChains(std::int64_t range_bytes, std::int64_t candidates, const Next& next)
    : range_bytes_(range_bytes), chains_(static_cast<std::size_t>(candidates)) {
  std::map<std::int64_t, std::int32_t> heads;  // place -> the chain that is there
  for (std::int64_t c = 0; c < candidates; ++c) heads.emplace(c, static_cast<std::int32_t>(c));
  while (!heads.empty() && heads.begin()->first < range_bytes) {
    std::int64_t place = heads.begin()->first;
    const std::int32_t chain = heads.begin()->second;
    heads.erase(heads.begin());
    const std::int64_t stop =
        heads.empty() ? range_bytes : std::min(range_bytes, heads.begin()->first);
    // The rearmost chain runs until it is no longer that.
    do {
      place = next(place);
    } while (place >= 0 && place < stop);
    if (place < 0) continue;
    const auto [other, is_new] = heads.emplace(place, chain);
    if (!is_new) chains_[chain].joined = other->second;
  }
  for (const auto& [place, chain] : heads) chains_[chain].end = place;
}

std::int64_t RecordChains::overhang(std::int64_t start) const {
  if (start < 0) return -1;
  if (start >= range_bytes_) return start - range_bytes_;  // a record longer than the range
  if (start >= static_cast<std::int64_t>(chains_.size())) return -1;
  auto chain = static_cast<std::size_t>(start);
  while (chains_[chain].joined >= 0) chain = static_cast<std::size_t>(chains_[chain].joined);
  return chains_[chain].end < 0 ? -1 : chains_[chain].end - range_bytes_;
}

}  // namespace planish
