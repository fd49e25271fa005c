#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <span>
#include <thread>
#include <type_traits>

#include "planish/core/callbacks.h"
#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/solve/backend.h"
#include "planish/solve/packed_rows.h"

namespace planish {
namespace {

// Palettes beyond this would push points out of the nearest cache.
constexpr std::size_t kMostClasses = 1024;
constexpr std::size_t kHashSlots = 4 * kMostClasses;
// One of so many of a piece's rows may be read from the table before the piece takes indices
// instead.
constexpr std::size_t kFewFarRows = 8;

// Odd, and a different one for each place.
constexpr auto kHashFactors = [] {
  std::array<std::uint64_t, 16> factors{0x9e3779b97f4a7c15u};
  for (std::size_t k = 1; k < factors.size(); ++k) factors[k] = factors[k - 1] * factors[0];
  return factors;
}();

}  // namespace

/// Packs pieces, one after another.
class PackedRows::Packer {
 public:
  explicit Packer(const StencilView<double>& table)
      : table_(table), places_(kPieceRows * kLengths.back()) {}

  void pack(std::size_t begin, std::size_t end, Piece& piece) {
    piece_ = &piece;
    slots_.fill(kPlain);
    place_ = places_.data();
    far_count_ = 0;
    piece.codes.resize(end - begin);
    for (std::size_t row = begin; row < end; ++row) {
      is_far_[row - begin] = false;
      piece.codes[row - begin] = code_of(row);
    }
    piece.is_near = far_count_ * kFewFarRows <= end - begin;
    if (piece.is_near) {
      if (far_count_ > 0) leave_far_rows();
      join_alike_rows();
      piece.differences.resize(static_cast<std::size_t>(place_ - places_.data()));
      std::transform(places_.data(), place_, piece.differences.begin(),
                     [](std::int32_t place) { return static_cast<std::int16_t>(place); });
    } else {
      piece.runs.push_back({static_cast<std::uint16_t>(end - begin), 0});
      write_indices(begin);
    }
  }

 private:
  // A row without sources has no point to fill up with.
  std::uint16_t code_of(std::size_t row) {
    const auto size = static_cast<std::uint32_t>(table_.sizes[row]);
    if (size == 0) return kPlain;
    if (size <= kLengths[0]) return pack_row<kLengths[0]>(row, size);
    if (size <= kLengths[1]) return pack_row<kLengths[1]>(row, size);
    if (size <= kLengths[2]) return pack_row<kLengths[2]>(row, size);
    if (size <= kLengths[3]) return pack_row<kLengths[3]>(row, size);
    return kPlain;
  }

  // Loops are of fixed length, past the row's end, since true lengths are hard to foretell.
  // Filled up with the first source, whatever that is: 0 times it changes no bit of the sum.
  template <std::size_t kLength>
  std::uint16_t pack_row(std::size_t row, std::uint32_t size) {
    const auto first = static_cast<std::size_t>(table_.offsets[row]);
    const double* weight = table_.weights.data() + first;
    const std::int32_t* index = table_.indices.data() + first;
    std::array<double, kLength> last_weights{};
    std::array<std::int32_t, kLength> last_indices{};
    if (first + kLength > table_.weights.size()) {
      std::copy_n(weight, size, last_weights.begin());
      std::copy_n(index, size, last_indices.begin());
      weight = last_weights.data();
      index = last_indices.data();
    }
    std::array<float, kLength> rounded;
    const auto own = static_cast<std::int32_t>(row);
    std::int32_t least = 0, most = 0;
    std::uint64_t hash = kLength;
    for (std::uint32_t k = 0; k < kLength; ++k) {
      rounded[k] = k < size ? static_cast<float>(weight[k]) : 0.0f;
      hash += std::bit_cast<std::uint64_t>(static_cast<double>(rounded[k])) * kHashFactors[k];
      const std::int32_t difference = (k < size ? index[k] : index[0]) - own;
      least = std::min(least, difference);
      most = std::max(most, difference);
      place_[k] = difference;
    }
    const std::uint16_t code = find_class(hash, std::span<const float, kLength>(rounded));
    if (code == kPlain) return code;
    using Limits = std::numeric_limits<std::int16_t>;
    if (least < Limits::min() || most > Limits::max()) {
      is_far_[row % kPieceRows] = true;
      ++far_count_;
    }
    place_ += kLength;
    return code;
  }

  // Rows of one length and equal weights; their sizes before filling up may differ.
  template <std::size_t kLength>
  std::uint16_t find_class(std::uint64_t hash, std::span<const float, kLength> weights) {
    hash = (hash ^ hash >> 32) * kHashFactors[0] >> 32;
    for (std::size_t slot = hash % kHashSlots;; slot = (slot + 1) % kHashSlots) {
      std::uint16_t& code = slots_[slot];
      if (code == kPlain) {
        if (piece_->classes.size() == kMostClasses) return kPlain;
        code = static_cast<std::uint16_t>(piece_->classes.size());
        piece_->classes.push_back({static_cast<std::uint32_t>(piece_->weights.size()), kLength});
        piece_->weights.insert(piece_->weights.end(), weights.begin(), weights.end());
        return code;
      }
      const Class& known = piece_->classes[code];
      if (known.length == kLength &&
          std::equal(weights.begin(), weights.end(), piece_->weights.begin() + known.first_weight))
        return code;
    }
  }

  // Rows that do not fit differences become plain.
  void leave_far_rows() {
    const std::int32_t* from = places_.data();
    place_ = places_.data();
    for (std::size_t i = 0; i < piece_->codes.size(); ++i) {
      std::uint16_t& code = piece_->codes[i];
      if (code == kPlain) continue;
      const std::uint32_t length = piece_->classes[code].length;
      if (is_far_[i])
        code = kPlain;
      else
        place_ = std::copy_n(from, length, place_);
      from += length;
    }
  }

  // Of rows one after another that are alike, a multiple of kLeastRun leaves one code and one set
  // of differences.
  void join_alike_rows() {
    std::vector<std::uint16_t>& codes = piece_->codes;
    const std::int32_t* from = places_.data();
    place_ = places_.data();
    std::size_t single_count = 0, kept = 0;
    const auto close = [&](std::size_t alike_count) {
      piece_->runs.push_back(
          {static_cast<std::uint16_t>(single_count), static_cast<std::uint16_t>(alike_count)});
      single_count = 0;
    };
    for (std::size_t i = 0; i < codes.size();) {
      const std::uint16_t code = codes[i];
      const std::uint32_t length = code == kPlain ? 0 : piece_->classes[code].length;
      std::size_t count = 1;
      if (code != kPlain) {
        while (i + count < codes.size() && codes[i + count] == code &&
               std::equal(from, from + length, from + count * length))
          ++count;
        count = count < kLeastRun ? 1 : count - count % kLeastRun;
      }
      codes[kept++] = code;
      place_ = std::copy_n(from, length, place_);
      from += count * length;
      i += count;
      if (count == 1)
        ++single_count;
      else
        close(count);
    }
    if (single_count > 0) close(0);
    codes.resize(kept);
  }

  void write_indices(std::size_t begin) {
    const std::int32_t* from = places_.data();
    piece_->indices.resize(static_cast<std::size_t>(place_ - from));
    auto to = piece_->indices.begin();
    for (std::size_t i = 0; i < piece_->codes.size(); ++i) {
      if (piece_->codes[i] == kPlain) continue;
      const auto row = static_cast<std::int32_t>(begin + i);
      const std::uint32_t length = piece_->classes[piece_->codes[i]].length;
      for (std::uint32_t k = 0; k < length; ++k) *to++ = *from++ + row;
    }
  }

  const StencilView<double>& table_;
  Piece* piece_ = nullptr;
  std::array<std::uint16_t, kHashSlots> slots_;
  RawVector<std::int32_t> places_;  // differences of the piece's packed rows
  std::int32_t* place_ = nullptr;
  std::array<bool, kPieceRows> is_far_;
  std::size_t far_count_ = 0;
};

PackedRows::PackedRows(const StencilView<double>& table)
    : table_(table), pieces_((table.sizes.size() + kPieceRows - 1) / kPieceRows) {
  parallel_for(pieces_.size(), 4, [&](std::size_t begin, std::size_t end) {
    Packer packer(table_);
    for (std::size_t p = begin; p < end; ++p)
      packer.pack(p * kPieceRows, std::min((p + 1) * kPieceRows, table_.sizes.size()), pieces_[p]);
  });
}

std::uint64_t PackedRows::packed_bytes() const {
  const auto bytes = [](const auto& values) { return values.size() * sizeof values[0]; };
  std::uint64_t total = 0;
  for (const Piece& piece : pieces_)
    total += bytes(piece.runs) + bytes(piece.codes) + bytes(piece.classes) + bytes(piece.weights) +
             bytes(piece.differences) + bytes(piece.indices);
  return total;
}

std::size_t PackedRows::alike_row_count() const {
  std::size_t count = 0;
  for (const Piece& piece : pieces_)
    for (const Run& run : piece.runs) count += run.alike_rows;
  return count;
}

std::size_t PackedRows::plain_row_count() const {
  std::size_t count = 0;
  for (const Piece& piece : pieces_)
    count += static_cast<std::size_t>(std::count(piece.codes.begin(), piece.codes.end(), kPlain));
  return count;
}

namespace {

// Over the residuals of a piece of rows.
struct PieceSums {
  double max_square = 0;
  glm::dvec3 sum{0.0};

  void add(const PieceSums& other) {
    max_square = std::max(max_square, other.max_square);
    sum += other.sum;
  }
};

// Squares of residuals, in registers while rows go by.
class SquareSums {
 public:
  template <class Real>
  void add(const PointLanes<Real>& residual) {
    const PointLanes<double> squares = (residual * residual).in_double();
    sum_ = sum_ + squares;
    const PointLanes<double>::Register pair = squares.xy + squares.z0;
    const double square = pair[0] + pair[1];
    if (square > max_square_) max_square_ = square;
  }

  // Comparisons pass a NaN by, sums do not.
  [[nodiscard]] PieceSums total() const {
    const glm::dvec3 sum = sum_.point();
    const bool is_nan = std::isnan(sum.x + sum.y + sum.z);
    return {is_nan ? std::numeric_limits<double>::infinity() : max_square_, sum};
  }

 private:
  PointLanes<double> sum_{};
  double max_square_ = 0;
};

// Sums are taken over pieces of this many rows, then over the pieces in order: the same bits for
// every thread count.
constexpr std::size_t kPieceRows = PackedRows::kPieceRows;

void join(PieceSums& total, const PieceSums& piece) { total.add(piece); }

ErrorNorms norms(const PieceSums& squares, std::size_t count) {
  const double sum = squares.sum.x + squares.sum.y + squares.sum.z;
  return {std::sqrt(squares.max_square), count == 0 ? 0.0 : std::sqrt(sum / count)};
}

// The rows of a table as they are, for steps in double: those gain less by packing than it costs.
class PlainRows {
 public:
  using Point = PointLanes<double>;
  explicit PlainRows(const StencilView<double>& table) : table_(table) {}

  [[nodiscard]] std::size_t piece_count() const {
    return (table_.sizes.size() + kPieceRows - 1) / kPieceRows;
  }

  // Sums in index order.
  template <class Take>
  void for_each_sum(std::size_t piece, const Point* source, const Take& take) const {
    const std::size_t end = std::min((piece + 1) * kPieceRows, table_.sizes.size());
    for (std::size_t row = piece * kPieceRows; row < end; ++row) {
      Point sum{};
      const std::int32_t* index = table_.indices.data() + table_.offsets[row];
      const double* weight = table_.weights.data() + table_.offsets[row];
      const std::int32_t size = table_.sizes[row];
      for (std::int32_t k = 0; k < size; ++k) sum = sum + weight[k] * source[index[k]];
      take(row, sum);
    }
  }

 private:
  StencilView<double> table_;
};

// Of a given number, or, for 0, those of whoever calls: he may have limited them himself.
class HostThreads {
 public:
  explicit HostThreads(int count) {
    if (count > 0) arena_.emplace(count);
  }

  template <class Work>
  void execute(const Work& work) {
    if (!arena_) return work();
    // Where others use the arena, too, the work may be done on one of their threads.
    const StopScope* const stop = AdoptedStop::current();
    arena_->execute([&] {
      const AdoptedStop adopted(stop);
      work();
    });
  }

 private:
  std::optional<oneapi::tbb::task_arena> arena_;
};

template <class Real>
using RowsIn = std::conditional_t<std::is_same_v<Real, float>, PackedRows, PlainRows>;

// Writes the sums of points behind these.
template <class Real>
void set_sums(const StencilView<double>& sums, RawVector<PointLanes<Real>>& points) {
  const std::size_t point_count = points.size() - sums.sizes.size();
  parallel_each(sums.sizes.size(), 1, [&](std::size_t row) {
    glm::dvec3 sum(0.0);
    const auto first = static_cast<std::size_t>(sums.offsets[row]);
    for (std::size_t k = first; k < first + static_cast<std::size_t>(sums.sizes[row]); ++k)
      sum += sums.weights[k] * points[sums.indices[k]].point();
    points[point_count + row] = PointLanes<Real>::of(sum);
  });
}

template <class Real>
class CpuSolve final : public Solve {
 public:
  CpuSolve(const SummedView& masks, HostThreads& threads)
      : threads_(threads), row_count_(masks.rows.sizes.size()), sums_(masks.sums) {
    PLANISH_ASSERT(masks.point_count() == masks.rows.row_count());
    threads_.execute([&] { rows_.emplace(masks.rows); });
  }

  void begin(std::span<const glm::dvec3> initial_residual) override {
    PLANISH_ASSERT(initial_residual.size() == row_count_);
    initial_residual_.resize(row_count_);
    for (Points* points : {&displacement_, &other_displacement_}) points->resize(source_count());
    for_pieces(row_count_, [&](std::size_t i) {
      initial_residual_[i] = Point::of(initial_residual[i]);
      displacement_[i] = other_displacement_[i] = Point{};
    });
  }

  StepLog run(std::span<const StepCoefficients> steps, double stop_error) override {
    StepLog log;
    for (const StepCoefficients& step : steps) {
      PieceSums squares;
      threads_.execute([&] { squares = take_step(step); });
      log.errors.push_back(norms(squares, row_count_));
      // The step is already computed, but displacement_ is still the one that was measured.
      if (log.errors.back().max <= stop_error) return log;
      std::swap(displacement_, other_displacement_);
      ++log.steps_taken;
    }
    return log;
  }

  ErrorNorms error() override {
    PieceSums squares;
    threads_.execute([&] {
      set_sums(sums_, displacement_);
      squares = sum_rows([initial = initial_residual_.data()](std::size_t i, const Point& image) {
        return initial[i] - image;
      });
    });
    return norms(squares, row_count_);
  }

  [[nodiscard]] std::vector<glm::dvec3> displacement() const override {
    std::vector<glm::dvec3> result(row_count_);
    for_pieces(result.size(), [&](std::size_t i) { result[i] = displacement_[i].point(); });
    return result;
  }

 private:
  using Rows = RowsIn<Real>;
  using Point = PointLanes<Real>;
  using Points = RawVector<Point>;

  // Points, and behind them sums of these.
  [[nodiscard]] std::size_t source_count() const { return row_count_ + sums_.sizes.size(); }

  template <class Body>
  void for_pieces(std::size_t count, const Body& body) const {
    threads_.execute([&] { parallel_each(count, kPieceRows, [&](std::size_t i) { body(i); }); });
  }

  // Squares of what residual_of(i, row i of the table applied to the displacement) returns.
  template <class Residual>
  [[nodiscard]] PieceSums sum_rows(const Residual& residual_of) const {
    const auto piece_of = [&](std::size_t p, std::size_t) {
      return sum_piece(*rows_, p, displacement_.data(), residual_of);
    };
    return ordered_reduce(rows_->piece_count(), 1, PieceSums{}, piece_of, join);
  }

  // All in line, or sums go to memory and back with every row.
  template <class Residual>
  [[gnu::flatten]] static PieceSums sum_piece(const Rows& rows, std::size_t piece,
                                              const Point* source, const Residual& residual_of) {
    SquareSums squares;
    rows.for_each_sum(piece, source, [&squares, residual_of](std::size_t i, const Point& image) {
      squares.add(residual_of(i, image));
    });
    return squares.total();
  }

  // One pass over each row: residual and next displacement. That is written over the last one,
  // which tells the last step: no vector of steps goes to memory and back.
  PieceSums take_step(const StepCoefficients& coefficients) {
    const Real momentum = static_cast<Real>(coefficients.momentum);
    const Real gain = static_cast<Real>(coefficients.gain);
    set_sums(sums_, displacement_);
    // Pointers that stay where they are: what is written might else move the vectors.
    return sum_rows([momentum, gain, initial = initial_residual_.data(),
                     from = displacement_.data(),
                     other = other_displacement_.data()](std::size_t i, const Point& image) {
      const Point residual = initial[i] - image;
      const Point last_step = from[i] - other[i];
      other[i] = from[i] + (momentum * last_step + gain * residual);
      return residual;
    });
  }

  HostThreads& threads_;
  std::size_t row_count_;
  std::optional<Rows> rows_;
  StencilView<double> sums_;
  // The other displacement is the last step's, and becomes the next one.
  Points initial_residual_, displacement_, other_displacement_;
};

// A coordinate whose residual has vanished stays as it is.
glm::dvec3 divide_or_zero(const glm::dvec3& a, const glm::dvec3& b) {
  return {b.x > 0 ? a.x / b.x : 0.0, b.y > 0 ? a.y / b.y : 0.0, b.z > 0 ? a.z / b.z : 0.0};
}

// Based on: M. R. Hestenes and E. Stiefel, "Methods of conjugate gradients for solving linear
// systems", 1952, with one alpha and beta per coordinate.
template <class Real>
std::vector<glm::dvec3> gradients_in(const SummedView& masks, std::span<const glm::dvec3> initial,
                                     std::span<const double> row_weights,
                                     const std::function<bool(const ErrorNorms&)>& goes_on) {
  using Point = PointLanes<Real>;
  using Points = RawVector<Point>;
  const RowsIn<Real> rows(masks.rows);
  const std::size_t count = initial.size();
  Points displacement(count), residual(count), image(count);
  Points step(count + masks.sums.sizes.size());
  parallel_each(count, kPieceRows, [&](std::size_t i) {
    displacement[i] = Point{};
    residual[i] = step[i] = Point::of(initial[i]);
  });
  const auto product = [&](const Points& a, const Points& b) {
    const auto piece_of = [&](std::size_t begin, std::size_t end) {
      PieceSums piece;
      for (std::size_t i = begin; i < end; ++i)
        piece.sum += row_weights[i] * a[i].point() * b[i].point();
      return piece;
    };
    return ordered_reduce(count, kPieceRows, PieceSums{}, piece_of, join).sum;
  };
  glm::dvec3 square = product(residual, residual);
  for (;;) {
    set_sums(masks.sums, step);
    parallel_each(rows.piece_count(), 1, [&](std::size_t p) {
      rows.for_each_sum(p, step.data(), [&](std::size_t i, const Point& sum) { image[i] = sum; });
    });
    const Point alpha = Point::of(divide_or_zero(square, product(step, image)));
    const auto advance = [&](std::size_t begin, std::size_t end) {
      SquareSums piece;
      for (std::size_t i = begin; i < end; ++i) {
        displacement[i] = displacement[i] + alpha * step[i];
        residual[i] = residual[i] - alpha * image[i];
        piece.add(residual[i]);
      }
      return piece.total();
    };
    if (!goes_on(norms(ordered_reduce(count, kPieceRows, PieceSums{}, advance, join), count)))
      break;
    const glm::dvec3 next = product(residual, residual);
    const Point beta = Point::of(divide_or_zero(next, square));
    parallel_each(count, kPieceRows,
                  [&](std::size_t i) { step[i] = residual[i] + beta * step[i]; });
    square = next;
  }
  std::vector<glm::dvec3> result(count);
  parallel_each(count, kPieceRows, [&](std::size_t i) { result[i] = displacement[i].point(); });
  return result;
}

class CpuBackend final : public Backend {
 public:
  explicit CpuBackend(const CpuBackendOptions& options)
      : options_(options), threads_(options.thread_count) {}

  [[nodiscard]] DeviceDescription description() const override {
    const int count = options_.thread_count > 0
                          ? options_.thread_count
                          : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    return {"cpu", std::to_string(count) + (count == 1 ? " thread" : " threads"), "", "", ""};
  }

  void run_on_host(const std::function<void()>& work) override { threads_.execute(work); }

  [[nodiscard]] Precision host_precision() const override { return options_.solve_precision; }

  [[nodiscard]] std::unique_ptr<Solve> make_solve(const SummedView& masks) override {
    if (options_.solve_precision == Precision::Float) {
      return std::make_unique<CpuSolve<float>>(masks, threads_);
    }
    return std::make_unique<CpuSolve<double>>(masks, threads_);
  }

  [[nodiscard]] std::uint64_t peak_device_bytes() const override { return 0; }

 private:
  CpuBackendOptions options_;
  HostThreads threads_;
};

}  // namespace

std::unique_ptr<Backend> make_cpu_backend(const CpuBackendOptions& options) {
  return std::make_unique<CpuBackend>(options);
}

std::vector<glm::dvec3> conjugate_gradients(Precision precision, const SummedView& limit_masks,
                                            std::span<const glm::dvec3> initial_residual,
                                            std::span<const double> row_weights,
                                            const std::function<bool(const ErrorNorms&)>& goes_on) {
  PLANISH_ASSERT(limit_masks.point_count() == std::ssize(initial_residual) &&
                 limit_masks.rows.sizes.size() == initial_residual.size() &&
                 row_weights.size() == initial_residual.size());
  return precision == Precision::Float
             ? gradients_in<float>(limit_masks, initial_residual, row_weights, goes_on)
             : gradients_in<double>(limit_masks, initial_residual, row_weights, goes_on);
}

}  // namespace planish
