#include "headless.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <utility>

#include "edit_session.h"
#include "overlay.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/files/images.h"

namespace planish::viewer {
namespace {

constexpr float kFontHeight = 600;  // of the picture for which ImGui's font has its own size

int font_scale(VkExtent2D extent) {
  return std::max(1,
                  static_cast<int>(std::lround(static_cast<float>(extent.height) / kFontHeight)));
}

}  // namespace

Headless::Headless(const Device& device, Scene scene, const HeadlessOptions& options)
    : device_(device),
      options_(options),
      pass_(make_render_pass(device, {kPictureFormat, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL})),
      image_(device, {kPictureFormat, options.extent, VK_SAMPLE_COUNT_1_BIT,
                      VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                      VK_IMAGE_ASPECT_COLOR_BIT}),
      targets_(device, pass_, kPictureFormat, options.extent, std::array{image_.view()}),
      overlay_(device, pass_, font_scale(options.extent)),
      renderer_(device, pass_, std::move(scene)) {
  if (options.settings.tessellate) device.demand_tessellation();
}

void Headless::draw(VkCommandBuffer commands) {
  overlay_.begin(options_.extent);
  if (options_.settings.heat && renderer_.status())
    draw_legend("largest " +
                error_text(renderer_.status()->residual / renderer_.system().diagonal()) +
                " after " + solve_text(scene().system.method, renderer_.status()->iterations));
  if (shown_)
    draw_selection(*shown_, options_.camera, {options_.extent.width, options_.extent.height});
  targets_.begin(commands, 0);
  renderer_.draw(commands, options_.camera, options_.extent, options_.settings);
  overlay_.record(commands);
  vkCmdEndRenderPass(commands);
}

void Headless::run(int frames) {
  for (int i = 0; i < frames; ++i) {
    renderer_.prepare(options_.settings.level);
    draw(renderer_.begin_frame(next_frame_++ / kFramesPerSecond, options_.settings));
    renderer_.end_frame();
  }
  renderer_.finish();
}

void Headless::show(const EditSession& session, Solved solved) {
  shown_ = &session;
  if (session.revision() != revision_) {
    renderer_.set_mesh(session.rest());
    revision_ = session.revision();
  }
  ViewSettings settings = options_.settings;
  if (solved == Solved::Anew) {
    settings.warm_start = false;
    settings.iterations = kMostIterations;
  }
  renderer_.prepare(settings.level);
  draw(renderer_.begin_frame(session.points(), settings));
  renderer_.end_frame();
  renderer_.finish();
}

std::vector<std::uint8_t> Headless::picture() {
  const Buffer copy = picture_buffer(device_, options_.extent);
  // Once more, now that the status of the last frame is known.
  const VkCommandBuffer commands = renderer_.begin_redraw();
  draw(commands);
  copy_picture(commands, image_, options_.extent, copy);
  renderer_.end_frame();
  renderer_.finish();
  return rgb_of(copy);
}

std::vector<SurfaceVertex> Headless::vertices() const {
  std::vector<SurfaceVertex> result(renderer_.system().vertex_count());
  const std::size_t bytes = result.size() * sizeof(SurfaceVertex);
  const Buffer copy(device_, bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, Place::Host);
  device_.run([&](VkCommandBuffer commands) {
    const VkBufferCopy region{0, 0, bytes};
    vkCmdCopyBuffer(commands, renderer_.vertices(), copy, 1, &region);
    host_barrier(commands);
  });
  std::memcpy(result.data(), copy.mapped().data(), bytes);
  return result;
}

namespace {

constexpr int kMostScriptFrames = 10000, kMostScriptSteps = 100000;

// The words of a line, from the second on, as what a step wants.
class ScriptWords {
 public:
  ScriptWords(const std::string& line, std::string where) : where_(std::move(where)) {
    std::istringstream stream(line);
    for (std::string word; stream >> word;) words_.push_back(word);
  }
  [[nodiscard]] const std::string& where() const { return where_; }
  [[nodiscard]] bool done() const { return next_ == words_.size(); }
  [[nodiscard]] bool take(std::string_view word) {
    if (done() || words_[next_] != word) return false;
    ++next_;
    return true;
  }
  std::string word(const char* wanted) {
    if (done()) refuse(where_, std::string(wanted) + " is wanted");
    return words_[next_++];
  }
  double number(const char* wanted) {
    const std::string text = word(wanted);
    double value = 0;
    if (!parse_number(text, value)) refuse(where_, "{} is wanted, not '{}'", wanted, text);
    return value;
  }
  std::int32_t count(const char* wanted, std::int32_t least, std::int32_t most) {
    const double value = number(wanted);
    if (value != std::floor(value) || value < least || value > most)
      refuse(where_, "{} from {} to {} is wanted, not {}", wanted, least, most, words_[next_ - 1]);
    return static_cast<std::int32_t>(value);
  }
  std::int32_t count_or_one(const char* wanted, std::int32_t most) {
    return done() ? 1 : count(wanted, 1, most);
  }
  std::int32_t vertex() { return count("a vertex", 0, INT32_MAX); }
  glm::vec2 pixel() {
    const double x = number("a pixel's x");
    return {x, number("a pixel's y")};
  }
  // What is left of the line: names may have spaces.
  std::string path() {
    std::string text = word("a file");
    while (!done()) text += " " + words_[next_++];
    return text;
  }
  void end() const {
    if (!done()) refuse(where_, "'" + words_[next_] + "' is too much");
  }

 private:
  std::string where_;
  std::vector<std::string> words_;
  std::size_t next_ = 0;
};

SavedPart saved_part(ScriptWords& words) {
  if (words.take("mesh")) return SavedPart::Mesh;
  if (words.take("cage")) return SavedPart::Cage;
  if (words.take("surface")) return SavedPart::Surface;
  refuse(words.where(), "mesh, cage or surface is wanted, then a file");
}

decltype(ScriptStep::what) step_of(ScriptWords& words) {
  if (words.take("pick")) {
    steps::Pick step{words.pixel()};
    step.adds = words.take("add");
    return step;
  }
  if (words.take("vertices")) {
    steps::Select step;
    do step.vertices.push_back(words.vertex());
    while (!words.done());
    return step;
  }
  if (words.take("radius")) return steps::Radius{words.number("a length")};
  if (words.take("move")) {
    steps::Move step;
    for (int k = 0; k < 3; ++k) step.way[k] = words.number("a way of three numbers");
    step.frames = words.count_or_one("a number of frames", kMostScriptFrames);
    return step;
  }
  if (words.take("drag")) {
    steps::Drag step{words.pixel(), {}};
    step.to = words.pixel();
    step.frames = words.count_or_one("a number of frames", kMostScriptFrames);
    return step;
  }
  if (words.take("crease")) {
    if (words.take("at")) return steps::CreaseAt{words.pixel()};
    const std::int32_t v0 = words.vertex();
    return steps::Crease{v0, words.vertex()};
  }
  if (words.take("corner")) return steps::Corner{words.vertex()};
  if (words.take("undo"))
    return steps::Undo{words.count_or_one("a number of steps", kMostScriptSteps)};
  if (words.take("redo"))
    return steps::Redo{words.count_or_one("a number of steps", kMostScriptSteps)};
  if (words.take("frames")) return steps::Frames{words.count("how many", 1, kMostScriptFrames)};
  if (words.take("picture")) return steps::Picture{words.path()};
  if (words.take("save")) {
    const SavedPart part = saved_part(words);
    return steps::Save{part, words.path()};
  }
  refuse(words.where(),
         "'" + words.word("a step") + "' is no step; planish-viewer --help lists them");
}

}  // namespace

std::vector<ScriptStep> parse_script(std::string_view text, const std::string& name) {
  std::vector<ScriptStep> result;
  std::istringstream stream{std::string(text)};
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    line = line.substr(0, line.find('#'));
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    ScriptWords words(line, formatted("{}:{}", name, number));
    ScriptStep step{words.where(), step_of(words)};
    words.end();
    result.push_back(std::move(step));
  }
  if (result.empty()) refuse(name, "has no step; planish-viewer --help lists them");
  return result;
}

std::vector<ScriptStep> read_script(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text(std::istreambuf_iterator<char>(file), {});
  if (!file.is_open() || file.bad())
    throw Error(ErrorCode::UnreadableInput, path + ": cannot be read");
  return parse_script(text, path);
}

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
