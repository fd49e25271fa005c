#include "panel.h"

#include <imgui.h>

#include "legend.h"

namespace planish::viewer {

namespace {

EditClicks draw_edit_tools(EditSession& session, float em) {
  EditClicks clicks;
  auto part = static_cast<float>(100 * session.radius() / session.diagonal());
  ImGui::PushItemWidth(12 * em);
  // Above the slider's range keys go on.
  if (ImGui::SliderFloat("falloff", &part, 0, 50, part > 0 ? "%.1f %%" : "none"))
    session.set_radius(part / 100 * session.diagonal());
  ImGui::PopItemWidth();
  clicks.undoes = ImGui::Button("undo");
  ImGui::SameLine();
  clicks.redoes = ImGui::Button("redo");
  ImGui::SameLine();
  clicks.saves = ImGui::Button("save");
  ImGui::Text("%zu selected, within %s of the diagonal", session.selected().size(),
              error_text(session.editor().error_bound()).c_str());
  return clicks;
}

}  // namespace

EditClicks draw_panel(const Renderer& renderer, const PanelFacts& facts, ViewSettings& settings,
                      EditSession* session, bool& edits) {
  const float em = ImGui::GetFontSize();
  ImGui::SetNextWindowPos({em, em}, ImGuiCond_FirstUseEver);
  ImGui::Begin("planish", nullptr, ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::PushItemWidth(12 * em);
  ImGui::SliderInt("level", &settings.level, 0, kMostLevel, "%d", ImGuiSliderFlags_AlwaysClamp);
  const bool iterates = renderer.scene().system.method == InterpolationMethod::Progressive;
  if (iterates)
    ImGui::SliderInt("iterations", &settings.iterations, 0, kMostIterations, "%d",
                     ImGuiSliderFlags_AlwaysClamp);
  ImGui::PopItemWidth();
  if (iterates) {
    ImGui::Checkbox("warm start", &settings.warm_start);
    ImGui::SameLine();
  }
  ImGui::Checkbox("pause", &settings.paused);
  ImGui::Checkbox("surface", &settings.surface);
  ImGui::SameLine();
  ImGui::Checkbox("cage", &settings.cage);
  ImGui::SameLine();
  ImGui::Checkbox("points", &settings.points);
  ImGui::SameLine();
  ImGui::Checkbox("errors", &settings.heat);
  if (renderer.scene().system.textured) {
    ImGui::SameLine();
    ImGui::Checkbox("texture", &settings.texture);
  }
  ImGui::Checkbox("edit", &edits);
  if (facts.tessellates) {
    ImGui::SameLine();
    ImGui::Checkbox("tessellation", &settings.tessellate);
  }
  const EditClicks clicks = session && edits ? draw_edit_tools(*session, em) : EditClicks{};
  ImGui::Separator();
  const vulkan::System& system = renderer.system();
  ImGui::Text("%s: %d points", renderer.scene().name.c_str(), system.given_count());
  if (!settings.draws_patches()) {
    ImGui::SameLine(0, 0);
    ImGui::Text(", %zu triangles", system.triangles().size() / 3);
  }
  if (renderer.status()) {
    const double error = renderer.status()->residual / system.diagonal();
    ImGui::Text("error %s of the diagonal", error_text(error).c_str());
  }
  ImGui::Text("%.0f frames/s, %s", static_cast<double>(facts.frames_per_second),
              facts.device.c_str());
  if (!facts.problem.empty()) ImGui::TextWrapped("%s", facts.problem.c_str());
  ImGui::End();
  return clicks;
}

}  // namespace planish::viewer
