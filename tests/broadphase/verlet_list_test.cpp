// Lists of candidates kept from step to step.
#include "methods/verlet_list.h"

#include <map>
#include <span>
#include <thread>

#include "box_worlds.h"
#include "catch.h"
#include "methods/bvh.h"
#include "methods/grid.h"
#include "methods/sweep.h"

using namespace tandem;

namespace {

/// A method with its list of candidates, as one broad phase.
template <class Method>
class Listed final : public BroadPhase {
 public:
  std::size_t begin(const BoxArray& boxes) override { return list.begin(boxes, method); }
  std::size_t blocks(std::size_t stage) const override { return list.blocks(stage); }
  void run(std::size_t stage, std::size_t block) override { list.run(stage, block); }
  void emit(std::size_t block, PairSink& sink) override { list.emit(block, sink); }
  BroadPhaseKind kind() const override { return method.kind(); }
  void expect(const PairFilter& filter) override { list.expect(filter); }
  void expect_changes(std::span<const std::uint8_t> changed) override { list.expect_changes(changed); }
  void expect_only_changes() override { list.expect_only_changes(); }
  std::size_t memory() const override { return method.memory() + list.memory(); }

  Method method;
  VerletList list;
};

/// Boxes with velocities; `stir` changes them before a step.
struct History {
  std::string name;
  std::function<void(BoxArray&, int, Random&)> step;
};

Aabb moved(Aabb box, const Point& by) {
  for (std::size_t k = 0; k < 3; ++k) {
    box.lo[k] += by[k];
    box.hi[k] += by[k];
  }
  return box;
}

/// A velocity for each box, always the same.
Point velocity(std::size_t i, float speed) {
  Random random(static_cast<unsigned>(i));
  return {uniform(random, -speed, speed), uniform(random, -speed, speed), uniform(random, -speed, speed)};
}

void fly(BoxArray& boxes, float speed) {
  for (std::size_t i = 0; i < boxes.size(); ++i)
    if (boxes.lo(0)[i] <= boxes.hi(0)[i]) boxes.set(i, moved(boxes[i], velocity(i, speed)));
}

void jump(BoxArray& boxes, std::size_t first, std::size_t every, Random& random) {
  for (std::size_t i = first; i < boxes.size(); i += every) {
    const Point to{uniform(random, 0, 20), uniform(random, 0, 20), uniform(random, 0, 20)};
    boxes.set(i, {to, {to[0] + 1, to[1] + 1, to[2] + 1}});
  }
}

std::vector<History> histories() {
  constexpr float big = std::numeric_limits<float>::max();
  return {
      {"at rest", [](BoxArray&, int, Random&) {}},
      {"straight", [](BoxArray& boxes, int, Random&) { fly(boxes, 0.05f); }},
      {"fast", [](BoxArray& boxes, int, Random&) { fly(boxes, 0.6f); }},
      {"there and back", [](BoxArray& boxes, int step, Random&) { fly(boxes, step % 6 < 3 ? 0.02f : -0.02f); }},
      {"all at once",
       [](BoxArray& boxes, int step, Random&) {
         if (step % 7 == 0) fly(boxes, 5);
       }},
      {"trembling",
       [](BoxArray& boxes, int, Random& random) {
         for (std::size_t i = 0; i < boxes.size(); ++i)
           boxes.set(i, moved(boxes[i], {uniform(random, -0.02f, 0.02f), uniform(random, -0.02f, 0.02f), 0}));
       }},
      {"one jumps",
       [](BoxArray& boxes, int step, Random& random) {
         jump(boxes, static_cast<std::size_t>(step) * 7 % boxes.size(), boxes.size(), random);
       }},
      {"some jump",
       [](BoxArray& boxes, int step, Random& random) { jump(boxes, static_cast<std::size_t>(step) % 50, 50, random); }},
      {"many jump", [](BoxArray& boxes, int, Random& random) { jump(boxes, random() % 3, 3, random); }},
      {"come and go",
       [](BoxArray& boxes, int step, Random& random) {
         fly(boxes, 0.02f);
         const auto turn = static_cast<std::size_t>(step);
         jump(boxes, (turn + 40) % 97, 97, random);
         for (std::size_t i = turn % 97; i < boxes.size(); i += 97) boxes.set_empty(i);
       }},
      {"grow and shrink",
       [](BoxArray& boxes, int step, Random&) {
         for (std::size_t i = 0; i < boxes.size(); i += 3) {
           Aabb box = boxes[i];
           if (!(box.lo[0] <= box.hi[0])) continue;
           for (std::size_t k = 0; k < 3; ++k)
             box.hi[k] = box.lo[k] + (step % 10 < 5 ? 1.1f : 0.5f) * static_cast<float>(i % 3 + 1);
           boxes.set(i, box);
         }
       }},
      {"a ground that comes, moves and goes",
       [](BoxArray& boxes, int step, Random&) {
         fly(boxes, 0.01f);
         const float top = 0.1f * static_cast<float>(step);
         boxes.set(5, {{-big, -big, -big}, {big, big, top}});
         if (step % 10 == 9) boxes.set_empty(5);
       }},
  };
}

/// The boxes of `now` that have changed, and in two steps of three some others.
std::vector<std::uint8_t> changes(const BoxArray& before, const BoxArray& now, int step) {
  std::vector<std::uint8_t> changed(now.size());
  for (std::size_t i = 0; i < now.size(); ++i) {
    const Aabb p = before[i], q = now[i];
    changed[i] = p.lo != q.lo || p.hi != q.hi || (step % 3 != 0 && (i + static_cast<std::size_t>(step)) % 31 == 0);
  }
  return changed;
}

enum class Told { nothing, changes, only_changes };

template <class Method>
std::map<VerletList::Mode, int> live_through(const History& history, BoxArray boxes, int steps, std::size_t& outside,
                                             Told told = Told::nothing, std::size_t* left = nullptr) {
  std::size_t left_out = 0;
  Listed<Method> one, other;
  Random random(5);
  std::map<VerletList::Mode, int> modes;
  for (int step = 0; step < steps; ++step) {
    CAPTURE(history.name, step);
    const BoxArray before = boxes;
    if (step != 0) history.step(boxes, step, random);
    const std::vector<std::uint8_t> changed = changes(before, boxes, step);
    const bool only_changes = told == Told::only_changes && step % 11 != 0;
    if (told != Told::nothing && step % 11 != 0)
      for (BroadPhase* method : {static_cast<BroadPhase*>(&one), static_cast<BroadPhase*>(&other)}) {
        method->expect_changes(changed);
        if (only_changes) method->expect_only_changes();
      }
    const auto found = pairs_of_blocks(one, boxes,
                                       step % 3 == 0   ? Order::shuffled
                                       : step % 3 == 1 ? Order::reversed
                                                       : Order::threads);
    const std::vector<Pair> all = overlapping_pairs(boxes), reported = sorted_pairs(found);
    if (only_changes) {
      const auto asked_for = [&](std::vector<Pair> pairs) {
        std::erase_if(pairs, [&](Pair pair) { return (changed[pair.a] | changed[pair.b]) == 0; });
        return pairs;
      };
      REQUIRE(asked_for(reported) == asked_for(all));
      REQUIRE(std::includes(all.begin(), all.end(), reported.begin(), reported.end()));
      left_out += all.size() - reported.size();
    } else {
      REQUIRE(reported == all);
    }
    REQUIRE((pairs_of_blocks(other, boxes, Order::forward) == found));
    ++modes[one.list.mode()];
    outside += one.list.outside();
  }
  if (left != nullptr) *left = left_out;
  return modes;
}

BoxArray crowd(std::size_t n) { return hard_worlds(n)[0].boxes; }

}  // namespace

TEST_CASE("Verlet list: the pairs of brute force after any history, in an order that threads do not change") {
  for (const History& history : histories()) {
    CAPTURE(history.name);
    std::size_t outside = 0;
    auto modes = live_through<Grid>(history, crowd(800), 40, outside);
    if (history.name == "at rest" || history.name == "straight" || history.name == "one jumps") {
      CHECK(modes[VerletList::Mode::reuse] > 20);
      CHECK(modes[VerletList::Mode::renew] > 0);
    }
    if (history.name == "many jump") CHECK(modes[VerletList::Mode::scratch] > 20);
    if (history.name == "some jump" || history.name == "come and go") CHECK(outside > 0);
    live_through<Bvh>(history, crowd(500), 25, outside);
    live_through<Sweep>(history, crowd(300), 25, outside);
  }
}

TEST_CASE("Verlet list: told what may have changed it finds the same, and all that is asked for") {
  std::vector<History> some = histories();
  some.push_back({"few move", [](BoxArray& boxes, int step, Random&) {
                    for (std::size_t i = 3; i < boxes.size(); i += 20)
                      boxes.set(i, moved(boxes[i], velocity(i + static_cast<std::size_t>(step) / 9, 0.2f)));
                  }});
  some.push_back({"few jump", [](BoxArray& boxes, int step, Random& random) {
                    jump(boxes, static_cast<std::size_t>(step % 5), 90, random);
                  }});
  // Between two jumps there are steps in which nothing changes, also right after a jump.
  some.push_back({"now and then", [](BoxArray& boxes, int step, Random& random) {
                    if (step % 9 == 2 || step % 9 == 4) jump(boxes, static_cast<std::size_t>(step % 5), 90, random);
                  }});
  for (const History& history : some) {
    CAPTURE(history.name);
    std::size_t outside = 0;
    auto modes = live_through<Grid>(history, crowd(800), 45, outside, Told::changes);
    std::size_t left_out = 0;
    live_through<Grid>(history, crowd(800), 45, outside, Told::only_changes, &left_out);
    if (history.name.starts_with("few")) {
      CHECK(modes[VerletList::Mode::reuse] > 25);
      CHECK(outside > 45);
      CHECK(left_out > 20 * overlapping_pairs(crowd(800)).size());
    }
    live_through<Bvh>(history, crowd(500), 16, outside, Told::changes);
    live_through<Sweep>(history, crowd(300), 16, outside, Told::changes);
  }
}

TEST_CASE("Verlet list: a box put back meets others that were, and what it met before, each once") {
  // Two rows of boxes that pass each other, so fast that all leave their enlarged boxes again and again.
  constexpr std::size_t n = 2000, movers = 60;
  BoxArray boxes = crowd(n);
  Listed<Grid> method;
  std::size_t outside = 0, reused = 0;
  for (int step = 0; step < 150; ++step) {
    CAPTURE(step);
    for (std::size_t i = 0; i < movers; ++i) {
      const int turn = step / 4 + static_cast<int>(i % 3);  // another direction every fourth step
      const auto place = static_cast<float>(i / 2) + 0.4f * static_cast<float>(turn % 2 == 0 ? step % 4 : 4 - step % 4);
      const float height = 10 + (i % 2 == 0 ? 0.3f * static_cast<float>(step % 7) : 0);
      boxes.set(i, {{place, 10, height}, {place + 0.9f, 10.9f, height + 0.9f}});
    }
    REQUIRE(find_pairs(method, boxes) == overlapping_pairs(boxes));
    outside += method.list.outside();
    reused += method.list.mode() == VerletList::Mode::reuse ? 1 : 0;
  }
  CHECK(outside > 5 * movers);
  CHECK(reused > 75);
}

TEST_CASE("Verlet list: while few of many move one list lasts, without growing") {
  constexpr std::size_t n = 3000, every = 50;
  BoxArray boxes = crowd(n);
  std::vector<std::uint8_t> changed(n), is_static(n);
  for (std::size_t i = 0; i < n; ++i) is_static[i] = i % every != 0;
  const PairFilter filter{{}, {}, is_static};
  Listed<Grid> method;
  std::map<VerletList::Mode, int> modes;
  std::size_t outside = 0, memory = 0;
  for (int step = 0; step < 800; ++step) {
    CAPTURE(step);
    for (std::size_t i = 0; step != 0 && i < n; i += every)
      boxes.set(i, moved(boxes[i], velocity(i, step / 10 % 2 == 0 ? 0.1f : -0.1f)));
    for (std::size_t i = 0; i < n; ++i) changed[i] = is_static[i] == 0;
    method.expect(filter);
    if (step != 0) method.expect_changes(changed);
    REQUIRE(find_pairs(method, boxes, filter) == find_pairs(*make_broad_phase(BroadPhaseKind::brute), boxes, filter));
    ++modes[method.list.mode()];
    outside += method.list.outside();
    if (step == 200) memory = method.memory();
  }
  CHECK(modes[VerletList::Mode::renew] <= 2);
  CHECK(modes[VerletList::Mode::scratch] <= 2);
  CHECK(outside > 20 * n / every);
  CHECK(outside < 100 * n / every);  // once for each change of direction, or so
  CHECK(method.memory() < memory + memory / 20);
}

TEST_CASE("Verlet list: where lists did not last they are tried again") {
  Listed<Grid> listed;
  BoxArray boxes = crowd(800);
  std::map<VerletList::Mode, int> shaken, calm;
  for (int step = 0; step < 240; ++step) {
    if (step < 80) fly(boxes, step % 6 < 3 ? 0.5f : -0.5f);  // the direction changes before a list has paid off
    REQUIRE(sorted_pairs(pairs_of_blocks(listed, boxes, Order::forward)) == overlapping_pairs(boxes));
    ++(step < 80 ? shaken : calm)[listed.list.mode()];
  }
  CHECK(shaken[VerletList::Mode::renew] > 1);
  CHECK(shaken[VerletList::Mode::scratch] > 40);
  CHECK(calm[VerletList::Mode::reuse] > 80);
}

TEST_CASE("Verlet list: the worlds that break broad phases, in motion") {
  for (BoxWorld& world : hard_worlds(500)) {
    std::size_t outside = 0;
    const History history{world.name, [](BoxArray& boxes, int step, Random& random) {
                            if (step % 5 == 0) jump(boxes, 3, 300, random);
                            fly(boxes, 0.01f);
                          }};
    live_through<Grid>(history, world.boxes, 11, outside);
    live_through<Bvh>(history, world.boxes, 11, outside);
  }
}

TEST_CASE("Verlet list: a step that was given up leaves nothing wrong behind") {
  BoxArray boxes = crowd(1300);
  Random random(1);
  for (std::size_t stop = 0; stop < 40; ++stop) {
    CAPTURE(stop);
    Listed<Grid> method;
    // The interrupted step makes the list (the second of all), or uses one.
    const bool makes = stop % 2 == 0;
    for (int step = 0; step < (makes ? 1 : 4); ++step) (void)find_pairs(method, boxes);
    if (!makes) jump(boxes, 1, 50 - stop, random);
    const std::size_t stages = method.begin(boxes);
    for (std::size_t stage = 0; stage + 1 < stages && stage < stop; ++stage)
      for (std::size_t block = 0; block < method.blocks(stage); ++block) method.run(stage, block);
    if (makes && stop > stages) CHECK(method.list.mode() == VerletList::Mode::renew);
    if (stop > stages) {
      ListSink sink;
      for (std::size_t block = 0; block < method.blocks(stages - 1) / 2; ++block) method.emit(block, sink);
    }
    for (int step = 0; step < 4; ++step) {
      fly(boxes, 0.01f);
      CHECK(find_pairs(method, boxes) == overlapping_pairs(boxes));
    }
  }
}

TEST_CASE("Verlet list: when all overlap all the candidates are not kept, the pairs are right") {
  BoxArray boxes;
  boxes.resize(700);
  Listed<Bvh> method, on_threads;
  std::map<VerletList::Mode, int> modes;
  for (int step = 0; step < 8; ++step) {
    const auto x = 0.001f * static_cast<float>(step);
    for (std::size_t i = 0; i < boxes.size(); ++i) boxes.set(i, {{x, 2, 3}, {x + 1, 3, 4}});
    const auto found = pairs_of_blocks(method, boxes, Order::forward);
    CHECK((pairs_of_blocks(on_threads, boxes, Order::threads) == found));
    const auto pairs = sorted_pairs(found);
    CHECK(pairs.size() == 700 * 699 / 2);
    CHECK(std::adjacent_find(pairs.begin(), pairs.end()) == pairs.end());
    ++modes[method.list.mode()];
  }
  CHECK(modes[VerletList::Mode::renew] == 1);
  CHECK(modes[VerletList::Mode::reuse] == 0);
}

TEST_CASE("Verlet list: many boxes, against a sweep from scratch") {
  BoxArray boxes = crowd(33'000);
  Listed<Grid> method;
  Random random(8);
  std::size_t outside = 0;
  for (int step = 0; step < 12; ++step) {
    CAPTURE(step);
    fly(boxes, 0.03f);
    if (step > 1) jump(boxes, static_cast<std::size_t>(step), 400, random);
    const auto pairs = sorted_pairs(pairs_of_blocks(method, boxes, step % 2 == 0 ? Order::threads : Order::shuffled));
    CHECK(pairs == find_pairs(*make_broad_phase(BroadPhaseKind::sweep), boxes));
    outside += method.list.outside();
  }
  CHECK(outside > 100);
}

TEST_CASE("Verlet list: copies of boxes are read only once all are made, while threads make them") {
  BoxArray boxes = crowd(33'000);
  std::vector<Point> velocities(boxes.size());
  for (std::size_t i = 0; i < velocities.size(); ++i) velocities[i] = velocity(i, 0.05f);
  Listed<Grid> together, alone;
  Random random(3);
  std::size_t reused = 0;
  for (int step = 0; step < 60; ++step) {
    CAPTURE(step);
    for (std::size_t i = 0; i < velocities.size(); ++i) boxes.set(i, moved(boxes[i], velocities[i]));
    jump(boxes, static_cast<std::size_t>(step), 300, random);
    const std::size_t stages = together.begin(boxes);
    for (std::size_t stage = 0; stage + 1 < stages; ++stage)
      for (std::size_t block = 0; block < together.blocks(stage); ++block) together.run(stage, block);
    std::vector<std::vector<Pair>> found(together.blocks(stages - 1));
    std::atomic<std::size_t> next{0};
    std::atomic<int> waiting{2};
    const auto work = [&] {
      for (--waiting; waiting != 0;) std::this_thread::yield();  // so that both begin at once
      for (std::size_t block = next++; block < found.size(); block = next++) {
        ListSink sink;
        // Also the last first, whose blocks need the boxes found outside.
        const std::size_t place = step % 2 == 0 ? block : found.size() - 1 - block;
        together.emit(place, sink);
        found[place] = sink.take();
      }
    };
    std::thread other(work);
    work();
    other.join();
    REQUIRE((pairs_of_blocks(alone, boxes, Order::forward) == found));
    reused += together.list.mode() == VerletList::Mode::reuse ? 1 : 0;
  }
  CHECK(reused > 40);
}

TEST_CASE("Verlet list: a change of number or of method starts anew") {
  Listed<Grid> method;
  for (const std::size_t n : {500u, 500u, 500u, 800u, 800u, 200u, 0u, 0u, 1u, 800u, 800u, 800u}) {
    const BoxArray boxes = crowd(n);
    CHECK(find_pairs(method, boxes) == overlapping_pairs(boxes));
  }
  Grid grid;
  Bvh bvh;
  VerletList list;
  BoxArray boxes = crowd(900);
  for (int step = 0; step < 12; ++step) {
    fly(boxes, 0.02f);
    ListedMethod& used = step / 3 % 2 == 0 ? static_cast<ListedMethod&>(grid) : bvh;
    ListSink sink;
    const std::size_t stages = list.begin(boxes, used);
    for (std::size_t stage = 0; stage + 1 < stages; ++stage)
      for (std::size_t block = 0; block < list.blocks(stage); ++block) list.run(stage, block);
    for (std::size_t block = 0; block < list.blocks(stages - 1); ++block) list.emit(block, sink);
    CHECK(sorted_pairs({sink.take()}) == overlapping_pairs(boxes));
  }
}

TEST_CASE("Verlet list: candidates that the filter forbids are not kept, and what it allows may change") {
  constexpr std::uint32_t n = 1300;
  BoxArray boxes = crowd(n);
  std::vector<std::uint32_t> group(n, 1), mask(n, ~0u);
  std::vector<std::uint8_t> is_static(n, 1);
  for (std::uint32_t i = 0; i < n; i += 100) is_static[i] = 0;
  const PairFilter filter{group, mask, is_static};
  const auto allowed = [&] {
    std::vector<Pair> pairs = overlapping_pairs(boxes);
    std::erase_if(pairs, [&](const Pair p) { return !filter.allows(p.a, p.b); });
    return pairs;
  };
  Listed<Grid> with, untold, without;
  Random random(4);
  int kept = 0;
  for (int step = 0; step < 60; ++step) {
    CAPTURE(step);
    const BoxArray before = boxes;
    std::vector<std::uint8_t> with_changes(n);
    const auto any = [&] {
      const std::size_t i = random() % n;
      with_changes[i] = 1;
      return i;
    };
    if (step != 0 && step < 40) fly(boxes, 0.01f);
    if (step > 20 && step % 4 == 0)
      for (int k = 0; k < 5; ++k) {
        is_static[any()] ^= 1;
        group[any()] = 1u << random() % 3;
        mask[any()] = static_cast<std::uint32_t>(random());
      }
    const std::vector<std::uint8_t> changed = changes(before, boxes, step);
    for (std::size_t i = 0; i < n; ++i) with_changes[i] = changed[i] | with_changes[i];
    with.expect_changes(with_changes);
    REQUIRE(find_pairs(with, boxes, filter) == allowed());
    REQUIRE(find_pairs(untold, boxes, filter) == allowed());
    (void)find_pairs(without, boxes);
    if (step == 15) {
      CHECK(without.list.candidates() > n / 2);
      CHECK(with.list.candidates() < without.list.candidates() / 20);
    }
    kept += with.list.mode() == VerletList::Mode::reuse ? 1 : 0;
  }
  CHECK(kept > 20);
  CHECK(find_pairs(with, boxes) == overlapping_pairs(boxes));  // no filter at all
}
