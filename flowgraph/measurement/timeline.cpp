// Slices and counters of steps, written in Chrome's trace-event format.
#include "tandem/flowgraph/timeline.h"

#include <nlohmann/json.hpp>
#include <ostream>

namespace tandem {

Timeline::Lane& Timeline::lane() {
  const std::thread::id self = std::this_thread::get_id();
  const std::scoped_lock lock(mutex_);
  for (const auto& lane : lanes_)
    if (lane->thread == self) return *lane;
  lanes_.push_back(std::make_unique<Lane>());
  lanes_.back()->thread = self;
  return *lanes_.back();
}

std::size_t Timeline::slices() const {
  std::size_t out = 0;
  for (const auto& lane : lanes_) out += lane->slices.size();
  return out;
}

void Timeline::count(std::string_view name, double value) {
  const std::scoped_lock lock(mutex_);
  counters_.push_back({name, Clock::now(), value});
}

void Timeline::note(std::string text) {
  const std::scoped_lock lock(mutex_);
  notes_.push_back({Clock::now(), std::move(text)});
}

void Timeline::write(std::ostream& out) const {
  using nlohmann::json;
  const std::scoped_lock lock(mutex_);
  const auto us = [this](Clock::time_point t) { return std::chrono::duration<double, std::micro>(t - start_).count(); };
  bool first = true;
  const auto event = [&](const json& value) {
    out << (first ? "\n" : ",\n") << value.dump();
    first = false;
  };
  out << "{\"displayTimeUnit\":\"ns\",\"traceEvents\":[";
  event({{"ph", "M"}, {"pid", 1}, {"name", "process_name"}, {"args", {{"name", "tandem"}}}});
  for (std::size_t thread = 0; thread < lanes_.size(); ++thread) {
    event({{"ph", "M"},
           {"pid", 1},
           {"tid", thread},
           {"name", "thread_name"},
           {"args", {{"name", "thread " + std::to_string(thread)}}}});
    for (const Slice& slice : lanes_[thread]->slices)
      event({{"ph", "X"},
             {"pid", 1},
             {"tid", thread},
             {"name", slice.name},
             {"ts", us(slice.begin)},
             {"dur", us(slice.end) - us(slice.begin)},
             {"args", {{"step", slice.step}, {"id", slice.id}, {"pairs", slice.pairs}}}});
  }
  for (const Counter& counter : counters_)
    event({{"ph", "C"},
           {"pid", 1},
           {"name", counter.name},
           {"ts", us(counter.at)},
           {"args", {{"value", counter.value}}}});
  for (const Note& note : notes_)
    event({{"ph", "i"}, {"s", "g"}, {"pid", 1}, {"tid", 0}, {"name", note.text}, {"ts", us(note.at)}});
  out << "\n]}\n";
}

}  // namespace tandem
