#include "planish/features/line_cut.h"

#include <algorithm>

#include "planish/core/group_by.h"

namespace planish {
namespace {

// Of all costs of a cut: less is rounding, and left as it is.
constexpr double kRounding = 1e-9;

constexpr char kOpen = 2;

// Places with what their decided neighbours say. Those whose own costs outweigh all open links are
// decided, too: nearly all.
class Decider {
 public:
  Decider(std::span<const LabelCost> costs, std::span<const LabelLink> links)
      : links_(links), costs_(costs.begin(), costs.end()), open_(costs.size(), 0.0) {
    labels_.assign(costs.size(), kOpen);
    links_at_ = group_by<std::int32_t>(costs.size(), [&](const auto& take) {
      for (std::size_t i = 0; i < links.size(); ++i) {
        take(links[i].a, static_cast<std::int32_t>(i));
        take(links[i].b, static_cast<std::int32_t>(i));
      }
    });
    for (const LabelLink& link : links) {
      open_[link.a] += link.cost;
      open_[link.b] += link.cost;
    }
  }

  void decide_clear_ones() {
    std::vector<std::int32_t> waiting(costs_.size());
    for (std::size_t i = 0; i < waiting.size(); ++i) waiting[i] = static_cast<std::int32_t>(i);
    while (!waiting.empty()) {
      const std::int32_t i = waiting.back();
      waiting.pop_back();
      if (labels_[i] != kOpen) continue;
      const double lead = costs_[i].smooth - costs_[i].sharp;
      // Sums that were taken from leave rounding.
      const double open = open_[i] + kRounding * (costs_[i].smooth + costs_[i].sharp);
      if (lead > open)
        labels_[i] = 1;
      else if (-lead > open)
        labels_[i] = 0;
      else
        continue;
      for (const std::int32_t l : links_at_.of(i)) {
        const std::int32_t other = other_end(l, i);
        open_[other] -= links_[l].cost;
        (labels_[i] ? costs_[other].smooth : costs_[other].sharp) += links_[l].cost;
        if (labels_[other] == kOpen) waiting.push_back(other);
      }
    }
  }

  [[nodiscard]] std::vector<char> cut_the_rest() {
    std::vector<std::int32_t> number(costs_.size(), -1), part;
    for (std::size_t start = 0; start < costs_.size(); ++start) {
      if (labels_[start] != kOpen) continue;
      part.assign(1, static_cast<std::int32_t>(start));
      number[start] = 0;
      for (std::size_t k = 0; k < part.size(); ++k) {
        for (const std::int32_t l : links_at_.of(part[k])) {
          const std::int32_t other = other_end(l, part[k]);
          if (labels_[other] != kOpen || number[other] >= 0) continue;
          number[other] = static_cast<std::int32_t>(part.size());
          part.push_back(other);
        }
      }
      cut(part, number);
    }
    return std::move(labels_);
  }

 private:
  struct Arc {
    std::int32_t to;
    double left;
  };
  std::span<const LabelLink> links_;
  std::vector<LabelCost> costs_;
  std::vector<double> open_;  // of links to open places
  std::vector<char> labels_;
  Groups<std::int32_t> links_at_;

  [[nodiscard]] std::int32_t other_end(std::int32_t link, std::int32_t place) const {
    return links_[link].a == place ? links_[link].b : links_[link].a;
  }

  void cut(std::span<const std::int32_t> part, std::span<const std::int32_t> number);
};

// Dinic's maximum flow; an arc and its reverse stand together, at 2 i and 2 i + 1.
class Flow {
 public:
  explicit Flow(std::size_t nodes) : arcs_at_(nodes), level_(nodes), next_(nodes) {}

  void add(std::int32_t from, std::int32_t to, double there, double back) {
    arcs_at_[from].push_back(static_cast<std::int32_t>(to_.size()));
    to_.push_back(to);
    left_.push_back(there);
    arcs_at_[to].push_back(static_cast<std::int32_t>(to_.size()));
    to_.push_back(from);
    left_.push_back(back);
    total_ += there + back;
  }

  // Afterwards a node is on the source's side where reached() says so.
  void run(std::int32_t source, std::int32_t sink) {
    least_ = kRounding * total_;
    while (set_levels(source, sink)) {
      std::ranges::fill(next_, 0);
      while (push(source, sink)) {
      }
    }
  }

  [[nodiscard]] bool reached(std::int32_t node) const { return level_[node] >= 0; }

 private:
  std::vector<std::vector<std::int32_t>> arcs_at_;
  std::vector<std::int32_t> to_, level_;
  std::vector<std::size_t> next_;
  std::vector<double> left_;
  std::vector<std::int32_t> path_;
  double total_ = 0, least_ = 0;

  bool set_levels(std::int32_t source, std::int32_t sink) {
    std::ranges::fill(level_, -1);
    level_[source] = 0;
    std::vector<std::int32_t> queue{source};
    for (std::size_t k = 0; k < queue.size(); ++k) {
      for (const std::int32_t arc : arcs_at_[queue[k]]) {
        if (left_[arc] <= least_ || level_[to_[arc]] >= 0) continue;
        level_[to_[arc]] = level_[queue[k]] + 1;
        queue.push_back(to_[arc]);
      }
    }
    return level_[sink] >= 0;
  }

  // One path by levels, without recursion.
  bool push(std::int32_t source, std::int32_t sink) {
    path_.clear();
    std::int32_t node = source;
    while (node != sink) {
      const std::vector<std::int32_t>& arcs = arcs_at_[node];
      std::size_t& next = next_[node];
      while (next < arcs.size() &&
             (left_[arcs[next]] <= least_ || level_[to_[arcs[next]]] != level_[node] + 1))
        ++next;
      if (next < arcs.size()) {
        path_.push_back(arcs[next]);
        node = to_[arcs[next]];
        continue;
      }
      if (path_.empty()) return false;
      node = to_[path_.back() ^ 1];
      path_.pop_back();
      ++next_[node];
    }
    double most = left_[path_.front()];
    for (const std::int32_t arc : path_) most = std::min(most, left_[arc]);
    for (const std::int32_t arc : path_) {
      left_[arc] -= most;
      left_[arc ^ 1] += most;
    }
    return true;
  }
};

void Decider::cut(std::span<const std::int32_t> part, std::span<const std::int32_t> number) {
  const auto count = static_cast<std::int32_t>(part.size());
  const std::int32_t source = count, sink = count + 1;
  Flow flow(part.size() + 2);
  for (std::int32_t k = 0; k < count; ++k) {
    const LabelCost& cost = costs_[part[k]];
    const double both = std::min(cost.smooth, cost.sharp);
    flow.add(source, k, cost.smooth - both, 0);
    flow.add(k, sink, cost.sharp - both, 0);
    for (const std::int32_t l : links_at_.of(part[k])) {
      const std::int32_t other = other_end(l, part[k]);
      if (number[other] > k && labels_[other] == kOpen)
        flow.add(k, number[other], links_[l].cost, links_[l].cost);
    }
  }
  flow.run(source, sink);
  for (std::int32_t k = 0; k < count; ++k) labels_[part[k]] = flow.reached(k) ? 1 : 0;
}

}  // namespace

std::vector<char> cheapest_labels(std::span<const LabelCost> costs,
                                  std::span<const LabelLink> links) {
  Decider decider(costs, links);
  decider.decide_clear_ones();
  return decider.cut_the_rest();
}

}  // namespace planish
