#include "page/page_reader.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

namespace planish::test {
namespace {

std::vector<std::uint8_t> inflated(const std::vector<std::uint8_t>& packed) {
  z_stream stream{};
  if (inflateInit2(&stream, -15) != Z_OK) throw std::runtime_error("no inflate");
  stream.next_in = const_cast<Bytef*>(packed.data());
  stream.avail_in = static_cast<uInt>(packed.size());
  std::vector<std::uint8_t> out;
  std::array<std::uint8_t, 4096> piece{};
  int state = Z_OK;
  while (state == Z_OK) {
    stream.next_out = piece.data();
    stream.avail_out = piece.size();
    state = inflate(&stream, Z_NO_FLUSH);
    out.insert(out.end(), piece.data(), stream.next_out);
  }
  inflateEnd(&stream);
  if (state != Z_STREAM_END) throw std::runtime_error("the stream is broken");
  return out;
}

}  // namespace

std::string between(std::string_view text, std::string_view begin, std::string_view end,
                    std::size_t from) {
  const std::size_t first = text.find(begin, from);
  if (first == std::string_view::npos) return "";
  const std::size_t start = first + begin.size();
  return std::string(text.substr(start, text.find(end, start) - start));
}

std::vector<std::uint8_t> bytes_of_base64(std::string_view text) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<std::uint8_t> bytes;
  std::uint32_t word = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    word = word << 6 | static_cast<std::uint32_t>(kDigits.find(c));
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes.push_back(static_cast<std::uint8_t>(word >> bits));
  }
  return bytes;
}

PageReader::PageReader(nlohmann::json head, std::string_view base64, const std::string& prefix)
    : head_(std::move(head)), bytes_(inflated(bytes_of_base64(base64))) {
  const auto sizes = list("sizes"), corners = list(prefix + "corners");
  Level base;
  base.count = head_[prefix + "base"];
  auto at = corners.begin();
  for (const std::int64_t size : sizes) {
    base.faces.emplace_back(at, at + size);
    at += size;
  }
  levels_.push_back(base);
  for (int l = 0; l < head_["level"]; ++l)
    split(list(prefix + "cuts" + std::to_string(l)), head_["split"] == "triangles");
}

const nlohmann::json& PageReader::section(const std::string& name) const {
  for (const auto& section : head_["sections"]) {
    if (section["name"] == name) return section;
  }
  throw std::runtime_error("no section " + name);
}

std::vector<std::int64_t> PageReader::list(const std::string& name) const {
  const auto& where = section(name);
  const std::size_t count = where["count"], offset = where["offset"];
  std::vector<std::int64_t> values;
  std::int64_t last = 0;
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t code = 0;
    for (std::size_t b = 0; b < 4; ++b)
      code |= std::uint32_t{bytes_[offset + b * count + i]} << (8 * b);
    last += (code & 1) != 0 ? -static_cast<std::int64_t>(code >> 1) - 1 : code >> 1;
    values.push_back(last);
  }
  return values;
}

std::vector<std::int64_t> PageReader::values(const std::string& name) const {
  const auto& where = section(name);
  const std::size_t count = where["count"], width = where["width"];
  const std::size_t components = where["components"], offset = where["offset"];
  const std::int64_t range = std::int64_t{1} << (8 * width);
  std::vector<std::int64_t> values(count * components);
  for (std::size_t c = 0; c < components; ++c) {
    const auto difference = [&](std::size_t i) {
      std::uint32_t code = 0;
      for (std::size_t b = 0; b < width; ++b)
        code |= std::uint32_t{bytes_[offset + (c * width + b) * count + i]} << (8 * b);
      return (code & 1) != 0 ? -static_cast<std::int64_t>(code >> 1) - 1
                             : static_cast<std::int64_t>(code >> 1);
    };
    const bool is_flat = name == "cage" || name == "given";
    const std::size_t base = is_flat ? count : static_cast<std::size_t>(levels_[0].count);
    std::int64_t last = 0;
    for (std::size_t i = 0; i < std::min(base, count); ++i) {
      last = (last + difference(i) + range) % range;
      values[i * components + c] = last;
    }
    std::size_t i = base;
    for (std::size_t l = 1; l < levels_.size(); ++l) {
      for (const auto& parents : levels_[l].parents) {
        if (i >= count) break;
        double sum = 0;
        for (const std::int64_t p : parents)
          sum += static_cast<double>(values[static_cast<std::size_t>(p) * components + c]);
        const auto mean =
            static_cast<std::int64_t>(std::floor(sum / static_cast<double>(parents.size()) + 0.5));
        values[i * components + c] = (mean + difference(i) + range) % range;
        ++i;
      }
    }
  }
  return values;
}

void PageReader::split(std::vector<std::int64_t> cuts, bool triangles) {
  const Level& coarse = levels_.back();
  Level fine;
  std::int64_t next = coarse.count;
  if (!triangles) {
    fine.parents = coarse.faces;
    next += static_cast<std::int64_t>(coarse.faces.size());
  }
  std::map<std::pair<std::int64_t, std::int64_t>, std::int64_t> points;
  std::int64_t corner = 0;
  for (std::size_t f = 0; f < coarse.faces.size(); ++f) {
    const auto& face = coarse.faces[f];
    const std::size_t n = face.size();
    std::vector<std::int64_t> edge;
    for (std::size_t k = 0; k < n; ++k, ++corner) {
      const std::pair<std::int64_t, std::int64_t> key = std::minmax(face[k], face[(k + 1) % n]);
      const bool own = std::ranges::find(cuts, corner) != cuts.end();
      if (own || !points.contains(key)) {
        fine.parents.push_back({face[k], face[(k + 1) % n]});
        points.emplace(key, next);
        edge.push_back(next++);
      } else {
        edge.push_back(points[key]);
      }
    }
    const std::int64_t middle = coarse.count + static_cast<std::int64_t>(f);
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t m = triangles ? 3 : 4, turn = n == m ? k : 0;
      std::vector<std::int64_t> child(m);
      child[turn] = face[k];
      child[(turn + 1) % m] = edge[k];
      if (!triangles) child[(turn + 2) % m] = middle;
      child[(turn + m - 1) % m] = edge[(k + n - 1) % n];
      fine.faces.push_back(child);
    }
    if (triangles) fine.faces.push_back({edge[1], edge[2], edge[0]});
  }
  fine.count = next;
  levels_.push_back(std::move(fine));
}

}  // namespace planish::test
