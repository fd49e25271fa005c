#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <random>
#include <vector>

#include "planish/edit/editor.h"
#include "planish/solve/backend.h"
#include "planish/vulkan/device/commands.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/device_cases.h"
#include "vulkan/embedding_fixture.h"

namespace planish::testing {
namespace {

constexpr std::uint32_t kMostMoves = 4096;

// A host that edits: everything is mapped. The frame's own Solve is not used.
struct EditHost {
  EditHost(vulkan::Context& context, vulkan::Submitter& with, const PolygonMesh& mesh,
           const vulkan::SystemOptions& options = {}, std::uint32_t instances = 1)
      : submitter(with),
        topology(context, with, mesh, options, {.takes_edits = true}),
        frame(context, topology, {}, instances),
        moves(context, (1 + kMostMoves) * sizeof(std::uint32_t), vulkan::MemoryUse::Upload),
        solve(context, topology.device,
              {.given = {frame.points.handle()},
               .vertices = {frame.output.handle()},
               .instances = instances,
               .moved = {moves.handle(), 0, kMostMoves}}),
        stop_error(static_cast<float>(system().tolerance() / 8)) {
    for (std::uint32_t i = 0; i < instances; ++i) frame.set_points(mesh, i);
    solve_all(false);
  }

  void set_point(std::int32_t vertex, const glm::vec3& to, std::uint32_t instance = 0) {
    const std::size_t place = instance * static_cast<std::size_t>(topology.device.given_count()) +
                              static_cast<std::size_t>(vertex);
    put(frame.points, std::span(&to, 1), place * sizeof to);
  }
  void list(std::vector<std::uint32_t> words, std::uint32_t count) {
    words.insert(words.begin(), count);
    put(moves, words);
  }
  void solve_all(bool warm) {
    vulkan::SolveParameters parameters = stopping(60, stop_error);
    parameters.warm_start = warm;
    submitter.run([&](VkCommandBuffer commands) {
      solve.record_solve(commands, parameters);
      solve.record_evaluate(commands);
      solve.record_status(commands, frame.report.handle(), 0);
    });
  }
  vulkan::EditReach edit() {
    submitter.run([&](VkCommandBuffer commands) {
      record(commands, {.iterations = 40, .stop_error = stop_error});
    });
    return frame.reach();
  }
  void record(VkCommandBuffer commands, const vulkan::EditParameters& parameters) const {
    solve.record_edit(commands, parameters);
    solve.record_status(commands, frame.report.handle(), 0);
    solve.record_reach(commands, frame.report.handle(), frame.reach_offset());
  }
  [[nodiscard]] const vulkan::System& system() const { return topology.system; }
  vulkan::GpuStatus status(std::uint32_t instance = 0) { return frame.status(instance); }
  std::vector<Vertex> vertices(std::uint32_t instance = 0) { return frame.vertices(instance); }
  // All rows made anew from what edits left.
  std::vector<Vertex> evaluated() {
    submitter.run([&](VkCommandBuffer commands) { solve.record_evaluate(commands); });
    return vertices();
  }

  vulkan::Submitter& submitter;
  HostTopology topology;
  HostFrame frame;
  vulkan::Buffer moves;
  vulkan::Solve solve;
  float stop_error;
};

// Edits on a device: against solves of all points, against the CPU's Editor, and what they cost.

using namespace vulkan;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

// Of the diagonal: what single precision leaves, beside a solve's tolerance.
constexpr double kSinglesError = 4e-7;

class EmbedEdit : public Embedding {
 protected:
  std::vector<test::NamedMesh> meshes() const {
    std::vector<test::NamedMesh> all = {
        {"sphere", test::icosphere(2)},
        {"torus", test::torus(30, 20, 1, 0.4)},
        {"closed", test::random_closed_mesh(3)},
        {"creased", test::with_random_creases(test::random_open_mesh(2), 0.1, 3)},
        {"sheet", test::random_open_mesh(5)}};
    const auto rings = large_rings();
    all.insert(all.end(), rings.begin(), rings.end());
    return all;
  }
};

// The CPU's Editor takes the same moves: both are within the tolerance of a solve from scratch.
TEST_F(EmbedEdit, AgreesWithTheEditor) {
  with_both_variants([&] {
    for (const auto& [name, given] : meshes()) {
      SCOPED_TRACE(name);
      const PolygonMesh mesh = in_floats(given);
      const auto backend = make_cpu_backend();
      EditorOptions options;
      options.fit.tolerance = 1e-6;
      const Fit first = fit(mesh, *backend, options.fit);
      ASSERT_TRUE(first.interpolation.converged);
      Editor editor(mesh, first, options);
      EditHost host(*context_, *submitter_, mesh);
      const double diagonal = host.system().diagonal();
      std::mt19937 random(5);
      std::uniform_int_distribution<std::size_t> any(0, host.system().used_vertices().size() - 1);
      for (int i = 0; i < 8; ++i) {
        std::vector<std::int32_t> vertices;
        std::vector<glm::dvec3> to;
        const double way = (i % 2 == 0 ? 0.01 : 0.1) * diagonal;
        for (int k = 0; k < (i % 3 == 2 ? 3 : 1); ++k) {
          vertices.push_back(host.system().used_vertices()[any(random)]);
          const glm::vec3 place(editor.points()[vertices.back()] +
                                way * glm::dvec3(std::sin(i), std::cos(2 * i), std::sin(3 * i)));
          to.push_back(glm::dvec3(place));
          host.set_point(vertices.back(), place);
        }
        editor.move(vertices, to);
        host.list({vertices.begin(), vertices.end()}, static_cast<std::uint32_t>(vertices.size()));
        host.edit();
        EXPECT_EQ(host.status().state, SolveState::Converged) << host.status().residual;
        EXPECT_LE(host.status().residual, host.stop_error);
        const std::vector<Vertex> found = host.vertices();
        ASSERT_EQ(found.size(), editor.positions().size());
        double farthest = 0;
        for (std::size_t v = 0; v < found.size(); ++v)
          farthest = std::max(farthest,
                              glm::length(glm::dvec3(found[v].position) - editor.positions()[v]));
        EXPECT_LE(farthest, (2e-6 + kSinglesError) * diagonal) << i;
        // What was not made anew is what it would be.
        EXPECT_TRUE(same_bits(found, host.evaluated())) << i;
      }
      // Solves go on from there: nothing is left to do.
      host.solve_all(true);
      EXPECT_EQ(host.status().iterations, 0u) << host.status().residual;
    }
  });
}

TEST_F(EmbedEdit, WeightsAndLevelsAreTheSystems) {
  const PolygonMesh mesh = in_floats(test::with_random_creases(test::random_open_mesh(4), 0.1, 7));
  for (const Weights weights : {Weights::DooSabin, Weights::Averaged})
    for (const int level : {0, 1, 3}) {
      EditHost host(*context_, *submitter_, mesh, {.level = level, .weights = weights});
      PolygonMesh moved = mesh;
      std::vector<std::uint32_t> words;
      for (const std::int32_t v : {3, 11, 12}) {
        moved.positions[v] =
            glm::dvec3(glm::vec3(moved.positions[v] + glm::dvec3(0.1, -0.05, 0.2)));
        host.set_point(v, glm::vec3(moved.positions[v]));
        words.push_back(static_cast<std::uint32_t>(v));
      }
      host.list(words, 3);
      host.edit();
      const std::vector<Vertex> found = host.vertices();
      EXPECT_LT(difference(found, surface_by_cpu(moved, mesh, {.level = level, .weights = weights}))
                    .distance,
                (1e-6 + kSinglesError) * host.system().diagonal());
      EXPECT_TRUE(same_bits(found, host.evaluated()));
    }
}

TEST_F(EmbedEdit, AnEmptyListChangesNothing) {
  EditHost host(*context_, *submitter_, test::torus(30, 20, 1, 0.4));
  const std::vector<Vertex> before = host.vertices();
  // A point that moved without being listed waits.
  host.set_point(7, glm::vec3(2, 2, 2));
  host.list({7}, 0);
  const EditReach reach = host.edit();
  EXPECT_EQ(reach.points, 0u);
  EXPECT_EQ(reach.patches, 0u);
  EXPECT_EQ(reach.listed, 0u);
  EXPECT_TRUE(same_bits(host.vertices(), before));
}

TEST_F(EmbedEdit, AllPointsMayMove) {
  const PolygonMesh mesh = test::torus(30, 20, 1, 0.4), pose = in_floats(posed(mesh, 3));
  with_both_variants([&] {
    EditHost host(*context_, *submitter_, mesh);
    std::vector<std::uint32_t> words;
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
      words.push_back(v);
      host.set_point(static_cast<std::int32_t>(v), glm::vec3(pose.positions[v]));
    }
    std::reverse(words.begin(), words.end());
    host.list(words, static_cast<std::uint32_t>(words.size()));
    EXPECT_EQ(host.edit().points, words.size());
    EXPECT_EQ(host.status().state, SolveState::Converged);
    const std::vector<Vertex> found = host.vertices();
    EXPECT_LT(difference(found, surface_by_cpu(pose, mesh, {})).distance,
              (1e-6 + kSinglesError) * host.system().diagonal());
    EXPECT_TRUE(same_bits(found, host.evaluated()));
  });
}

// A host's words may be anything, and name vertices that no face names.
TEST_F(EmbedEdit, ListsMayHoldAnything) {
  // Unused vertices, so that rows are not the mesh's numbers.
  const PolygonMesh mesh = with_unused(test::torus(30, 20, 1, 0.4), 0, glm::dvec3(0), 5);
  const auto edited = [&](const std::vector<std::uint32_t>& words, std::uint32_t count) {
    EditHost host(*context_, *submitter_, mesh);
    host.set_point(40, glm::vec3(mesh.positions[40]) + glm::vec3(0.1f));
    host.set_point(300, glm::vec3(std::numeric_limits<float>::quiet_NaN()));
    host.list(words, count);
    const EditReach reach = host.edit();
    EXPECT_EQ(reach.listed, std::min(count, kMostMoves));
    return host.vertices();
  };
  const std::vector<Vertex> once = edited({40}, 1);
  EXPECT_TRUE(same_bits(edited({40, 40, 40, 0, 4, 605, 0xffffffff, 40}, 8), once));
  EXPECT_TRUE(same_bits(edited({300, 40}, 2), once));
  std::vector<std::uint32_t> all(kMostMoves, 40);
  EXPECT_TRUE(same_bits(edited(all, 0xffffffff), once));
  for (const Vertex& v : once) ASSERT_TRUE(std::isfinite(v.position.x));
}

TEST_F(EmbedEdit, InstancesGetTheBitsOfTheirOwnEdits) {
  const PolygonMesh mesh = test::with_random_creases(test::random_open_mesh(2), 0.1, 3);
  constexpr std::uint32_t kCount = 4;
  with_both_variants([&] {
    EditHost together(*context_, *submitter_, mesh, {}, kCount);
    const auto count = static_cast<std::uint32_t>(mesh.positions.size());
    std::vector<std::unique_ptr<EditHost>> alone;
    for (std::uint32_t i = 0; i < kCount; ++i)
      alone.push_back(std::make_unique<EditHost>(*context_, *submitter_, mesh));
    for (int round = 0; round < 3; ++round) {
      std::vector<std::uint32_t> words;
      std::uint32_t points = 0;
      for (const std::uint32_t i : {3u, 0u, 2u}) {
        const std::uint32_t vertex = (7 * i + 5 * static_cast<std::uint32_t>(round)) % count;
        // Each stops by itself.
        const glm::vec3 to = glm::vec3(mesh.positions[vertex]) +
                             glm::vec3(0.1f * std::pow(0.03f, static_cast<float>(i)));
        together.set_point(static_cast<std::int32_t>(vertex), to, i);
        alone[i]->set_point(static_cast<std::int32_t>(vertex), to);
        words.push_back(i * count + vertex);
        alone[i]->list({vertex}, 1);
        points += alone[i]->edit().points;
      }
      together.list(words, 3);
      EXPECT_EQ(together.edit().points, points);
      for (std::uint32_t i = 0; i < kCount; ++i) {
        EXPECT_TRUE(same_bits(together.vertices(i), alone[i]->vertices())) << i;
        if (i != 1) {
          EXPECT_EQ(bits_of(together.status(i)), bits_of(alone[i]->status())) << i;
        }
      }
    }
  });
}

// By count: rows and patches, which are what is read and written, do not grow with the mesh.
TEST_F(EmbedEdit, CostDoesNotGrowWithTheMesh) {
  constexpr std::uint32_t kSteps = 6, kSide = 2 * kSteps + 3;
  std::vector<EditReach> all;
  std::vector<std::map<std::string, int>> calls;
  for (const int size : {1, 4}) {
    const PolygonMesh mesh = test::torus(60 * size, 30 * size, 1, 0.4);
    EditHost host(*context_, *submitter_, mesh);
    host.set_point(900, glm::vec3(mesh.positions[900]) + glm::vec3(0.01f));
    host.list({900}, 1);
    const std::vector<Vertex> before = host.vertices();
    HostCommands commands(*own_);
    calls.push_back(recorded_calls(
        commands, [&](VkCommandBuffer buffer) { host.record(buffer, {.iterations = kSteps}); }));
    commands.submit();
    commands.wait();
    all.push_back(host.frame.reach());
    const std::vector<Vertex> after = host.vertices();
    std::uint32_t changed = 0;
    for (std::size_t v = 0; v < after.size(); ++v)
      changed += std::memcmp(&after[v], &before[v], sizeof(Vertex)) != 0;
    // Of level 2, between the outermost control points that moved and the next ones.
    constexpr std::uint32_t kRows = (4 * kSide - 1) * (4 * kSide - 1);
    EXPECT_LE(changed, kRows);
    EXPECT_GT(changed, kRows * 9 / 10);
  }
  EXPECT_EQ(all[0].points, kSide * kSide);
  EXPECT_EQ(all[0].patches, 8 * kSide * kSide);
  EXPECT_EQ(std::memcmp(&all[0], &all[1], sizeof all[0]), 0);
  EXPECT_EQ(calls[0], calls[1]);
  EXPECT_GT(calls[0]["vkCmdDispatchIndirect"], 2 * int(kSteps));
  // The count of the list, and the status.
  EXPECT_EQ(calls[0]["vkCmdDispatch"], 2);
}

TEST_F(EmbedEdit, KernelsMayWriteTheList) {
  const PolygonMesh mesh = test::icosphere(2);
  EditHost host(*context_, *submitter_, mesh);
  const Buffer device(*context_, host.moves.size() + 256, MemoryUse::Device);
  const Buffer output(*context_, host.frame.output.size(), MemoryUse::Device);
  const vulkan::Solve solve(*context_, host.topology.device,
                            {.given = {host.frame.points.handle()},
                             .vertices = {output.handle()},
                             .moved = {device.handle(), 12, kMostMoves}});
  submitter_->run([&](VkCommandBuffer commands) {
    solve.record_solve(commands, stopping(60, host.stop_error));
    solve.record_evaluate(commands);
  });
  host.set_point(17, glm::vec3(mesh.positions[17]) * 1.1f);
  host.list({17}, 1);
  host.edit();
  const std::vector<Vertex> expected = host.vertices();
  submitter_->run([&](VkCommandBuffer commands) {
    const VkBufferCopy copy{0, 12, host.moves.size()};
    context_->vk().vkCmdCopyBuffer(commands, host.moves.handle(), device.handle(), 1, &copy);
    record_barrier(*context_, commands, kCopyScope, kEntryScope);
    solve.record_edit(commands, {.iterations = 40, .stop_error = host.stop_error});
    record_barrier(*context_, commands, kExitScope, kEntryScope);
    const VkBufferCopy back{0, 0, output.size()};
    context_->vk().vkCmdCopyBuffer(commands, output.handle(), host.frame.output.handle(), 1, &back);
  });
  EXPECT_TRUE(same_bits(host.vertices(), expected));
}

// Residuals are made from the points each time, so that nothing adds up.
TEST_F(EmbedEdit, ThousandsOfEditsKeepTheTolerance) {
  const PolygonMesh mesh = in_floats(test::torus(24, 14, 2, 0.7));
  EditHost host(*context_, *submitter_, mesh);
  PolygonMesh moved = mesh;
  HostCommands commands(*own_);
  commands.record([&](VkCommandBuffer buffer) {
    host.record(buffer, {.iterations = 24, .stop_error = host.stop_error});
  });
  std::mt19937 random(2);
  std::uniform_int_distribution<std::uint32_t> any(0, 24 * 14 - 1);
  std::uniform_real_distribution<float> way(-0.03f, 0.03f);
  for (int i = 0; i < 2000; ++i) {
    const std::uint32_t v = any(random);
    const glm::vec3 to =
        glm::vec3(mesh.positions[v]) + glm::vec3(way(random), way(random), way(random));
    moved.positions[v] = glm::dvec3(to);
    host.set_point(static_cast<std::int32_t>(v), to);
    host.list({v}, 1);
    commands.submit();
    commands.wait();
    ASSERT_EQ(host.status().state, SolveState::Converged) << i;
  }
  EXPECT_LT(difference(host.vertices(), surface_by_cpu(moved, mesh, {})).distance,
            (1e-6 + kSinglesError) * host.system().diagonal());
  host.solve_all(true);
  EXPECT_EQ(host.status().iterations, 0u) << host.status().residual;
}

// Recording cannot fail; the host hears of it, once for each call.
TEST_F(EmbedEdit, WithoutAListAHostIsTold) {
  std::vector<std::string> lines;
  bool throws = false;
  HostDevice host = own_->host_device();
  host.log = [&](std::string_view line) {
    lines.emplace_back(line);
    if (throws) throw Error(ErrorCode::Cancelled, "of the host's log");
  };
  Context context(host);
  const System system(test::icosphere(1));
  const DeviceSystem tables(context, system, {.takes_edits = true});
  const Buffer list(context, 4096, MemoryUse::Device), points(context, 4096, MemoryUse::Device);
  const vulkan::Solve none(context, tables, {.given = {points.handle()}}),
      one(context, tables, {.further_slots = {{.moved = {list.handle(), 0, 9}}}});
  HostCommands commands(*own_);
  commands.record([&](VkCommandBuffer buffer) {
    const auto told = [&](const auto& record) {
      lines.clear();
      const std::map<std::string, int> before = PretendedDriver::counts();
      record();
      EXPECT_EQ(PretendedDriver::counts() == before, !lines.empty());
      return lines;
    };
    for (const bool is_thrown : {false, true}) {
      throws = is_thrown;
      const auto no_list = ElementsAre(
          "planish: record_edit does nothing, as its slot has no list; set SolveOptions::moved, or "
          "FrameSlot::moved");
      EXPECT_THAT(told([&] { none.record_edit(buffer, {}); }), no_list);
      EXPECT_THAT(told([&] { one.record_edit(buffer, {.slot = 0}); }), no_list);
      EXPECT_THAT(told([&] { none.record_reach(buffer, list.handle(), 0); }),
                  ElementsAre(HasSubstr("record_reach does nothing")));
      EXPECT_THAT(told([&] { none.record_given(buffer, list.handle(), 0); }),
                  ElementsAre(HasSubstr("record_given does nothing")));
    }
    EXPECT_THAT(told([&] { one.record_reach(buffer, list.handle(), 0); }), IsEmpty());
    EXPECT_THAT(told([&] { one.record_given(buffer, points.handle(), 0); }), IsEmpty());
  });
}

TEST_F(EmbedEdit, WhatCannotBeHadIsRefusedByName) {
  const PolygonMesh mesh = test::icosphere(1);
  const DeviceSystemOptions edits{.takes_edits = true};
  using enum ErrorCode;
  expect_refusal(InvalidArgument, "edits are of the progressive method",
                 [&] { topology_of(mesh, {.method = InterpolationMethod::Fair}, edits); });
  expect_refusal(InvalidArgument, "edits take surfaces through their points",
                 [&] { topology_of(mesh, {.within = 0.01}, edits); });
  {
    const HostTopology plain = topology_of(mesh), editable = topology_of(mesh, {}, edits);
    const Buffer list(*context_, 4096, MemoryUse::Device);
    struct Row {
      const HostTopology& of;
      MovedPoints moved;
      const char* words;
    };
    for (const Row& row :
         {Row{plain, {list.handle(), 0, 9}, "make it with takes_edits"},
          Row{editable, {list.handle()}, "max_count of 0"},
          Row{editable, {list.handle(), 6, 9}, "begins at 6, which is no multiple of 4"}})
      expect_refusal(
          InvalidArgument, row.words,
          [&] { const vulkan::Solve solve(*context_, row.of.device, {.moved = row.moved}); },
          "Pipeline");
  }
  // 4,800 corners' points of level 1; rows of 1,271 vertices.
  const System sheet(test::flat_grid(40, 30), {.level = 0});
  const auto expect_limit = [&](std::uint32_t range, const std::string& words) {
    PretendedDriver::pretence().storage_range = range;
    open();
    const Buffer moves(*context_, 4096, MemoryUse::Device);
    expect_refusal(
        OutOfMemory, words,
        [&] {
          const DeviceSystem cut(*context_, sheet, {24, false, true});
          const vulkan::Solve solve(*context_, cut, {.moved = {moves.handle(), 0, 9}});
        },
        "Pipeline");
  };
  expect_limit(80000,
               "points of level 1 take 81280 bytes of one binding, but "
               "maxStorageBufferRange is 80000");
  expect_limit(85000, "the limit masks are in 2 slices, edits take one");
}

// Edits with several frames in flight: each slot's vertices are those that a Solve of one slot has
// after the same edits, whatever slots took them.

// Slots of a Solve beside the EditHost's own, made on the same tables.
class SlotsOfEdits {
 public:
  SlotsOfEdits(Context& context, const OwnDevice& device, EditHost& host, int count)
      : host_(host),
        count_(count),
        frames_(context, device, host.topology, count, host.frame.instances, kMostMoves) {
    solve_all();
  }

  // All points, as the host has them; then each slot's vertices.
  void solve_all() {
    for (int i = 0; i < count_; ++i) put(frames_.done(i).frame.points, host_.frame.points.mapped());
    host_.submitter.run([&](VkCommandBuffer commands) {
      frames_.solve().record_solve(commands, stopping(60, host_.stop_error));
      for (int i = 0; i < count_; ++i)
        frames_.solve().record_evaluate(commands, {.slot = static_cast<std::uint32_t>(i)});
    });
  }
  // Points are those of the EditHost, which holds the list, too; earlier edits may still run.
  void edit(int number) {
    FramesInFlight::Slot& of_frame = frames_.done(number);
    put(of_frame.frame.points, host_.frame.points.mapped());
    put(of_frame.moves, host_.moves.mapped());
    frames_.submit(number, [&](VkCommandBuffer commands, FramesInFlight::Slot& slot) {
      frames_.solve().record_edit(commands, {.iterations = 40,
                                             .stop_error = host_.stop_error,
                                             .slot = static_cast<std::uint32_t>(number)});
      frames_.solve().record_reach(commands, slot.frame.report.handle(), slot.frame.reach_offset());
    });
  }
  std::vector<Vertex> vertices(int number, std::uint32_t instance = 0) {
    return frames_.done(number).frame.vertices(instance);
  }
  EditReach reach(int number) { return frames_.done(number).frame.reach(); }

 private:
  EditHost& host_;
  int count_;
  FramesInFlight frames_;
};

class EmbedEditSlots : public Embedding {
 protected:
  // Moves a vertex of an instance and lists it.
  static void move(EditHost& host, const PolygonMesh& mesh, std::uint32_t vertex,
                   std::uint32_t instance, float way) {
    const glm::vec3 rest(mesh.positions[vertex]);
    host.set_point(static_cast<std::int32_t>(vertex),
                   rest + way * glm::vec3(std::sin(7.0f * rest.x), 1, std::cos(5.0f * rest.y)),
                   instance);
    host.list({instance * static_cast<std::uint32_t>(mesh.positions.size()) + vertex}, 1);
  }
};

// In turn, as frames are, and in any order.
TEST_F(EmbedEditSlots, VerticesAreThoseOfOneSlot) {
  std::vector<test::NamedMesh> meshes = {
      {"torus", test::torus(30, 20, 1, 0.4)},
      {"creased", test::with_random_creases(test::random_open_mesh(2), 0.1, 3)}};
  meshes.push_back(large_rings().front());
  with_both_variants([&] {
    for (const auto& [name, mesh] : meshes)
      for (const int count : {2, 3}) {
        SCOPED_TRACE(name + " " + std::to_string(count));
        EditHost host(*context_, *submitter_, mesh);
        SlotsOfEdits slots(*context_, *own_, host, count);
        std::mt19937 random(3);
        std::vector<std::vector<Vertex>> expected(static_cast<std::size_t>(count));
        for (int i = 0; i < 18; ++i) {
          const int slot = i < 9 ? i % count : static_cast<int>(random() % unsigned(count));
          const auto used = host.system().used_vertices();
          move(host, mesh, static_cast<std::uint32_t>(used[random() % used.size()]), 0, 0.05f);
          slots.edit(slot);
          host.edit();
          expected[slot] = host.vertices();
          // One that is older: as it was when its edit was done.
          const int other = (slot + 1) % count;
          if (!expected[other].empty() && i % 3 == 2) {
            EXPECT_TRUE(same_bits(slots.vertices(other), expected[other])) << i;
          }
          if (i % 2 == 1) {
            EXPECT_TRUE(same_bits(slots.vertices(slot), host.vertices())) << i;
          }
        }
      }
  });
}

TEST_F(EmbedEditSlots, InstancesHaveThem) {
  const PolygonMesh mesh = test::torus(12, 7, 2, 0.7);
  EditHost host(*context_, *submitter_, mesh, {}, 3);
  SlotsOfEdits slots(*context_, *own_, host, 2);
  for (int i = 0; i < 9; ++i) {
    move(host, mesh, static_cast<std::uint32_t>(11 * i) % 84, static_cast<std::uint32_t>(i) % 3,
         0.05f);
    slots.edit(i);
    host.edit();
    for (std::uint32_t k = 0; k < 3; ++k)
      EXPECT_TRUE(same_bits(slots.vertices(i, k), host.vertices(k))) << i << " " << k;
  }
}

// What a slot has not yet got costs once, and what all have got nothing.
TEST_F(EmbedEditSlots, StalePatchesAreEvaluatedOnce) {
  const PolygonMesh mesh = test::torus(60, 30, 1, 0.4);
  EditHost host(*context_, *submitter_, mesh);
  SlotsOfEdits slots(*context_, *own_, host, 3);
  move(host, mesh, 900, 0, 0.01f);
  slots.edit(0);
  const EditReach first = slots.reach(0);
  EXPECT_GT(first.patches, 0u);
  host.list({}, 0);
  for (const int slot : {1, 2}) {
    slots.edit(slot);
    EXPECT_EQ(slots.reach(slot).patches, first.patches) << slot;
    EXPECT_EQ(slots.reach(slot).points, first.points) << slot;
    EXPECT_EQ(slots.reach(slot).listed, 0u);
  }
  for (const int slot : {0, 1, 2}) {
    slots.edit(slot);
    EXPECT_EQ(slots.reach(slot).patches, 0u) << slot;
  }
  // The same place twice is stale once; the second edit finds all as it should be.
  move(host, mesh, 900, 0, 0.02f);
  slots.edit(0);
  const EditReach moved = slots.reach(0);
  slots.edit(0);
  EXPECT_LT(slots.reach(0).patches, moved.patches);
  host.list({}, 0);
  slots.edit(1);
  EXPECT_EQ(slots.reach(1).patches, moved.patches);
  EXPECT_TRUE(same_bits(slots.vertices(1), slots.vertices(0)));
}

TEST_F(EmbedEditSlots, SolvesForgetWhatWasStale) {
  const PolygonMesh mesh = test::torus(30, 20, 1, 0.4);
  EditHost host(*context_, *submitter_, mesh);
  SlotsOfEdits slots(*context_, *own_, host, 2);
  move(host, mesh, 100, 0, 0.1f);
  slots.edit(0);
  slots.solve_all();
  host.list({}, 0);
  slots.edit(1);
  EXPECT_EQ(slots.reach(1).patches, 0u);
  EXPECT_TRUE(same_bits(slots.vertices(1), slots.vertices(0)));
}

}  // namespace
}  // namespace planish::testing
