// Edits with several frames in flight: each slot's vertices are those that a Solve of one slot has
// after the same edits, whatever slots took them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <list>
#include <optional>
#include <random>

#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/edit_host.h"
#include "vulkan/large_rings.h"

namespace planish::testing {
namespace {

using namespace vulkan;

// Slots of a Solve beside the EditHost's own, made on the same tables.
class SlotsOfEdits {
 public:
  SlotsOfEdits(Context& context, const OwnDevice& device, EditHost& host, int count) : host_(host) {
    for (int i = 0; i < count; ++i) slots_.emplace_back(context, device, host);
    SolveOptions options;
    options.instances = host.instances;
    for (const Slot& slot : slots_)
      options.further_slots.push_back(
          {{slot.points.handle()}, {slot.output.handle()}, {slot.moves.handle(), 0, kMostMoves}});
    options.given = options.further_slots[0].given;
    options.vertices = options.further_slots[0].vertices;
    options.moved = options.further_slots[0].moved;
    options.further_slots.erase(options.further_slots.begin());
    solve_.emplace(context, host.tables, options);
    solve_all();
  }
  ~SlotsOfEdits() {
    for (Slot& slot : slots_) slot.wait();
  }
  SlotsOfEdits(const SlotsOfEdits&) = delete;
  SlotsOfEdits& operator=(const SlotsOfEdits&) = delete;

  // All points, as the host has them; then each slot's vertices.
  void solve_all() {
    SolveParameters parameters = iterations(60);
    parameters.stop_error = host_.stop_error;
    for (Slot& slot : slots_) {
      slot.wait();
      std::ranges::copy(host_.points.mapped(), slot.points.mapped().begin());
      slot.points.flush();
    }
    host_.submitter.run([&](VkCommandBuffer commands) {
      solve_->record_solve(commands, parameters);
      for (std::uint32_t i = 0; i < slots_.size(); ++i)
        solve_->record_evaluate(commands, {.slot = i});
    });
  }
  // Points are those of the EditHost, which holds the list, too; earlier edits may still run.
  void edit(int number) {
    Slot& slot = at(number);
    slot.wait();
    std::ranges::copy(host_.points.mapped(), slot.points.mapped().begin());
    std::ranges::copy(host_.moves.mapped(), slot.moves.mapped().begin());
    slot.points.flush();
    slot.moves.flush();
    slot.commands.record([&](VkCommandBuffer commands) {
      solve_->record_edit(commands, {.iterations = 40,
                                     .stop_error = host_.stop_error,
                                     .slot = static_cast<std::uint32_t>(number)});
      solve_->record_reach(commands, slot.report.handle(), 0);
    });
    slot.commands.submit();
    slot.is_under_way = true;
  }
  std::vector<Vertex> vertices(int number, std::uint32_t instance = 0) {
    Slot& slot = at(number);
    slot.wait();
    slot.output.invalidate();
    std::vector<Vertex> result(static_cast<std::size_t>(host_.system.vertex_count()));
    const std::size_t bytes = result.size() * sizeof(Vertex);
    std::memcpy(result.data(), slot.output.mapped().data() + instance * bytes, bytes);
    return result;
  }
  EditReach reach(int number) {
    Slot& slot = at(number);
    slot.wait();
    slot.report.invalidate();
    EditReach result;
    std::memcpy(&result, slot.report.mapped().data(), sizeof result);
    return result;
  }

 private:
  struct Slot {
    Slot(Context& context, const OwnDevice& device, const EditHost& host)
        : points(context, host.points.size(), MemoryUse::Upload),
          output(context, host.output.size(), MemoryUse::Download),
          moves(context, host.moves.size(), MemoryUse::Upload),
          report(context, sizeof(EditReach), MemoryUse::Download),
          commands(device) {}
    void wait() {
      if (is_under_way) commands.wait();
      is_under_way = false;
    }
    Buffer points, output, moves, report;
    HostCommands commands;
    bool is_under_way = false;
  };
  Slot& at(int number) {
    return *std::next(slots_.begin(), number % static_cast<int>(slots_.size()));
  }

  EditHost& host_;
  std::list<Slot> slots_;
  std::optional<vulkan::Solve> solve_;
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
          const auto used = host.system.used_vertices();
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
