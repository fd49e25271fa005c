#pragma once

#include <cstdint>
#include <limits>
#include <queue>
#include <vector>

#include "planish/reconstruct/simplify_state.h"

namespace planish {

/// Half-edge collapses, the cheapest first, until none is allowed or the target is reached.
class CollapsePass {
 public:
  /// Keeps the state.
  explicit CollapsePass(SimplifyState& state)
      : state_(state), waiting_(state.positions.size(), Waiting{}) {}

  /// Looks at the vertices that are due.
  void run();

 private:
  // What a vertex waits for in the queue; entries of an older version are stale.
  struct Waiting {
    double cost = std::numeric_limits<double>::infinity();
    std::uint32_t version = 0;
  };
  struct Entry {
    double cost;
    std::int32_t vertex;
    std::uint32_t version;
    [[nodiscard]] bool operator<(const Entry& other) const {
      return cost > other.cost || (cost == other.cost && vertex > other.vertex);
    }
  };
  struct Candidate {
    double cost;
    std::size_t target;  // of the fan's ring
  };

  [[nodiscard]] double cost_of(std::int32_t vertex, std::int32_t target) const;
  [[nodiscard]] double least_cost(std::int32_t vertex) const;
  void fill_queue();
  void push(std::int32_t vertex, double cost);
  void list_candidates(std::int32_t vertex);
  void collapse_best(const Entry& entry);
  bool try_collapse(std::int32_t vertex, std::size_t target);
  bool keeps_valences(std::int32_t vertex, std::size_t target) const;
  bool keeps_shape(std::int32_t vertex, std::size_t target);
  void apply(std::int32_t vertex, std::size_t target);

  SimplifyState& state_;
  std::vector<Waiting> waiting_;  // by vertex
  std::priority_queue<Entry> queue_;
  // Used again from step to step.
  Fan fan_;
  std::vector<Candidate> candidates_;
  TriangleChange change_;
};

}  // namespace planish
