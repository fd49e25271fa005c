#include "planish/job/page/trial.h"

#include <string_view>

#include "page_files.h"
#include "planish/core/words.h"
#include "planish/job/job_text.h"
#include "planish/job/page/page.h"
#include "planish/job/page/sheet.h"

namespace planish {
namespace {

constexpr std::string_view kTaken = " <span class=\"pill good\">taken by default</span>";

std::string number_of(double number, int digits) { return html_text(fixed(number, digits)); }

std::string card_html(const TrialCard& card, std::size_t number) {
  const TriedSurface& tried = card.tried;
  std::string html =
      formatted("<li><a class=\"card\" href=\"#keep{}\" data-job=\"{}\">", number, number);
  if (!tried.picture.empty())
    html += formatted(
        "<img width=\"{}\" height=\"{}\" alt=\"The surface: {}\" "
        "src=\"data:image/png;base64,{}\">",
        kTriedWidth, kTriedWidth * 2 / 3, html_text(tried.title), tried.picture);
  html += "<strong>" + html_text(tried.title) + "</strong>";
  if (tried.is_taken) html += kTaken;
  if (!tried.failure.empty()) return html + "<span class=\"bad\">failed</span></a>";
  const SheetRow row = sheet_row(tried.report);
  if (tried.is_measured)
    html += formatted("<span>cost {}</span><span>{}</span>", number_of(tried.cost.sum(), 2),
                      tried.folded > 0 ? "folds " + html_text(percent(tried.folded)) : "no folds");
  if (row.is_measured)
    html += formatted("<span>normals {}\u00b0 off</span>", number_of(row.normals, 1));
  html += formatted("<span>{}</span>", html_text(byte_size(row.bytes)));
  if (!row.converged) html += "<span class=\"bad\">not converged</span>";
  return html + "</a>";
}

// A row of the cost table.
std::string cost_row_html(const TrialCard& card, std::size_t number) {
  const TriedSurface& tried = card.tried;
  std::string html =
      formatted("<tr data-job=\"{}\"><th scope=\"row\"><a href=\"#job{}\">{}</a>{}", number, number,
                html_text(tried.title), tried.is_taken ? kTaken : "");
  if (!tried.failure.empty()) return html + "<td colspan=\"8\">failed: " + html_text(tried.failure);
  if (!tried.is_measured) return html + "<td colspan=\"8\">other meshes of the file have a surface";
  const CostTerms& cost = tried.cost;
  html += "<td class=\"n\"><strong>" + number_of(cost.sum(), 3) + "</strong>";
  for (const double term : {cost.bending, cost.folds, cost.doubt, cost.by_lot, cost.missed})
    html += "<td class=\"n\">" + (term == 0 ? std::string("0") : number_of(term, 3));
  return html + formatted("<td class=\"n\">{}<td class=\"n\">{}", html_text(figure(tried.bending)),
                          html_text(percent(tried.folded)));
}

std::string text_to_copy(const std::string& text) {
  return formatted(
      "<p class=\"text\"><button type=\"button\" class=\"copy\">Copy</button></p>"
      "<pre tabindex=\"0\">{}</pre>",
      html_lines(text));
}

std::string keep_html(const TrialCard& card, std::size_t number) {
  if (!card.tried.failure.empty()) return {};
  return formatted(
      "<section class=\"keep\" id=\"keep{}\" data-keep=\"{}\"><h2>Keep: {}</h2>{}"
      "<details><summary>As a scene file, for planish run</summary>{}</details></section>",
      number, number, html_text(card.tried.title), text_to_copy(card.command),
      text_to_copy(card.scene));
}

}  // namespace

std::string make_trial_page(std::vector<TrialCard> cards, const PageOptions& options,
                            const std::filesystem::path& folder, const std::string& name,
                            const std::string& reason) {
  std::string list, rows, keeps;
  std::vector<PageJob> jobs;
  for (TrialCard& card : cards) {
    card.tried.failure = relative_to(folder, card.tried.failure);
    const std::size_t number = jobs.size();
    list += card_html(card, number) + "\n";
    rows += cost_row_html(card, number) + "\n";
    keeps += keep_html(card, number) + "\n";
    jobs.push_back(std::move(card.tried.page));
  }
  const std::string why = reason.empty() ? "" : "Without flags it takes the first: " + reason + ".";
  const PageLead lead{
      .html =
          filled_form(kTrialForm, {{"cards", list}, {"keeps", keeps}, {"reason", html_text(why)}}),
      .below = filled_form(kTrialTable, {{"rows", rows}}),
      .style = kTrialStyle,
      .script = kTrialScript};
  return make_page(jobs, options, folder, name, "surface", &lead);
}

}  // namespace planish
