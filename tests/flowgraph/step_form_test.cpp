// The choice of a step's form.
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <memory>
#include <random>
#include <utility>

#include "catch.h"
#include "flowgraph/answers/ordered_answers.h"
#include "flowgraph/answers/pair_order.h"
#include "flowgraph/step/step_form.h"
#include "synthetic_work.h"

using namespace tandem;

namespace {

/// Steps with a given cost for each form.
class Steps {
 public:
  explicit Steps(double small_ms = 0.3, bool can_order = true, double join_share = 0.1, double heavy_share = 0,
                 double more_when_shared = 1, int threads = 4)
      : chooser_(StepForm::automatic, small_ms, can_order),
        join_share_(join_share),
        heavy_share_(heavy_share),
        more_when_shared_(more_when_shared),
        threads_(threads) {}

  StepForm step(double caller_ms, double overlapped_ms, double ordered_ms, double pairs = 1000) {
    const StepForm form = chooser_.next();
    ExecutionReport report;
    report.form = form;
    report.threads = threads_;
    report.join_ms = join_share_ * overlapped_ms;
    report.narrow_ms = caller_ms;
    report.heavy_ms = heavy_share_ * caller_ms;
    report.detect_ms = form == StepForm::caller ? caller_ms : form == StepForm::overlapped ? overlapped_ms : ordered_ms;
    chooser_.learn(report, form == StepForm::caller ? caller_ms : more_when_shared_ * caller_ms, pairs);
    return form;
  }
  StepForm next() const { return chooser_.next(); }

 private:
  FormChooser chooser_;
  double join_share_, heavy_share_, more_when_shared_;
  int threads_;
};

}  // namespace

TEST_CASE("step form: the fastest is found within fourteen steps, and the others are tried ever more rarely") {
  for (const StepForm best : {StepForm::caller, StepForm::overlapped, StepForm::ordered}) {
    CAPTURE(name(best));
    Steps steps;
    const auto ms = [&](StepForm form) { return form == best ? 1.0 : 1.2; };
    const auto step = [&] { return steps.step(ms(StepForm::caller), ms(StepForm::overlapped), ms(StepForm::ordered)); };
    for (int i = 0; i < 14; ++i) step();
    int others = 0;
    for (int i = 0; i < 10; ++i) others += step() != best;
    CHECK(others <= 4);
    others = 0;
    for (int i = 0; i < 1000; ++i) others += step() != best;
    CHECK(others > 0);
    CHECK(others < (best == StepForm::caller ? 40 : 60));
  }
}

TEST_CASE("step form: a gain within the noise changes nothing, and the caller needs none") {
  Steps alone;
  for (int i = 0; i < 300; ++i) alone.step(1, 0.99, 0.98);
  CHECK(alone.next() == StepForm::caller);
  Steps shared(0);
  for (int i = 0; i < 300; ++i) shared.step(1, 1, 0.98);
  CHECK(shared.next() == StepForm::overlapped);
  // A form shared for long is given up soon when its gain is gone.
  for (const int long_time : {600, 800, 1000, 1200}) {
    CAPTURE(long_time);
    Steps steps;
    for (int i = 0; i < long_time; ++i) steps.step(1, 0.9, 0.95);
    int shared_on = 0;
    for (int i = 0; i < 200; ++i) shared_on += steps.step(1, 0.99, 1) != StepForm::caller;
    CHECK(shared_on < 100);
  }
}

TEST_CASE("step form: short steps that vary by a third are mostly of the fastest form") {
  std::mt19937 random(1);
  const auto noisy = [&](double ms) { return ms * (1 + static_cast<double>(random() % 1000) / 3000); };
  for (const StepForm best : {StepForm::caller, StepForm::ordered}) {
    CAPTURE(name(best));
    int others = 0;
    for (int scene = 0; scene < 20; ++scene) {
      Steps steps;
      for (int i = 0; i < 500; ++i)
        others += steps.step(noisy(best == StepForm::caller ? 0.4 : 0.5), noisy(0.45), noisy(0.43)) != best;
    }
    CHECK(others < 20 * 500 / (best == StepForm::caller ? 12 : 4));
  }
}

TEST_CASE("step form: sums are never two in a hundred above the caller's, though sharing costs up to twice as much") {
  std::mt19937 random(2);
  for (const double noise : {0.0, 0.1, 0.3})
    for (const double shared : {0.5, 0.8, 1.0, 1.2, 1.6, 2.0})
      for (const double small_ms : {0.3, 0.03})
        for (const int count : {300, 3000}) {
          double sum = 0, alone = 0;
          for (int scene = 0; scene < 20; ++scene) {
            Steps steps(small_ms);
            const auto noisy = [&](double ms) {
              return ms * (1 + noise * static_cast<double>(random() % 1000) / 1000);
            };
            for (int i = 0; i < count; ++i) {
              const double caller = noisy(0.4), overlapped = noisy(1.05 * shared * 0.4), ordered = noisy(shared * 0.4);
              const StepForm form = steps.step(caller, overlapped, ordered);
              alone += caller;
              sum += form == StepForm::caller ? caller : form == StepForm::overlapped ? overlapped : ordered;
            }
          }
          CAPTURE(noise, shared, small_ms, count);
          CHECK(sum < 1.02 * alone);
        }
}

TEST_CASE("step form: another load is looked at anew") {
  Steps steps;
  for (int i = 0; i < 300; ++i) steps.step(0.4, 0.6, 0.5, 1000);
  REQUIRE(steps.next() == StepForm::caller);
  int i = 0;
  for (; i < 50 && (steps.next() != StepForm::ordered || i < 10); ++i) steps.step(1.6, 1.0, 0.9, 3000);
  CHECK(i < 20);
  // Beyond some work steps are shared at once, whatever was measured.
  for (int k = 0; k < 300; ++k) steps.step(0.4, 0.6, 0.5, 1000);
  REQUIRE(steps.next() == StepForm::caller);
  steps.step(8, 5, 4, 1000);
  CHECK(steps.next() != StepForm::caller);
  // Also if that happens during a trial of another form.
  Steps trying;
  int k = 0;
  for (; k < 300 && (k < 10 || trying.next() == StepForm::caller); ++k) trying.step(0.4, 0.6, 0.5);
  REQUIRE(k < 300);
  for (k = 0; k < 20; ++k) CHECK(trying.step(30, 0.8, 0.8) != StepForm::caller);
}

TEST_CASE("step form: what cannot pay is not tried") {
  Steps many_threads;  // 1.9 ms of work in 0.1 ms
  for (int i = 0; i < 300; ++i) CHECK(many_threads.step(1.9, 0.1, 0.1) != StepForm::caller);
  Steps nothing_to_join(0.3, true, 0.01);
  for (int i = 0; i < 300; ++i) CHECK(nothing_to_join.step(3, 2, 2) == StepForm::overlapped);
  Steps meshes(0.3, true, 0.1, 0.9);
  for (int i = 0; i < 300; ++i) CHECK(meshes.step(3, 2, 1) == StepForm::overlapped);
}

TEST_CASE("step form: a short step goes to the caller though threads that share it are busy most of it") {
  Steps short_steps(0.3, true, 0.1, 0, 2);  // 0.7 ms of work in 0.4, of which the caller has 0.35
  int shared = 0;
  for (int i = 0; i < 300; ++i) shared += short_steps.step(0.35, 0.42, 0.4) != StepForm::caller;
  CHECK(shared < 30);
}

TEST_CASE("step form: two threads give a step of some work back to the caller where it is faster") {
  for (const double caller : {1.5, 2.5, 4.0}) {
    CAPTURE(caller);
    // Cores that wait for each other's lines: both work all the time, and are no faster.
    Steps two(0.3, true, 0.1, 0, 2.3, 2);
    int shared = 0;
    for (int i = 0; i < 600; ++i) shared += two.step(caller, 1.7 * caller, 1.2 * caller) != StepForm::caller;
    CHECK(shared < 40);
    // Where they gain, the caller is tried rarely.
    Steps gaining(0.3, true, 0.1, 0, 1.2, 2);
    double sum = 0;
    for (int i = 0; i < 600; ++i) {
      const StepForm form = gaining.step(caller, 0.7 * caller, 0.6 * caller);
      sum += caller * (form == StepForm::caller ? 1 : form == StepForm::overlapped ? 0.7 : 0.6);
    }
    CHECK(sum < 1.03 * 600 * 0.6 * caller);
  }
  Steps four(0.3, true, 0.1, 0, 2.3, 4);
  for (int i = 0; i < 300; ++i) CHECK(four.step(2.5, 4, 3) != StepForm::caller);
}

TEST_CASE("step form: small steps stay on the caller unless none may") {
  Steps small;
  small.step(0.1, 0.05, 0.05);
  for (int i = 0; i < 100; ++i) CHECK(small.step(0.1, 0.05, 0.05) == StepForm::caller);
  Steps never(0);
  for (int i = 0; i < 100; ++i) CHECK(never.step(0.1, 1, 1) != StepForm::caller);
  Steps fused(0.3, false);
  for (int i = 0; i < 100; ++i) CHECK(fused.step(3, 2, 1) == StepForm::overlapped);
}

TEST_CASE("step form: each gives the answer of a double loop, whatever was there before") {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 16);
  // Several sizes: lists grow and shrink.
  std::vector<std::unique_ptr<SyntheticWork>> works;
  for (const std::size_t n : {1200u, 40u, 1u, 900u, 1000u})
    works.push_back(std::make_unique<SyntheticWork>(n, 8.0f, 5));
  std::vector<std::uint64_t> expected;
  for (const auto& work : works) expected.push_back(hash(work->expected()));
  for (const ExecutorKind kind : {ExecutorKind::barrier, ExecutorKind::threads, ExecutorKind::flowgraph})
    for (const StepForm form : {StepForm::automatic, StepForm::caller, StepForm::overlapped, StepForm::ordered})
      for (const int threads : {2, 5})
        for (const std::size_t batch : {7u, 128u}) {
          CAPTURE(name(kind), name(form), threads, batch);
          const auto executor = make_executor({.kind = kind,
                                               .threads = threads,
                                               .batches = {.pairs = batch},
                                               .sharing = {.form = form, .short_step_ms = 0}});
          ContactList contacts;
          for (const std::size_t which : {0u, 0u, 1u, 3u, 2u, 4u, 4u, 0u}) {
            ExecutionReport report;
            executor->run(*works[which], contacts, report, {}, nullptr);
            CHECK(hash(contacts) == expected[which]);
            if (form != StepForm::automatic) CHECK(report.form == form);
          }
        }
}

TEST_CASE("ordered answers: a thread takes many batches in a row while there are many, each batch once") {
  std::vector<std::uint64_t> pairs;
  for (std::uint64_t a = 0; a < 3000; ++a) pairs.push_back(a << 32 | (a + 1));
  for (const std::size_t threads : {0u, 1u, 2u, 64u}) {
    CAPTURE(threads);
    ContactList out;
    OrderedAnswers answers;
    answers.begin(pairs, {.most = 10, .threads = threads}, {}, out);
    CHECK(answers.batches() == 300);
    if (threads == 2) CHECK(answers.runs() < 60);
    if (threads == 0) CHECK(answers.runs() == 300);
    std::vector<std::uint32_t> seen;
    std::size_t longest = 0;
    // The last run first: none has a place before all are answered.
    for (std::size_t run = answers.runs(); run-- > 0;) {
      Batch& batch = answers.take(run);
      std::vector<std::uint32_t> own;
      std::size_t batches = 0;
      do {
        ++batches;
        for (const Pair& pair : std::span(batch.pairs).first(batch.count)) {
          own.push_back(pair.a);
          batch.results.push_back({pair.a, pair.b, static_cast<std::uint32_t>(batch.contacts.size()), 1, {}});
          batch.contacts.push_back({Vec3(pair.a, 0, 0), Vec3::UnitZ(), 1, pair.b});
        }
      } while (answers.next(batch));
      answers.put(batch);
      longest = std::max(longest, batches);
      seen.insert(seen.begin(), own.begin(), own.end());
    }
    // No thread has more than a fourth of its share at once.
    if (threads != 0) CHECK(longest <= std::max<std::size_t>(1, 300 / (4 * threads)));
    for (std::size_t block = answers.open_rest(); block-- > 0;) answers.copy_rest(block);
    REQUIRE(seen.size() == 3000);
    REQUIRE(out.pairs.size() == 3000);
    for (std::uint32_t a = 0; a < 3000; ++a) {
      CHECK(seen[a] == a);
      CHECK(out.pairs[a].a == a);
      CHECK(out.of(out.pairs[a]).front().feature == a + 1);
    }
  }
}

TEST_CASE("pair order: as a sort by (a, b)") {
  std::mt19937 random(3);
  for (const std::size_t bodies : {2u, 3u, 300u, 5000u, 100000u})
    for (const std::size_t wanted : {0u, 1u, 100u, 5000u, 30000u})
      for (const bool ground : {false, true}) {
        CAPTURE(bodies, wanted, ground);
        std::vector<std::uint64_t> keys;
        std::uniform_int_distribution<std::uint32_t> any(0, static_cast<std::uint32_t>(bodies - 1));
        for (std::size_t i = 0; i < wanted; ++i) {
          const std::uint32_t a = ground && i % 2 == 0 ? 0 : any(random), b = any(random);
          if (a != b) keys.push_back(std::uint64_t{std::min(a, b)} << 32 | std::max(a, b));
        }
        std::sort(keys.begin(), keys.end());
        keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
        const std::vector<std::uint64_t> expected = keys;
        std::shuffle(keys.begin(), keys.end(), random);

        std::vector<Batch> batches(keys.size() / 50 + 1);
        for (Batch& batch : batches) batch.clear(50);
        for (std::size_t i = 0; i < keys.size(); ++i) {
          Batch& batch = batches[i / 50];
          batch.pairs[batch.count++] = pair_of(keys[i]);
        }
        std::vector<Batch*> all;
        for (Batch& batch : batches) all.push_back(&batch);
        PairOrder order;
        order.sort(all, bodies);
        CHECK(std::ranges::equal(order.sorted(), expected));
        for (int again = 0; again < 3; ++again) {  // noted, then seen to be the same
          order.sort(all, bodies);
          REQUIRE(std::ranges::equal(order.sorted(), expected));
        }
        order.begin(all, bodies);
        for (std::size_t stage = 0; stage < PairOrder::stages; ++stage)
          for (std::size_t block = order.open(stage); block-- > 0;) order.run(stage, block);
        CHECK(std::ranges::equal(order.sorted(), expected));
        if (keys.empty()) continue;
        const Pair other{0, static_cast<std::uint32_t>(bodies)}, given = std::exchange(all.front()->pairs[0], other);
        for (int again = 0; again < 2; ++again) {  // as many, and one of them another
          order.sort(all, bodies + 1);
          REQUIRE(std::ranges::is_sorted(order.sorted()));
          REQUIRE_FALSE(std::ranges::equal(order.sorted(), expected));
        }
        all.front()->pairs[0] = given;
        order.sort(all, bodies);
        CHECK(std::ranges::equal(order.sorted(), expected));
        std::swap(all.front(), all.back());
        --all.back()->count;  // one pair less, in another order
        order.sort(all, bodies);
        CHECK(order.sorted().size() == expected.size() - 1);
        CHECK(std::ranges::is_sorted(order.sorted()));
      }
}
