// Estimates of the costs of pairs.
#include "pipeline/pair_costs.h"

#include <chrono>
#include <thread>
#include <vector>

#include "catch.h"

using namespace tandem;
using namespace std::chrono_literals;

TEST_CASE("pair costs: the costliest pairs of the last step, and those like them, are told from the others") {
  PairCosts costs;
  costs.begin_step(6);
  CHECK_FALSE(costs.is_costliest({0, 1}, shortest_batch));  // nothing is known
  costs.learn({0, 1}, 400us);
  costs.learn({0, 2}, 20us);
  costs.learn({3, 4}, 210us);
  costs.learn({3, 5}, 190us);
  CHECK_FALSE(costs.is_costliest({0, 1}, shortest_batch));  // it counts only in the next step
  costs.begin_step(6);
  CHECK(costs.is_costliest({0, 1}, shortest_batch));
  CHECK(costs.is_costliest({3, 4}, shortest_batch));
  CHECK(costs.is_costliest({0, 3}, shortest_batch));  // both have such a pair
  CHECK_FALSE(costs.is_costliest({0, 2}, shortest_batch));
  CHECK_FALSE(costs.is_costliest({3, 5}, shortest_batch));
  CHECK(costs.is_costliest({0, 1}, 400us));  // as long as batches take as much, others can travel with it
  CHECK_FALSE(costs.is_costliest({0, 1}, 401us));
  CHECK_FALSE(costs.is_costliest({3, 4}, 211us));
  costs.begin_step(7);  // a pair not costly in the last step is forgotten, a new body is cheap
  CHECK_FALSE(costs.is_costliest({0, 1}, shortest_batch));
  CHECK_FALSE(costs.is_costliest({0, 6}, shortest_batch));
}

TEST_CASE("pair costs: pairs that do not fill a batch are all alike") {
  PairCosts costs;
  costs.begin_step(3);
  costs.learn({0, 1}, 14us);
  costs.learn({1, 2}, 1us);
  costs.begin_step(3);
  CHECK_FALSE(costs.is_costliest({0, 1}, shortest_batch));
}

TEST_CASE("pair costs: learned from several threads at once the most is kept") {
  PairCosts costs;
  costs.begin_step(3);
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t)
      threads.emplace_back([&costs, t] {
        for (int i = 0; i < 10'000; ++i)
          costs.learn({0, 1}, std::chrono::microseconds(t == 2 && i == 5000 ? 900 : i % 50));
      });
  }
  costs.learn({1, 2}, 449us);
  costs.begin_step(3);
  CHECK(costs.is_costliest({0, 1}, shortest_batch));
  CHECK_FALSE(costs.is_costliest({1, 2}, shortest_batch));
}
