#include "planish/backend/packed_rows.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <span>

#include "planish/core/parallel.h"

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

}  // namespace planish
