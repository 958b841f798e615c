// Box records and enlarged boxes.
#include "kernels/box_record.h"

#include "box_worlds.h"
#include "catch.h"

using namespace tandem;

TEST_CASE("box records: copies, and who left, of few boxes and of so many that they are streamed") {
  for (const std::size_t n : {std::size_t{5003}, std::size_t{500'003}}) {
    CAPTURE(n);
    const BoxArray boxes = make_boxes(
        n, 1,
        [](Random& r) {
          return Point{uniform(r, 0, 9), uniform(r, 0, 9), uniform(r, 0, 9)};
        },
        [](Random&) {
          return Point{1, 1, 1};
        });
    BoxArray within = boxes;
    Random random(2);
    for (std::size_t i = 0; i < n; ++i) {
      Aabb box = boxes[i];
      const std::size_t axis = random() % 3;
      if (random() % 9 == 0) (random() % 2 == 0 ? box.lo : box.hi)[axis] = box.lo[axis] + 0.5f;
      within.set(i, box);
    }
    const std::size_t begin = n / 3, end = n - 2;
    std::vector<BoxRecord> records(n), before(n);
    for (std::size_t i = 0; i < n; ++i) records[i].set({{1, 2, static_cast<float>(i)}, {3, 4, 5}});
    std::vector<std::uint32_t> outside(n);
    const std::size_t count =
        copy_boxes_that_left(boxes, begin, end, within, records.data(), outside.data(), before.data());
    std::size_t expected = 0, wrong = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const bool copied = begin <= i && i < end;
      BoxRecord record;
      record.set(copied ? boxes[i] : Aabb{{1, 2, static_cast<float>(i)}, {3, 4, 5}});
      wrong += std::equal(record.bounds, record.bounds + 8, records[i].bounds) ? 0 : 1;
      const Aabb box = boxes[i], larger = within[i];
      bool in = true;
      for (std::size_t k = 0; k < 3; ++k) in = in && larger.lo[k] <= box.lo[k] && box.hi[k] <= larger.hi[k];
      if (in || !copied) continue;
      wrong += expected < count && outside[expected] == i && before[expected].lo()[2] == static_cast<float>(i) ? 0 : 1;
      ++expected;
    }
    CHECK(count == expected);
    CHECK(wrong == 0);
    CHECK(copy_boxes_that_left(boxes, begin, end, within, nullptr, outside.data(), nullptr) == expected);
    CHECK(count_boxes_that_left(boxes, begin, end, within) == expected);
  }
}

TEST_CASE("bytes that are not 0: counted and named") {
  Random random(3);
  std::vector<std::uint8_t> bytes(1001);
  for (auto& byte : bytes) byte = random() % 7 == 0 ? static_cast<std::uint8_t>(1 + random() % 255) : std::uint8_t{0};
  std::vector<std::uint32_t> found(bytes.size());
  for (const auto& [begin, end] : {std::pair{0, 1001}, {0, 0}, {3, 70}, {64, 128}, {990, 1001}}) {
    std::vector<std::uint32_t> expected;
    for (int i = begin; i < end; ++i)
      if (bytes[static_cast<std::size_t>(i)] != 0) expected.push_back(static_cast<std::uint32_t>(i));
    const auto from = static_cast<std::size_t>(begin), to = static_cast<std::size_t>(end);
    found.resize(indices_set(bytes, from, to, found.data()));
    CHECK(found == expected);
    CHECK(count_set(std::span(bytes).subspan(from, to - from)) == expected.size());
    found.resize(bytes.size());
  }
}
