// Copies of a filter detect every change, whether the bodies' groups and masks are equal or not.
#include "storage/filter_copy.h"

#include <array>
#include <random>
#include <vector>

#include "catch.h"

using namespace tandem;

TEST_CASE("copies of a filter: as one that holds every body's part, whether all have the same or not") {
  std::mt19937 random(7);
  constexpr std::size_t n = 40;
  const auto draw = [&](std::uint32_t below) { return static_cast<std::uint32_t>(random() % below); };
  for (int trial = 0; trial < 400; ++trial) {
    // All meet, none meets, and bodies of several groups.
    const std::uint32_t mask_of_all = trial % 3 == 1 ? 6 : 7;
    std::vector<std::uint32_t> group(n, 1), mask(n, mask_of_all);
    std::vector<std::uint8_t> is_static(n, 0);
    if (trial % 3 == 2)
      for (std::size_t i = 0; i < n; ++i) group[i] = 1 + draw(3), mask[i] = draw(8);
    for (std::size_t i = 0; i < n; ++i) is_static[i] = static_cast<std::uint8_t>(draw(4) == 0 ? 1 : 0);
    const PairFilter filter{group, mask, is_static};
    FilterCopy copy;
    copy.take(filter);
    CHECK(copy.same_arrays(filter));
    CHECK_FALSE(copy.same_arrays({}));
    CHECK_FALSE(copy.same_arrays({group, {}, is_static}));
    FilterCopy masks_alone;
    masks_alone.take({{}, mask, is_static});
    CHECK(masks_alone.same_arrays({{}, mask, is_static}));
    CHECK(masks_alone.same({{}, mask, is_static}, 0, n));
    CHECK(copy.same(filter, 0, n));
    CHECK(copy.memory() <= (trial % 3 == 0 ? n : 9 * n));

    std::vector<std::uint32_t> held_group = group, held_mask = mask;
    std::vector<std::uint8_t> held_static = is_static;
    for (int change = 0; change < 4; ++change) {
      const std::uint32_t body = draw(n);
      (change % 2 == 0 ? group : mask)[body] ^= 1 + draw(2);
      const auto held = PairFilter{held_group, held_mask, held_static};
      const auto is_same = [&](std::size_t i) { return group[i] == held_group[i] && mask[i] == held_mask[i]; };
      for (std::size_t i = 0; i < n; ++i) REQUIRE(copy.same(filter, i, i + 1) == is_same(i));
      if (draw(2) == 0) {  // a copy of some is taken over, body by body
        const std::array<std::uint32_t, 2> some{draw(n), body};
        FilterCopy part;
        part.take(filter, some);
        for (std::size_t k = 0; k < some.size(); ++k) {
          copy.set(some[k], part, k);
          held_group[some[k]] = group[some[k]];
          held_mask[some[k]] = mask[some[k]];
        }
      }
      for (std::uint32_t a = 0; a < n; ++a)
        for (std::uint32_t b = 0; b < n; ++b) {
          REQUIRE(copy.allows(a, b) == held.allows(a, b));
          REQUIRE(copy.view().allows(a, b) == held.allows(a, b));
        }
      CHECK(copy.same(filter, 0, n) == (group == held_group && mask == held_mask));
    }
  }
}
