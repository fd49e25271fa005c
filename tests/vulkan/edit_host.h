#pragma once

#include <cstdint>
#include <cstring>
#include <glm/vec3.hpp>
#include <vector>

#include "vulkan/embedding_fixture.h"

namespace planish::testing {

inline constexpr std::uint32_t kMostMoves = 4096;

/// A host that edits: everything is mapped.
struct EditHost {
  EditHost(vulkan::Context& on, vulkan::Submitter& with, const PolygonMesh& mesh,
           const vulkan::SystemOptions& options = {}, std::uint32_t instance_count = 1)
      : context(on),
        submitter(with),
        instances(instance_count),
        system(mesh, options),
        tables(on, system, {.takes_edits = true}),
        points(on, instances * mesh.positions.size() * sizeof(glm::vec3),
               vulkan::MemoryUse::Upload),
        output(on, std::uint64_t(instances) * system.vertex_count() * sizeof(Vertex),
               vulkan::MemoryUse::Download),
        report(on, instances * sizeof(vulkan::GpuStatus) + sizeof(vulkan::EditReach),
               vulkan::MemoryUse::Download),
        moves(on, (1 + kMostMoves) * sizeof(std::uint32_t), vulkan::MemoryUse::Upload),
        solve(on, tables,
              {.given = {points.handle()},
               .vertices = {output.handle()},
               .instances = instances,
               .moved = {moves.handle(), 0, kMostMoves}}) {
    vulkan::Buffer staging(on, tables.upload_bytes(), vulkan::MemoryUse::Upload);
    tables.write_upload(system, staging.mapped().first(tables.upload_bytes()));
    staging.flush();
    submitter.run(
        [&](VkCommandBuffer commands) { tables.record_upload(commands, staging.handle(), 0); });
    stop_error = static_cast<float>(system.tolerance() / 8);
    for (std::uint32_t i = 0; i < instances; ++i)
      for (std::size_t v = 0; v < mesh.positions.size(); ++v)
        set_point(static_cast<std::int32_t>(v), glm::vec3(mesh.positions[v]), i);
    solve_all(false);
  }

  void set_point(std::int32_t vertex, const glm::vec3& to, std::uint32_t instance = 0) {
    const std::size_t place = instance * static_cast<std::size_t>(tables.given_count()) +
                              static_cast<std::size_t>(vertex);
    std::memcpy(points.mapped().data() + place * sizeof to, &to, sizeof to);
    points.flush();
  }
  void list(const std::vector<std::uint32_t>& words, std::uint32_t count) {
    std::memcpy(moves.mapped().data(), &count, sizeof count);
    std::memcpy(moves.mapped().data() + sizeof count, words.data(), words.size() * sizeof words[0]);
    moves.flush();
  }
  void solve_all(bool warm) {
    vulkan::SolveParameters parameters = iterations(60);
    parameters.stop_error = stop_error;
    parameters.warm_start = warm;
    submitter.run([&](VkCommandBuffer commands) {
      solve.record_solve(commands, parameters);
      solve.record_evaluate(commands);
      solve.record_status(commands, report.handle(), 0);
    });
  }
  vulkan::EditReach edit(const vulkan::EditParameters& parameters) {
    submitter.run([&](VkCommandBuffer commands) { record(commands, parameters); });
    return reach();
  }
  vulkan::EditReach edit() { return edit({.iterations = 40, .stop_error = stop_error}); }
  void record(VkCommandBuffer commands, const vulkan::EditParameters& parameters) const {
    solve.record_edit(commands, parameters);
    solve.record_status(commands, report.handle(), 0);
    solve.record_reach(commands, report.handle(), instances * sizeof(vulkan::GpuStatus));
  }
  template <class T>
  T report_at(std::size_t offset) {
    report.invalidate();
    T result;
    std::memcpy(&result, report.mapped().data() + offset, sizeof result);
    return result;
  }
  vulkan::GpuStatus status(std::uint32_t i = 0) {
    return report_at<vulkan::GpuStatus>(i * sizeof(vulkan::GpuStatus));
  }
  vulkan::EditReach reach() {
    return report_at<vulkan::EditReach>(instances * sizeof(vulkan::GpuStatus));
  }
  std::vector<Vertex> vertices(std::uint32_t instance = 0) {
    output.invalidate();
    std::vector<Vertex> result(static_cast<std::size_t>(system.vertex_count()));
    std::memcpy(result.data(), output.mapped().data() + instance * result.size() * sizeof(Vertex),
                result.size() * sizeof(Vertex));
    return result;
  }
  // All rows made anew from what edits left.
  std::vector<Vertex> evaluated() {
    submitter.run([&](VkCommandBuffer commands) { solve.record_evaluate(commands); });
    return vertices();
  }

  vulkan::Context& context;
  vulkan::Submitter& submitter;
  std::uint32_t instances;
  vulkan::System system;
  vulkan::DeviceSystem tables;
  vulkan::Buffer points, output, report, moves;
  vulkan::Solve solve;
  float stop_error = 0;
};

}  // namespace planish::testing
