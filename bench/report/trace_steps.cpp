// Reads the steps of a timeline for the page's drawing.
#include "trace_steps.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <vector>

namespace tandem::bench {
namespace {

/// Process and thread, as the events name them.
using Thread = std::pair<std::uint32_t, std::uint32_t>;

struct Slice {
  Thread thread;
  std::string name;
  double begin, duration;
  std::uint64_t pairs;
};

struct Step {
  double begin = std::numeric_limits<double>::infinity(), end = 0;
  std::vector<Slice> slices;
  double length() const { return end - begin; }
};

struct Sample {
  double at, value;
};

/// Microseconds; the sum of two remains finite.
double time_of(const JsonRef& json) {
  constexpr double most = 1e18;  // far beyond any clock
  const double us = json.number();
  if (!(std::abs(us) <= most)) json.refuse("microseconds, at most 1e18 in size");
  return us;
}

double duration_of(const JsonRef& json) {
  if (!(json.number() >= 0)) json.refuse("a number >= 0");
  return time_of(json);
}

/// Tenths of microseconds are enough for a drawing.
double rounded(double us) { return std::round(10 * us) / 10; }

/// The names of the rows of a drawing: threads, or ranks where a file has several processes.
std::vector<std::string> row_names(const std::set<Thread>& threads, const std::map<std::uint32_t, std::string>& names) {
  const bool several = !threads.empty() && threads.begin()->first != threads.rbegin()->first;
  std::vector<std::string> out;
  for (const auto& [process, thread] : threads) {
    const std::string own = "thread " + std::to_string(thread);
    const auto name = names.find(process);
    out.push_back(!several || name == names.end() ? own : name->second + (thread == 0 ? "" : ", " + own));
  }
  return out;
}

std::set<std::uint32_t> chosen(const std::map<std::uint32_t, Step>& steps) {
  std::vector<std::pair<double, std::uint32_t>> by_length;
  for (const auto& [number, step] : steps) by_length.emplace_back(step.length(), number);
  std::sort(by_length.begin(), by_length.end());
  std::set<std::uint32_t> out{steps.begin()->first, steps.rbegin()->first, by_length.back().second,
                              by_length[by_length.size() / 2].second};
  constexpr std::size_t most = 8;
  for (std::size_t k = 1; k < most && out.size() < std::min(most, steps.size()); ++k)
    out.insert(std::next(steps.begin(), static_cast<std::ptrdiff_t>(k * steps.size() / most))->first);
  return out;
}

}  // namespace

Json trace_steps(const JsonRef& document, const std::string& file) {
  const JsonRef events = document.at("traceEvents");
  events.require_array("an array of events");
  std::map<std::uint32_t, Step> steps;
  std::vector<Sample> queue;
  std::vector<std::pair<double, std::string>> notes;
  std::set<Thread> threads;
  std::map<std::uint32_t, std::string> processes;
  for (std::size_t i = 0; i < events.size(); ++i) {
    const JsonRef event = events.at(i);
    const std::string& phase = event.at("ph").text();
    if (phase == "X") {
      const JsonRef args = event.at("args");
      Step& step = steps[args.at("step").whole(0xffffffffu)];
      const Thread thread(event.at("pid").whole(0xffffffffu), event.at("tid").whole(65535));
      const Slice slice{thread, event.at("name").text(), time_of(event.at("ts")), duration_of(event.at("dur")),
                        args.at("pairs").whole(0xffffffffu)};
      step.begin = std::min(step.begin, slice.begin);
      step.end = std::max(step.end, slice.begin + slice.duration);
      threads.insert(thread);
      step.slices.push_back(slice);
    } else if (phase == "M" && event.at("name").text() == "process_name") {
      const JsonRef args = event.at("args");
      processes[event.at("pid").whole(0xffffffffu)] = args.at("name").text();
    } else if (phase == "C" && event.at("name").text() == "queue") {
      const JsonRef args = event.at("args");
      queue.push_back({time_of(event.at("ts")), args.at("value").number()});
    } else if (phase == "i") {
      notes.emplace_back(time_of(event.at("ts")), event.at("name").text());
    }
  }
  if (steps.empty()) events.refuse("slices of at least one step");
  std::sort(queue.begin(), queue.end(), [](const Sample& x, const Sample& y) { return x.at < y.at; });

  Json out = Json::array();
  for (const std::uint32_t number : chosen(steps)) {
    Step& step = steps[number];
    std::stable_sort(step.slices.begin(), step.slices.end(),
                     [](const Slice& x, const Slice& y) { return x.begin < y.begin; });
    Json slices = Json::array(), samples = Json::array(), said = Json::array();
    for (const Slice& s : step.slices)
      slices.push_back({std::distance(threads.begin(), threads.find(s.thread)), s.name, rounded(s.begin - step.begin),
                        rounded(s.duration), s.pairs});
    for (const Sample& s : queue)
      if (s.at >= step.begin && s.at <= step.end) samples.push_back({rounded(s.at - step.begin), s.value});
    const std::string begin = "step " + std::to_string(number) + ":";
    for (const auto& [at, text] : notes)
      if (text.starts_with(begin)) said.push_back(text);
    out.push_back({{"step", number},
                   {"length", rounded(step.length())},
                   {"slices", slices},
                   {"queue", samples},
                   {"notes", said}});
  }
  return {{"file", file},
          {"threads", threads.size()},
          {"rows", row_names(threads, processes)},
          {"recorded_steps", steps.size()},
          {"steps", out}};
}

}  // namespace tandem::bench
