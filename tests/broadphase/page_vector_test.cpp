// Vectors in large pages.
#include "storage/page_vector.h"

#include <cstdint>
#include <numeric>

#include "catch.h"

using namespace tandem;

TEST_CASE("arrays of large pages keep what is in them as they grow, below and above the size where these begin") {
  struct alignas(32) Record {
    std::uint32_t values[8];
  };
  constexpr std::size_t begin_at = PageAllocator<Record>::page / sizeof(Record);
  PageVector<Record> records;
  PageVector<std::uint32_t> numbers;
  for (const std::size_t n : {std::size_t{3}, begin_at - 1, begin_at, begin_at + 1, 3 * begin_at}) {
    CAPTURE(n);
    const std::size_t before = records.size();
    records.resize(n);
    for (std::size_t i = before; i < n; ++i) records[i].values[7] = static_cast<std::uint32_t>(i);
    CHECK(reinterpret_cast<std::uintptr_t>(records.data()) % alignof(Record) == 0);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < n; ++i) wrong += records[i].values[7] != i ? 1 : 0;
    CHECK(wrong == 0);
    numbers.assign(8 * n, 5u);
    CHECK(std::accumulate(numbers.begin(), numbers.end(), std::uint64_t{0}) == 40 * n);
  }
  PageVector<Record> copy = records, moved = std::move(records);
  CHECK(copy.size() == moved.size());
  CHECK(copy.back().values[7] == moved.back().values[7]);
}
