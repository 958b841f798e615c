// Stores of answers by threads.
#include "answers/answer_store.h"

#include <algorithm>
#include <barrier>
#include <cstdint>
#include <set>
#include <thread>
#include <vector>

#include "catch.h"

using namespace tandem;

namespace {

/// Puts results begin ... end - 1 of one writer into the store, a few at a time.
void write(AnswerStore& store, std::uint32_t writer, std::uint32_t begin, std::uint32_t end) {
  constexpr std::uint32_t at_once = 7;
  for (std::uint32_t first = begin; first < end; first += at_once) {
    AnswerChunk& chunk = store.room(at_once);
    for (std::uint32_t i = first; i < std::min(end, first + at_once); ++i)
      chunk.results.push_back({writer, i, static_cast<std::uint32_t>(chunk.contacts.size()), 0, {}});
  }
}

}  // namespace

TEST_CASE("answer store: many threads at once, more than it has slots for, each write to chunks of their own") {
  AnswerStore store;
  for (const int writers : {1, 3, 100}) {
    CAPTURE(writers);
    store.begin();
    CHECK(store.taken().empty());
    std::barrier all_at_work(writers);
    {
      std::vector<std::jthread> threads;
      for (int i = 0; i < writers; ++i)
        threads.emplace_back([&, i] {
          write(store, static_cast<std::uint32_t>(i), 0, 10);
          all_at_work.arrive_and_wait();  // so that no two have the same mark
          write(store, static_cast<std::uint32_t>(i), 10, 310);
        });
    }
    // Every result once, in chunks of one thread each.
    std::set<std::uint64_t> seen;
    std::set<const AnswerChunk*> chunks;
    for (const AnswerChunk* chunk : store.taken()) {
      CHECK(chunks.insert(chunk).second);
      for (const PairResult& result : chunk->results) {
        CHECK(result.a == chunk->results.front().a);
        CHECK(seen.insert(std::uint64_t{result.a} << 32 | result.b).second);
      }
    }
    CHECK(seen.size() == static_cast<std::size_t>(writers) * 310);
  }
}

TEST_CASE("answer store: a thread goes through its chunk, and comes back to it in the next step") {
  AnswerStore store;
  store.begin();
  AnswerChunk& first = store.room(100);
  first.results.resize(100);
  CHECK(&store.room(100) == &first);
  first.results.resize(200);
  AnswerChunk& second = store.room(100);  // has no room for 100 more
  CHECK(&second != &first);
  CHECK(second.results.empty());
  second.results.resize(1000);  // a batch may exceed the intended size of a chunk
  CHECK(&store.room(1) != &second);
  CHECK(store.taken().size() == 3);
  store.begin();
  CHECK(store.taken().empty());
  AnswerChunk& again = store.room(1);
  CHECK(again.results.empty());
  CHECK(again.thread == first.thread);
}
