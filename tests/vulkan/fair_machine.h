#pragma once

#include <cstring>
#include <glm/vec4.hpp>
#include <initializer_list>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "fair/fair_case.h"
#include "planish/vulkan/backend/vulkan_machine.h"
#include "planish/vulkan/fair/gpu_fair.h"
#include "support/random_meshes.h"
#include "vulkan/device_cases.h"
#include "vulkan/fixture.h"

namespace planish::testing {

/// Those of the fair method, and some whose vertices, corners, edges or faces fill work groups
/// nearly, just, and just not.
[[nodiscard]] inline std::vector<test::NamedMesh> device_meshes() {
  std::vector<test::NamedMesh> meshes = test::fair_meshes();
  meshes.push_back({"narrow quads", test::torus(12, 48, 1, 0.4)});
  for (const int n : {63, 64, 65}) {
    meshes.push_back({"vertices " + std::to_string(n), test::bipyramid(n - 2)});
    meshes.push_back({"faces " + std::to_string(n), test::prism(n - 2)});
    meshes.push_back({"corners " + std::to_string(n), test::single_polygon(n)});
  }
  for (test::NamedMesh& mesh : large_rings()) meshes.push_back(std::move(mesh));
  return meshes;
}

/// A device with validation on, and nets built on it step by step.
class FairMachine : public VulkanTest {
 protected:
  void SetUp() override {
    VulkanTest::SetUp();
    if (!IsSkipped() && !HasFatalFailure()) make_machine(context_options());
  }
  /// What the machine is made with.
  [[nodiscard]] virtual vulkan::ContextOptions context_options() const { return {}; }

  void make_machine(const vulkan::ContextOptions& context) {
    machine_.reset();
    machine_ = std::make_unique<vulkan::VulkanMachine>(device_options(), context);
  }

  template <class Item>
  std::vector<Item> download(const vulkan::Buffer& source, std::size_t count) {
    std::vector<Item> items(count);
    machine_->submitter.download({source.handle(), 0, count * sizeof(Item)},
                                 [&](std::uint64_t offset, std::span<const std::byte> piece) {
                                   std::memcpy(reinterpret_cast<std::byte*>(items.data()) + offset,
                                               piece.data(), piece.size());
                                 });
    return items;
  }
  std::vector<glm::dvec3> download_points(const vulkan::Buffer& source, std::size_t count) {
    return machine_->download_points(source, count);
  }

  std::unique_ptr<vulkan::VulkanMachine> machine_;
};

struct DeviceNet;

/// The same on each read path: the kernels of hardware, and those of software devices.
class FairReads : public FairMachine,
                  public ::testing::WithParamInterface<vulkan::PipelineVariant> {
 protected:
  [[nodiscard]] vulkan::ContextOptions context_options() const override {
    vulkan::ContextOptions options;
    options.variant = GetParam();
    return options;
  }
  void record(const DeviceNet& net, std::initializer_list<vulkan::FairPart> parts);
  std::vector<glm::dvec3> face_normals(const DeviceNet& net);
  std::vector<glm::dvec3> normals(const DeviceNet& net);
  std::vector<glm::dvec3> result(const DeviceNet& net);
};
inline auto both_reads() {
  return ::testing::Values(vulkan::kHardwareVariant, vulkan::kSoftwareVariant);
}
inline std::string name_of_reads(const ::testing::TestParamInfo<vulkan::PipelineVariant>& variant) {
  return variant.param.read_path == vulkan::ReadPath::Texel ? "Texel" : "Storage";
}

/// A net in the making on a device.
struct DeviceNet {
  DeviceNet(vulkan::VulkanMachine& machine, const test::FairCase& c, std::uint32_t polish_steps,
            const FairDecisions* decisions = nullptr)
      : topology(make_fair_topology(c.mesh, c.subdivision)),
        records(vulkan::fair_records(topology, decisions)),
        tables(machine.context, records),
        points(machine.context, c.given.size() * sizeof(glm::vec4), vulkan::MemoryUse::Device),
        fair(machine.context, tables, points, {polish_steps, true, true}) {
    tables.for_each(records, [&](const vulkan::Buffer& buffer, std::span<const std::byte> bytes) {
      machine.submitter.upload({buffer.handle(), 0, bytes.size()}, bytes);
    });
    machine.upload_points(points, c.given);
    for (const glm::dvec3& p : c.given) given.emplace_back(glm::vec3(p));
  }

  FairTopology topology;
  vulkan::FairRecords records;
  vulkan::FairTables tables;
  vulkan::Buffer points;
  vulkan::GpuFair fair;
  std::vector<glm::dvec3> given;  ///< as the device has them
};

inline void FairReads::record(const DeviceNet& net, std::initializer_list<vulkan::FairPart> parts) {
  machine_->submitter.run([&](VkCommandBuffer commands) {
    for (const vulkan::FairPart part : parts) net.fair.record(commands, part);
  });
}
inline std::vector<glm::dvec3> FairReads::face_normals(const DeviceNet& net) {
  return download_points(net.fair.buffers().face_normals,
                         static_cast<std::size_t>(net.topology.face_count));
}
inline std::vector<glm::dvec3> FairReads::normals(const DeviceNet& net) {
  return download_points(net.fair.buffers().normals, net.given.size());
}
inline std::vector<glm::dvec3> FairReads::result(const DeviceNet& net) {
  return download_points(net.fair.buffers().result, net.records.owners.size());
}

}  // namespace planish::testing
