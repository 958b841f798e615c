// The report's page, opened in a browser.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "../engine/temporary_folder.h"
#include "browser.h"
#include "catch.h"
#include "text_of.h"

using namespace tandem;
using namespace tandem::bench;
using nlohmann::json;

namespace {

struct Finished {
  int status;
  std::string text;  // both streams
};

Finished run(const TemporaryFolder& folder, const std::string& command) {
  const auto out = folder / "said";
  const int status = std::system(("cd " + (folder / ".").string() + " && " + command + " > said 2>&1").c_str());
  return {WEXITSTATUS(status), text_of(out)};
}

Finished report(const TemporaryFolder& folder, const std::string& files) {
  return run(folder, TANDEM_BENCH_PATH " report " + files + " -o page.html");
}

void write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

json row(const char* bench, const char* workload, const char* contestant, int threads, double ns, const json& more) {
  json out{{"bench", bench},
           {"workload", workload},
           {"contestant", contestant},
           {"threads", threads},
           {"n", 100},
           {"samples", 5},
           {"median_ns", ns},
           {"p10_ns", 0.9 * ns},
           {"p90_ns", 1.2 * ns},
           {"hash", "0123456789abcdef"}};
  out.update(more);
  return out;
}

json result(const json& rows) {
  return {{"version", 1},
          {"machine", {{"cpu", "a cpu"}, {"cores", 2}, {"compiler", "g++"}, {"versions", {{"oneTBB", "2021.8"}}}}},
          {"rows", rows}};
}

json series(const char* contestant, bool strict, double speedup) {
  const json decision{{"step", 1},
                      {"action", "change"},
                      {"reason", "broad is longer"},
                      {"before", "2-2"},
                      {"after", "3-1"},
                      {"control_step", 2},
                      {"broad_ms", 2.0},
                      {"narrow_ms", 1.0},
                      {"measure", 1.0},
                      {"measure_before", 2.0}};
  json confirmed = decision;
  confirmed.update({{"step", 2}, {"action", "confirm"}, {"before", "3-1"}});
  json out{{"contestant", contestant}, {"sum_ms", 6 / speedup},  {"speedup", speedup},
           {"over_oracle", 1.01},      {"strict_split", strict}, {"ms", {2, 3, 1}}};
  if (!strict) out["broad_threads"] = {2, 3, 3}, out["decisions"] = json::array({decision, confirmed});
  return out;
}

/// Small results of every bench, with a few rows each. Used where there is a browser to open the report.
[[maybe_unused]] void write_results(const TemporaryFolder& folder) {
  write(folder / "scenes.json",
        result({row("scenes", "cubes-on-plane", "sequential", 1, 4e6, {{"ratio_to_sequential", 1.0}, {"steps", 9}}),
                row("scenes", "cubes-on-plane", "flowgraph", 2, 2e6,
                    {{"ratio_to_sequential", 2.0},
                     {"ratio_of_sums", 1.9},
                     {"steps", 9},
                     {"serial_share", 0.025},
                     {"serial_us", {{"begin", 3}, {"update", 0.5}, {"broad", 30}, {"join", 16.5}}}}),
                row("scenes", "cubes-on-plane", "a contestant of tomorrow", 2, 2e6, json::object())})
            .dump());
  json accuracy = json::array();
  for (const char* contestant : {"tandem", "FCL"}) {
    const bool wrong = std::string(contestant) == "FCL";
    accuracy.push_back(row("narrowphase", "box-box/near/distance", contestant, 1, wrong ? 900 : 60,
                           {{"kind", "box-box"},
                            {"class", "near"},
                            {"request", "distance"},
                            {"error_p50", 0.0},
                            {"error_p99", wrong ? 1e-6 : 0.0},
                            {"error_max", 1e-5},
                            {"wrong", wrong ? 3 : 0},
                            {"failed", 0},
                            {"wrong_normals", 0},
                            {"unmeasured", 0},
                            {"worst", {{"id", "box-box/near/7"}}}}));
  }
  write(folder / "narrowphase.json", result(accuracy).dump());
  write(folder / "peers.json", result({row("peers", "9-cubes", "tandem", 1, 1e6, {{"pairs", 100}}),
                                       row("peers", "9-cubes", "Bullet, double", 1, 3e6,
                                           {{"pairs", 90}, {"pairs_missed", 10}, {"pairs_extra", 0}}),
                                       row("a bench of tomorrow", "9-cubes", "somebody", 3, 1, {{"surprise", {1, 2}}})})
                                   .dump());
  write(folder / "broadphase.json",
        result({row("broadphase", "W1", "tandem auto", 1, 1e5, {{"cpu_mean_ns", 1e5}, {"agrees", true}, {"pairs", 5}}),
                row("broadphase", "W1", "FCL tree", 1, 9e5, {{"cpu_mean_ns", 9e5}, {"agrees", true}, {"pairs", 5}}),
                row("broadphase", "needles", "tandem auto", 1, 3e5,
                    {{"cpu_mean_ns", 3e5}, {"agrees", true}, {"pairs", 5}})})
            .dump());
  json figures =
      result(json::array({row("figures", "tori-and-cubes", "flowgraph", 2, 1e6, {{"step", 0}, {"figure", "7"}})}));
  json picture{{"workload", "tori-and-cubes"},    {"bodies", 100},          {"threads", 4},      {"simulated", true},
               {"figures", {"3", "5", "6", "7"}}, {"oracle_ms", {2, 3, 1}}, {"oracle_sum_ms", 6}};
  picture["series"] = {series("flowgraph", false, 3.5), series("strict, paper rule", false, 2.5),
                       series("strict 1-3", true, 1.5), series("strict 2-2", true, 2)};
  figures["pictures"] = {picture,
                         {{"workload", "cubes-on-plane"},
                          {"bodies", 100},
                          {"threads", 2},
                          {"simulated", false},
                          {"figures", {"4"}},
                          {"ms", {1, 2, 3}},
                          {"mode", {"sequential", "flowgraph", "flowgraph"}}}};
  write(folder / "figures.json", figures.dump());
  const Finished made = run(folder, TANDEM_PROGRAM_PATH
                            " run cubes-on-plane --bodies 60 --steps 30 --threads 2 "
                            "--record replay.record --json replay.jsonl --trace timeline.json");
  INFO(made.text);
  REQUIRE(made.status == 0);
}

const std::string all_files =
    "scenes.json narrowphase.json peers.json broadphase.json figures.json replay.record replay.jsonl timeline.json";

}  // namespace

TEST_CASE("report: bad input gets one line that says what, where and what is allowed") {
  const TemporaryFolder folder;
  const std::string good = result(json::array({row("scenes", "s", "sequential", 1, 1, json::object())})).dump();
  write(folder / "good.json", good);
  REQUIRE(report(folder, "good.json").status == 0);

  json other = json::parse(good), no_rows = other, no_time = other, text_time = other;
  other["version"] = 2;
  no_rows["rows"] = json::array();
  no_time["rows"][0].erase("median_ns");
  text_time["rows"][0]["median_ns"] = "fast";
  const struct {
    std::string text, says;
  } bad[] = {
      {good.substr(0, good.size() / 2), "bad.json: /rows/0/contestant: byte 134"},
      {"", "bad.json: empty, allowed: a result of tandem-bench"},
      {" \n", "bad.json: empty, allowed: a result of tandem-bench"},
      {other.dump(), "bad.json: /version: 2, allowed: 1"},
      {no_rows.dump(), "bad.json: /rows: [], allowed: at least one row"},
      {no_time.dump(), "bad.json: /rows/0/median_ns: missing"},
      {text_time.dump(), "bad.json: /rows/0/median_ns: \"fast\", allowed: "},
      {R"({"id":"a","shapeA":{"kind":"sphere","radius":1},"ask":["distance"]})",
       "bad.json: pair records, allowed: a result of tandem-bench"},
      {"{\"step\":0,\"contacts\":[]}\n", "bad.json: what --contacts wrote, allowed: "},
      {"{\"shapes\":{},\"gravity\":[0,0,0]}", "bad.json: a scene file, allowed: "},
      {"# Words", "bad.json: no JSON, allowed: "},
      {"\x1f\x8b\x08", "bad.json: a .gz file that is damaged or cut off"},
      {"{\"name\":1}", "bad.json: document: {\"name\":1}, allowed: a result of tandem-bench"},
      {"{\"traceEvents\":[]}", "bad.json: /traceEvents: [], allowed: slices"},
      {R"({"traceEvents":[{"ph":"X","pid":0,"tid":0,"name":"a","ts":1e308,"dur":1,"args":{"step":0,"pairs":1}}]})",
       "bad.json: /traceEvents/0/ts: 1e+308, allowed: microseconds, at most 1e18 in size"},
      {R"({"traceEvents":[{"ph":"X","pid":0,"tid":0,"name":"a","ts":0,"dur":1e300,"args":{"step":0,"pairs":1}}]})",
       "bad.json: /traceEvents/0/dur: 1e+300, allowed: microseconds, at most 1e18 in size"},
      {"{\"step\":0,\"candidate", "bad.json: line 1: /step: byte 21"},
      {"{\"step\":0}\n", "bad.json: line 1: /candidate_pairs: missing"},
      {"{\"format\":\"tandem-record\",\"version\":2,\"scene\":{}}\n", "bad.json: /version: 2, allowed: 1"},
      {"{\"format\":\"tandem-record\",\"version\":1,\"scene\":{\"bodies\":[]", "bad.json: /scene/bodies: byte 59"},
      {std::string("\0\xff\x7f", 3), "bad.json: a binary file, allowed: "}};
  for (const auto& [text, says] : bad) {
    write(folder / "bad.json", text);
    std::filesystem::remove(folder / "page.html");
    const Finished done = report(folder, "good.json bad.json");
    INFO(text << "\n" << done.text);
    CHECK(done.status == 2);
    CHECK_THAT(done.text, Catch::StartsWith("tandem-bench: ") && Catch::Contains(says));
    CHECK(std::count(done.text.begin(), done.text.end(), '\n') == 1);
    CHECK(!std::filesystem::exists(folder / "page.html"));
  }
  CHECK(report(folder, "missing.json").status == 2);
  CHECK(run(folder, TANDEM_BENCH_PATH " report good.json").status == 2);
  CHECK(run(folder, TANDEM_BENCH_PATH " report -o page.html").status == 2);
  CHECK(run(folder, TANDEM_BENCH_PATH " report good.json -o page.html --frames 1").status == 2);
}

TEST_CASE("report: results come from a pipe too, a recording from a file only") {
  const TemporaryFolder folder;
  write(folder / "good.json", result(json::array({row("scenes", "s", "sequential", 1, 1, json::object())})).dump());
  CHECK(run(folder, "cat good.json | " TANDEM_BENCH_PATH " report /dev/stdin -o page.html").status == 0);
  write(folder / "a.record", R"({"format":"tandem-record","version":1,"scene":{}})"
                             "\n");
  const Finished piped = run(folder, "cat a.record | " TANDEM_BENCH_PATH " report /dev/stdin -o page.html");
  CHECK(piped.status == 2);
  CHECK_THAT(piped.text, Catch::Contains("/dev/stdin: a recording in a pipe, allowed: one in a file"));
  const Finished endless = run(folder, "yes | " TANDEM_BENCH_PATH " report /dev/stdin -o page.html");
  CHECK(endless.status == 2);
  CHECK_THAT(endless.text, Catch::StartsWith("tandem-bench: /dev/stdin: a pipe, device or growing file that goes on"));
}

TEST_CASE("report: a record that ends within a step is refused with the byte") {
  const TemporaryFolder folder;
  REQUIRE(run(folder, TANDEM_PROGRAM_PATH " run cubes-on-plane --bodies 5 --steps 3 --record whole.record").status ==
          0);
  const std::string whole = text_of(folder / "whole.record");
  write(folder / "cut.record", whole.substr(0, whole.size() - 7));
  const Finished cut = report(folder, "cut.record");
  CHECK(cut.status == 2);
  CHECK_THAT(cut.text, Catch::Contains("cut.record: byte " + std::to_string(whole.size() - 7)));
  write(folder / "none.record", whole.substr(0, whole.find('\n') + 1));
  const Finished none = report(folder, "none.record");
  CHECK(none.status == 2);
  CHECK_THAT(none.text, Catch::Contains("none.record: a record without a step"));
}

TEST_CASE("report: a record whose steps have other bodies than the first is refused") {
  const TemporaryFolder folder;
  REQUIRE(run(folder, TANDEM_PROGRAM_PATH " run cubes-on-plane --bodies 5 --steps 2 --record whole.record").status ==
          0);
  std::string bytes = text_of(folder / "whole.record");
  // The last body of the last step, by its four bytes: those of the plane, which is body 0, in the place of the first.
  const std::size_t step = bytes.rfind("STEP");
  const std::size_t first = step + 28;
  REQUIRE(bytes.compare(first, 4, std::string("\x01\0\0\0", 4)) == 0);
  bytes[first] = '\0';
  write(folder / "other.record", bytes);
  const Finished other = report(folder, "other.record");
  CHECK(other.status == 2);
  CHECK_THAT(other.text, Catch::Contains("other.record: step 1: body 0, allowed: body 1 as in the first step"));
}

TEST_CASE("report: the page in a browser") {
#ifndef TANDEM_CHROMIUM
  TANDEM_SKIP("no Chromium was found when the tests were configured: the page is not opened");
#else
  const TemporaryFolder folder;
  write_results(folder);
  const Finished made = report(folder, all_files);
  INFO(made.text);
  REQUIRE(made.status == 0);
  CHECK(std::filesystem::file_size(folder / "page.html") < 15'000'000);

  Browser browser(TANDEM_CHROMIUM, folder / "profile");
  browser.open("file://" + (folder / "page.html").string());
  const bool ready = browser.wait_for("document.documentElement?.dataset.ready !== undefined", 60);
  INFO(json(browser.complaints()).dump(1));
  REQUIRE(ready);
  const auto value = [&](const std::string& expression) { return browser.evaluate(expression); };

  {
    INFO("every section has data, nothing complains, nothing is loaded");
    CHECK(value("document.documentElement?.dataset.ready") == "true");
    CHECK(value("[...document.querySelectorAll('section')].map((s) => s.id)") ==
          json({"scenes", "accuracy", "figures", "replay", "timeline", "broadphase", "scaling", "commands"}));
    CHECK(
        value(
            "[...document.querySelectorAll('section')].filter((s) => s.dataset.filled !== 'true').map((s) => s.id)") ==
        json::array());
    CHECK(value("[...document.querySelectorAll('section')].filter((s) => s.id !== 'commands' && "
                "!s.querySelector('.rerun code')).map((s) => s.id)") == json::array());
    CHECK(
        value("[...document.querySelectorAll('svg:not([aria-hidden])')].every((s) => s.getAttribute('aria-label'))") ==
        true);
    for (const char* figure : {"3", "4", "5", "6", "7"})
      CHECK(value("document.querySelectorAll('#figure-" + std::string(figure) + " svg').length") >= 1);
    // Wrong answers are visible: a cross instead of a dot, and how much a peer misses.
    CHECK(value("document.querySelectorAll('#accuracy figure .wrong').length") == 1);
    CHECK(value("document.querySelector('.missed').textContent") == "misses 10 %");
    CHECK(value("document.querySelectorAll('#scenes .scenes')[1].querySelector('.best .ratio').textContent") ==
          "3.00×");
    // 1 / (0.025 + 0.975 / 64)
    CHECK(value("[...document.querySelectorAll('.serial tbody td')].map((cell) => cell.textContent).join(' ')")
              .get<std::string>()
              .ends_with("2.5 % 24.9×"));
    CHECK(
        value("document.querySelector('#figure-3 .scroll .good').textContent").get<std::string>().starts_with("kept"));
    CHECK(browser.complaints() == std::vector<std::string>{});
    for (const std::string& url : browser.requests())
      CHECK((url.starts_with("file://") || url.starts_with("data:") || url.starts_with("blob:")));
  }
  {
    INFO("the slider moves bodies");
    const json before = value("document.querySelector('.stage').dataset.body");
    value(
        "(() => { const s = document.querySelector('.time input'); s.value = s.max; s.dispatchEvent(new "
        "Event('input')); })()");
    const json after = value("document.querySelector('.stage').dataset.body");
    CHECK(before.is_string());
    CHECK(before != after);
    CHECK(value("document.querySelector('.time output').value").get<std::string>().starts_with("step 29,"));
    // The shown values are the recorded ones, to the rounding of 16 bits.
    CHECK_THAT(value("document.querySelector('#replay > div > .note').textContent").get<std::string>(),
               Catch::Contains("15 of 15") || Catch::Contains("30 of 30"));
  }
  {
    INFO("keys move it, a picked body tells what it touches, contacts are drawn");
    const auto key = [&](const char* name) {
      for (const char* type : {"keyDown", "keyUp"})
        browser.call("Input.dispatchKeyEvent", {{"type", type}, {"key", name}, {"code", name}});
    };
    const auto clock = [&] { return value("document.querySelector('.time output').value").get<std::string>(); };
    value("document.querySelector('.stage canvas').focus()");
    key("End");
    CHECK(clock().starts_with("step 29,"));
    key("ArrowLeft");
    CHECK(!clock().starts_with("step 29,"));
    key("Home");
    CHECK(clock().starts_with("step 0,"));
    key("End");
    value(
        "(() => { const b = document.querySelector('.controls input[type=number]'); b.value = 1; b.dispatchEvent(new "
        "Event('change')); })()");
    CHECK(value("document.querySelector('.stage .side b').textContent").get<std::string>().starts_with("body 1,"));
    CHECK(value("document.querySelectorAll('.stage .side tbody tr').length") >= 1);
    CHECK(value("Number(document.querySelector('.stage').dataset.contacts)") >= 1);
    // Arrow keys read out the values of a curve.
    value("document.querySelector('#figure-5 [role=group]').focus()");
    key("ArrowRight");
    CHECK(value("document.querySelector('.tip').textContent").get<std::string>().find("step 1") != std::string::npos);
  }
  {
    INFO("dark, on paper, on a phone, and for those who cannot see it");
    const auto media = [&](const char* medium, const char* scheme) {
      browser.call("Emulation.setEmulatedMedia",
                   {{"media", medium}, {"features", {{{"name", "prefers-color-scheme"}, {"value", scheme}}}}});
      return value("getComputedStyle(document.body).backgroundColor");
    };
    CHECK(media("screen", "light") == "rgb(251, 250, 247)");
    CHECK(media("screen", "dark") == "rgb(20, 23, 27)");
    CHECK(media("print", "light") == "rgb(255, 255, 255)");
    CHECK(value("getComputedStyle(document.querySelector('nav')).display") == "none");
    media("screen", "light");
    browser.call("Emulation.setDeviceMetricsOverride",
                 {{"width", 390}, {"height", 844}, {"deviceScaleFactor", 1}, {"mobile", true}});
    CHECK(browser.wait_for("document.documentElement.scrollWidth <= 390", 10));
    const std::string unnamed =
        "[...document.querySelectorAll('button, select, input, canvas, [tabindex=\"0\"]')].filter((e) => "
        "!(e.getAttribute('aria-label') || e.textContent.trim() || e.labels?.length || "
        "e.ariaLabelledByElements)).length";
    CHECK(value(unnamed) == 0);
    CHECK(value("[...document.querySelectorAll('section')].every((s) => s.getAttribute('aria-labelledby'))") == true);
    CHECK(value("document.documentElement.lang") == "en");
  }
  {
    INFO("it may not load anything even if it wanted to");
    const auto refused = [&](const std::string& attempt) {
      return value(
          "new Promise((done) => { document.addEventListener('securitypolicyviolation', (e) => "
          "done(e.effectiveDirective), {once: true}); setTimeout(() => done('asked for'), 3000); " +
          attempt + " })");
    };
    CHECK(refused("fetch('http://127.0.0.1:9/').catch(() => {});") == "connect-src");
    CHECK(refused("new Image().src = 'http://127.0.0.1:9/x.png';") == "img-src");
    CHECK(refused("document.head.append(Object.assign(document.createElement('script'), {src: "
                  "'http://127.0.0.1:9/x.js'}));") == "script-src-elem");
    CHECK(std::any_of(browser.complaints().begin(), browser.complaints().end(), [](const std::string& line) {
      return line.find("Content Security Policy") != std::string::npos;
    }));
  }
  {
    INFO("a mark's worst input can be asked of tandem query");
    const json record = value("document.querySelector('.detail pre').textContent");
    const json parsed = json::parse(record.get<std::string>());
    CHECK(parsed.at("id") == "box-box/near/7");
    CHECK(parsed.at("ask") == json({"distance"}));
    write(folder / "record.jsonl", parsed.dump() + "\n");
    const Finished answer = run(folder, TANDEM_PROGRAM_PATH " query record.jsonl");
    INFO(answer.text);
    CHECK(answer.status == 0);
    CHECK(json::parse(answer.text).contains("signed_distance"));
  }
#endif
}

TEST_CASE("report: a page of some results tells how the others are measured") {
#ifndef TANDEM_CHROMIUM
  TANDEM_SKIP("no Chromium was found when the tests were configured: the page is not opened");
#else
  const TemporaryFolder folder;
  write(folder / "scenes.json", result(json::array({row("scenes", "s", "sequential", 1, 1e6, json::object())})).dump());
  REQUIRE(report(folder, "scenes.json").status == 0);
  Browser browser(TANDEM_CHROMIUM, folder / "profile");
  browser.open("file://" + (folder / "page.html").string());
  REQUIRE(browser.wait_for("document.documentElement?.dataset.ready === 'true'", 60));
  CHECK(browser.evaluate("document.querySelectorAll('section .none .rerun code').length") == 6);
  CHECK(browser.complaints() == std::vector<std::string>{});
#endif
}
