#include "planish/job/page/page.h"
#include "planish/core/counted.h"
#include "planish/core/number_text.h"

#include <algorithm>
#include <map>
#include <span>

#include "page_files.h"
#include "planish/core/assert.h"
#include "planish/core/formatted.h"
#include "planish/core/version.h"
#include "planish/job/digest.h"
#include "planish/job/page/page_coding.h"
#include "planish/job/page/page_section.h"
#include "planish/job/page/page_text.h"
#include "planish/job/text.h"

namespace planish {
namespace {

using Json = nlohmann::ordered_json;

// What a browser compares an inline script or style with before it takes it.
std::string csp_hash(std::string_view text) {
  return "'sha256-" + base64_text(sha256_bytes(std::as_bytes(std::span(text)))) + "'";
}

std::string content_security() {
  return formatted(
      "default-src 'none'; script-src {}; style-src {}; img-src data: blob:; base-uri 'none'; "
      "form-action 'none'; require-trusted-types-for 'script'",
      csp_hash(kPageScript), csp_hash(kPageStyle));
}

void replace_all(std::string& text, const std::string& old, const std::string& fresh) {
  for (std::size_t at = text.find(old); at != std::string::npos;
       at = text.find(old, at + fresh.size())) {
    text.replace(at, old.size(), fresh);
  }
}

// A page is mailed round, and absolute paths name who made it.
void make_relative(Json& value, const std::filesystem::path& folder) {
  if (value.is_structured()) {
    for (Json& entry : value) make_relative(entry, folder);
  } else if (value.is_string()) {
    std::string text = value.get<std::string>();
    replace_all(text, (folder / "").string(), "");
    if (const std::filesystem::path path = text; path.is_absolute())
      text = path.lexically_relative(folder).string();
    value = text;
  }
}

// The report as the page has it: paths relative, times only where they are wanted.
Json shown_report(const PageJob& job, const PageOptions& options,
                  const std::filesystem::path& folder) {
  Json report = job.report;
  if (!options.times) {
    report.erase("timing_ms");
    report.erase("memory");
  }
  if (!report["argv"].empty()) report["argv"][0] = "planish";
  make_relative(report, folder);
  return report;
}

// Of each job the level that is shown; -1: none.
using ChosenLevels = std::vector<int>;

std::size_t scene_bytes(const PageJob& job, int level) {
  if (level < 0) return 0;
  const PagePayload& payload = job.payloads[level];
  return payload.packed.size() + payload.head.dump().size() + job.still.size();
}

ChosenLevels choose_levels(std::span<const PageJob> jobs, std::size_t words_bytes,
                           std::uint64_t limit) {
  ChosenLevels levels;
  std::size_t sum = words_bytes;
  for (const PageJob& job : jobs) {
    levels.push_back(static_cast<int>(job.payloads.size()) - 1);
    sum += scene_bytes(job, levels.back());
  }
  while (sum > limit) {
    std::size_t largest = 0;
    for (std::size_t j = 1; j < jobs.size(); ++j) {
      if (scene_bytes(jobs[j], levels[j]) > scene_bytes(jobs[largest], levels[largest]))
        largest = j;
    }
    if (levels.empty() || levels[largest] < 0) break;
    sum -= scene_bytes(jobs[largest], levels[largest]);
    sum += scene_bytes(jobs[largest], --levels[largest]);
  }
  return levels;
}

std::string view_note(const PageJob& job, int level, const PageOptions& options) {
  if (job.payloads.empty()) return "The view leaves this job out: its surface is too large.";
  const int deepest = job.payloads.back().level;
  if (level < 0)
    return "The view leaves this job out: even level 0 is larger than the page may be (" +
           byte_size(options.limit_bytes) + "; --page-limit raises it).";
  const std::string shown = formatted("The view shows level {}", job.payloads[level].level);
  const int larger = level + 1 < static_cast<int>(job.payloads.size()) ? deepest : deepest + 1;
  if (larger > kPageLevel) return shown + ".";
  return shown + ", because level " + std::to_string(larger) + " is larger than the page may be (" +
         byte_size(options.limit_bytes) + "; --page-limit raises it).";
}

std::string scene_blocks(const Json& report, const PagePayload& payload, std::size_t number) {
  Json head = {{"job", number},
               {"name", report["job"]},
               {"label", job_label(report)},
               {"tolerance", report["solve"]["tolerance"]}};
  head.update(payload.head);
  return "<script type=\"application/json\" class=\"head\">" + script_json(visible_json(head)) +
         "</script>\n<script type=\"application/octet-stream\" class=\"payload\">" +
         payload.packed + "</script>\n";
}

// Names that two jobs share get numbers, so that they can be told apart where they are compared.
void number_names(std::vector<Json>& reports) {
  std::map<std::string, int> seen;
  for (Json& report : reports) {
    if (report.is_null()) continue;
    const std::string name = report["job"].get<std::string>();
    if (const int before = seen[name]++; before > 0)
      report["job"] = formatted("{} ({})", name, before + 1);
  }
}

std::string status_of(std::span<const PageJob> jobs, std::string_view kind) {
  const auto bad = std::ranges::count_if(jobs, [](const PageJob& job) {
    return !job.failure.empty() || !job.report["solve"]["converged"].get<bool>();
  });
  if (bad > 0)
    return formatted("{} of {}{}", bad, counted(std::ssize(jobs), kind),
                     bad == 1 ? " has failed or not converged" : " have failed or not converged");
  return jobs.size() > 1 ? "all converged" : "";
}

using Places = std::map<std::string, std::string, std::less<>>;

std::string filled(std::string_view form, const Places& places) {
  std::string out;
  while (true) {
    const std::size_t open = form.find("{{"), close = form.find("}}");
    if (open == std::string_view::npos) return out.append(form);
    const auto place = places.find(form.substr(open + 2, close - open - 2));
    PLANISH_ASSERT(place != places.end());
    out.append(form.substr(0, open)).append(place->second);
    form.remove_prefix(close + 2);
  }
}

}  // namespace

std::string_view page_script() { return kPageScript; }
std::string_view page_style() { return kPageStyle; }

std::string make_page(std::span<const PageJob> jobs, const PageOptions& options,
                      const std::filesystem::path& folder, const std::string& title,
                      std::string_view kind) {
  std::vector<Json> reports;
  for (const PageJob& job : jobs)
    reports.push_back(job.failure.empty() ? shown_report(job, options, folder) : Json());
  number_names(reports);

  const auto page_with = [&](const ChosenLevels& levels) {
    Places places;
    for (std::size_t j = 0; j < jobs.size(); ++j) {
      if (reports[j].is_null()) {
        Json message = jobs[j].failure;
        make_relative(message, folder);
        places["rows"] += failed_row_html(jobs[j].name, j);
        places["jobs"] += failed_section(jobs[j].name, message.get<std::string>(), j);
        continue;
      }
      places["rows"] += overview_row(reports[j], j);
      places["jobs"] += job_section(reports[j], j, view_note(jobs[j], levels[j], options),
                                    levels[j] >= 0 ? jobs[j].still : std::string());
      if (levels[j] >= 0)
        places["scenes"] += scene_blocks(reports[j], jobs[j].payloads[levels[j]], j);
    }
    places["jobs"];
    places["rows"];
    places["scenes"];
    places["security"] = content_security();
    places["style"] = kPageStyle;
    places["script"] = kPageScript;
    const bool alone = jobs.size() == 1;
    places["title"] = alone           ? html_text(reports[0].is_null() ? jobs[0].name
                                                                       : reports[0]["job"].get<std::string>())
                      : title.empty() ? counted(std::ssize(jobs), kind)
                                      : html_text(title);
    places["kind"] = kind;
    places["overview"] = alone ? "hidden" : "";
    places["time"] = options.times ? "<th scope=\"col\">time" : "";
    places["status"] = status_of(jobs, kind);
    places["tool"] = "planish " PLANISH_VERSION;
    return filled(kPageForm, places);
  };
  // The words are needed to know how much room they leave.
  const std::string words = page_with(ChosenLevels(jobs.size(), -1));
  const ChosenLevels levels =
      choose_levels(jobs, words.size() + 1024 * jobs.size(), options.limit_bytes);
  return page_with(levels);
}

}  // namespace planish
