#include "contest.h"

#include <fmt/format.h>
#include <oneapi/tbb/info.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <stdexcept>

#include "at_once.h"
#include "results.h"
#include "tandem/engine/response.h"

namespace tandem::bench {
namespace {

void work_for(std::chrono::microseconds time) {
  const auto end = std::chrono::steady_clock::now() + time;
  while (std::chrono::steady_clock::now() < end) {
  }
}

/// One contestant's pipelines: one, or copies that detect at once.
class Entry {
 public:
  Entry(const Contestant& contestant, double margin) {
    PipelineOptions options = contestant.options;
    options.contact_hash = true;
    options.margin = margin;
    for (int i = 0; i < contestant.copies; ++i) pipelines_.emplace_back(options);
    pipelines_.front().record_to(contestant.timeline);
    if (contestant.copies > 1) crew_ = std::make_unique<AtOnce>(contestant.copies);
  }

  StepReport step(const Scene& scene) {
    if (!crew_) return pipelines_.front().step(scene);
    std::vector<StepReport> reports(pipelines_.size());
    crew_->run([&](int i) {
      const auto at = static_cast<std::size_t>(i);
      reports[at] = pipelines_[at].step(scene);
    });
    // Together they do so many steps a millisecond.
    double rate = 0;
    for (const StepReport& report : reports) rate += 1 / report.execution.detect_ms;
    StepReport& first = reports.front();
    first.execution.detect_ms = 1 / rate;
    first.execution.threads = static_cast<int>(pipelines_.size());
    return std::move(first);
  }
  const ContactList& contacts() const { return pipelines_.front().contacts(); }

 private:
  std::vector<Pipeline> pipelines_;
  std::unique_ptr<AtOnce> crew_;
};

}  // namespace

void contest(Scene scene, const std::vector<Contestant>& contestants, int steps, int repeat,
             const std::function<void(const Turn&)>& on_turn, const std::function<void(int)>& on_step) {
  std::vector<Entry> pipelines;
  for (const Contestant& contestant : contestants) pipelines.emplace_back(contestant, recommended_margin(scene));
  Response response;
  const std::size_t n = pipelines.size();
  for (int step = 0; step < steps; ++step) {
    std::vector<std::uint64_t> hashes(n);
    for (std::size_t turn = 0; turn < n * static_cast<std::size_t>(repeat); ++turn) {
      const std::size_t who = (turn + static_cast<std::size_t>(step)) % n;
      work_for(std::chrono::microseconds(300));
      const StepReport report = pipelines[who].step(scene);
      hashes[who] = report.contact_hash;
      on_turn({who, step, report, scene});
    }
    for (std::size_t i = 1; i < n; ++i)
      if (hashes[i] != hashes[0])
        throw std::runtime_error(fmt::format("step {}: {} found contacts {}, {} found {}", step, contestants[0].name,
                                             hex(hashes[0]), contestants[i].name, hex(hashes[i])));
    response.step(scene, pipelines.front().contacts());
    on_step(step);
  }
}

std::vector<Contestant> executors(int threads, const PipelineOptions& base) {
  std::vector<Contestant> all;
  for (const ExecutorKind kind : executor_kinds) {
    Contestant contestant{std::string(name(kind)), base};
    contestant.options.executor = kind;
    contestant.options.threads = threads;
    all.push_back(std::move(contestant));
    if (kind != ExecutorKind::sequential) continue;
    Contestant copies = all.front();
    copies.copies = threads != 0 ? threads : tbb::info::default_concurrency();
    copies.copies = std::min(copies.copies, tbb::info::default_concurrency());
    copies.name = copies_name(copies.copies);
    if (copies.copies > 1) all.push_back(std::move(copies));
  }
  return all;
}

}  // namespace tandem::bench
