// Based on: M. Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008, section 4; J. Pineda,
// "A Parallel Algorithm for Polygon Rasterization", 1988: places of triangles by edge functions.
#include "planish/surface/bake_normals.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "planish/core/callbacks.h"
#include "planish/core/parallel.h"
#include "planish/core/vectors.h"

namespace planish {
namespace {

// Texels that are made at once, along a side: rows of a band.
constexpr int kBandTexels = 16;
// Samples along a side of the texture, where a texel has several: edges of charts look the same at
// every size, and the time does not grow.
constexpr int kSampleSide = 4096;
constexpr int kMostSamples = 4;
// Beside the mesh so many texels of a side of 1024 are filled: four levels of a mipmap mix in no
// other ones.
constexpr int kPadding = 16, kPaddingOf = 1024, kLeastPadding = 4;
// A triangle that is repeated more often is one of a texture that repeats.
constexpr int kMostTiles = 64;
// Of the frame of a texel, whose vectors are about unit, below which it turns nothing back.
constexpr double kLeastFrame = 1e-6;
constexpr std::int32_t kNone = -1;

int samples_of(int size) { return std::clamp(kSampleSide / size, 1, kMostSamples); }

// A triangle moved by whole squares of the texture.
struct Placed {
  std::int32_t triangle = 0;
  std::int32_t across = 0, up = 0;  // squares that it is moved back by

  [[nodiscard]] bool is_moved() const { return across != 0 || up != 0; }
};

// In samples, the top row first.
using Corners = std::array<glm::dvec2, 3>;

Corners corners_of(const BakeSheet& sheet, const Placed& placed, int side) {
  Corners corners;
  for (std::size_t k = 0; k < 3; ++k) {
    const glm::dvec2 uv(sheet
                            .vertices[static_cast<std::size_t>(
                                sheet.triangles[static_cast<std::size_t>(placed.triangle)][k])]
                            .uv);
    corners[k] = {(uv.x - placed.across) * side, (1 - (uv.y - placed.up)) * side};
  }
  return corners;
}

// Twice the area of an edge and a place, the same but for its sign from either end.
double edge_function(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& p) {
  const bool is_turned = b.x < a.x || (b.x == a.x && b.y < a.y);
  const glm::dvec2 &from = is_turned ? b : a, &to = is_turned ? a : b;
  const double twice = (to.x - from.x) * (p.y - from.y) - (to.y - from.y) * (p.x - from.x);
  return is_turned ? -twice : twice;
}

// Of the corners at a place.
glm::dvec3 weights_at(const Corners& corners, const glm::dvec2& p) {
  glm::dvec3 weights;
  for (int k = 0; k < 3; ++k)
    weights[k] = edge_function(corners[static_cast<std::size_t>((k + 1) % 3)],
                               corners[static_cast<std::size_t>((k + 2) % 3)], p);
  return weights / (weights.x + weights.y + weights.z);
}

// Samples whose middles lie in a range, of a side of them.
std::pair<int, int> samples_within(double low, double high, int side) {
  const double first = std::ceil(low - 0.5), last = std::floor(high - 0.5);
  return {static_cast<int>(std::clamp(first, 0.0, static_cast<double>(side))),
          static_cast<int>(std::clamp(last, -1.0, side - 1.0))};
}

// The triangles of a sheet, as they lie in the square, by bands of its rows.
class PlacedTriangles {
 public:
  PlacedTriangles(const BakeSheet& sheet, const BakeOptions& options)
      : sheet_(sheet), side_(options.size * samples_of(options.size)) {
    for (std::size_t t = 0; t < sheet.triangles.size(); ++t)
      if (options.charts[static_cast<std::size_t>(sheet.faces[t])] >= 0)
        place(static_cast<std::int32_t>(t));
    std::ranges::stable_partition(placed_, [](const Placed& one) { return !one.is_moved(); });
    const int band = kBandTexels * samples_of(options.size);
    first_.assign(static_cast<std::size_t>((side_ + band - 1) / band) + 1, 0);
    for_bands(band, [&](std::size_t, std::size_t b) { ++first_[b + 1]; });
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    order_.resize(static_cast<std::size_t>(first_.back()));
    std::vector<std::int64_t> next(first_.begin(), first_.end() - 1);
    for_bands(band, [&](std::size_t i, std::size_t b) {
      order_[static_cast<std::size_t>(next[b]++)] = static_cast<std::int32_t>(i);
    });
  }

  [[nodiscard]] const Placed& at(std::int32_t number) const {
    return placed_[static_cast<std::size_t>(number)];
  }
  [[nodiscard]] std::int32_t face(std::int32_t number) const {
    return sheet_.faces[static_cast<std::size_t>(at(number).triangle)];
  }
  /// A triangle too many squares long.
  [[nodiscard]] std::int32_t repeating_face() const { return repeating_face_; }

  /// visit(sample, number) for the samples of rows [first_row, end_row) on each triangle, in order.
  template <class Visit>
  void visit_band(std::size_t band, int first_row, int end_row, const Visit& visit) const {
    for (std::int64_t i = first_[band]; i < first_[band + 1]; ++i) {
      const std::int32_t number = order_[static_cast<std::size_t>(i)];
      Corners c = corners_of(sheet_, at(number), side_);
      const double area = edge_function(c[0], c[1], c[2]);
      if (area == 0) continue;
      if (area < 0) std::swap(c[1], c[2]);
      const auto [y_low, y_high] = std::minmax({c[0].y, c[1].y, c[2].y});
      const auto [x_low, x_high] = std::minmax({c[0].x, c[1].x, c[2].x});
      const auto rows = samples_within(y_low, y_high, side_);
      const auto columns = samples_within(x_low, x_high, side_);
      for (int y = std::max(rows.first, first_row); y <= std::min(rows.second, end_row - 1); ++y)
        for (int x = columns.first; x <= columns.second; ++x)
          if (is_inside(c, {x + 0.5, y + 0.5}))
            visit(static_cast<std::size_t>(y - first_row) * static_cast<std::size_t>(side_) +
                      static_cast<std::size_t>(x),
                  number);
    }
  }

 private:
  // Of a place on an edge one of the two triangles has it.
  [[nodiscard]] static bool is_inside(const Corners& c, const glm::dvec2& p) {
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::dvec2 &a = c[k], &b = c[(k + 1) % 3];
      const double side = edge_function(a, b, p);
      const bool is_turned = b.x < a.x || (b.x == a.x && b.y < a.y);
      if (side < 0 || (side == 0 && is_turned)) return false;
    }
    return true;
  }

  void place(std::int32_t triangle) {
    glm::dvec2 low(std::numeric_limits<double>::infinity()), high(-low);
    for (const std::int32_t v : sheet_.triangles[static_cast<std::size_t>(triangle)]) {
      const glm::dvec2 uv(sheet_.vertices[static_cast<std::size_t>(v)].uv);
      low = {std::min(low.x, uv.x), std::min(low.y, uv.y)};
      high = {std::max(high.x, uv.x), std::max(high.y, uv.y)};
    }
    const double left = std::floor(low.x), right = std::max(std::ceil(high.x), left + 1);
    const double down = std::floor(low.y), top = std::max(std::ceil(high.y), down + 1);
    constexpr double kFarthest = 1 << 30;
    if ((right - left) * (top - down) > kMostTiles || std::max(-left, right) > kFarthest ||
        std::max(-down, top) > kFarthest) {
      if (repeating_face_ < 0) repeating_face_ = sheet_.faces[static_cast<std::size_t>(triangle)];
      return;
    }
    for (auto up = static_cast<std::int32_t>(down); up < top; ++up)
      for (auto across = static_cast<std::int32_t>(left); across < right; ++across)
        placed_.push_back({triangle, across, up});
  }

  // take(number, band) for each band that a triangle lies in.
  template <class Take>
  void for_bands(int band, const Take& take) const {
    for (std::size_t i = 0; i < placed_.size(); ++i) {
      const Corners c = corners_of(sheet_, placed_[i], side_);
      const auto [low, high] = std::minmax({c[0].y, c[1].y, c[2].y});
      const auto rows = samples_within(low, high, side_);
      for (int b = rows.first / band; rows.first <= rows.second && b <= rows.second / band; ++b)
        take(i, static_cast<std::size_t>(b));
    }
  }

  const BakeSheet& sheet_;
  int side_;
  std::vector<Placed> placed_;
  std::vector<std::int64_t> first_;  // of each band, in order_
  std::vector<std::int32_t> order_;
  std::int32_t repeating_face_ = kNone;
};

// Normal and tangent at a place of a triangle, as renderers interpolate them.
struct Frame {
  glm::dvec3 normal{0.0}, tangent{0.0}, bitangent{0.0};
};

Frame frame_at(const BakeSheet& sheet, std::int32_t triangle, const glm::dvec3& weights) {
  Frame frame;
  double sign = 1;
  for (int k = 0; k < 3; ++k) {
    const BakeVertex& vertex = sheet.vertices[static_cast<std::size_t>(
        sheet.triangles[static_cast<std::size_t>(triangle)][static_cast<std::size_t>(k)])];
    frame.normal += weights[k] * glm::dvec3(vertex.normal);
    frame.tangent += weights[k] * glm::dvec3(vertex.tangent);
    if (vertex.tangent.w < 0) sign = -1;
  }
  frame.bitangent = sign * glm::cross(frame.normal, frame.tangent);
  return frame;
}

// Where tangents cancel out any frame is as good: renderers have none.
glm::dvec3 in_frame(const Frame& frame, const glm::dvec3& direction) {
  const glm::dmat3 axes(frame.tangent, frame.bitangent, frame.normal);
  const double volume = glm::determinant(axes);
  if (std::abs(volume) < kLeastFrame) return {0, 0, 1};
  return unit_or_zero(glm::inverse(axes) * direction);
}

enum class Texel : std::uint8_t { Empty, Lacking, Made };

// Sums of a band.
struct BandSums {
  std::int64_t covered = 0, overlapped = 0;
  std::int32_t overlapping = std::numeric_limits<std::int32_t>::max();
  std::int32_t outside = overlapping, repeating = overlapping;

  void add(const BandSums& other) {
    covered += other.covered, overlapped += other.overlapped;
    overlapping = std::min(overlapping, other.overlapping);
    outside = std::min(outside, other.outside);
    repeating = std::min(repeating, other.repeating);
  }
};

class Baker {
 public:
  Baker(const BakeSheet& low, const BakeSheet& fine, const BakeOptions& options)
      : low_(low),
        fine_(fine),
        options_(options),
        samples_(samples_of(options.size)),
        side_(options.size * samples_),
        low_placed_(low, options),
        fine_placed_(fine, options) {
    const auto count =
        static_cast<std::size_t>(options.size) * static_cast<std::size_t>(options.size);
    map_.size = options.size;
    map_.pixels.assign(3 * count, 0);
    states_.assign(count, Texel::Empty);
    charts_.assign(count, kNone);
  }

  NormalMap bake() {
    const auto bands = static_cast<std::size_t>((options_.size + kBandTexels - 1) / kBandTexels);
    std::vector<BandSums> of_bands(bands);
    parallel_each(bands, 1, [&](std::size_t b) { of_bands[b] = make_band(b); });
    BandSums sums;
    for (const BandSums& one : of_bands) sums.add(one);
    options_.callbacks.report("bake", 0.8);
    const auto known = [](std::int32_t face) {
      return face == std::numeric_limits<std::int32_t>::max() ? kNone : face;
    };
    map_.covered = static_cast<double>(sums.covered) / static_cast<double>(side_) / side_;
    if (sums.covered > 0)
      map_.overlapped = static_cast<double>(sums.overlapped) / static_cast<double>(sums.covered);
    map_.overlapping_face = known(sums.overlapping);
    map_.outside_face = known(sums.outside);
    map_.repeating_face =
        low_placed_.repeating_face() >= 0 ? low_placed_.repeating_face() : known(sums.repeating);
    fill_lacking();
    pad();
    for (std::size_t i = 0; i < states_.size(); ++i)
      if (states_[i] != Texel::Made) write(i, {0, 0, 1});
    return std::move(map_);
  }

 private:
  BandSums make_band(std::size_t band) {
    const int first = static_cast<int>(band) * kBandTexels;
    const int end = std::min(first + kBandTexels, options_.size);
    const int first_row = first * samples_, end_row = end * samples_;
    const auto count =
        static_cast<std::size_t>(end_row - first_row) * static_cast<std::size_t>(side_);
    std::vector<std::int32_t> lows(count, kNone), fines(count, kNone);
    std::vector<bool> is_shared(count, false);
    BandSums sums;
    low_placed_.visit_band(band, first_row, end_row, [&](std::size_t sample, std::int32_t number) {
      const std::int32_t face = low_placed_.face(number);
      if (low_placed_.at(number).is_moved()) sums.outside = std::min(sums.outside, face);
      if (lows[sample] == kNone) {
        lows[sample] = number;
        ++sums.covered;
        return;
      }
      if (!is_shared[sample]) ++sums.overlapped;
      is_shared[sample] = true;
      sums.overlapping = std::min(sums.overlapping, face);
      // Beside itself: by another square of the same chart.
      const Placed &own = low_placed_.at(lows[sample]), &other = low_placed_.at(number);
      if (chart(low_placed_.face(lows[sample])) == chart(face) &&
          (own.across != other.across || own.up != other.up))
        sums.repeating = std::min(sums.repeating, face);
    });
    fine_placed_.visit_band(band, first_row, end_row, [&](std::size_t sample, std::int32_t number) {
      if (lows[sample] == kNone || fines[sample] != kNone) return;
      const Placed &low = low_placed_.at(lows[sample]), &fine = fine_placed_.at(number);
      if (low.across == fine.across && low.up == fine.up &&
          chart(low_placed_.face(lows[sample])) == chart(fine_placed_.face(number)))
        fines[sample] = number;
    });
    for (int y = first; y < end; ++y)
      for (int x = 0; x < options_.size; ++x) make_texel(x, y, first_row, lows, fines);
    return sums;
  }

  void make_texel(int x, int y, int first_row, const std::vector<std::int32_t>& lows,
                  const std::vector<std::int32_t>& fines) {
    constexpr std::size_t kMost = kMostSamples * kMostSamples;
    std::array<std::size_t, kMost> covered;
    std::size_t count = 0;
    for (int j = 0; j < samples_; ++j)
      for (int i = 0; i < samples_; ++i) {
        const std::size_t sample = static_cast<std::size_t>(y * samples_ + j - first_row) *
                                       static_cast<std::size_t>(side_) +
                                   static_cast<std::size_t>(x * samples_ + i);
        if (lows[sample] != kNone) covered[count++] = sample;
      }
    if (count == 0) return;
    const auto chart_of = [&](std::size_t sample) { return chart(low_placed_.face(lows[sample])); };
    // Frames of two charts have no mean: the one with most of the texel has all of it.
    std::int32_t taken = kNone;
    std::size_t most = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const std::int32_t own = chart_of(covered[k]);
      const auto same = static_cast<std::size_t>(
          std::count_if(covered.begin(), covered.begin() + static_cast<std::ptrdiff_t>(count),
                        [&](std::size_t sample) { return chart_of(sample) == own; }));
      if (same > most || (same == most && own < taken)) taken = own, most = same;
    }
    glm::dvec3 sum(0.0);
    for (std::size_t k = 0; k < count; ++k)
      if (chart_of(covered[k]) == taken && fines[covered[k]] != kNone)
        sum += normal_at(covered[k], first_row, lows[covered[k]], fines[covered[k]]);
    const std::size_t texel =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(options_.size) +
        static_cast<std::size_t>(x);
    charts_[texel] = taken;
    states_[texel] = sum == glm::dvec3(0.0) ? Texel::Lacking : Texel::Made;
    if (states_[texel] == Texel::Made) write(texel, sum);
  }

  // Of the fine surface, in the frame of the mesh.
  [[nodiscard]] glm::dvec3 normal_at(std::size_t sample, int first_row, std::int32_t low_number,
                                     std::int32_t fine_number) const {
    const auto side = static_cast<std::size_t>(side_);
    const glm::dvec2 place(static_cast<double>(sample % side) + 0.5,
                           static_cast<double>(sample / side) + first_row + 0.5);
    const Placed &low = low_placed_.at(low_number), &fine = fine_placed_.at(fine_number);
    const glm::dvec3 low_weights = weights_at(corners_of(low_, low, side_), place);
    const glm::dvec3 fine_weights = weights_at(corners_of(fine_, fine, side_), place);
    const Frame of_fine = frame_at(fine_, fine.triangle, fine_weights);
    glm::dvec3 direction = of_fine.normal;
    if (options_.detail) {
      const glm::dvec2 uv(place.x / side_ + fine.across, 1 - place.y / side_ + fine.up);
      const glm::dvec3 texel = options_.detail(uv);
      direction =
          texel.x * of_fine.tangent + texel.y * of_fine.bitangent + texel.z * of_fine.normal;
    }
    return in_frame(frame_at(low_, low.triangle, low_weights), direction);
  }

  [[nodiscard]] std::int32_t chart(std::int32_t face) const {
    return options_.charts[static_cast<std::size_t>(face)];
  }

  // Blue is at least a half: renderers take nothing that looks inwards.
  void write(std::size_t texel, glm::dvec3 normal) {
    normal.z = std::max(normal.z, 0.0);
    normal = unit_or_zero(normal);
    for (int k = 0; k < 3; ++k)
      map_.pixels[3 * texel + static_cast<std::size_t>(k)] =
          static_cast<std::uint8_t>(std::floor(255 * (0.5 * normal[k] + 0.5) + 0.5));
  }
  [[nodiscard]] glm::dvec3 read(std::size_t texel) const {
    const std::uint8_t* rgb = map_.pixels.data() + 3 * texel;
    return glm::dvec3(rgb[0], rgb[1], rgb[2]) / 127.5 - 1.0;
  }

  // Textures go on at their other side.
  template <class Visit>
  void for_neighbours(std::size_t texel, const Visit& visit) const {
    const auto size = static_cast<std::size_t>(options_.size);
    const std::size_t x = texel % size, y = texel / size;
    for (const std::size_t dy : {size - 1, std::size_t{0}, std::size_t{1}})
      for (const std::size_t dx : {size - 1, std::size_t{0}, std::size_t{1}})
        if (dx != 0 || dy != 0) visit((y + dy) % size * size + (x + dx) % size);
  }

  // One ring around `made` texels, of those that are wanted: each has the mean of those beside it
  // that may be taken. Returns the ring, ascending.
  template <class IsWanted, class MayTake>
  std::vector<std::size_t> add_ring(const std::vector<std::size_t>& made, const IsWanted& is_wanted,
                                    const MayTake& may_take) {
    std::vector<std::size_t> ring;
    for (const std::size_t texel : made)
      for_neighbours(texel, [&](std::size_t other) {
        if (states_[other] != Texel::Made && is_wanted(other) && may_take(other, texel))
          ring.push_back(other);
      });
    std::ranges::sort(ring);
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    std::vector<glm::dvec3> means(ring.size(), glm::dvec3(0.0));
    for (std::size_t i = 0; i < ring.size(); ++i)
      for_neighbours(ring[i], [&](std::size_t other) {
        if (states_[other] == Texel::Made && may_take(ring[i], other)) means[i] += read(other);
      });
    for (std::size_t i = 0; i < ring.size(); ++i) {
      write(ring[i], means[i]);
      states_[ring[i]] = Texel::Made;
    }
    return ring;
  }

  // Texels of the mesh that the fine surface leaves out, as along its border, from their own chart.
  void fill_lacking() {
    std::vector<std::size_t> ring;
    std::int64_t lacking = 0, covered = 0;
    for (std::size_t i = 0; i < states_.size(); ++i) {
      covered += states_[i] != Texel::Empty ? 1 : 0;
      if (states_[i] != Texel::Lacking) continue;
      ++lacking;
      for_neighbours(i, [&](std::size_t other) {
        if (states_[other] == Texel::Made) ring.push_back(other);
      });
    }
    std::ranges::sort(ring);
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    while (!ring.empty())
      ring = add_ring(
          ring, [&](std::size_t texel) { return states_[texel] == Texel::Lacking; },
          [&](std::size_t texel, std::size_t other) { return charts_[texel] == charts_[other]; });
    if (covered > 0) map_.filled = static_cast<double>(lacking) / static_cast<double>(covered);
  }

  void pad() {
    std::vector<std::size_t> ring;
    for (std::size_t i = 0; i < states_.size(); ++i) {
      if (states_[i] != Texel::Made) continue;
      bool is_border = false;
      for_neighbours(i, [&](std::size_t other) { is_border |= states_[other] == Texel::Empty; });
      if (is_border) ring.push_back(i);
    }
    const int rings = std::max(kPadding * options_.size / kPaddingOf, kLeastPadding);
    for (int r = 0; r < rings; ++r)
      ring = add_ring(
          ring, [&](std::size_t texel) { return states_[texel] == Texel::Empty; },
          [](std::size_t, std::size_t) { return true; });
  }

  const BakeSheet &low_, &fine_;
  const BakeOptions& options_;
  int samples_, side_;
  PlacedTriangles low_placed_, fine_placed_;
  NormalMap map_;
  std::vector<Texel> states_;
  std::vector<std::int32_t> charts_;  // of texels; kNone: no chart's
};

// Faces that are joined: the first of them stands for all.
class JoinedFaces {
 public:
  explicit JoinedFaces(std::int32_t count) : first_(static_cast<std::size_t>(count)) {
    std::iota(first_.begin(), first_.end(), 0);
  }
  std::int32_t first_of(std::int32_t face) {
    std::int32_t& up = first_[static_cast<std::size_t>(face)];
    if (up == face) return face;
    while (first_[static_cast<std::size_t>(up)] != up) up = first_[static_cast<std::size_t>(up)];
    return up;
  }
  void join(std::int32_t a, std::int32_t b) {
    const std::int32_t of_a = first_of(a), of_b = first_of(b);
    first_[static_cast<std::size_t>(std::max(of_a, of_b))] = std::min(of_a, of_b);
  }

 private:
  std::vector<std::int32_t> first_;
};

}  // namespace

std::vector<std::int32_t> texture_charts(const PolygonMesh& mesh, std::span<const glm::dvec2> uvs,
                                         const std::function<bool(std::int32_t face)>& is_wanted) {
  struct Edge {
    std::int32_t low, high, face;
    bool is_left;
    auto key() const { return std::tuple(low, high, is_left, face); }
  };
  std::vector<std::int32_t> charts(static_cast<std::size_t>(mesh.face_count()), kNone);
  if (mesh.face_uvs.empty()) return charts;
  std::vector<Edge> edges;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto begin = static_cast<std::size_t>(mesh.face_offsets[f]);
    const std::span face =
        std::span(mesh.face_uvs).subspan(begin, static_cast<std::size_t>(mesh.face_size(f)));
    if (std::ranges::any_of(face, [](std::int32_t uv) { return uv < 0; }) || !is_wanted(f))
      continue;
    charts[static_cast<std::size_t>(f)] = f;
    double area = 0;
    for (std::size_t k = 0; k < face.size(); ++k) {
      const glm::dvec2 &a = uvs[static_cast<std::size_t>(face[k])],
                       &b = uvs[static_cast<std::size_t>(face[(k + 1) % face.size()])];
      area += a.x * b.y - a.y * b.x;
    }
    for (std::size_t k = 0; k < face.size(); ++k) {
      const auto [low, high] = std::minmax(face[k], face[(k + 1) % face.size()]);
      edges.push_back({low, high, f, area > 0});
    }
  }
  oneapi::tbb::parallel_sort(edges, [](const Edge& a, const Edge& b) { return a.key() < b.key(); });
  JoinedFaces joined(mesh.face_count());
  for (std::size_t i = 1; i < edges.size(); ++i)
    if (edges[i].low == edges[i - 1].low && edges[i].high == edges[i - 1].high &&
        edges[i].is_left == edges[i - 1].is_left)
      joined.join(edges[i].face, edges[i - 1].face);
  for (std::int32_t& chart : charts)
    if (chart >= 0) chart = joined.first_of(chart);
  return charts;
}

NormalMap bake_normals(const BakeSheet& low, const BakeSheet& fine, const BakeOptions& options) {
  const HostScope host(options.callbacks);
  options.callbacks.report("bake", 0);
  NormalMap map = Baker(low, fine, options).bake();
  options.callbacks.report("bake", 1);
  return map;
}

}  // namespace planish
