#include "planish/backend/cpu_backend.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <thread>
#include <type_traits>

#include "planish/backend/packed_rows.h"
#include "planish/backend/square_sums.h"
#include "planish/core/assert.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/core/stop.h"

namespace planish {

namespace {

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
      set_sums(displacement_);
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

  glm::dvec3 cg_begin(std::span<const glm::dvec3> initial_residual,
                      std::span<const double> row_weights) override {
    begin(initial_residual);
    row_weights_.assign(row_weights.begin(), row_weights.end());
    residual_ = step_ = initial_residual_;
    step_.resize(source_count());
    image_.resize(row_count_);
    return inner_product(residual_, residual_);
  }

  glm::dvec3 cg_apply() override {
    threads_.execute([&] {
      set_sums(step_);
      parallel_each(rows_->piece_count(), 1, [&](std::size_t p) {
        rows_->for_each_sum(p, step_.data(),
                            [&](std::size_t i, const Point& image) { image_[i] = image; });
      });
    });
    return inner_product(step_, image_);
  }

  CgAdvance cg_advance(const glm::dvec3& alpha) override {
    const Point factor = Point::of(alpha);
    PieceSums squares;
    threads_.execute([&] {
      const auto piece_of = [&](std::size_t begin, std::size_t end) {
        SquareSums piece;
        for (std::size_t i = begin; i < end; ++i) {
          displacement_[i] = displacement_[i] + factor * step_[i];
          residual_[i] = residual_[i] - factor * image_[i];
          piece.add(residual_[i]);
        }
        return piece.total();
      };
      squares = ordered_reduce(row_count_, kPieceRows, PieceSums{}, piece_of, join);
    });
    return {inner_product(residual_, residual_), norms(squares, row_count_)};
  }

  void cg_turn(const glm::dvec3& beta) override {
    const Point factor = Point::of(beta);
    threads_.execute([&] {
      parallel_each(row_count_, kPieceRows,
                    [&](std::size_t i) { step_[i] = residual_[i] + factor * step_[i]; });
    });
  }

 private:
  using Rows = std::conditional_t<std::is_same_v<Real, float>, PackedRows, PlainRows>;
  using Point = PointLanes<Real>;
  using Points = RawVector<Point>;

  // Points, and behind them sums of these.
  [[nodiscard]] std::size_t source_count() const { return row_count_ + sums_.sizes.size(); }
  void set_sums(Points& points) const {
    parallel_each(sums_.sizes.size(), 1, [&](std::size_t row) {
      glm::dvec3 sum(0.0);
      const auto first = static_cast<std::size_t>(sums_.offsets[row]);
      for (std::size_t k = first; k < first + static_cast<std::size_t>(sums_.sizes[row]); ++k)
        sum += sums_.weights[k] * points[sums_.indices[k]].point();
      points[row_count_ + row] = Point::of(sum);
    });
  }

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
    set_sums(displacement_);
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

  glm::dvec3 inner_product(const Points& a, const Points& b) {
    PieceSums sums;
    threads_.execute([&] {
      const auto piece_of = [&](std::size_t begin, std::size_t end) {
        PieceSums piece;
        for (std::size_t i = begin; i < end; ++i) {
          piece.sum += row_weights_[i] * a[i].point() * b[i].point();
        }
        return piece;
      };
      sums = ordered_reduce(row_count_, kPieceRows, PieceSums{}, piece_of, join);
    });
    return sums.sum;
  }

  HostThreads& threads_;
  std::size_t row_count_;
  std::optional<Rows> rows_;
  StencilView<double> sums_;
  // The other displacement is the last step's, and becomes the next one.
  Points initial_residual_, displacement_, other_displacement_;
  Points step_, residual_, image_;  // of conjugate gradients
  std::vector<double> row_weights_;
};

class CpuPoints final : public DevicePoints {
 public:
  explicit CpuPoints(std::vector<glm::dvec3> values) : points(std::move(values)) {}
  [[nodiscard]] std::int32_t size() const override {
    return static_cast<std::int32_t>(points.size());
  }
  std::vector<glm::dvec3> points;
};

glm::dvec3 apply_row(const StencilView<double>& table, std::size_t row,
                     const std::vector<glm::dvec3>& source) {
  glm::dvec3 sum(0.0);
  const auto first = static_cast<std::size_t>(table.offsets[row]);
  for (std::size_t k = first; k < first + table.sizes[row]; ++k) {
    sum += table.weights[k] * source[table.indices[k]];
  }
  return sum;
}

struct LimitPoint {
  glm::dvec3 position{0.0}, du{0.0}, dv{0.0};
};

LimitPoint apply_limit_row(const StencilView<double>& table, std::size_t row,
                           const std::vector<glm::dvec3>& source) {
  LimitPoint limit;
  const auto first = static_cast<std::size_t>(table.offsets[row]);
  for (std::size_t k = first; k < first + table.sizes[row]; ++k) {
    const glm::dvec3& point = source[table.indices[k]];
    limit.position += table.weights[k] * point;
    limit.du += table.du_weights[k] * point;
    limit.dv += table.dv_weights[k] * point;
  }
  return limit;
}

glm::vec3 unit_normal(const glm::dvec3& du, const glm::dvec3& dv) {
  const glm::dvec3 normal = glm::cross(du, dv);
  const double length = glm::length(normal);
  const bool degenerate =
      !(length >= kDegenerateNormal * glm::length(du) * glm::length(dv)) || length == 0;
  return degenerate ? glm::vec3(0.0f) : glm::vec3(normal / length);
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

  [[nodiscard]] std::unique_ptr<Solve> make_solve(const SummedView& masks) override {
    if (options_.solve_precision == Precision::Float) {
      return std::make_unique<CpuSolve<float>>(masks, threads_);
    }
    return std::make_unique<CpuSolve<double>>(masks, threads_);
  }

  [[nodiscard]] std::unique_ptr<DevicePoints> upload(std::span<const glm::dvec3> points) override {
    return std::make_unique<CpuPoints>(std::vector<glm::dvec3>(points.begin(), points.end()));
  }

  [[nodiscard]] std::unique_ptr<DevicePoints> allocate(std::int32_t count) override {
    return std::make_unique<CpuPoints>(std::vector<glm::dvec3>(static_cast<std::size_t>(count)));
  }

  [[nodiscard]] std::vector<glm::dvec3> download(const DevicePoints& points) override {
    return static_cast<const CpuPoints&>(points).points;
  }

  void apply(const StencilView<double>& table, const DevicePoints& source, DevicePoints& target,
             std::int32_t first_target) override {
    const auto& from = static_cast<const CpuPoints&>(source).points;
    auto& to = static_cast<CpuPoints&>(target).points;
    PLANISH_ASSERT(&from != &to && table.source_count <= source.size());
    PLANISH_ASSERT(first_target + table.row_count() <= target.size());
    threads_.execute([&] {
      parallel_each(table.sizes.size(), kPieceRows,
                    [&](std::size_t i) { to[first_target + i] = apply_row(table, i, from); });
    });
  }

  void apply_limit(const StencilView<double>& table, const DevicePoints& source,
                   std::span<glm::dvec3> positions, std::span<glm::vec3> normals) override {
    const auto& from = static_cast<const CpuPoints&>(source).points;
    PLANISH_ASSERT(positions.size() == table.sizes.size() && normals.size() == positions.size());
    threads_.execute([&] {
      parallel_each(table.sizes.size(), kPieceRows, [&](std::size_t i) {
        const LimitPoint limit = apply_limit_row(table, i, from);
        positions[i] = limit.position;
        normals[i] = unit_normal(limit.du, limit.dv);
      });
    });
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

}  // namespace planish
