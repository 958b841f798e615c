#include "contest.h"

#include <fmt/format.h>

#include <chrono>
#include <stdexcept>

#include "results.h"
#include "tandem/engine/response.h"

namespace tandem::bench {
namespace {

void work_for(std::chrono::microseconds time) {
  const auto end = std::chrono::steady_clock::now() + time;
  while (std::chrono::steady_clock::now() < end) {
  }
}

}  // namespace

void contest(Scene scene, const std::vector<Contestant>& contestants, int steps, int repeat,
             const std::function<void(const Turn&)>& on_turn, const std::function<void(int)>& on_step) {
  std::vector<Pipeline> pipelines;
  for (const Contestant& contestant : contestants) {
    PipelineOptions options = contestant.options;
    options.contact_hash = true;
    options.margin = recommended_margin(scene);
    pipelines.emplace_back(std::move(options));
    pipelines.back().record_to(contestant.timeline);
  }
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
  }
  return all;
}

}  // namespace tandem::bench
