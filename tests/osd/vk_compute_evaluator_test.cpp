#include <gmock/gmock.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/osd/cpuEvaluator.h>
#include <opensubdiv/osd/cpuPatchTable.h>
#include <opensubdiv/osd/mesh.h>

#include <numeric>
#include <thread>

#include "osd/conformance.h"
#include "osd/fixture.h"
#include "planish/osd/vk_compute_evaluator.h"
#include "planish/solve/far_tables.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/device/context.h"
#include "planish/vulkan/device/driver.h"
#include "support/calls.h"
#include "vulkan/host_commands.h"
#include "vulkan/pretended_driver.h"

namespace planish::testing {
namespace {

// A buffer that a host made for itself, with memory of its own.
class HostBuffer {
 public:
  HostBuffer(vulkan::Context& context, VkDeviceSize size, VkBufferUsageFlags usage)
      : context_(context) {
    const vulkan::DeviceFunctions& vk = context.vk();
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = size;
    info.usage = usage;
    vulkan::check(vk.vkCreateBuffer(context.device(), &info, nullptr, &buffer_), "vkCreateBuffer");
    vulkan::MemoryRequest request{{}, vulkan::MemoryUse::Device};
    vk.vkGetBufferMemoryRequirements(context.device(), buffer_, &request.requirements);
    size_ = request.requirements.size;
    block_ = context.memory().allocate(request);
    vulkan::check(vk.vkBindBufferMemory(context.device(), buffer_, block_.memory, block_.offset),
                  "vkBindBufferMemory");
  }
  ~HostBuffer() {
    context_.vk().vkDestroyBuffer(context_.device(), buffer_, nullptr);
    context_.memory().free(block_, size_);
  }
  HostBuffer(const HostBuffer&) = delete;
  HostBuffer& operator=(const HostBuffer&) = delete;

  [[nodiscard]] VkBuffer handle() const { return buffer_; }

 private:
  vulkan::Context& context_;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  vulkan::MemoryBlock block_;
  VkDeviceSize size_ = 0;
};

// EvalStencils in all its forms, recorded and submitted, cut into dispatches, and refused.

using namespace OpenSubdiv;
using Osd::BufferDescriptor;
using osd::VkComputeEvaluator;
using osd::VkStencilTable;
using osd::VkVertexBuffer;

BufferDescriptor unused() { return {}; }

// A torus refined twice: the table, its points, and what Osd::CpuEvaluator makes of them.
struct Refinement {
  Cage cage = torus(6, 5);
  Refined refined = refine(cage, {.level = 2});
  const Far::StencilTable& table = *refined.vertices;
  int sources = table.GetNumControlVertices(), rows = table.GetNumStencils();
  BufferDescriptor desc{0, 3, 3};
  std::vector<float> points, expected;

  Refinement() {
    for (const auto& position : cage.positions)
      points.insert(points.end(), position.begin(), position.end());
    expected = evaluate(points);
  }

  std::vector<float> evaluate(const std::vector<float>& from) const {
    std::vector<float> result(std::size_t(rows) * 3);
    Osd::CpuEvaluator::EvalStencils(from.data(), desc, result.data(), desc, table.GetSizes().data(),
                                    table.GetOffsets().data(), table.GetControlIndices().data(),
                                    table.GetWeights().data(), 0, rows);
    return result;
  }
};

// A table of planish's own: every row is its own source.
std::unique_ptr<const Far::StencilTable> identity(int rows) {
  StencilTable result;
  result.sizes.assign(rows, 1);
  result.indices.resize(rows);
  std::iota(result.indices.begin(), result.indices.end(), 0);
  result.weights.assign(rows, 1.0);
  result.close(rows);
  return to_far<float>(result.view());
}

class OsdStencils : public OsdTest {
 protected:
  std::unique_ptr<VkStencilTable> upload(const Far::StencilTable& table) {
    return std::unique_ptr<VkStencilTable>(VkStencilTable::Create(&table, device_context_.get()));
  }
};

TEST_F(OsdStencils, InstancesAndHandlesDoWhatTheStaticFunctionDoes) {
  const Refinement torus;
  const auto source = buffer_of(torus.points);
  const auto table = upload(torus.table);
  Osd::EvaluatorCacheT<VkComputeEvaluator> cache;
  const VkComputeEvaluator* instance =
      cache.GetEvaluator(torus.desc, torus.desc, device_context_.get());
  ASSERT_NE(instance, nullptr);
  BufferDescriptor moved = torus.desc;
  moved.offset = 30 * 3;
  EXPECT_EQ(cache.GetEvaluator(torus.desc, moved, device_context_.get()), instance);

  const std::vector<float> nothing(torus.expected.size(), 9.0f);
  const auto of_static = buffer_of(nothing), of_instance = buffer_of(nothing),
             of_handles = buffer_of(nothing);
  EXPECT_TRUE(VkComputeEvaluator::EvalStencils(source.get(), torus.desc, of_static.get(),
                                               torus.desc, table.get(), instance,
                                               device_context_.get()));
  EXPECT_TRUE(
      instance->EvalStencils(source.get(), torus.desc, of_instance.get(), torus.desc, table.get()));
  EXPECT_TRUE(instance->EvalStencils(source->BindVBO(), torus.desc, of_handles->BindVBO(),
                                     torus.desc, table.get(), 0, torus.rows));
  EXPECT_EQ(floats_of(*of_static), torus.expected);
  EXPECT_EQ(floats_of(*of_instance), torus.expected);
  EXPECT_EQ(floats_of(*of_handles), torus.expected);
}

// So that no frame waits for a compiler.
TEST_F(OsdStencils, KernelsAreCompiledWithTheirEvaluator) {
  close();
  PretendedDriver::reset();
  make_device(PretendedDriver::get_proc());
  const auto compiled = [] { return PretendedDriver::count("vkCreateComputePipelines"); };
  const Refinement torus;
  const auto table = upload(torus.table);
  const BufferDescriptor from(0, 3, 5), to(0, 3, 7);
  const auto source = buffer_of(std::vector<float>(std::size_t(torus.sources) * 5));
  const auto target = buffer_of(std::vector<float>(std::size_t(torus.rows) * 7));
  const int before = compiled();
  const std::unique_ptr<VkComputeEvaluator> instance(
      VkComputeEvaluator::Create(from, to, unused(), unused(), device_context_.get()));
  const int with_evaluator = compiled();
  EXPECT_GT(with_evaluator, before);
  EXPECT_TRUE(
      instance->EvalStencils(source->BindVBO(), from, target->BindVBO(), to, table.get(), 0, 1));
  EXPECT_EQ(compiled(), with_evaluator);
}

TEST_F(OsdStencils, StartAndEndLeaveOtherElementsAlone) {
  const Refinement torus;
  const auto source = buffer_of(torus.points);
  const auto table = upload(torus.table);
  const std::unique_ptr<VkComputeEvaluator> instance(VkComputeEvaluator::Create(
      torus.desc, torus.desc, unused(), unused(), device_context_.get()));
  for (const auto& [start, end] : {std::pair{0, 1}, std::pair{5, 70}, std::pair{63, 65},
                                   std::pair{torus.rows - 1, torus.rows}, std::pair{7, 7}}) {
    std::vector<float> expected(torus.expected.size(), 9.0f);
    const auto target = buffer_of(expected);
    std::copy(torus.expected.begin() + 3 * start, torus.expected.begin() + 3 * end,
              expected.begin() + 3 * start);
    EXPECT_TRUE(instance->EvalStencils(source->BindVBO(), torus.desc, target->BindVBO(), torus.desc,
                                       table.get(), start, end));
    EXPECT_EQ(floats_of(*target), expected) << start << " to " << end;
  }
}

TEST_F(OsdStencils, ACommandBufferOfTheHostIsOnlyRecordedInto) {
  const Refinement torus;
  HostCommands host(*device_);
  const std::vector<float> nothing(torus.expected.size(), 9.0f);
  const auto target = buffer_of(nothing);
  osd::VkDeviceContext recording(*context_);
  host.record([&](VkCommandBuffer commands) {
    recording.SetCommandBuffer(commands);
    // Uploads are recorded too, and their data are free at once.
    std::unique_ptr<VkVertexBuffer> source(VkVertexBuffer::Create(3, torus.sources, &recording));
    std::vector<float> points = torus.points;
    source->UpdateData(points.data(), 0, torus.sources, &recording);
    points.assign(points.size(), 0.0f);
    const std::unique_ptr<VkStencilTable> table(VkStencilTable::Create(&torus.table, &recording));
    EXPECT_TRUE(VkComputeEvaluator::EvalStencils(source.get(), torus.desc, target.get(), torus.desc,
                                                 table.get(), nullptr, &recording));
    // What the commands use may be deleted before they ran, as here.
  });
  VkComputeEvaluator::Synchronize(&recording);
  EXPECT_EQ(floats_of(*target), nothing);
  host.submit();
  host.wait();
  EXPECT_EQ(floats_of(*target), torus.expected);
  recording.Release(host.handle());
}

TEST_F(OsdStencils, ThreadsRecordWithContextsOfTheirOwn) {
  constexpr int kThreads = 4;
  const Refinement torus;
  const auto source = buffer_of(torus.points);
  const auto padded = buffer_of(std::vector<float>(8 * std::size_t(torus.sources), 0.5f));
  const auto table = upload(torus.table);
  device_context_->Synchronize();
  std::vector<std::unique_ptr<HostCommands>> hosts;
  std::vector<std::unique_ptr<osd::VkDeviceContext>> contexts;
  std::vector<std::unique_ptr<VkVertexBuffer>> targets;
  for (int i = 0; i < kThreads; ++i) {
    hosts.push_back(std::make_unique<HostCommands>(*device_));
    contexts.push_back(std::make_unique<osd::VkDeviceContext>(*context_));
    targets.push_back(buffer_of(torus.expected));
  }
  std::vector<std::thread> threads;
  for (int i = 0; i < kThreads; ++i)
    threads.emplace_back([&, i] {
      hosts[i]->record([&](VkCommandBuffer commands) {
        contexts[i]->SetCommandBuffer(commands);
        // Strides that no other thread has: kernels are compiled side by side.
        EXPECT_TRUE(VkComputeEvaluator::EvalStencils(padded.get(), {0, 1, 4 + i}, targets[i].get(),
                                                     {0, 1, 3}, table.get(), nullptr,
                                                     contexts[i].get()));
        EXPECT_TRUE(VkComputeEvaluator::EvalStencils(source.get(), torus.desc, targets[i].get(),
                                                     torus.desc, table.get(), nullptr,
                                                     contexts[i].get()));
      });
    });
  for (std::thread& thread : threads) thread.join();
  for (const auto& host : hosts) {
    host->submit();
    host->wait();
  }
  for (int i = 0; i < kThreads; ++i) EXPECT_EQ(floats_of(*targets[i]), torus.expected) << i;
}

TEST_F(OsdStencils, BuffersOfTheHostNeedNoMoreThanTheUsageStated) {
  const Refinement torus;
  const auto table = upload(torus.table);
  const auto source = buffer_of(torus.points);
  const std::unique_ptr<VkComputeEvaluator> instance(VkComputeEvaluator::Create(
      torus.desc, torus.desc, unused(), unused(), device_context_.get()));
  // From ours to the host's, and back by a table that copies.
  HostBuffer host(*context_, torus.expected.size() * sizeof(float),
                  device_context_->GetBufferUsage());
  EXPECT_TRUE(instance->EvalStencils(source->BindVBO(), torus.desc, host.handle(), torus.desc,
                                     table.get(), 0, torus.rows));
  const auto copies = identity(torus.rows);
  const std::unique_ptr<VkStencilTable> copy(
      VkStencilTable::Create(copies.get(), device_context_.get()));
  const auto result = buffer_of(std::vector<float>(torus.expected.size(), 9.0f));
  EXPECT_TRUE(instance->EvalStencils(host.handle(), torus.desc, result->BindVBO(), torus.desc,
                                     copy.get(), 0, torus.rows));
  EXPECT_EQ(floats_of(*result), torus.expected);
}

TEST_F(OsdStencils, SeveralMeshesAndFramesAreInFlight) {
  constexpr int kMeshes = 4, kFrames = 5;
  const Refinement torus;
  std::vector<std::unique_ptr<VkStencilTable>> tables;
  std::vector<std::unique_ptr<VkVertexBuffer>> buffers;
  BufferDescriptor target = torus.desc;
  target.offset = 3 * torus.sources;
  for (int mesh = 0; mesh < kMeshes; ++mesh) {
    tables.push_back(upload(torus.table));
    buffers.emplace_back(
        VkVertexBuffer::Create(3, torus.sources + torus.rows, device_context_.get()));
  }
  std::vector<std::vector<float>> points(kMeshes, torus.points);
  for (int frame = 0; frame < kFrames; ++frame)
    for (int mesh = 0; mesh < kMeshes; ++mesh) {
      for (float& coordinate : points[mesh]) coordinate *= 1.0f + 0.125f * mesh;
      buffers[mesh]->UpdateData(points[mesh].data(), 0, torus.sources, device_context_.get());
      EXPECT_TRUE(VkComputeEvaluator::EvalStencils(buffers[mesh].get(), torus.desc,
                                                   buffers[mesh].get(), target, tables[mesh].get(),
                                                   nullptr, device_context_.get()));
    }
  VkComputeEvaluator::Synchronize(device_context_.get());
  for (int mesh = 0; mesh < kMeshes; ++mesh) {
    const std::vector<float> result = floats_of(*buffers[mesh]);
    const std::vector<float> expected = torus.evaluate(points[mesh]);
    EXPECT_TRUE(std::equal(expected.begin(), expected.end(), result.begin() + target.offset))
        << mesh;
  }
}

TEST_F(OsdStencils, LowLimitsCutDispatchesAndChangeNothing) {
  const Cage cage = torus(12, 10);
  const Refined refined = refine(cage, {.level = 4});
  for (const vulkan::PipelineVariant& variant :
       {vulkan::kHardwareVariant, vulkan::kSoftwareVariant}) {
    make_context({.max_storage_range = 128 << 10, .max_group_count = 40, .variant = variant});
    Conformance conformance{*device_context_, {}};
    for (const Layout& layout : all_layouts())
      conformance.stencils("limits", cage, *refined.vertices, layout);
    EXPECT_GT(conformance.tally.floats, 1000000);
  }
}

TEST_F(OsdStencils, ElementsThatNoBindingSpansAreRefusedByName) {
  const Refinement torus;
  make_context({.max_storage_range = 64 << 10});
  const auto table = upload(torus.table);
  const BufferDescriptor wide{0, 3, 1000};
  const auto source = buffer_of(std::vector<float>(30000, 0.0f)),
             target = buffer_of(torus.expected);
  // The source spans 120 kB.
  EXPECT_THAT(test::message_of(ErrorCode::OutOfMemory,
                               [&] {
                                 VkComputeEvaluator::EvalStencils(source.get(), wide, target.get(),
                                                                  torus.desc, table.get(), nullptr,
                                                                  device_context_.get());
                               }),
              ::testing::HasSubstr("maxStorageBufferRange is 65536"));
}

TEST_F(OsdStencils, WhatDoesNotFitIsRefused) {
  const Refinement torus;
  const auto source = buffer_of(torus.points), target = buffer_of(torus.expected);
  const auto table = upload(torus.table);
  const auto eval = [&](const BufferDescriptor& from, const BufferDescriptor& to) {
    return VkComputeEvaluator::EvalStencils(source.get(), from, target.get(), to, table.get(),
                                            nullptr, device_context_.get());
  };
  EXPECT_TRUE(eval({0, 3, 3}, {0, 3, 3}));
  EXPECT_FALSE(eval({0, 3, 3}, {0, 2, 3})) << "lengths differ";
  EXPECT_FALSE(eval({0, 3, 2}, {0, 3, 3})) << "stride below length";
  EXPECT_FALSE(eval({0, 0, 3}, {0, 0, 3})) << "no floats";
  EXPECT_FALSE(eval({-3, 3, 3}, {0, 3, 3})) << "before the buffer";
  VkVertexBuffer* const none = nullptr;
  EXPECT_FALSE(VkComputeEvaluator::EvalStencils(none, torus.desc, target.get(), torus.desc,
                                                table.get(), nullptr, device_context_.get()));
  EXPECT_FALSE(VkComputeEvaluator::EvalStencils(source.get(), torus.desc, target.get(), torus.desc,
                                                target.get(), torus.desc, target.get(), torus.desc,
                                                table.get(), nullptr, device_context_.get()))
      << "the table has no derivatives";
  const std::unique_ptr<VkComputeEvaluator> instance(VkComputeEvaluator::Create(
      torus.desc, torus.desc, unused(), unused(), device_context_.get()));
  const auto range = [&](int start, int end) {
    return instance->EvalStencils(source->BindVBO(), torus.desc, target->BindVBO(), torus.desc,
                                  table.get(), start, end);
  };
  EXPECT_FALSE(range(-1, 3));
  EXPECT_FALSE(range(0, torus.rows + 1));
  EXPECT_EQ(
      VkComputeEvaluator::Create({0, 3, 3}, {0, 4, 4}, unused(), unused(), device_context_.get()),
      nullptr);
  EXPECT_THROW(source->UpdateData(torus.points.data(), 1, 90, device_context_.get()), Error);
  EXPECT_THROW(static_cast<void>(VkVertexBuffer::Create(0, 3, device_context_.get())), Error);
}

TEST_F(OsdStencils, StencilsThatReadEachOtherAreRefused) {
  const auto refiner = make_refiner(cube());
  refiner->RefineUniform(Far::TopologyRefiner::UniformOptions(3));
  Far::StencilTableFactory::Options options;
  options.factorizeIntermediateLevels = false;
  options.generateIntermediateLevels = true;
  options.generateOffsets = true;
  const std::unique_ptr<const Far::StencilTable> table(
      Far::StencilTableFactory::Create(*refiner, options));
  // Those of level 2 read those of level 1.
  EXPECT_THAT(test::message_of(ErrorCode::InvalidArgument, [&] { upload(*table); }),
              ::testing::HasSubstr("factorizeIntermediateLevels"));
}

TEST_F(OsdStencils, AContextWithoutQueueNeedsACommandBuffer) {
  osd::VkDeviceContext recording(*context_);
  const std::unique_ptr<VkVertexBuffer> buffer(VkVertexBuffer::Create(3, 1, &recording));
  const float point[3] = {};
  EXPECT_THROW(buffer->UpdateData(point, 0, 1, &recording), Error);
}

// EvalPatches in all its forms, recorded, cut into dispatches, refused, on drivers that differ.
using Far::PatchTableFactory;
using osd::VkPatchTable;

constexpr int kForms = 6;

RefineOptions adaptive_to(int level, PatchTableFactory::Options::EndCapType end_cap) {
  RefineOptions options;
  options.adaptive = true;
  options.level = level;
  options.patches = PatchTableFactory::Options(level);
  options.patches.SetEndCapType(end_cap);
  return options;
}

// A prism's patches, points to evaluate them with and what Osd::CpuEvaluator makes of them: value,
// du, dv, duu, duv, dvv.
struct Evaluation {
  Cage cage = prism(5);
  Refined refined;
  BufferDescriptor desc{0, 3, 3};
  std::vector<float> points;
  std::vector<Osd::PatchCoord> coords;
  std::array<std::vector<float>, kForms> expected;

  explicit Evaluation(const RefineOptions& options =
                          adaptive_to(2, PatchTableFactory::Options::ENDCAP_GREGORY_BASIS))
      : refined(refine(cage, options)) {
    const Far::StencilTable& table = *refined.vertices;
    const int coarse = table.GetNumControlVertices(), rows = table.GetNumStencils();
    points.resize(std::size_t(coarse + rows) * 3);
    for (int i = 0; i < coarse; ++i)
      std::copy(cage.positions[i].begin(), cage.positions[i].end(), points.begin() + 3 * i);
    Osd::CpuEvaluator::EvalStencils(points.data(), desc, points.data(),
                                    BufferDescriptor(3 * coarse, 3, 3), table.GetSizes().data(),
                                    table.GetOffsets().data(), table.GetControlIndices().data(),
                                    table.GetWeights().data(), 0, rows);
    for (const Patch& patch : patches_of(*refined.patches))
      coords.push_back(patch.coord(0.25f, 0.625f));
    evaluate();
  }

  void evaluate() {
    const Osd::CpuPatchTable table(refined.patches.get());
    for (std::vector<float>& result : expected) result.resize(coords.size() * 3);
    Osd::CpuEvaluator::EvalPatches(
        points.data(), desc, expected[0].data(), desc, expected[1].data(), desc, expected[2].data(),
        desc, expected[3].data(), desc, expected[4].data(), desc, expected[5].data(), desc, count(),
        coords.data(), table.GetPatchArrayBuffer(), table.GetPatchIndexBuffer(),
        table.GetPatchParamBuffer());
  }
  int count() const { return static_cast<int>(coords.size()); }
};

class OsdPatches : public OsdTest {
 protected:
  void TearDown() override {
    forget();
    OsdTest::TearDown();
  }
  void forget() {
    source_.reset();
    coords_.reset();
    table_.reset();
    for (auto& target : targets_) target.reset();
  }

  /// Patches in all forms and the stencils before them, on a driver that differs, against
  /// OpenSubdiv's own evaluator.
  void expect_on_pretended_driver(const Evaluation& from) {
    forget();
    make_device(PretendedDriver::get_proc());
    expect_evaluated(from, kForms);
    const Far::StencilTable& stencils = *from.refined.vertices;
    const auto first = from.points.begin() + 3 * stencils.GetNumControlVertices();
    const std::unique_ptr<VkStencilTable> table(
        VkStencilTable::Create(&stencils, device_context_.get()));
    const auto target = buffer_of(std::vector<float>(from.points.end() - first, 9.0f));
    EXPECT_TRUE(VkComputeEvaluator::EvalStencils(source_.get(), from.desc, target.get(), from.desc,
                                                 table.get(), nullptr, device_context_.get()));
    EXPECT_EQ(floats_of(*target), std::vector<float>(first, from.points.end()));
  }

  void upload(const Evaluation& from) {
    source_ = buffer_of(from.points);
    table_.reset(VkPatchTable::Create(from.refined.patches.get(), device_context_.get()));
    coords_ = upload_coords(from.coords);
    for (auto& target : targets_)
      target = buffer_of(std::vector<float>(from.coords.size() * 3, 9.0f));
  }
  /// Into the targets of the first one, three or six forms.
  bool eval(const Evaluation& from, int forms, osd::VkDeviceContext& context) {
    const BufferDescriptor& d = from.desc;
    VkVertexBuffer* const to[] = {targets_[0].get(), targets_[1].get(), targets_[2].get(),
                                  targets_[3].get(), targets_[4].get(), targets_[5].get()};
    if (forms == 1)
      return VkComputeEvaluator::EvalPatches(source_.get(), d, to[0], d, from.count(),
                                             coords_.get(), table_.get(), nullptr, &context);
    if (forms == 3)
      return VkComputeEvaluator::EvalPatches(source_.get(), d, to[0], d, to[1], d, to[2], d,
                                             from.count(), coords_.get(), table_.get(), nullptr,
                                             &context);
    return VkComputeEvaluator::EvalPatches(source_.get(), d, to[0], d, to[1], d, to[2], d, to[3], d,
                                           to[4], d, to[5], d, from.count(), coords_.get(),
                                           table_.get(), nullptr, &context);
  }
  /// As Osd::CpuEvaluator does.
  void expect_evaluated(const Evaluation& from, int forms) {
    upload(from);
    EXPECT_TRUE(eval(from, forms, *device_context_));
    expect(from, forms);
  }
  std::unique_ptr<VkVertexBuffer> upload_coords(const std::vector<Osd::PatchCoord>& coords) {
    const int count = static_cast<int>(coords.size());
    std::unique_ptr<VkVertexBuffer> buffer(VkVertexBuffer::Create(5, count, device_context_.get()));
    buffer->UpdateData(reinterpret_cast<const float*>(coords.data()), 0, count,
                       device_context_.get());
    return buffer;
  }
  void expect(const Evaluation& from, int forms) {
    const std::vector<float> untouched(from.coords.size() * 3, 9.0f);
    for (int i = 0; i < kForms; ++i) {
      EXPECT_EQ(floats_of(*targets_[i]), i < forms ? from.expected[i] : untouched) << i;
      targets_[i] = buffer_of(untouched);
    }
  }

  std::unique_ptr<VkVertexBuffer> source_, coords_;
  std::unique_ptr<VkPatchTable> table_;
  std::array<std::unique_ptr<VkVertexBuffer>, kForms> targets_;
};

TEST_F(OsdPatches, AllFormsDoTheSame) {
  const Evaluation prism;
  upload(prism);
  const BufferDescriptor& d = prism.desc;
  const std::unique_ptr<VkComputeEvaluator> instance(
      VkComputeEvaluator::Create(d, d, d, d, device_context_.get()));
  for (const int forms : {1, 3}) {
    EXPECT_TRUE(eval(prism, forms, *device_context_));
    expect(prism, forms);
  }
  EXPECT_TRUE(instance->EvalPatches(source_.get(), d, targets_[0].get(), d, prism.count(),
                                    coords_.get(), table_.get()));
  expect(prism, 1);
  EXPECT_TRUE(instance->EvalPatches(source_.get(), d, targets_[0].get(), d, targets_[1].get(), d,
                                    targets_[2].get(), d, targets_[3].get(), d, targets_[4].get(),
                                    d, targets_[5].get(), d, prism.count(), coords_.get(),
                                    table_.get()));
  expect(prism, 6);
  EXPECT_TRUE(instance->EvalPatches(source_->BindVBO(), d, targets_[0]->BindVBO(), d,
                                    targets_[1]->BindVBO(), d, targets_[2]->BindVBO(), d,
                                    prism.count(), coords_->BindVBO(), table_->GetPatches()));
  expect(prism, 3);
}

TEST_F(OsdPatches, TablesAreThoseOfOpenSubdiv) {
  const Evaluation prism;
  upload(prism);
  EXPECT_EQ(table_->GetPatchArrays().size(),
            std::size_t(prism.refined.patches->GetNumPatchArrays()));
  EXPECT_NE(table_->GetPatchIndexBuffer(), VkBuffer(VK_NULL_HANDLE));
  EXPECT_NE(table_->GetPatchParamBuffer(), VkBuffer(VK_NULL_HANDLE));
  EXPECT_NE(table_->GetVaryingPatchIndexBuffer(), VkBuffer(VK_NULL_HANDLE));
  EXPECT_EQ(table_->GetNumFVarChannels(), 0);
  EXPECT_TRUE(table_->GetFVarPatchArrays(0).empty());
}

TEST_F(OsdPatches, ACommandBufferOfTheHostIsOnlyRecordedInto) {
  const Evaluation prism;
  upload(prism);
  HostCommands host(*device_);
  osd::VkDeviceContext recording(*context_);
  host.record([&](VkCommandBuffer commands) {
    recording.SetCommandBuffer(commands);
    EXPECT_TRUE(eval(prism, 1, recording));
  });
  EXPECT_THAT(floats_of(*targets_[0]), ::testing::Each(9.0f));
  host.submit();
  host.wait();
  expect(prism, 1);
  recording.Release(host.handle());
}

TEST_F(OsdPatches, LowLimitsCutDispatchesAndChangeNothing) {
  make_context({.max_storage_range = 64 << 10, .max_group_count = 3});
  Evaluation prism;
  const std::vector<Osd::PatchCoord> once = prism.coords;
  while (prism.coords.size() < 3000)
    prism.coords.insert(prism.coords.end(), once.begin(), once.end());
  prism.evaluate();
  expect_evaluated(prism, 3);
}

// Windows begin at multiples of an alignment: one that begins in the middle shares bytes with the
// one before.
TEST_F(OsdPatches, DispatchesWhoseWindowsShareBytesWaitForEachOther) {
  make_context({.max_group_count = 1});
  Evaluation prism;
  while (prism.coords.size() < 200) prism.coords.push_back(prism.coords[prism.coords.size() / 2]);
  prism.evaluate();
  upload(prism);
  std::vector<float> wanted = prism.expected[0];
  wanted.insert(wanted.begin(), 9.0f);
  targets_[0] = buffer_of(std::vector<float>(wanted.size(), 9.0f));
  EXPECT_TRUE(VkComputeEvaluator::EvalPatches(
      source_.get(), prism.desc, targets_[0].get(), BufferDescriptor(1, 3, 3), prism.count(),
      coords_.get(), table_.get(), nullptr, device_context_.get()));
  EXPECT_EQ(floats_of(*targets_[0]), wanted);
}

TEST_F(OsdPatches, CoordinatesWithoutAPatchGiveZero) {
  Evaluation prism;
  prism.coords.resize(4);
  prism.evaluate();
  prism.coords[1].handle.arrayIndex = 1000;
  prism.coords[2].handle.patchIndex = -1;
  prism.coords[3].handle.patchIndex = 1 << 30;
  std::fill(prism.expected[0].begin() + 3, prism.expected[0].end(), 0.0f);
  expect_evaluated(prism, 1);
}

TEST_F(OsdPatches, LegacyGregoryPatchesGiveWhatTheCpuGives) {
  const Evaluation prism(adaptive_to(2, PatchTableFactory::Options::ENDCAP_LEGACY_GREGORY));
  EXPECT_THAT(prism.expected[0], ::testing::Contains(0.0f)) << "none of them is legacy";
  expect_evaluated(prism, 1);
}

TEST_F(OsdPatches, WhatDoesNotFitIsRefused) {
  RefineOptions uniform;
  const Evaluation prism(uniform);
  upload(prism);
  const auto eval = [&](const BufferDescriptor& from, const BufferDescriptor& to, int count,
                        const VkPatchTable* table) {
    return VkComputeEvaluator::EvalPatches(source_.get(), from, targets_[0].get(), to, count,
                                           coords_.get(), table, nullptr, device_context_.get());
  };
  EXPECT_TRUE(eval({0, 3, 3}, {0, 3, 3}, 0, table_.get()));
  EXPECT_FALSE(eval({0, 3, 3}, {0, 2, 3}, 1, table_.get()));
  EXPECT_FALSE(eval({0, 3, 3}, {0, 3, 3}, -1, table_.get()));
  EXPECT_FALSE(eval({0, 3, 3}, {0, 3, 3}, 1, nullptr));
  EXPECT_FALSE(VkComputeEvaluator::EvalPatchesVarying(source_.get(), prism.desc, targets_[0].get(),
                                                      prism.desc, 1, coords_.get(), table_.get(),
                                                      nullptr, device_context_.get()))
      << "uniform tables have no varying patches";
  for (const int channel : {-1, 0, 7})
    EXPECT_FALSE(VkComputeEvaluator::EvalPatchesFaceVarying(
        source_.get(), prism.desc, targets_[0].get(), prism.desc, 1, coords_.get(), table_.get(),
        channel, nullptr, device_context_.get()));
}

TEST_F(OsdPatches, DriversThatDifferGiveTheSame) {
  const Evaluation prism;
  using Pretence = PretendedDriver::Pretence;
  const std::vector<std::pair<const char*, void (*)(Pretence&)>> drivers = {
      {"as it is", [](Pretence&) {}},
      {"1 lane", [](Pretence& p) { p.subgroup_size = 1; }},
      {"128 lanes", [](Pretence& p) { p.subgroup_size = 128; }},
      {"no subgroups", [](Pretence& p) { p.no_subgroup_operations = true; }},
      {"not coherent", [](Pretence& p) { p.split_memory = true; }},
      {"small heap",
       [](Pretence& p) {
         p.bar_bytes = 4096;
         p.host_bytes = 1u << 20;
       }},
      {"small ranges", [](Pretence& p) { p.storage_range = 128u << 20; }},
      {"no timestamps", [](Pretence& p) { p.no_timestamps = true; }},
      {"portability subset", [](Pretence& p) { p.portability_subset = true; }},
      {"queue that only computes", [](Pretence& p) { p.separate_compute = true; }}};
  for (const auto& [name, differ] : drivers) {
    SCOPED_TRACE(name);
    forget();
    close();
    PretendedDriver::reset();
    differ(PretendedDriver::pretence());
    expect_on_pretended_driver(prism);
    EXPECT_GT(PretendedDriver::count("vkCmdDispatch"), 1);
    EXPECT_EQ(PretendedDriver::illegal_maps(), 0);
  }
  forget();
  close();
  EXPECT_TRUE(PretendedDriver::alive().empty());
  PretendedDriver::reset();
}

TEST_F(OsdPatches, ADeviceThatIsLostInTheMiddleIsReported) {
  const Evaluation prism;
  close();
  PretendedDriver::reset();
  int lost = 0;
  for (bool done = false; !done; lost += lost < 2 ? 1 : 6) {
    ASSERT_LT(lost, 100);
    PretendedDriver::pretence().submissions_left = lost;
    try {
      expect_on_pretended_driver(prism);
      done = true;
    } catch (const vulkan::VulkanError& error) {
      EXPECT_EQ(error.code(), ErrorCode::DeviceLost);
    }
    forget();
    close();
    ASSERT_TRUE(PretendedDriver::alive().empty()) << "after " << lost << " submissions";
  }
  EXPECT_GT(lost, 5);
  PretendedDriver::reset();
}

}  // namespace
}  // namespace planish::testing
