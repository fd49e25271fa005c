// Based on: C. Berge, "Two Theorems in Graph Theory", 1957 (a matching grows along a path that
// leaves and enters its pairs in turn).
#include "planish/mesh/triangle_pairing.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "planish/core/parallel.h"
#include "planish/core/prefix_sum.h"
#include "planish/mesh/quad_rule.h"

namespace planish {
namespace {

// The half-edges of a triangle.
std::array<std::int32_t, 3> sides_of(std::int32_t triangle) {
  return {3 * triangle, 3 * triangle + 1, 3 * triangle + 2};
}

}  // namespace

TrianglePairing::TrianglePairing(std::span<const std::int32_t> twins, std::vector<double> badness)
    : twins_(twins),
      badness_(std::move(badness)),
      chosen_(twins.size() / 3, -1),
      is_tied_(twins.size(), 0) {}

void TrianglePairing::join(std::int32_t half_edge) {
  chosen_[half_edge / 3] = half_edge;
  chosen_[twins_[half_edge] / 3] = twins_[half_edge];
}

void TrianglePairing::pair_greedily() {
  const auto leads = [&](std::int32_t h) { return badness_[h] != kNoPair && h < twins_[h]; };
  const SelectedBlocks blocks = count_selected(twins_.size(), leads);
  std::vector<std::pair<double, std::int32_t>> order(static_cast<std::size_t>(blocks.total));
  for_selected(twins_.size(), blocks, leads, [&](std::size_t h, std::int32_t number) {
    order[number] = {badness_[h], static_cast<std::int32_t>(h)};
  });
  oneapi::tbb::parallel_sort(order.begin(), order.end());
  for (const auto& [badness, h] : order) {
    if (!is_free(h)) continue;
    find_ties(h);
    if (tied_.size() == 1)
      join(h);
    else
      join_ties();
    for (const std::int32_t tied : tied_) is_tied_[tied] = is_tied_[twins_[tied]] = 0;
  }
}

// Those that are as good and hang together by triangles, each once.
void TrianglePairing::find_ties(std::int32_t half_edge) {
  const double badness = badness_[half_edge];
  tied_.clear();
  const auto add = [&](std::int32_t h) {
    tied_.push_back(h);
    is_tied_[h] = is_tied_[twins_[h]] = 1;
  };
  add(half_edge);
  for (std::size_t i = 0; i < tied_.size(); ++i)
    for (const std::int32_t own : {tied_[i], twins_[tied_[i]]})
      for (const std::int32_t h : sides_of(own / 3))
        if (!is_tied_[h] && is_free(h) && std::abs(badness_[h] - badness) <= kAsGood) add(h);
}

int TrianglePairing::partners(std::int32_t triangle) const {
  return static_cast<int>(std::ranges::count_if(
      sides_of(triangle), [&](std::int32_t h) { return is_tied_[h] && is_free(h); }));
}

// All that are tied, or none: then they may be no pairs any more.
void TrianglePairing::join_ties() {
  std::vector<std::int32_t> joined;
  if (join_from_ends(joined)) return;
  for (const std::int32_t h : joined) chosen_[h / 3] = chosen_[twins_[h] / 3] = -1;
  for (const std::int32_t h : tied_) badness_[h] = badness_[twins_[h]] = kNoPair;
}

// From triangles with one partner inwards. False where that leaves one alone, or none has only one.
bool TrianglePairing::join_from_ends(std::vector<std::int32_t>& joined) {
  waiting_.clear();
  for (const std::int32_t h : tied_)
    for (const std::int32_t t : {h / 3, twins_[h] / 3})
      if (partners(t) == 1) waiting_.push_back(t);
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    const std::int32_t t = waiting_[i];
    if (chosen_[t] >= 0) continue;
    const auto sides = sides_of(t);
    const auto side =
        std::ranges::find_if(sides, [&](std::int32_t h) { return is_tied_[h] && is_free(h); });
    if (side == sides.end()) return false;
    join(*side);
    joined.push_back(*side);
    for (const std::int32_t g : sides_of(twins_[*side] / 3)) {
      const std::int32_t beyond = is_tied_[g] ? twins_[g] / 3 : t;
      if (chosen_[beyond] >= 0) continue;
      const int left = partners(beyond);
      if (left == 0) return false;
      if (left == 1) waiting_.push_back(beyond);
    }
  }
  return std::ranges::none_of(tied_, [&](std::int32_t h) { return is_free(h); });
}

void TrianglePairing::exchange(int most, double worst) {
  std::vector<std::int32_t> alone;
  for (std::size_t t = 0; t < chosen_.size(); ++t)
    if (chosen_[t] < 0) alone.push_back(static_cast<std::int32_t>(t));
  std::vector<std::int32_t> claims(chosen_.size());
  while (!alone.empty()) {
    std::vector<Exchange> found;
    for (const std::int32_t t : alone) {
      Exchange best{std::numeric_limits<double>::infinity(), {}, true};
      search(t, most, 0, worst, best);
      if (best.joins.empty() || !best.is_only) continue;
      for (std::int32_t& h : best.joins) h = std::min(h, twins_[h]);
      std::ranges::sort(best.joins);
      found.push_back(std::move(best));
    }
    if (!join_cheapest(found, claims)) return;
    std::erase_if(alone, [&](std::int32_t t) { return chosen_[t] >= 0; });
  }
}

// The cheapest first; of those that cost as much and want the same triangles none. Whether any was
// made.
bool TrianglePairing::join_cheapest(std::vector<Exchange>& found,
                                    std::vector<std::int32_t>& claims) {
  constexpr std::int32_t kUnclaimed = -1, kTaken = -2;
  std::ranges::sort(found, [](const Exchange& a, const Exchange& b) {
    return std::pair(a.cost, std::span(a.joins).front()) <
           std::pair(b.cost, std::span(b.joins).front());
  });
  std::ranges::fill(claims, kUnclaimed);
  const auto all_ends = [&](const Exchange& exchange, const auto& holds) {
    return std::ranges::all_of(exchange.joins, [&](std::int32_t h) {
      return holds(claims[h / 3]) && holds(claims[twins_[h] / 3]);
    });
  };
  bool has_joined = false;
  for (std::size_t first = 0, last = 0; first < found.size(); first = last) {
    // Each is found from both of its ends.
    std::vector<std::int32_t> group;
    for (; last < found.size() && found[last].cost <= found[first].cost + kAsGood; ++last) {
      const auto is_same = [&](std::int32_t g) { return found[g].joins == found[last].joins; };
      const bool is_open =
          all_ends(found[last], [](std::int32_t claim) { return claim != kTaken; });
      if (is_open && std::ranges::none_of(group, is_same))
        group.push_back(static_cast<std::int32_t>(last));
    }
    std::vector<char> is_wanted(group.size(), 1);
    for (std::size_t i = 0; i < group.size(); ++i)
      for (const std::int32_t h : found[group[i]].joins)
        for (std::int32_t* const claim : {&claims[h / 3], &claims[twins_[h] / 3]}) {
          if (*claim >= 0 && *claim != static_cast<std::int32_t>(i))
            is_wanted[*claim] = is_wanted[i] = 0;
          else
            *claim = static_cast<std::int32_t>(i);
        }
    for (std::size_t i = 0; i < group.size(); ++i)
      for (const std::int32_t h : found[group[i]].joins) {
        claims[h / 3] = claims[twins_[h] / 3] = is_wanted[i] ? kTaken : kUnclaimed;
        if (is_wanted[i]) join(h);
        has_joined |= is_wanted[i] != 0;
      }
  }
  return has_joined;
}

// Continues path_ from a triangle that has lost its partner, or has none.
void TrianglePairing::search(std::int32_t triangle, int exchanges, double cost, double worst,
                             Exchange& best) {
  passed_.push_back(triangle);
  for (const std::int32_t h : sides_of(triangle)) {
    if (badness_[h] == kNoPair || badness_[h] > worst + kAsGood || h == chosen_[triangle]) continue;
    const std::int32_t next = twins_[h] / 3;
    if (std::ranges::find(passed_, next) != passed_.end()) continue;
    path_.push_back(h);
    const std::int32_t left = chosen_[next];
    if (left < 0) {
      const double whole = cost + badness_[h];
      if (whole < best.cost - kAsGood)
        best = {whole, path_, true};
      else if (whole < best.cost + kAsGood)
        best.is_only = false;
    } else if (exchanges > 0) {
      passed_.push_back(next);
      search(twins_[left] / 3, exchanges - 1, cost + badness_[h] - badness_[left], worst, best);
      passed_.pop_back();
    }
    path_.pop_back();
  }
  passed_.pop_back();
}

}  // namespace planish
