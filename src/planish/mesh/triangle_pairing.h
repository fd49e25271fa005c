#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace planish {

/// Badness that says that two triangles may be no pair.
inline constexpr double kNoPair = -1;

/// Pairs of neighbouring triangles, by their badness alone: the order of triangles decides nothing.
/// Of quads that share triangles and are as good all are joined that one matching asks for, or
/// none: triangles of an even fan have two such matchings, of an odd one none.
class TrianglePairing {
 public:
  /// `twins` by half-edge, three a triangle, -1 where there is none; `badness` in radians by
  /// half-edge, kNoPair where there may be no pair.
  TrianglePairing(std::span<const std::int32_t> twins, std::vector<double> badness);

  /// A triangle's half-edge to its partner; -1: none.
  [[nodiscard]] std::span<const std::int32_t> chosen() const { return chosen_; }

  /// The least bad first.
  void pair_greedily();

  /// Triangles left alone are joined by exchanging at most so many pairs, by pairs of at most that
  /// badness, the cheapest exchange first.
  void exchange(int most, double worst);

 private:
  std::span<const std::int32_t> twins_;
  std::vector<double> badness_;
  std::vector<std::int32_t> chosen_;
  std::vector<std::int32_t> tied_, waiting_;  // half-edges, triangles
  std::vector<char> is_tied_;                 // by half-edge
  std::vector<std::int32_t> path_, passed_;   // half-edges to join; triangles

  /// Half-edges to join, ascending, the lesser of each two twins; `is_only`: none other costs as
  /// little.
  struct Exchange {
    double cost = 0;
    std::vector<std::int32_t> joins;
    bool is_only = true;
  };

  [[nodiscard]] bool is_free(std::int32_t half_edge) const {
    return badness_[half_edge] != kNoPair && chosen_[half_edge / 3] < 0 &&
           chosen_[twins_[half_edge] / 3] < 0;
  }
  void join(std::int32_t half_edge);
  void find_ties(std::int32_t half_edge);
  void join_ties();
  [[nodiscard]] bool join_from_ends(std::vector<std::int32_t>& joined);
  [[nodiscard]] int partners(std::int32_t triangle) const;
  [[nodiscard]] bool join_cheapest(std::vector<Exchange>& found, std::vector<std::int32_t>& claims);
  void search(std::int32_t triangle, int exchanges, double cost, double worst, Exchange& best);
};

}  // namespace planish
