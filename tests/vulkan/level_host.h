#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "planish/vulkan/device/commands.h"
#include "vulkan/embedding_fixture.h"

namespace planish::testing {

/// Words of a buffer, as a host gets them.
[[nodiscard]] inline std::vector<std::uint32_t> words_of(vulkan::Buffer& buffer) {
  buffer.invalidate();
  std::vector<std::uint32_t> words(buffer.mapped().size() / sizeof(std::uint32_t));
  std::memcpy(words.data(), buffer.mapped().data(), words.size() * sizeof words[0]);
  return words;
}

/// The sphere around a box of points, in double.
struct Sphere {
  glm::dvec3 centre{0.0};
  double radius = 0;
};
[[nodiscard]] inline Sphere sphere_around(const std::vector<glm::dvec3>& points) {
  glm::dvec3 low = points.at(0), high = low;
  for (const glm::dvec3& p : points) low = glm::min(low, p), high = glm::max(high, p);
  Sphere sphere{0.5 * (low + high)};
  for (const glm::dvec3& p : points)
    sphere.radius = std::max(sphere.radius, glm::distance(p, sphere.centre));
  return sphere;
}

/// A camera at the origin that looks along -z, 60 degrees high and wide, in Vulkan's clip space.
[[nodiscard]] inline glm::mat4 perspective(float near, float far) {
  const float f = std::sqrt(3.0f);
  glm::mat4 clip(0.0f);
  clip[0][0] = f;
  clip[1][1] = -f;
  clip[2][2] = far / (near - far);
  clip[2][3] = -1;
  clip[3][2] = near * far / (near - far);
  return clip;
}

/// A view of instances, with a host's picture in mind.
[[nodiscard]] inline vulkan::TessellateParameters view_of(const glm::mat4& clip,
                                                          float chord_pixels = 0.5f) {
  vulkan::TessellateParameters view;
  std::memcpy(view.clip_from_world.data(), &clip, sizeof clip);
  view.viewport_height = 720;
  view.chord_pixels = chord_pixels;
  return view;
}

/// Instances of a mesh, each at a place of its own in a pose of its own, with a Tessellation.
struct LevelHost {
  using Place = std::function<glm::dvec3(std::uint32_t)>;

  LevelHost(vulkan::Context& on, vulkan::Submitter& with, const PolygonMesh& mesh,
            const vulkan::SystemOptions& options, const std::vector<glm::dvec3>& places,
            std::vector<std::uint32_t> room = {}, vulkan::VertexLayout layout = {})
      : context(on),
        submitter(with),
        rest(mesh),
        offsets(places),
        count(static_cast<std::uint32_t>(places.size())),
        level_numbers(options.levels),
        system(mesh, options),
        tables(on, system, {.max_vertex_stride = 64}),
        points(on, count * mesh.positions.size() * sizeof(glm::vec3), vulkan::MemoryUse::Upload),
        output(on, vertex_total(tables, count, room) * layout.stride, vulkan::MemoryUse::Download),
        solve(on, tables, {.given = {points.handle()}, .instances = count}) {
    layout.buffer = output.handle();
    levels.emplace(on, tables, solve,
                   vulkan::TessellationOptions{.vertices = layout, .places = std::move(room)});
    vulkan::Buffer staging(on, tables.upload_bytes(), vulkan::MemoryUse::Upload);
    tables.write_upload(system, staging.mapped().first(tables.upload_bytes()));
    staging.flush();
    submitter.run(
        [&](VkCommandBuffer commands) { tables.record_upload(commands, staging.handle(), 0); });
    for (std::uint32_t i = 0; i < count; ++i) {
      const PolygonMesh pose = pose_of(i);
      const std::vector<glm::vec3> rounded(pose.positions.begin(), pose.positions.end());
      const std::size_t bytes = rounded.size() * sizeof rounded[0];
      std::memcpy(points.mapped().data() + i * bytes, rounded.data(), bytes);
    }
    points.flush();
    submitter.run([&](VkCommandBuffer commands) {
      levels->record_reset(commands);
      solve.record_solve(commands, iterations(20));
      solve.record_surface(commands);
    });
  }

  static std::uint64_t vertex_total(const vulkan::DeviceSystem& tables, std::uint32_t instances,
                                    const std::vector<std::uint32_t>& room) {
    const std::vector<std::int32_t> counts = tables.level_vertex_counts();
    std::uint64_t total = 0;
    for (std::size_t k = 0; k < counts.size(); ++k)
      total +=
          std::uint64_t(room.empty() ? instances : room[k]) * static_cast<std::uint64_t>(counts[k]);
    return total;
  }

  [[nodiscard]] PolygonMesh pose_of(std::uint32_t instance) const {
    PolygonMesh pose = posed(rest, static_cast<int>(instance));
    for (glm::dvec3& p : pose.positions) p = glm::dvec3(glm::vec3(p + offsets[instance]));
    return pose;
  }

  /// Draws a view; returns each instance's level.
  std::vector<std::uint32_t> draw(const vulkan::TessellateParameters& view) {
    vulkan::Buffer report(context, count * sizeof(std::uint32_t), vulkan::MemoryUse::Download);
    submitter.run([&](VkCommandBuffer commands) {
      levels->record_evaluate(commands, view);
      levels->record_levels(commands, report.handle(), 0);
    });
    std::vector<std::uint32_t> words = words_of(report);
    words.resize(count);
    return words;
  }

  /// A buffer of planish's own.
  std::vector<std::uint32_t> fetch(VkBuffer from, VkDeviceSize offset, VkDeviceSize bytes) {
    vulkan::Buffer copy(context, bytes, vulkan::MemoryUse::Download);
    submitter.run([&](VkCommandBuffer commands) {
      vulkan::record_barrier(context, commands, vulkan::kExitScope, vulkan::kEntryScope);
      const VkBufferCopy region{offset, 0, bytes};
      context.vk().vkCmdCopyBuffer(commands, from, copy.handle(), 1, &region);
    });
    std::vector<std::uint32_t> words = words_of(copy);
    words.resize(bytes / sizeof(std::uint32_t));
    return words;
  }
  std::vector<VkDrawIndexedIndirectCommand> draws() {
    const VkDeviceSize bytes = count * sizeof(VkDrawIndexedIndirectCommand);
    const std::vector<std::uint32_t> words = fetch(levels->draws(), 0, bytes);
    std::vector<VkDrawIndexedIndirectCommand> result(count);
    std::memcpy(result.data(), words.data(), bytes);
    return result;
  }
  /// Control points of an instance.
  std::vector<glm::dvec3> control_points(std::uint32_t instance) {
    const std::size_t rows = system.used_vertices().size();
    const std::vector<std::uint32_t> words = fetch(
        solve.control_points(), instance * solve.control_point_stride(), rows * 4 * sizeof(float));
    std::vector<glm::dvec3> result;
    for (std::size_t i = 0; i < rows; ++i) {
      std::array<float, 3> p{};
      std::memcpy(p.data(), &words[4 * i], sizeof p);
      result.emplace_back(p[0], p[1], p[2]);
    }
    return result;
  }

  vulkan::Context& context;
  vulkan::Submitter& submitter;
  PolygonMesh rest;
  std::vector<glm::dvec3> offsets;
  std::uint32_t count;
  std::vector<int> level_numbers;
  vulkan::System system;
  vulkan::DeviceSystem tables;
  vulkan::Buffer points, output;
  vulkan::Solve solve;
  std::optional<vulkan::Tessellation> levels;
};

/// What a view should choose, in double and without a device: the rule of host/tessellation.h.
class LevelChoice {
 public:
  static constexpr std::uint32_t kNotSeen = vulkan::Tessellation::kNotSeen;

  /// `ratios`: chord errors for a sphere of radius 1.
  LevelChoice(const vulkan::TessellateParameters& view, std::vector<double> ratios)
      : view_(view), ratios_(std::move(ratios)) {}

  [[nodiscard]] std::uint32_t level(const Sphere& sphere, std::uint32_t last = kNotSeen) {
    glm::dvec4 rows[4];
    for (int r = 0; r < 4; ++r)
      for (int c = 0; c < 4; ++c) rows[r][c] = view_.clip_from_world[4 * c + r];
    const glm::dvec4 planes[] = {rows[3] + rows[0], rows[3] - rows[0], rows[3] + rows[1],
                                 rows[3] - rows[1], rows[2],           rows[3] - rows[2]};
    for (const glm::dvec4& plane : planes) {
      const double length = glm::length(glm::dvec3(plane));
      if (length == 0) continue;
      const double distance = (glm::dot(glm::dvec3(plane), sphere.centre) + plane.w) / length;
      note(distance, -sphere.radius, sphere.radius);
      if (distance < -sphere.radius) return kNotSeen;
    }
    const double depth = glm::dot(glm::dvec3(rows[3]), sphere.centre) + rows[3].w -
                         sphere.radius * glm::length(glm::dvec3(rows[3]));
    const auto pixels = [&](std::size_t k) {
      return depth > 0 ? sphere.radius * ratios_[k] * glm::length(glm::dvec3(rows[1])) * 0.5 *
                             view_.viewport_height / depth
                       : 1e30;
    };
    const auto first_within = [&](double limit) {
      std::uint32_t k = 0;
      while (k + 1 < ratios_.size()) {
        note(pixels(k), limit, limit);
        if (pixels(k) <= limit) break;
        ++k;
      }
      return k;
    };
    const std::uint32_t needed = first_within(view_.chord_pixels);
    if (last >= ratios_.size() || needed >= last) return needed;
    return std::min(last, first_within(view_.chord_pixels * view_.coarser_at));
  }
  /// How near any comparison was to its limit, of the limit's size.
  [[nodiscard]] double closest_call() const { return closest_; }

 private:
  void note(double value, double limit, double scale) {
    if (scale > 0) closest_ = std::min(closest_, std::abs(value - limit) / scale);
  }

  vulkan::TessellateParameters view_;
  std::vector<double> ratios_;
  double closest_ = 1e30;
};

}  // namespace planish::testing
