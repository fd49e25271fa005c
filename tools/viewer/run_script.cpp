#include "run_script.h"

#include <cmath>

#include "edit_hand.h"
#include "planish/core/error.h"
#include "planish/core/refuse.h"
#include "planish/files/image/png.h"

namespace planish::viewer {
namespace {

class ScriptRun {
 public:
  ScriptRun(EditSession& session, Headless& headless, const SaveOptions& save)
      : session_(session), headless_(headless), save_(save), hand_(session) {}

  void run(const ScriptStep& step) {
    where_ = step.where;
    std::visit([&](const auto& what) { act(what); }, step.what);
  }
  [[nodiscard]] int frames() const { return frames_; }

 private:
  [[nodiscard]] float aspect() const {
    const VkExtent2D extent = headless_.options().extent;
    return static_cast<float>(extent.width) / static_cast<float>(extent.height);
  }
  [[nodiscard]] glm::vec2 place(const glm::vec2& pixel) const {
    const VkExtent2D extent = headless_.options().extent;
    return (pixel + 0.5f) / glm::vec2(extent.width, extent.height);
  }
  [[nodiscard]] const OrbitCamera& camera() const { return headless_.options().camera; }
  [[nodiscard]] static std::string text_of(const glm::vec2& pixel) {
    return formatted("{} {}", std::lround(pixel.x), std::lround(pixel.y));
  }
  void show() {
    headless_.show(session_, Headless::Solved::On);
    ++frames_;
  }

  void act(const steps::Pick& step) {
    if (!hand_.press(camera(), aspect(), place(step.pixel), step.adds))
      refuse(where_, "no vertex is under pixel " + text_of(step.pixel));
    hand_.release();
  }
  void act(const steps::Select& step) { session_.select(step.vertices); }
  void act(const steps::Radius& step) { session_.set_radius(step.length); }
  void act(const steps::Move& step) {
    session_.begin_drag();
    for (int i = 1; i <= step.frames; ++i) {
      session_.drag_to(step.way * (static_cast<double>(i) / step.frames));
      show();
    }
    session_.end_drag();
  }
  void act(const steps::Drag& step) {
    if (!hand_.press(camera(), aspect(), place(step.from), false))
      refuse(where_, "no vertex is under pixel " + text_of(step.from));
    for (int i = 1; i <= step.frames; ++i) {
      const float part = static_cast<float>(i) / static_cast<float>(step.frames);
      hand_.drag(camera(), aspect(), place(step.from + part * (step.to - step.from)));
      show();
    }
    hand_.release();
  }
  void act(const steps::Crease& step) { session_.toggle_crease(step.v0, step.v1); }
  void act(const steps::CreaseAt& step) {
    if (!hand_.toggle_crease(camera(), aspect(), place(step.pixel)))
      refuse(where_, "no edge is under pixel " + text_of(step.pixel));
  }
  void act(const steps::Corner& step) { session_.toggle_corner(step.vertex); }
  void act(const steps::Undo& step) {
    for (int i = 0; i < step.count; ++i)
      if (!session_.undo()) refuse(where_, "there is nothing left to take back");
  }
  void act(const steps::Redo& step) {
    for (int i = 0; i < step.count; ++i)
      if (!session_.redo()) refuse(where_, "there is nothing left to do again");
  }
  void act(const steps::Frames& step) {
    for (int i = 0; i < step.count; ++i) show();
  }
  void act(const steps::Picture& step) {
    // From a cold start, so that the same points are the same picture, whatever was before.
    headless_.show(session_, Headless::Solved::Anew);
    ++frames_;
    write_png(step.path, static_cast<int>(headless_.options().extent.width), headless_.picture());
  }
  void act(const steps::Save& step) { save(session_, step.part, step.path, save_); }

  EditSession& session_;
  Headless& headless_;
  const SaveOptions& save_;
  EditHand hand_;
  std::string where_;
  int frames_ = 0;
};

}  // namespace

int run_script(std::span<const ScriptStep> script, EditSession& session, Headless& headless,
               const SaveOptions& save) {
  ScriptRun run(session, headless, save);
  for (const ScriptStep& step : script) {
    try {
      run.run(step);
    } catch (const Error& error) {
      const std::string what = error.what();
      if (what.starts_with(step.where)) throw;
      throw Error(error.code(), step.where + ": " + what, error.element());
    }
  }
  return run.frames();
}

}  // namespace planish::viewer
