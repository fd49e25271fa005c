#include "legend.h"

#include <imgui.h>

#include <cstdio>

#include "planish/core/formatted.h"
#include "shared.h"

namespace planish::viewer {
namespace {

constexpr ImU32 kInk = IM_COL32(30, 34, 42, 255), kPaper = IM_COL32(255, 255, 255, 205);
constexpr const char* kTitle = "distance from given points / diagonal";

ImU32 stop_colour(std::size_t stop) {
  const glm::vec3& colour = shared::kHeatStops[stop];
  return ImGui::ColorConvertFloat4ToU32({colour.x, colour.y, colour.z, 1});
}

}  // namespace

std::string error_text(double relative_error) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1e", relative_error);
  return text;
}

std::string solve_text(InterpolationMethod method, std::uint32_t iterations) {
  if (method == InterpolationMethod::Fair) return "the fair method";
  return std::to_string(iterations) + (iterations == 1 ? " iteration" : " iterations");
}

void draw_legend(const std::string& line) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float em = ImGui::GetFontSize(), pad = 0.8f * em, bar_height = 1.1f * em;
  const float width = 24 * em;
  const float height = 2 * pad + bar_height + 4.3f * em;
  const float left = em, top = ImGui::GetIO().DisplaySize.y - em - height;
  list.AddRectFilled({left, top}, {left + width + 2 * pad, top + height}, kPaper, 0.5f * em);
  const float x = left + pad;
  float y = top + pad;
  list.AddText({x, y}, kInk, kTitle);
  y += 1.4f * em;
  const float step = width / static_cast<float>(shared::kHeatStopCount - 1);
  for (std::size_t i = 0; i + 1 < shared::kHeatStopCount; ++i) {
    const float from = x + step * static_cast<float>(i);
    list.AddRectFilledMultiColor({from, y}, {from + step, y + bar_height}, stop_colour(i),
                                 stop_colour(i + 1), stop_colour(i + 1), stop_colour(i));
  }
  y += bar_height;
  const int lowest = static_cast<int>(shared::kHeatLowest);
  const int decades = static_cast<int>(shared::kHeatHighest) - lowest;
  for (int i = 0; i <= decades; ++i) {
    const std::string text = formatted("1e{}", lowest + i);
    const float at = x + width * static_cast<float>(i) / static_cast<float>(decades);
    const float text_width = ImGui::CalcTextSize(text.c_str()).x;
    // Inside the bar's ends, centred between them.
    const float shift = text_width * static_cast<float>(i) / static_cast<float>(decades);
    list.AddLine({at, y}, {at, y + 0.35f * em}, kInk);
    list.AddText({at - shift, y + 0.35f * em}, kInk, text.c_str());
  }
  list.AddText({x, y + 1.6f * em}, kInk, line.c_str());
}

}  // namespace planish::viewer
