#include <gtest/gtest.h>
#include <openssl/sha.h>

#include <array>
#include <cmath>
#include <limits>
#include <regex>
#include <set>
#include <sstream>

#include "page/page_reader.h"
#include "planish/job/job_text.h"
#include "planish/job/page/page.h"
#include "planish/job/page/page_scene.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "support/meshes.h"

namespace planish {
namespace {

TEST(PageText, WhatCannotBeSeenIsMadeVisible) {
  for (const auto& [text, shown] : std::initializer_list<std::pair<const char*, const char*>>{
           {"a\x1b[31mb\n\t", "a\\u001b[31mb\\u000a\\u0009"},
           {"\u202e\u200b\ufeff\u2028\u00ad\u0085", "\\u202e\\u200b\\ufeff\\u2028\\u00ad\\u0085"},
           {"\U000e0041", "\\u{e0041}"},
           {"gr\u00fc\u00dfe \u4e2d \U0001f600", "gr\u00fc\u00dfe \u4e2d \U0001f600"},
           // No UTF-8.
           {"a\xff\xc3", "a\\xff\\xc3"},
           {"\xc0\x80", "\\xc0\\x80"},                     // overlong
           {"\xed\xa0\x80", "\\xed\\xa0\\x80"},            // a surrogate
           {"\xf4\x90\x80\x80", "\\xf4\\x90\\x80\\x80"}})  // beyond Unicode
    EXPECT_EQ(visible_text(text), shown);
  const nlohmann::ordered_json value = {{"a\u202e", {1, "b\u200b", {{"c", "\x07"}}}}};
  EXPECT_EQ(visible_json(value).dump(), R"({"a\\u202e":[1,"b\\u200b",{"c":"\\u0007"}]})");
}

TEST(PageText, HtmlHasNoMarkupLeft) {
  EXPECT_EQ(html_text("\"><script>'`&"), "&#34;&#62;&#60;script&#62;&#39;&#96;&#38;");
  EXPECT_EQ(html_lines("a<\nb"), "a&#60;\nb");
  EXPECT_EQ(html_text("a\nb"), "a\\u000ab");
}

TEST(PageText, JsonCannotEndItsElement) {
  const nlohmann::ordered_json value = {{"</script>", "<!--&\u2028"}};
  const std::string text = script_json(value);
  EXPECT_EQ(text.find_first_of("<>&"), std::string::npos);
  EXPECT_EQ(nlohmann::ordered_json::parse(text), value);
}

TEST(PageText, WordsOfACommandAreQuoted) {
  EXPECT_EQ(shell_word("out/a-b_c.glb"), "out/a-b_c.glb");
  EXPECT_EQ(shell_word(""), "''");
  EXPECT_EQ(shell_word("a b"), "'a b'");
  EXPECT_EQ(shell_word("`$(id)`'"), "'`$(id)`'\\'''");
}

TEST(PageText, FiguresHaveThreeDigits) {
  EXPECT_EQ(figure(1.9949e-7), "1.99e-07");
  EXPECT_EQ(figure(0.35349), "0.353");
  EXPECT_EQ(figure(999.9), "1,000");
  EXPECT_EQ(figure(-69741.0), "-69,700");
  EXPECT_EQ(figure(1.5e6), "1.5e+06");
  EXPECT_EQ(figure(std::numeric_limits<double>::infinity()), "not finite");
  EXPECT_EQ(figure(nlohmann::ordered_json()), "not finite");
}

using test::between;

// A report as fit writes it; the schema's own test keeps its keys.
nlohmann::ordered_json report_named(const std::string& name) {
  return nlohmann::ordered_json::parse(R"({
    "schema": "planish.report/1", "tool": {"name": "planish", "version": "0.1.0", "git": "abc"},
    "argv": ["/usr/bin/planish", "fit", "in put.obj"], "job": "job", "exit_code": 0,
    "input": {"path": "in put.obj", "sha256": "00ff", "format": "obj", "vertices": 8194,
              "faces": 6, "face_sizes": {"4": 6}, "boundary_loops": 0, "components": 1,
              "genus": 0, "sharp_edges": 0, "corners": 0, "welded": 0, "dropped": 0,
              "separated_edges": 0, "changed_faces": []},
    "device": {"kind": "cpu", "name": "2 threads", "uuid": "", "driver": "", "api": ""},
    "solve": {"method": "progressive", "scheme": "doo-sabin", "weights": "doo-sabin",
              "solver": "chebyshev", "boundary": "edge", "creases": "use", "repair": "safe",
              "weld": null, "tolerance": 1e-6, "converged": true, "stop_reason": "converged", "iterations": 2,
              "spectral_bound": 0.3, "error": {"max": 3.4812e-7, "rms": 1.2e-7, "worst_vertex": 3},
              "history": [{"iteration": 0, "max": 0.01, "rms": 0.005},
                          {"iteration": 1, "max": 0.0001, "rms": null},
                          {"iteration": 2, "max": 3.4812e-7, "rms": 1.2e-7}],
              "fair": null},
    "surface": {"level": 2, "reference": "input", "folded_area": 0.00104,
                "rms_normal_deviation": 6.3012, "max_normal_deviation": 41.5, "bending": 69712.0,
                "sheet_gap": null},
    "outputs": [{"path": "out.glb", "what": "surface", "bytes": 2202009, "sha256": "0a0b",
                 "level": 2, "vertices": 131074, "quads": 131072, "triangles": 262144,
                 "as_written_error": 4e-8}],
    "timing_ms": {"read": 1.5, "check": 0.5, "solve": 12.04, "total": 14.04},
    "memory": {"host_peak_bytes": 73400320, "device_bytes": 0}, "warnings": []})")
      .patch({{{"op", "replace"}, {"path", "/job"}, {"value", name}}});
}

std::vector<PagePayload> payloads_of(const PolygonMesh& mesh) {
  const SurfaceMesh surface = evaluate(mesh, *make_cpu_backend(), {.level = 2});
  const PageScene scene = make_page_scene({surface, mesh, mesh, {}, 2.0, 1});
  std::vector<PagePayload> payloads;
  for (int level = 0; level <= 2; ++level) payloads.push_back(encode_scene(scene, level));
  return payloads;
}

PageJob job_named(const std::string& name) {
  return {name, "", report_named(name), payloads_of(test::prism(5))};
}

std::string page_of(std::vector<PageJob> jobs, const PageOptions& options = {}) {
  return make_page(jobs, options, "/home/someone/work");
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++count;
  return count;
}

TEST(Page, ScriptAndStyleKeepTheirBudget) {
  EXPECT_LE(page_script().size() + page_style().size(), 52'000u);
  EXPECT_GT(page_script().size(), 10'000u);
}

// What the browser compares: the text between the tags, to the byte.
TEST(Page, HashesAreThoseOfScriptAndStyle) {
  const std::string page = page_of({job_named("a")});
  const auto hash_of = [](const std::string& text) {
    std::array<std::uint8_t, 32> digest{};
    SHA256(reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest.data());
    return "'sha256-" + base64_text(digest) + "'";
  };
  const std::string policy = between(page, "Content-Security-Policy\" content=\"", "\"");
  const std::string script = between(page, "\n<script>", "</script>");
  EXPECT_EQ(script, page_script());
  EXPECT_NE(policy.find("script-src " + hash_of(script) + ";"), std::string::npos) << policy;
  EXPECT_NE(policy.find("style-src " + hash_of(between(page, "<style>", "</style>")) + ";"),
            std::string::npos);
  EXPECT_TRUE(policy.starts_with("default-src 'none';"));
  EXPECT_EQ(policy.find("unsafe"), std::string::npos);
}

TEST(Page, NothingIsLoadedFromElsewhere) {
  std::string page = page_of({job_named("a")});
  page = std::regex_replace(page, std::regex("http://www.w3.org/2000/svg"), "");
  for (const char* part : {"http:", "https:", "//cdn", "@import", "<link", "<img", "<iframe",
                           " src=", "url(h", "innerHTML", "eval("}) {
    EXPECT_EQ(page.find(part), std::string::npos) << part;
  }
}

// Lines of this text, what is no UTF-8, and words with a mark between.
constexpr const char* kHostileLines = R"("><script>alert(1)</script>
</title><script>alert(1)</script>
' onmouseover='alert(1)
" autofocus onfocus="alert(1)
</script><script>alert(1)</script>
<!--<script>
-->
]]>
&lt;script&gt;
&#x3c;script>
`$(id)`
$(touch x)
a;rm -rf b
it's
{{script}}
{{jobs}}
javascript:alert(1)
<svg/onload=alert(1)>
<img src=x onerror=alert(1)>
\u003cscript>
constructor
__proto__
%00%3Cscript%3E)";

std::vector<std::string> hostile_names() {
  std::vector<std::string> names{"\xff\xfe", "\xc0\xbcscript", "\xed\xa0\x80"};
  std::istringstream lines(kHostileLines);
  for (std::string line; std::getline(lines, line);) names.push_back(line);
  for (const char* mark :
       {"\x01",   "\x07",   "\b",     "\t",     "\n",     "\r",        "\x1b[31m",
        "\x7f",   "\u0085", "\u061c", "\u200b", "\u200e", "\u2028",    "\u2029",
        "\u202a", "\u202e", "\u2066", "\u2069", "\ufeff", "\U000e0001"})
    names.push_back("left" + std::string(mark) + "right");
  return names;
}

// A job of this name everywhere that a name can stand.
PageJob hostile_job(const std::string& name) {
  PageJob job = job_named(name);
  for (const char* place : {"/input/path", "/device/name", "/device/driver", "/surface/reference",
                            "/solve/stop_reason", "/outputs/0/path", "/tool/git"})
    job.report[nlohmann::ordered_json::json_pointer(place)] = name;
  job.report["argv"].push_back(name);
  job.report["warnings"].push_back({{"code", name}, {"message", name}, {"count", 2}, {"first", 0}});
  job.report["solve"]["converged"] = false;
  return job;
}

TEST(Page, NamesBecomeNeitherMarkupNorInvisible) {
  const std::string plain = page_of({hostile_job("plain"), {.name = "x", .failure = "plain"}});
  ASSERT_GE(hostile_names().size(), 40u);
  for (const std::string& name : hostile_names()) {
    SCOPED_TRACE(visible_text(name));
    std::string page = page_of({hostile_job(name), {.name = name, .failure = name}});
    // As many elements as with a harmless name, and not one attribute more.
    for (const char* part : {"<", "<script", "</script", "<svg", "<img", "<!--"})
      EXPECT_EQ(count_of(page, part), count_of(plain, part)) << part;
    const std::regex handler("<[^>]* on[a-z]+=");
    EXPECT_FALSE(std::regex_search(page.substr(0, page.find("<script")), handler));
    std::erase(page, '\n');
    EXPECT_EQ(visible_text(page), page);
    EXPECT_EQ(nlohmann::json::parse(between(page, "class=\"head\">", "</script>"))["name"],
              visible_text(name));
  }
}

TEST(Page, TheCommandCanBeRepeatedAndPathsAreRelativeToTheFolder) {
  EXPECT_NE(page_of({job_named("a")}).find("planish fit &#39;in put.obj&#39;"), std::string::npos);
  PageJob job = job_named("a");
  job.report["argv"] = {"/opt/planish", "fit", "/home/someone/work/sub/in.obj", "-o",
                        "/data/x.glb"};
  job.report["input"]["path"] = "/home/someone/work/sub/in.obj";
  job.report["warnings"].push_back({{"code", "w"},
                                    {"message", "/home/someone/work/sub/in.obj: odd"},
                                    {"count", 1},
                                    {"first", -1}});
  const std::string page =
      page_of({job, {.name = "b", .failure = "/home/someone/work/b.obj: cannot read"}});
  for (const char* part : {"planish fit sub/in.obj -o ../../../data/x.glb", "sub/in.obj: odd",
                           ">b.obj: cannot read", "1 of 2 jobs has failed"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  for (const char* part : {"someone", "/opt"})
    EXPECT_EQ(page.find(part), std::string::npos) << part;
}

TEST(Page, TheLargestLevelThatFitsIsShown) {
  const auto level_of = [](const std::string& page) {
    const std::string head = between(page, "class=\"head\">", "</script>");
    return head.empty() ? -1 : nlohmann::json::parse(head)["level"].get<int>();
  };
  const std::string whole = page_of({job_named("a")});
  EXPECT_EQ(level_of(whole), 2);
  EXPECT_EQ(whole.find("--page-limit"), std::string::npos);
  int last = 2;
  std::set<int> seen;
  for (std::size_t limit = whole.size() + 2000; limit > 40'000; limit -= 500) {
    const std::string page = page_of({job_named("a")}, {.limit_bytes = limit});
    const int level = level_of(page);
    EXPECT_LE(level, last);
    EXPECT_TRUE(level < 0 || page.size() <= limit);
    EXPECT_EQ(level < 2, page.find("--page-limit") != std::string::npos);
    // The figures never go.
    EXPECT_NE(page.find("3.48e-07 of the diagonal"), std::string::npos);
    last = level;
    seen.insert(level);
  }
  EXPECT_TRUE(seen.contains(2) && seen.contains(-1));
}

TEST(Page, TimesCanBeLeftOut) {
  PageJob slow = job_named("a");
  slow.report["timing_ms"]["total"] = 99;
  slow.report["memory"]["host_peak_bytes"] = 1;
  EXPECT_NE(page_of({slow}), page_of({job_named("a")}));
  EXPECT_EQ(page_of({slow}, {.times = false}), page_of({job_named("a")}, {.times = false}));
}

// The colour of a step is the same on every page, and no other step's.
TEST(Page, StepsHaveColoursOfTheirOwn) {
  PageJob job = job_named("a");
  auto& timing = job.report["timing_ms"] = to_json(JobReport{})["timing_ms"];
  for (auto& [step, milliseconds] : timing.items()) milliseconds = 1.0;
  timing["check"] = 0.0;  // what took no time has no part of the bar
  const std::string page = page_of({job});
  const std::string style(page_style()), bar = between(page, "<svg class=\"bar\"", "</svg>");
  std::set<std::string> colours;
  for (const auto& [step, milliseconds] : timing.items()) {
    if (step == "total") continue;
    const std::string colour = between(style, ".t-" + step + " { fill: ", ";");
    EXPECT_TRUE(colours.insert(colour).second) << step << " " << colour;
    EXPECT_EQ(count_of(bar, "class=\"t-" + step + "\""), step == "check" ? 0u : 1u) << step;
  }
}

TEST(Page, JobsOfOneNameAreNumbered) {
  const std::string page = page_of({job_named("a"), job_named("a")});
  EXPECT_NE(page.find("a (2), progressive"), std::string::npos);
}

// Every number that a report holds, also inside its texts.
std::vector<double> numbers_in(const std::string& text) {
  std::vector<double> numbers;
  const std::regex form("[0-9][0-9,]*(\\.[0-9]+)?(e[+-]?[0-9]+)?");
  for (std::sregex_iterator at(text.begin(), text.end(), form), end; at != end; ++at) {
    std::string digits = at->str();
    std::erase(digits, ',');
    numbers.push_back(std::stod(digits));
  }
  return numbers;
}

std::string words_of(const std::string& page) {
  std::string words = between(page, "<div id=\"figures\">", "</main>");
  for (const char* element : {"svg", "pre", "code", "h2", "summary"})
    words = std::regex_replace(
        words, std::regex("<" + std::string(element) + "[ >](.|\\n)*?</" + element + ">"), " ");
  return std::regex_replace(std::regex_replace(words, std::regex("<[^>]*>"), " "),
                            std::regex("&#[0-9]+;"), " ");
}

// Each figure is that of its label: no two numbers of the report are alike.
TEST(Page, EveryFigureStandsBesideItsLabel) {
  PageJob job = job_named("a");
  job.report["input"].update(nlohmann::ordered_json{
      {"boundary_loops", 2}, {"components", 3}, {"genus", 5}, {"sharp_edges", 7}, {"corners", 9}});
  const std::string page = page_of({job});
  for (const auto& [label, value] : std::initializer_list<std::pair<const char*, const char*>>{
           {"file", "in put.obj (obj)"},
           {"vertices, faces", "8,194, 6"},
           {"faces by corners", "4: 6"},
           {"boundary loops, parts, genus", "2, 3, 5"},
           {"sharp edges, corners", "7, 9"},
           {"method", "progressive, doo-sabin (doo-sabin weights), chebyshev, 2 iterations"},
           {"error, rms and largest", "1.2e-07, 3.48e-07 of the diagonal"},
           {"folded area", "0.104 %"},
           {"bending, of level 1", "69,700"},
           {"measured on level", "2"},
           {"device", "cpu, 2 threads"},
           {"memory", "70.0 MiB"},
           {"planish", "0.1.0 (abc)"}}) {
    EXPECT_EQ(between(page, "<tr><th scope=\"row\">" + std::string(label) + "<td>", "<"),
              std::string(value))
        << label;
  }
  EXPECT_NE(page.find("rms and largest<td>6.3, 41.5 degrees"), std::string::npos);
  EXPECT_NE(page.find("out.glb<td>surface, level 2<td class=\"n\">131,074<td class=\"n\">2.1 MiB"),
            std::string::npos);
  EXPECT_NE(page.find("solve 12 ms</title>"), std::string::npos);
}

// Numbers are the report's, rounded to what is shown, as they are or in per cent, KiB, MiB or s.
TEST(Page, EveryNumberIsTheReports) {
  const PageJob job = job_named("a");
  const std::vector<double> known = numbers_in(job.report.dump());
  const std::vector<double> shown = numbers_in(words_of(page_of({job})));
  EXPECT_GT(shown.size(), 40u);
  for (const double number : shown) {
    // SHA-256 is the name of a sum, iterations are counted from 0.
    if (number == 256) continue;
    bool found = false;
    for (const double value : known) {
      for (const double unit : {1.0, 100.0, 1.0 / 1024, 1.0 / 1048576, 1e-3})
        found = found || std::abs(value * unit - number) <= 0.006 * std::abs(number) + 1e-300;
    }
    EXPECT_TRUE(found) << number;
  }
}

}  // namespace
}  // namespace planish
