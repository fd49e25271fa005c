#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <utility>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/solve/stencil_table.h"

namespace planish {

/// A point in registers of 16 bytes, which every x86-64 and ARM has: one of four floats or two of
/// two doubles, the last lane idle. A row's sum is a chain of multiply-adds on whole registers.
/// (Wider vectors than the machine's go through memory with GCC 12, at a third of the speed.)
template <class Real>
struct PointLanes;

template <>
struct PointLanes<float> {
  typedef float Register __attribute__((vector_size(16)));
  Register xyz0;

  static PointLanes of(const glm::dvec3& v) {
    return {Register{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z), 0}};
  }
  [[nodiscard]] glm::dvec3 point() const { return {xyz0[0], xyz0[1], xyz0[2]}; }
  [[nodiscard]] PointLanes<double> in_double() const;
  friend PointLanes operator+(PointLanes a, PointLanes b) { return {a.xyz0 + b.xyz0}; }
  friend PointLanes operator-(PointLanes a, PointLanes b) { return {a.xyz0 - b.xyz0}; }
  friend PointLanes operator*(PointLanes a, PointLanes b) { return {a.xyz0 * b.xyz0}; }
  friend PointLanes operator*(float a, PointLanes b) { return {a * b.xyz0}; }
};

template <>
struct PointLanes<double> {
  typedef double Register __attribute__((vector_size(16)));
  Register xy, z0;

  static PointLanes of(const glm::dvec3& v) { return {Register{v.x, v.y}, Register{v.z, 0}}; }
  [[nodiscard]] glm::dvec3 point() const { return {xy[0], xy[1], z0[0]}; }
  [[nodiscard]] PointLanes in_double() const { return *this; }
  friend PointLanes operator+(PointLanes a, PointLanes b) { return {a.xy + b.xy, a.z0 + b.z0}; }
  friend PointLanes operator-(PointLanes a, PointLanes b) { return {a.xy - b.xy, a.z0 - b.z0}; }
  friend PointLanes operator*(PointLanes a, PointLanes b) { return {a.xy * b.xy, a.z0 * b.z0}; }
  friend PointLanes operator*(double a, PointLanes b) { return {a * b.xy, a * b.z0}; }
};

inline PointLanes<double> PointLanes<float>::in_double() const {
  using Pair = PointLanes<double>::Register;
  return {__builtin_convertvector(__builtin_shufflevector(xyz0, xyz0, 0, 1), Pair),
          __builtin_convertvector(__builtin_shufflevector(xyz0, xyz0, 2, 3), Pair)};
}

/// A stencil table in the form that the CPU's steps in float read fastest. A row's weights follow
/// from its valence and its faces' sizes, so few rows differ: each piece of rows has a palette of
/// them, and a row holds a number of that and its sources as 16-bit differences to its own index
/// (32-bit indices in pieces where many do not fit). Rows are filled up to few lengths with weights
/// of 0, which the machine foretells better than true lengths. Where rows one after another have
/// the same weights and differences, as in a grid of quads, they are one run that has them once.
/// Sums are the bits of plain ones, in index order. Rows that do not fit are read from the table
/// itself, which must outlive this.
class PackedRows {
 public:
  using Point = PointLanes<float>;
  /// Rows of a piece; the last one may have fewer.
  static constexpr std::size_t kPieceRows = 4096;
  /// Sources that a row has after filling up, where it has no more; longer ones are not packed.
  static constexpr std::array<std::uint32_t, 4> kLengths{8, 9, 12, 16};
  /// Rows that are alike make a run from so many on; it has a multiple of this.
  static constexpr std::size_t kLeastRun = 8;

  /// Packs on TBB's threads. Weights are rounded once.
  explicit PackedRows(const StencilView<double>& table);

  [[nodiscard]] std::size_t piece_count() const { return pieces_.size(); }

  /// Calls take(row, sum) for the rows of piece `piece` in their order; `source` has the table's
  /// source_count points, all of them finite or the sums of their rows are not.
  template <class Take>
  void for_each_sum(std::size_t piece, const Point* source, const Take& take) const {
    const Piece& rows = pieces_[piece];
    if (rows.is_near)
      walk<true>(piece, rows.differences.data(), source, take);
    else
      walk<false>(piece, rows.indices.data(), source, take);
  }

  /// What all pieces take, rows that are read from the table, and rows of runs.
  [[nodiscard]] std::uint64_t packed_bytes() const;
  [[nodiscard]] std::size_t plain_row_count() const;
  [[nodiscard]] std::size_t alike_row_count() const;

 private:
  static constexpr std::uint16_t kPlain = 0xffff;
  struct Class {
    std::uint32_t first_weight, length;
  };
  // Rows one after another: first those that are single, then those that are alike.
  struct Run {
    std::uint16_t single_rows, alike_rows;
  };
  struct Piece {
    bool is_near = true;  // differences, else indices
    std::vector<Run> runs;
    // The class of each single row, or kPlain; then that of all that are alike.
    std::vector<std::uint16_t> codes;
    std::vector<Class> classes;
    std::vector<float> weights;
    RawVector<std::int16_t> differences;
    RawVector<std::int32_t> indices;
  };
  class Packer;

  template <class Index, std::size_t... kNumbers>
  static Point add_up(const Point* base, const Index* at, const float* weight,
                      std::index_sequence<kNumbers...>) {
    Point sum{};
    ((sum = sum + weight[kNumbers] * base[at[kNumbers]]), ...);
    return sum;
  }
  template <std::size_t kLength, class Index>
  static Point add_up(const Point* base, const Index* at, const float* weight) {
    return add_up(base, at, weight, std::make_index_sequence<kLength>());
  }

  [[nodiscard]] Point plain_sum(std::size_t row, const Point* source) const {
    Point sum{};
    const auto first = static_cast<std::size_t>(table_.offsets[row]);
    const std::size_t end = first + static_cast<std::size_t>(table_.sizes[row]);
    for (std::size_t k = first; k < end; ++k)
      sum = sum + static_cast<float>(table_.weights[k]) * source[table_.indices[k]];
    return sum;
  }

  template <bool kIsNear, class Index, class Take>
  void walk(std::size_t piece, const Index* at, const Point* source, const Take& take) const {
    const Piece& rows = pieces_[piece];
    const std::uint16_t* code = rows.codes.data();
    std::size_t row = piece * kPieceRows;
    for (const Run& run : rows.runs) {
      at = walk_singles<kIsNear>(rows, {code, run.single_rows}, row, at, source, take);
      code += run.single_rows;
      row += run.single_rows;
      if (run.alike_rows == 0) continue;
      const Class& alike = rows.classes[*code++];
      const float* weight = rows.weights.data() + alike.first_weight;
      const auto walk_run = [&]<std::size_t... kPlace>(std::index_sequence<kPlace...>) {
        (void)((alike.length == kLengths[kPlace] &&
                (walk_alike<kLengths[kPlace]>(row, run.alike_rows, source, at, weight, take),
                 true)) ||
               ...);
      };
      walk_run(std::make_index_sequence<kLengths.size()>());
      at += alike.length;
      row += run.alike_rows;
    }
  }

  template <bool kIsNear, class Index, class Take>
  const Index* walk_singles(const Piece& rows, std::span<const std::uint16_t> codes,
                            std::size_t row, const Index* at, const Point* source,
                            const Take& take) const {
    const Class* classes = rows.classes.data();
    const float* weights = rows.weights.data();
    for (const std::uint16_t code : codes) {
      Point sum;
      if (code == kPlain) {
        sum = plain_sum(row, source);
      } else {
        const std::uint32_t length = classes[code].length;
        const float* weight = weights + classes[code].first_weight;
        const Point* base = kIsNear ? source + row : source;
        if (length == kLengths[0])
          sum = add_up<kLengths[0]>(base, at, weight);
        else if (length == kLengths[1])
          sum = add_up<kLengths[1]>(base, at, weight);
        else if (length == kLengths[2])
          sum = add_up<kLengths[2]>(base, at, weight);
        else
          sum = add_up<kLengths[3]>(base, at, weight);
        at += length;
      }
      // In one place, so that it becomes part of the loop.
      take(row++, sum);
    }
    return at;
  }

  // Sources of rows that are alike lie one after another, too: each weight and difference is read
  // once for four rows.
  template <std::size_t kLength, class Index, class Take>
  static void walk_alike(std::size_t row, std::size_t count, const Point* source, const Index* at,
                         const float* weight, const Take& take) {
    for (const std::size_t end = row + count; row < end; row += 4) {
      const Point* base = source + row;
      Point a{}, b{}, c{}, d{};
      const auto add = [&](std::size_t k) {
        const Point* from = base + at[k];
        const float w = weight[k];
        a = a + w * from[0];
        b = b + w * from[1];
        c = c + w * from[2];
        d = d + w * from[3];
      };
      [&]<std::size_t... kNumbers>(std::index_sequence<kNumbers...>) { (add(kNumbers), ...); }
      (std::make_index_sequence<kLength>());
      const auto take_four = [&](const auto&... sums) {
        std::size_t next = row;
        (take(next++, sums), ...);
      };
      take_four(a, b, c, d);
    }
  }

  static_assert(kLeastRun % 4 == 0);
  StencilView<double> table_;
  std::vector<Piece> pieces_;
};

}  // namespace planish
