// Blocks of a stage are taken once each, from one end or from both.
#include "flowgraph/step/tickets.h"

#include <atomic>
#include <thread>
#include <vector>

#include "catch.h"

using namespace tandem;

TEST_CASE("tickets: from both ends or from one, each block is taken once") {
  constexpr std::size_t blocks = 5000;
  Tickets tickets;
  for (int step = 0; step < 20; ++step) {
    tickets.begin(2);
    tickets.open(0, blocks, true);
    std::size_t block = 0;
    REQUIRE_FALSE(tickets.take(1, block));  // not open
    for (std::size_t k = 0; k < 10; ++k) {
      REQUIRE(tickets.take(0, block));
      REQUIRE(block == k);
    }
    std::vector<std::atomic<int>> taken(blocks);
    const auto take_all = [&] {
      for (std::size_t own = 0; tickets.take(0, own);) taken[own].fetch_add(1);
    };
    std::size_t first_of_other = 0;
    std::thread other([&] {
      tickets.take(0, first_of_other);
      take_all();
    });
    take_all();
    other.join();
    const bool came_in_time = first_of_other != 0;
    for (std::size_t k = 10; k < blocks; ++k) REQUIRE(taken[k] == (came_in_time && k == first_of_other ? 0 : 1));
    CHECK(tickets.all_taken(0));
    CHECK(tickets.stage() == 0);

    tickets.open(1, 3, false);
    std::vector<std::size_t> found;
    std::thread([&] {
      for (std::size_t own = 0; tickets.take(1, own);) found.push_back(own);
    }).join();
    CHECK(found == std::vector<std::size_t>{0, 1, 2});
    REQUIRE_FALSE(tickets.take(0, block));  // over
  }
}

TEST_CASE("tickets: who did not begin a step takes its blocks from the last on") {
  Tickets tickets;
  tickets.begin(1);
  tickets.open(0, 6, true);
  std::vector<std::size_t> found;
  std::size_t block = 0;
  REQUIRE(tickets.take(0, block));
  CHECK(block == 0);
  std::thread([&] {
    for (std::size_t own = 0; found.size() < 3 && tickets.take(0, own);) found.push_back(own);
  }).join();
  CHECK(found == std::vector<std::size_t>{5, 4, 3});
  REQUIRE(tickets.take(0, block));
  CHECK(block == 1);
  REQUIRE(tickets.take(0, block));
  CHECK(block == 2);
  CHECK_FALSE(tickets.take(0, block));
  CHECK(tickets.all_taken(0));
}

TEST_CASE("tickets: many stages, and more blocks than fit into 26 bits") {
  constexpr std::size_t stages = 5000, many = (std::size_t{1} << 27) + 1;
  for (const bool from_both_ends : {false, true}) {
    CAPTURE(from_both_ends);
    Tickets tickets;
    tickets.begin(stages);
    std::size_t block = 0;
    for (std::size_t stage = 0; stage < stages; ++stage) {
      tickets.open(stage, 2, from_both_ends);
      REQUIRE(tickets.stage() == stage);
      REQUIRE(tickets.take(stage, block));
      REQUIRE(tickets.take(stage, block));
      REQUIRE_FALSE(tickets.take(stage, block));
    }
    if (!from_both_ends) continue;
    tickets.begin(1);
    tickets.open(0, many, from_both_ends);
    std::size_t taken = 0;
    while (tickets.take(0, block)) ++taken;
    CHECK(taken == many);
    CHECK(tickets.all_taken(0));
  }
}
