// Surfaces by corner patches in single precision on a device, against the same in double.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>
#include <iostream>
#include <numbers>
#include <optional>

#include "planish/mesh/polygon_mesh.h"
#include "planish/patches/doo_sabin_step.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "planish/vulkan/backend/vulkan_machine.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/evaluate/gpu_patches.h"
#include "planish/vulkan/evaluate/patch_tables.h"
#include "planish/vulkan/host/system.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/device_cases.h"
#include "vulkan/embedding_fixture.h"

namespace planish::testing {
namespace {

using namespace vulkan;

using VulkanPatches = VulkanTest;

/// Largest differences, positions in parts of the diagonal, normals in radians.
struct Off {
  double position = 0, normal = 0, rms_normal = 0;
};

Off off_by(const SurfaceMesh& a, const SurfaceMesh& b, double diagonal) {
  Off result;
  if (a.positions.size() != b.positions.size() || a.face_vertices != b.face_vertices)
    return {HUGE_VAL, HUGE_VAL};
  const auto grow = [](double& largest, double value) {
    if (!(value <= largest)) largest = value;
  };
  for (std::size_t i = 0; i < a.positions.size(); ++i) {
    grow(result.position, glm::distance(a.positions[i], b.positions[i]) / diagonal);
    grow(result.normal, glm::distance(a.normals[i], b.normals[i]));
  }
  return result;
}

/// Every kind of patch: valences 3 to 8, faces of 3 to 9 corners, boundaries, creases, darts,
/// corners of all sectors, tagged vertices, holes.
std::vector<test::NamedMesh> meshes_of_all_kinds() {
  std::vector<test::NamedMesh> meshes = {{"cube", test::cube()},
                                         {"icosphere", test::icosphere(2)},
                                         {"torus", test::torus(12, 7, 2, 0.7)}};
  const std::vector<test::NamedMesh> kinds = random_kinds();
  meshes.insert(meshes.end(), kinds.begin(), kinds.end());
  const std::vector<test::NamedMesh> rings = large_rings();
  meshes.insert(meshes.end(), rings.begin(), rings.end());
  return meshes;
}

TEST_F(VulkanPatches, SurfacesAreTheCpus) {
  const auto cpu = make_cpu_backend();
  for (const VulkanReads reads : {VulkanReads::TexelBuffers, VulkanReads::StorageBuffers}) {
    const auto vulkan = make_backend({.reads = reads});
    for (const test::NamedMesh& mesh : meshes_of_all_kinds())
      for (const Weights weights : {Weights::DooSabin, Weights::Averaged})
        for (int level = 0; level < 5; ++level) {
          const EvaluateOptions options{.level = level, .weights = weights};
          const Off found =
              off_by(evaluate(mesh.mesh, *vulkan, options), evaluate(mesh.mesh, *cpu, options),
                     placement_of(mesh.mesh).diagonal);
          EXPECT_LT(found.position, 1e-7) << mesh.name << " " << level;
          EXPECT_LT(found.normal, 2e-5) << mesh.name << " " << level;
        }
  }
}

TEST_F(VulkanPatches, SlicesChangeNothing) {
  // Kernels of software take 16 chunks a work group, those of hardware one.
  for (const auto& [reads, groups] :
       {std::pair{VulkanReads::TexelBuffers, 4u}, std::pair{VulkanReads::StorageBuffers, 16u}}) {
    const auto whole = make_backend({.reads = reads}),
               by_groups = make_backend({.max_work_groups = groups, .reads = reads}),
               by_range = make_backend({.max_storage_bytes = 1 << 16, .reads = reads});
    for (const test::NamedMesh& mesh : meshes_of_all_kinds())
      for (const int level : {0, 2, 3}) {
        const SurfaceMesh expected = evaluate(mesh.mesh, *whole, {.level = level});
        for (Backend* low : {by_range.get(), by_groups.get()}) {
          const SurfaceMesh sliced = evaluate(mesh.mesh, *low, {.level = level});
          EXPECT_EQ(sliced.positions, expected.positions) << mesh.name << " " << level;
          EXPECT_EQ(sliced.normals, expected.normals) << mesh.name << " " << level;
        }
      }
  }
}

TEST_F(VulkanPatches, BothSidesOfACutLieAtOnePlace) {
  const PolygonMesh mesh = test::with_random_creases(test::random_closed_mesh(2), 0.3, 2);
  const SurfaceMesh surface = evaluate(mesh, *make_backend(), {.level = 3});
  const System system(mesh, {.level = 3});
  const auto copied = system.copied_vertices();
  ASSERT_EQ(copied.size(), surface.positions.size());
  int copies = 0;
  for (std::size_t i = 0; i < copied.size(); ++i) {
    if (static_cast<std::size_t>(copied[i]) == i) continue;
    ++copies;
    EXPECT_EQ(surface.positions[i], surface.positions[copied[i]]) << i;
  }
  EXPECT_GT(copies, 20);
}

class EmbedPatches : public Embedding {
 protected:
  /// One frame of a System against the CPU's surface of the same points, in units of the model.
  Off frame_against_cpu(const PolygonMesh& mesh, const SystemOptions& options) {
    const HostTopology topology = topology_of(mesh, options);
    HostFrame frame = frame_of(topology);
    const std::vector<Vertex> found = run(frame, mesh, iterations(60)),
                              expected = surface_by_cpu(mesh, mesh, options);
    if (found.size() != expected.size()) return {HUGE_VAL, HUGE_VAL};
    Off result;
    for (std::size_t i = 0; i < found.size(); ++i) {
      result.position =
          std::max<double>(result.position, glm::distance(found[i].position, expected[i].position));
      if (found[i].normal == glm::vec3(0.0f)) continue;  // the CPU has a facet's
      const double off = glm::distance(found[i].normal, expected[i].normal);
      result.normal = std::max(result.normal, off);
      result.rms_normal += off * off / double(found.size());
    }
    result.rms_normal = std::sqrt(result.rms_normal);
    return result;
  }
};

TEST_F(EmbedPatches, AllLevelsAndWeights) {
  const PolygonMesh mesh = test::with_random_creases(test::random_open_mesh(5), 0.15, 6);
  for (const Weights weights : {Weights::DooSabin, Weights::Averaged})
    for (int level = 0; level < 6; ++level) {
      const Off found = frame_against_cpu(mesh, {.level = level, .weights = weights});
      EXPECT_LT(found.position, 4e-6) << level;
      // Where derivatives are nearly parallel their last bits, which are the device's, turn it
      // more.
      EXPECT_LT(found.normal, 2e-4) << level;
      EXPECT_LT(found.rms_normal, 1e-6) << level;
    }
}

// By the sums of large rings, and by points where weights are averaged.
TEST_F(EmbedPatches, LargeRings) {
  const auto expect_near = [&](const test::NamedMesh& named, double normal) {
    for (const Weights weights : {Weights::DooSabin, Weights::Averaged})
      for (const int level : {0, 2, 3}) {
        const Off found = frame_against_cpu(named.mesh, {.level = level, .weights = weights});
        EXPECT_LT(found.position, 2e-7) << named.name << " " << level;
        EXPECT_LT(found.normal, normal) << named.name << " " << level;
      }
  };
  for (const test::NamedMesh& named : large_rings()) expect_near(named, 2e-5);
  // Wedges of 33 corners at a hub: patches at their rims are 100 times as long as wide.
  expect_near({"ring and faces", hub_of(36, 33, 2 * std::numbers::pi)}, 1e-3);
  expect_near({"hub of 1,000", hub_of(1000, 3, 2 * std::numbers::pi)}, 5e-5);
}

TEST_F(EmbedPatches, APatchByLargeRingsHasFewColumns) {
  for (const test::NamedMesh& named : large_rings()) {
    const System system(named.mesh);
    const PatchRecords records =
        patch_records(system.surface_records().patches, patch_limits(*context_, 24));
    for (const shared::PatchGroup& group : records.groups)
      EXPECT_LE(group.columns, 14u) << named.name;
  }
}

TEST_F(EmbedPatches, NormalsKeepTheirDigitsFarFromTheOrigin) {
  PolygonMesh mesh = test::icosphere(4);
  for (glm::dvec3& p : mesh.positions) p += glm::dvec3(10, -20, 30);
  mesh.positions = through_floats(mesh.positions);
  const HostTopology topology = topology_of(mesh);
  HostFrame frame = frame_of(topology);
  // Of the given points as a cage, so that no solve blurs what is compared.
  const std::vector<Vertex> found = run(frame, mesh, iterations(0));
  const SurfaceMesh expected = evaluate(mesh, *make_cpu_backend(), {.level = 2});
  ASSERT_EQ(found.size(), expected.positions.size());
  double position = 0, normal = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    position =
        std::max(position, glm::distance(glm::dvec3(found[i].position), expected.positions[i]));
    normal = std::max<double>(normal, glm::distance(found[i].normal, expected.normals[i]));
  }
  EXPECT_LT(position, 4e-6);  // rounded once
  // Edges are 0.07 long: points of level 1 rounded to 2e-6 would turn normals by 1e-4.
  EXPECT_LT(normal, 2e-6);
}

TEST_F(EmbedPatches, FirstStepsAreTheCpus) {
  std::vector<test::NamedMesh> meshes = meshes_of_all_kinds();
  meshes.push_back({"faces of 1,000", hub_of(3, 1000, 2 * std::numbers::pi)});
  for (const Weights weights : {Weights::DooSabin, Weights::Averaged})
    for (const test::NamedMesh& named : meshes) {
      PolygonMesh mesh = named.mesh;
      mesh.hole_faces.clear();
      const Placement placement = placement_of(mesh);
      for (glm::dvec3& p : mesh.positions) p = placement.to_unit(p) + glm::dvec3(30);
      mesh.positions = through_floats(mesh.positions);
      const System system(mesh, {.weights = weights});
      const SurfaceRecords& surface = system.surface_records();
      VulkanMachine machine(device_options(), {});
      const PatchLimits limits = patch_limits(machine.context, 24);
      PatchRecords patches = patch_records(surface.patches, limits);
      add_rings(surface.patch_mesh, patches);
      const StepRecords step =
          step_records(surface.patch_mesh, surface.weights, surface.sharp_rows->view());
      const PatchTables patch_tables(machine.context, patches, surface.patch_mesh.point_count());
      const StepTables step_tables(machine.context, step);
      const auto upload = [&](const Buffer& buffer, std::span<const std::byte> bytes) {
        machine.submitter.upload({buffer.handle(), 0, bytes.size()}, bytes);
      };
      patch_tables.for_each(patches, upload);
      step_tables.for_each(step, upload);
      const std::vector<glm::dvec3> moved = through_floats(random_points(mesh.vertex_count()));
      const auto uploaded = [&](const std::vector<glm::dvec3>& points) {
        Buffer buffer(machine.context, points.size() * sizeof(glm::vec4), MemoryUse::Device);
        machine.upload_points(buffer, points);
        return buffer;
      };
      const Buffer given_buffer = uploaded(mesh.positions), moved_buffer = uploaded(moved);
      const GpuFirstStep gpu(machine.context, patch_tables, step_tables, given_buffer,
                             moved_buffer);
      std::optional<GpuRingSums> sums;
      if (surface.patch_mesh.has_sums())
        sums.emplace(machine.context, patch_tables, given_buffer, gpu.state());
      machine.submitter.run([&](VkCommandBuffer commands) {
        gpu.record(commands);
        if (!sums) return;
        const Wait wait = sums->record(commands);
        record_barrier(machine.context, commands, wait.from, wait.to);
      });
      const std::vector<glm::dvec3> found = machine.download_points(
          gpu.state(), static_cast<std::size_t>(surface.patch_mesh.point_count()));

      std::vector<glm::dvec3> cage = mesh.positions;
      for (std::size_t v = 0; v < moved.size(); ++v) cage[v] += moved[v];
      const auto expected = first_step(surface.patch_mesh, surface.weights, cage);
      const std::vector<std::int32_t> owners = state_owners(surface.patch_mesh);
      double largest = 0;
      for (std::size_t i = 0; i < found.size(); ++i)
        largest =
            std::max(largest, glm::distance(found[i], expected[i] - mesh.positions[owners[i]]));
      // Points are 30 from the origin, of which single precision keeps 2e-6.
      EXPECT_LT(largest, 2e-7) << named.name;
    }
}

TEST_F(EmbedPatches, TablesAreSmall) {
  for (const PolygonMesh& mesh : {test::torus(259, 25, 2, 0.7), test::icosphere(5)}) {
    const System system(mesh);
    const DeviceSystem device(*context_, system);
    const double share = 6475.0 / double(mesh.positions.size());
    EXPECT_LT(double(device.device_bytes()) * share, 1.5e6) << mesh.positions.size();
    std::cout << "  " << mesh.positions.size() << " points, level 2: " << device.device_bytes()
              << " bytes\n";
  }
}

}  // namespace
}  // namespace planish::testing
