#include "planish/brep/quad_layout.h"

#include <algorithm>
#include <array>
#include <utility>

namespace planish {
namespace {

std::size_t at(std::int32_t index) { return static_cast<std::size_t>(index); }

// The places of cuts in a side of a rectangle: in equal parts, at lines of the mesh where it can.
std::vector<std::int32_t> cuts_of(std::int32_t length, std::int32_t parts) {
  std::vector<std::int32_t> cuts;
  for (std::int32_t i = 1; i < parts; ++i) {
    const std::int32_t exact = length * i / parts;
    const std::int32_t even = exact / 2 * 2;
    cuts.push_back(length / parts >= 4 && even > 0 ? even : exact);
  }
  return cuts;
}

}  // namespace

std::vector<std::int32_t> QuadLayout::Rectangle::side(int index) const {
  std::vector<std::int32_t> half_edges;
  const std::int32_t length = index % 2 == 0 ? width : height;
  for (std::int32_t i = 0; i < length; ++i) {
    const std::int32_t back = length - 1 - i;
    const Cell& c = index == 0   ? cell(i, 0)
                    : index == 1 ? cell(width - 1, i)
                    : index == 2 ? cell(back, height - 1)
                                 : cell(0, back);
    half_edges.push_back(4 * c.corner + (c.turn + index) % 4);
  }
  return half_edges;
}

QuadLayout::QuadLayout(const SplineSurface& surface, std::int32_t face_size,
                       std::span<const std::int32_t> groups, bool has_corners)
    : surface_(surface), topology_(surface.topology()) {
  marked_.assign(4 * at(topology_.corner_count()), 0);
  extraordinary_.assign(at(vertex_count()), 0);
  seen_.assign(at(vertex_count()), 0);
  find_extraordinary();
  std::vector<std::int32_t> tracks = mark_curves(groups, has_corners);
  for (std::int32_t h = 0; h < 4 * topology_.corner_count(); ++h) {
    if (!is_hidden(h / 4) && is_extraordinary(origin(h))) tracks.push_back(h);
  }
  follow(std::move(tracks));
  fill_all();
  while (cut(face_size)) fill_all();
  find_ends();
}

std::int32_t QuadLayout::vertex_count() const {
  return topology_.vertex_count() + topology_.edge_count() + topology_.face_count();
}

bool QuadLayout::is_hidden(std::int32_t corner) const {
  const auto hidden = surface_.hidden();
  return !hidden.empty() && hidden[at(topology_.face_of(corner))] != 0;
}

std::int32_t QuadLayout::origin(std::int32_t h) const {
  const std::int32_t c = h / 4;
  switch (h & 3) {
    case 0:
      return topology_.vertex_of(c);
    case 1:
      return topology_.vertex_count() + topology_.edge_of(c);
    case 2:
      return topology_.vertex_count() + topology_.edge_count() + topology_.face_of(c);
    default:
      return topology_.vertex_count() + topology_.edge_of(topology_.prev(c));
  }
}

std::int32_t QuadLayout::twin(std::int32_t h) const {
  const std::int32_t c = h / 4;
  const auto across = [&](std::int32_t other, std::int32_t k) {
    return other < 0 || is_hidden(other) ? -1 : 4 * other + k;
  };
  switch (h & 3) {
    case 0:
      return across(topology_.cw(c), 3);
    case 1:
      return 4 * topology_.next(c) + 2;
    case 2:
      return 4 * topology_.prev(c) + 1;
    default:
      return across(topology_.ccw(c), 0);
  }
}

bool QuadLayout::is_sharp(std::int32_t h) const {
  if ((h & 3) == 0) return surface_.is_sharp(h / 4);
  return (h & 3) == 3 && surface_.is_sharp(topology_.prev(h / 4));
}

void QuadLayout::find_extraordinary() {
  for (std::int32_t f = 0; f < topology_.face_count(); ++f) {
    if (topology_.face_size(f) != 4)
      extraordinary_[at(topology_.vertex_count() + topology_.edge_count() + f)] = 1;
  }
  for (std::int32_t v = 0; v < topology_.vertex_count(); ++v) {
    // Visible quads between edges where the surface ends or is sharp.
    bool is_regular = true;
    std::int32_t run = 0, borders = 0, first_run = -1;
    const auto end_run = [&] {
      if (first_run < 0) {
        first_run = run;
      } else {
        is_regular = is_regular && run <= 2;
      }
      run = 0;
      ++borders;
    };
    const auto corners = topology_.corners_at(v);
    bool has_hidden = false;
    for (const std::int32_t c : corners) {
      if (is_hidden(c)) {
        has_hidden = true;
        continue;
      }
      if (twin(4 * c) < 0 || is_sharp(4 * c)) end_run();
      ++run;
      is_regular = is_regular && !surface_.is_singular_at_vertex(c);
    }
    // What is left over belongs to the sector that was begun with.
    if (borders == 0) {
      is_regular = is_regular && !has_hidden && corners.size() == 4;
    } else {
      const bool is_ring = !topology_.is_boundary_vertex(v);
      is_regular = is_regular && !(is_ring && borders == 1 && !has_hidden);
      is_regular = is_regular && run + std::max(first_run, 0) <= 2;
    }
    extraordinary_[at(v)] = is_regular || corners.empty() ? 0 : 1;
  }
  for (std::size_t v = 0; v < seen_.size(); ++v) seen_[v] = extraordinary_[v];
}

void QuadLayout::mark(std::int32_t h) {
  marked_[at(h)] = 1;
  if (const std::int32_t other = twin(h); other >= 0) marked_[at(other)] = 1;
}

std::vector<std::int32_t> QuadLayout::mark_curves(std::span<const std::int32_t> groups,
                                                  bool has_corners) {
  const auto is_border = [&](std::int32_t h) {
    const std::int32_t other = twin(h);
    return other < 0 || is_sharp(h) ||
           (!groups.empty() &&
            groups[at(topology_.face_of(h / 4))] != groups[at(topology_.face_of(other / 4))]);
  };
  for (std::int32_t h = 0; h < 4 * topology_.corner_count(); ++h) {
    if (is_hidden(h / 4) || !is_border(h)) continue;
    mark(h);
    seen_[at(origin(h))] = seen_[at(target(h))] = 1;
  }
  std::vector<std::int32_t> tracks;
  for (std::int32_t c = 0; has_corners && c < topology_.corner_count(); ++c) {
    if (is_hidden(c) || !is_border(4 * c)) continue;
    // More than two quads from here to the next border.
    std::vector<std::int32_t> between;
    for (std::int32_t d = topology_.ccw(c); d >= 0 && d != c && !is_border(4 * d);
         d = topology_.ccw(d))
      between.push_back(4 * d);
    if (between.size() > 1) tracks.insert(tracks.end(), between.begin(), between.end());
  }
  return tracks;
}

// All by one edge in turn, so that meeting tracks have gone about as far.
void QuadLayout::follow(std::vector<std::int32_t> tracks) {
  std::vector<std::int32_t> further;
  while (!tracks.empty()) {
    further.clear();
    for (const std::int32_t h : tracks) {
      mark(h);
      const std::int32_t vertex = target(h);
      if (std::exchange(seen_[at(vertex)], 1) != 0) continue;
      further.push_back(next(twin(next(h))));
    }
    std::swap(tracks, further);
  }
}

// From a place without any track, or along an edge between two that have some.
void QuadLayout::seed(std::int32_t half_edge) {
  std::vector<std::int32_t> tracks{half_edge};
  if (std::exchange(seen_[at(origin(half_edge))], 1) == 0) {
    for (std::int32_t h = twin(previous(half_edge)); h != half_edge; h = twin(previous(h)))
      tracks.push_back(h);
  }
  follow(std::move(tracks));
}

std::vector<std::int32_t> QuadLayout::fill() {
  constexpr std::array<std::array<int, 2>, 4> kSteps{{{0, -1}, {1, 0}, {0, 1}, {-1, 0}}};
  place_.assign(at(topology_.corner_count()), {});
  rectangles_.clear();
  std::vector<std::int32_t> open, region;
  for (std::int32_t first = 0; first < topology_.corner_count(); ++first) {
    if (is_hidden(first) || place_[at(first)].rectangle >= 0) continue;
    const auto number = static_cast<std::int32_t>(rectangles_.size());
    place_[at(first)] = {number, 0, 0, 0};
    region.assign(1, first);
    std::int32_t inside = -1;  // an edge without a mark
    bool is_rectangle = true;
    std::int32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    for (std::size_t i = 0; i < region.size(); ++i) {
      const std::int32_t c = region[i];
      const Place here = place_[at(c)];
      x0 = std::min(x0, here.x), x1 = std::max(x1, here.x);
      y0 = std::min(y0, here.y), y1 = std::max(y1, here.y);
      for (int k = 0; k < 4; ++k) {
        const std::int32_t h = 4 * c + (here.turn + k) % 4;
        if (marked_[at(h)] != 0) continue;
        inside = h;
        const std::int32_t other = twin(h);
        const auto& step = kSteps[k];
        const Place there{number, ((other & 3) - (k + 2) + 8) % 4, here.x + step[0],
                          here.y + step[1]};
        Place& known = place_[at(other / 4)];
        if (known.rectangle < 0) {
          known = there;
          region.push_back(other / 4);
        } else if (known.turn != there.turn || known.x != there.x || known.y != there.y) {
          is_rectangle = false;
        }
      }
    }
    Rectangle made{x1 - x0 + 1, y1 - y0 + 1, {}};
    const auto area = std::int64_t{made.width} * made.height;
    if (!is_rectangle || area != static_cast<std::int64_t>(region.size())) {
      open.push_back(inside);
    } else {
      made.cells.resize(region.size());
      for (const std::int32_t c : region) {
        Place& place = place_[at(c)];
        place.x -= x0;
        place.y -= y0;
        made.cells[at(place.x + made.width * place.y)] = {c, place.turn};
      }
    }
    rectangles_.push_back(std::move(made));
  }
  return open;
}

// Ends since each round marks an edge more in every region that is no rectangle yet.
void QuadLayout::fill_all() {
  for (;;) {
    const std::vector<std::int32_t> open = fill();
    if (open.empty()) return;
    for (const std::int32_t h : open) {
      if (marked_[at(h)] == 0) seed(h);
    }
  }
}

// Also those that meet themselves: programs differ in what they take of such faces.
bool QuadLayout::cut(std::int32_t face_size) {
  bool any = false;
  for (std::size_t r = 0; r < rectangles_.size(); ++r) {
    const Rectangle& whole = rectangles_[r];
    bool meets_itself = false;
    for (int s = 0; s < 4; ++s) {
      for (const std::int32_t h : whole.side(s)) {
        const std::int32_t other = twin(h);
        meets_itself =
            meets_itself || (other >= 0 && rectangle_of(other / 4) == static_cast<std::int32_t>(r));
      }
    }
    const auto parts = [&](std::int32_t length) {
      const std::int32_t wanted = (length + face_size - 1) / face_size;
      return meets_itself ? std::max(wanted, std::min(length, 2)) : wanted;
    };
    for (const std::int32_t x : cuts_of(whole.width, parts(whole.width))) {
      any = true;
      for (std::int32_t y = 0; y < whole.height; ++y) {
        const Cell& c = whole.cell(x, y);
        mark(4 * c.corner + (c.turn + 3) % 4);
      }
    }
    for (const std::int32_t y : cuts_of(whole.height, parts(whole.height))) {
      any = true;
      for (std::int32_t x = 0; x < whole.width; ++x) {
        const Cell& c = whole.cell(x, y);
        mark(4 * c.corner + c.turn);
      }
    }
  }
  return any;
}

void QuadLayout::find_ends() {
  std::vector<std::int32_t> tracks(at(vertex_count()), 0);
  for (std::int32_t h = 0; h < 4 * topology_.corner_count(); ++h) {
    if (marked_[at(h)] == 0 || is_hidden(h / 4)) continue;
    ++tracks[at(origin(h))];
    if (twin(h) < 0) ++tracks[at(target(h))];
  }
  ends_.resize(tracks.size());
  for (std::size_t v = 0; v < tracks.size(); ++v) ends_[v] = tracks[v] > 0 && tracks[v] != 2;
  for (const Rectangle& rectangle : rectangles_) {
    for (int s = 0; s < 4; ++s) ends_[at(origin(rectangle.side(s).front()))] = 1;
  }
}

}  // namespace planish
