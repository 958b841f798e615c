// Executors when allocations fail, and that allocate nothing once warm.
#include <atomic>
#include <cstdlib>
#include <new>

#include "catch.h"
#include "synthetic_work.h"

namespace {

/// Allocations until one fails; negative: none does.
std::atomic<long> allocations_left{-1};
std::atomic<std::uint64_t> allocations{0};

}  // namespace

void* operator new(std::size_t size) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  if (allocations_left.load(std::memory_order_relaxed) >= 0 && allocations_left.fetch_sub(1) == 0)
    throw std::bad_alloc();
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

using namespace tandem;

TEST_CASE("whichever allocation of a step fails, it ends with bad_alloc or is right, and so is the next") {
  SyntheticWork work(600, 6.0f, 4);
  const ContactList expected = work.expected();
  const auto check = [&](ExecutorKind kind, StepForm form) {
    int failed = 0;
    for (long k = 0; k < 120; k += form == StepForm::ordered ? 5 : 1) {
      CAPTURE(name(kind), name(form), k);
      const auto executor = make_executor(
          {.kind = kind, .threads = 2, .batches = {.pairs = 64}, .sharing = {.form = form, .short_step_ms = 0}});
      ContactList contacts;
      ExecutionReport report;
      // The threads of the baseline start with the first step; the failures are to hit later steps.
      executor->run(work, contacts, report, {}, nullptr);
      contacts = {};
      work.on_tile = [&](std::size_t tile) {
        if (tile == 0) allocations_left.store(k);
      };
      try {
        executor->run(work, contacts, report, {}, nullptr);
        allocations_left.store(-1);
        CHECK(hash(contacts) == hash(expected));
      } catch (const std::bad_alloc&) {
        allocations_left.store(-1);
        ++failed;
      }
      work.on_tile = nullptr;
      executor->run(work, contacts, report, {}, nullptr);
      CHECK(hash(contacts) == hash(expected));
    }
    CHECK(failed > 0);
  };
  for (const ExecutorKind kind : executor_kinds) check(kind, StepForm::overlapped);
  for (const ExecutorKind kind : {ExecutorKind::barrier, ExecutorKind::threads, ExecutorKind::flowgraph})
    check(kind, StepForm::ordered);
}

TEST_CASE("a step whose load was there before allocates nothing") {
  SyntheticWork work(600, 6.0f, 4);
  for (const ExecutorKind kind : executor_kinds)
    for (const int threads : {1, 2})
      for (const StepForm form : {StepForm::overlapped, StepForm::ordered}) {
        CAPTURE(name(kind), threads, name(form));
        const auto executor =
            make_executor({.kind = kind, .threads = threads, .sharing = {.form = form, .short_step_ms = 0}});
        ContactList contacts;
        std::uint64_t least = UINT64_MAX;  // batch sizes depend on measured times: a slow step may need more batches
        for (int step = 0; step < 60; ++step) {
          ExecutionReport report;
          const std::uint64_t before = allocations.load();
          executor->run(work, contacts, report, {}, nullptr);
          if (step >= 20) least = std::min(least, allocations.load() - before);
        }
        // oneTBB's loops use pools of their own, except the one that keeps a writer for each thread.
        const bool loop = kind == ExecutorKind::barrier && threads > 1 && form == StepForm::overlapped;
        CHECK(least <= (loop ? 2 : 0));
      }
}
