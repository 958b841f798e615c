// Runs contestants in turn on the same recorded poses, and compares their contacts.
#include "contest.h"

#include <fmt/format.h>
#include <oneapi/tbb/info.h>
#include <sched.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <numeric>
#include <random>
#include <stdexcept>

#include "at_once.h"
#include "clocks.h"
#include "results.h"
#include "tandem/engine/response.h"

namespace tandem::bench {
namespace {

/// Moves the calling thread to one of the cores that it may use, the next one each time, and then lets it migrate
/// again. The cores of a shared machine differ in speed for seconds at a time; a contestant whose busiest thread always
/// ran on the same core could not be compared with one whose busiest thread ran on another.
class CoreInTurn {
 public:
  CoreInTurn() {
    CPU_ZERO(&allowed_);
    if (sched_getaffinity(0, sizeof allowed_, &allowed_) != 0) return;
    for (int core = 0; core < CPU_SETSIZE; ++core)
      if (CPU_ISSET(core, &allowed_)) cores_.push_back(core);
  }
  void next() {
    if (cores_.size() < 2) return;
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(cores_[at_++ % cores_.size()], &one);
    // If refused, the thread stays where it is, which is no worse.
    if (sched_setaffinity(0, sizeof one, &one) == 0) sched_setaffinity(0, sizeof allowed_, &allowed_);
  }

 private:
  cpu_set_t allowed_;
  std::vector<int> cores_;
  std::size_t at_ = 0;
};

/// A contestant's pipelines: one, or several copies that detect at the same time.
class Entry {
 public:
  Entry(const Contestant& contestant, double margin) {
    PipelineOptions options = contestant.options;
    options.answer.contact_hash = true;
    options.answer.margin = margin;
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
    // The copies together do so many steps a millisecond.
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

/// Sets the poses of the bodies that moved.
void place(Scene& scene, const std::vector<Pose>& poses) {
  for (std::uint32_t i = 0; i < scene.indices(); ++i) {
    const Pose& now = scene.poses()[i];
    if (now.rotation != poses[i].rotation || now.translation != poses[i].translation)
      scene.move(i, poses[i], Vec3::Zero(), Vec3::Zero());
  }
}

}  // namespace

void contest(Scene scene, const std::vector<Contestant>& contestants, const Rounds& rounds,
             const std::function<void(const Turn&)>& on_turn, const std::function<void(int)>& on_step) {
  const double margin = recommended_margin(scene);
  std::vector<Entry> pipelines;
  for (const Contestant& contestant : contestants) pipelines.emplace_back(contestant, margin);
  Entry guide({"guide", contestants.front().options}, margin);
  Response response;
  Scene ahead = scene;
  const std::size_t n = pipelines.size();
  // A contestant that ran on one thread leaves the other cores idle and cold, so the next one must not always be the
  // same.
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::mt19937 random(1);
  CoreInTurn core;
  for (int first = 0; first < rounds.steps; first += rounds.stretch) {
    const int count = std::min(rounds.stretch, rounds.steps - first);
    std::vector<std::vector<Pose>> poses;
    std::vector<std::uint64_t> hashes;
    for (int k = 0; k < count; ++k) {
      poses.emplace_back(ahead.poses().begin(), ahead.poses().end());
      hashes.push_back(guide.step(ahead).contact_hash);
      response.step(ahead, guide.contacts());
    }
    for (std::size_t turn = 0; turn < n * static_cast<std::size_t>(rounds.repeat); ++turn) {
      if (turn % n == 0) {
        std::shuffle(order.begin(), order.end(), random);
        core.next();
      }
      const std::size_t who = order[turn % n];
      for (int k = 0; k < count; ++k) {
        const auto at = static_cast<std::size_t>(k);
        place(scene, poses[at]);
        stay_busy(std::chrono::microseconds(300));
        const StepReport report = pipelines[who].step(scene);
        if (report.contact_hash != hashes[at])
          throw std::runtime_error(fmt::format("step {}: {} found contacts {}, {} found {}", first + k,
                                               contestants[0].name, hex(hashes[at]), contestants[who].name,
                                               hex(report.contact_hash)));
        if (k != 0 || rounds.stretch == 1) on_turn({who, first + k, report});
      }
    }
    for (int k = 0; k < count; ++k) on_step(first + k);
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
