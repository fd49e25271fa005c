#include "planish/patches/facet_normals.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <vector>

#include "planish/core/work.h"
#include "planish/mesh/area_vector.h"

namespace planish {

using Part = PatchNumbering::Part;

// A row's sample as all the corners on its side of a cut see it.
std::vector<FacetNormals::Sample> FacetNormals::samples_of(const PatchTile& tile,
                                                           std::int64_t row) const {
  const MeshTopology& topology = mesh_.topology();
  const std::int32_t n = numbering_.samples().side();
  std::vector<Sample> samples;
  const std::int64_t offset = row - tile.first_row;
  const auto add_edge_side = [&](std::int32_t corner) {
    samples.push_back({corner, n, 0});
    samples.push_back({topology.next(corner), 0, n});
  };
  const auto add_edge = [&](std::int32_t corner) {
    add_edge_side(corner);
    if (!mesh_.is_sharp(corner)) add_edge_side(topology.twin(corner));
  };
  const auto add_sector = [&](std::int32_t start) {
    const bool cut = mesh_.vertex_point(start).patch.has_sharp_edges();
    std::int32_t c = start;
    do {
      samples.push_back({c, 0, 0});
      c = topology.ccw(c);
    } while (c >= 0 && c != start && !(cut && mesh_.is_sharp(c)));
  };
  const auto item = tile.first_item + offset;
  switch (tile.part) {
    case Part::Vertices:
      add_sector(numbering_.item_corner(tile.part, item));
      break;
    case Part::Faces: {
      const std::int32_t face = topology.face_of(numbering_.item_corner(tile.part, item));
      for (std::int32_t i = 0; i < topology.face_size(face); ++i) {
        samples.push_back({topology.first_corner(face) + i, n, n});
      }
      break;
    }
    case Part::Edges:
      add_edge(numbering_.item_corner(tile.part, item));
      break;
    case Part::Further: {
      const std::int32_t corner = numbering_.item_corner(tile.part, item);
      if (numbering_.is_further_edge(item)) {
        add_edge_side(corner);
      } else {
        add_sector(corner);
      }
      break;
    }
    case Part::Trailing: {
      const std::int32_t count = numbering_.samples().trailing_count();
      const std::int32_t corner =
          numbering_.item_corner(tile.part, tile.first_item + offset / count);
      samples.push_back({corner, 0, static_cast<std::int32_t>(offset % count) + 1});
      break;
    }
    case Part::Corners: {
      const std::int32_t corner = numbering_.corner_of_row(row);
      const auto [a, b] = numbering_.samples().place(
          static_cast<std::int32_t>(row - numbering_.corner_row(corner)));
      samples.push_back({corner, a, b});
      if (b == 0 && !mesh_.is_sharp(corner)) samples.push_back({topology.cw(corner), 0, a});
      if (b > 0 && a == n) samples.push_back({topology.next(corner), b, n});
      break;
    }
  }
  return samples;
}

glm::dvec3 FacetNormals::point(const PatchPlace& place, std::int32_t sample) const {
  const auto columns = static_cast<std::size_t>(place.patch.column_count());
  count_work(Work::Products, static_cast<std::int64_t>(columns));
  std::vector<std::int32_t> indices(columns);
  mesh_.gather(place, indices.data(), 1);
  const auto at = [&](std::size_t k) {
    const double* p = state_ + 3 * static_cast<std::ptrdiff_t>(indices[k]);
    return glm::dvec3(p[0], p[1], p[2]);
  };
  const auto weights = classes_.weights(classes_.index_of(place.patch)).rows(sample);
  glm::dvec3 sum(0.0);
  for (std::size_t k = 1; k < columns; ++k) sum += weights[k - 1] * (at(k) - at(0));
  return placement_.to_model(sum + at(0));
}

glm::dvec3 FacetNormals::cells_around(const Sample& sample) const {
  const PatchSamples& samples = numbering_.samples();
  const PatchPlace place = mesh_.corner_patch(sample.corner);
  glm::dvec3 sum(0.0);
  for (std::int32_t b = sample.b - 1; b <= sample.b; ++b) {
    for (std::int32_t a = sample.a - 1; a <= sample.a; ++a) {
      if (a < 0 || b < 0 || a >= samples.side() || b >= samples.side()) continue;
      const std::array<glm::dvec3, 4> cell = {
          point(place, samples.index(a, b)), point(place, samples.index(a + 1, b)),
          point(place, samples.index(a + 1, b + 1)), point(place, samples.index(a, b + 1))};
      sum += area_vector(cell, std::array<std::int32_t, 4>{0, 1, 2, 3});
    }
  }
  return sum;
}

glm::dvec3 FacetNormals::polygon(std::int32_t face) const {
  const MeshTopology& topology = mesh_.topology();
  std::vector<glm::dvec3> points;
  std::vector<std::int32_t> order;
  for (std::int32_t i = 0; i < topology.face_size(face); ++i) {
    const std::int32_t vertex = topology.vertex_of(topology.first_corner(face) + i);
    std::vector<std::int32_t> starts;
    mesh_.sector_starts(vertex, starts);
    points.push_back(point(mesh_.vertex_point(starts.front()), 0));
    order.push_back(i);
  }
  return area_vector(points, order);
}

glm::vec3 FacetNormals::at(const PatchTile& tile, std::int64_t row) const {
  std::vector<Sample> samples = samples_of(tile, row);
  std::sort(samples.begin(), samples.end(),
            [](const Sample& x, const Sample& y) { return x.corner < y.corner; });
  glm::dvec3 sum(0.0);
  for (const Sample& sample : samples) {
    sum += numbering_.level() == 0 ? polygon(mesh_.topology().face_of(sample.corner))
                                   : cells_around(sample);
  }
  const double length = glm::length(sum);
  return length > 0 ? glm::vec3(sum / length) : glm::vec3(0.0f, 0.0f, 1.0f);
}

}  // namespace planish
