#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <new>

#include "synthetic_work.h"

namespace {

/// Allocations until one fails; negative: none does.
std::atomic<long> allocations_left{-1};

}  // namespace

void* operator new(std::size_t size) {
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
  for (const ExecutorKind kind : executor_kinds) {
    int failed = 0;
    for (long k = 0; k < 120; ++k) {
      CAPTURE(name(kind), k);
      const auto executor = make_executor({.kind = kind, .threads = 2, .batch_pairs = 64, .small_step_ms = 0});
      ContactList contacts;
      ExecutionReport report;
      // The threads of the baseline start with the first step; the failures are to hit the steps after it.
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
  }
}
