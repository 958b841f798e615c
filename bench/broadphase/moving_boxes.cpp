// The worlds of moving boxes of the broad-phase bench.
#include "moving_boxes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <stdexcept>

namespace tandem::bench {
namespace {

using Point = std::array<double, 3>;

/// SplitMix64 (Steele et al. 2014).
class BoxRandom {
 public:
  explicit BoxRandom(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return z ^ (z >> 31);
  }
  double uniform(double lo, double hi) { return lo + (hi - lo) * (static_cast<double>(next() >> 11) * 0x1p-53); }
  Point in_cube(double side) { return {uniform(0, side), uniform(0, side), uniform(0, side)}; }
  /// A log-uniform number.
  double decades(double lo, double hi) { return lo * std::pow(hi / lo, uniform(0, 1)); }

 private:
  std::uint64_t state_;
};

struct Body {
  Point centre{}, half{}, velocity{};
};

/// Bodies that fly and bounce off the walls of [lo, hi]^3, and boxes that stand still.
class Flying : public MovingBoxes {
 public:
  Flying(std::vector<Body> bodies, double lo, double hi, std::span<const Aabb> standing = {})
      : bodies_(std::move(bodies)), lo_(lo), hi_(hi) {
    boxes_.resize(bodies_.size() + standing.size());
    for (std::size_t i = 0; i < standing.size(); ++i) boxes_.set(bodies_.size() + i, standing[i]);
    for (std::size_t i = 0; i < bodies_.size(); ++i) put(i);
  }

 protected:
  void move(int) override {
    for (std::size_t i = 0; i < bodies_.size(); ++i) fly(i);
  }
  void fly(std::size_t i) {
    Body& body = bodies_[i];
    for (std::size_t k = 0; k < 3; ++k) {
      body.centre[k] += body.velocity[k];
      if (body.centre[k] < lo_) body.velocity[k] = std::abs(body.velocity[k]);
      if (body.centre[k] > hi_) body.velocity[k] = -std::abs(body.velocity[k]);
    }
    put(i);
  }
  void put(std::size_t i) {
    const Body& body = bodies_[i];
    Aabb box;
    for (std::size_t k = 0; k < 3; ++k) {
      box.lo[k] = round_down(body.centre[k] - body.half[k]);
      box.hi[k] = round_up(body.centre[k] + body.half[k]);
    }
    boxes_.set(i, box);
  }
  std::vector<Body> bodies_;

 private:
  double lo_, hi_;
};

/// Flying boxes whose motion is changed before each step by a function of the bodies and the step.
class Stirred final : public Flying {
 public:
  using Stir = std::function<void(std::vector<Body>&, int)>;
  Stirred(std::vector<Body> bodies, Stir stir)
      : Flying(std::move(bodies), -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()),
        stir_(std::move(stir)) {}

 private:
  void move(int step) override {
    stir_(bodies_, step);
    Flying::move(step);
  }
  Stir stir_;
};

/// A tenth of the bodies is absent at a time, and a twentieth appears or leaves in each step.
class Changing final : public Flying {
 public:
  Changing(std::vector<Body> bodies, double side) : Flying(std::move(bodies), 0, side) {}

 private:
  void move(int step) override {
    Flying::move(step);
    for (std::size_t i = 0; i < bodies_.size(); ++i)
      if ((i + static_cast<std::size_t>(step)) % 20 < 2) boxes_.set_empty(i);
  }
};

/// 99 of 100 boxes stand still and are not written to; pairs of two of these are not wanted.
class Still final : public Flying {
 public:
  Still(std::vector<Body> bodies, double side) : Flying(std::move(bodies), 0, side) {
    is_static_.resize(bodies_.size());
    changes_.resize(bodies_.size());
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      is_static_[i] = i % among != 0;
      changes_[i] = is_static_[i] == 0;
    }
  }

 private:
  static constexpr std::size_t among = 100;
  void move(int) override {
    for (std::size_t i = 0; i < bodies_.size(); i += among) fly(i);
  }
};

std::vector<Body> bodies_of(std::size_t n, std::uint64_t seed, const std::function<Body(BoxRandom&)>& make) {
  BoxRandom random(seed);
  std::vector<Body> bodies(n);
  for (Body& body : bodies) body = make(random);
  return bodies;
}

Point same(double x) { return {x, x, x}; }

/// A box of edge 1 with a random velocity of at most 5 % of it a step.
Body unit_body(BoxRandom& random, const Point& centre) {
  return {centre, same(0.5), {random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05)}};
}

std::vector<Body> unit_bodies(std::size_t n, double side) {
  return bodies_of(n, 1, [&](BoxRandom& r) { return unit_body(r, r.in_cube(side)); });
}

std::vector<Body> pile(std::size_t n) {
  const auto across = static_cast<std::size_t>(std::ceil(std::cbrt(static_cast<double>(n))));
  std::size_t i = 0;
  return bodies_of(n, 2, [&](BoxRandom& r) {
    // Boxes one unit apart and jittered: neighbours overlap along an axis half of the time, seven of the 26 on all
    // three.
    Body body{{}, same(0.5), {}};
    const std::array<std::size_t, 3> at{i % across, i / across % across, i / across / across};
    for (std::size_t k = 0; k < 3; ++k) {
      body.centre[k] = static_cast<double>(at[k]) + r.uniform(-0.05, 0.05);
      body.velocity[k] = r.uniform(-0.0005, 0.0005);
    }
    ++i;
    return body;
  });
}

/// Reverses the motion, so that a pile stays where it is.
void reverse(std::vector<Body>& bodies) {
  for (Body& body : bodies)
    for (double& v : body.velocity) v = -v;
}

constexpr std::array<BoxWorkload, 18> workloads{{
    {"W1", "unit boxes, each overlaps about one other, 5 % of their size a step"},
    {"W2", "a pile: 6 to 7 neighbours each, hardly moving"},
    {"W3", "sizes over three decades on a huge ground"},
    {"W4", "sparse, all falling together"},
    {"still", "W1, 99 % of the boxes stand still and make no pairs"},
    {"alone", "those of `still` that move, a hundredth of them, without the others"},
    {"decades", "sizes over six decades", 0, true},
    {"clusters", "16 tight clusters in an empty world", 0, true},
    {"line", "all on one line", 0, true},
    {"plane", "all in one plane", 0, true},
    {"point", "boxes of many sizes around one point: all pairs", 2000, true},
    {"walls", "W1 in a room of six huge boxes", 0, true},
    {"identical", "one box many times: all pairs", 2000, true},
    {"far", "W1 around 1e6, where floats are 1/16 apart", 0, true},
    {"jumping", "W1, a tenth of the boxes jumps anywhere each step", 0, true},
    {"changing", "W1, a twentieth comes and goes each step", 0, true},
    {"jolts", "W2, shaken by half a box every eighth step", 0, true},
    {"needles", "30 long, 0.01 thick, along the axes", 0, true},
}};

/// Boxes that fly between lo and hi.
std::unique_ptr<MovingBoxes> flying(std::vector<Body> bodies, double lo, double hi,
                                    std::span<const Aabb> standing = {}) {
  return std::make_unique<Flying>(std::move(bodies), lo, hi, standing);
}

/// The edge of a cube in which n unit boxes overlap one other on average.
double side_of(std::size_t n) { return 2 * std::cbrt(static_cast<double>(n)); }

/// The worlds W1 to W4 and variants of them; null: another name.
std::unique_ptr<MovingBoxes> usual_boxes(std::string_view name, std::size_t n) {
  const double side = side_of(n);
  if (name == "W1") return flying(unit_bodies(n, side), 0, side);
  if (name == "still") return std::make_unique<Still>(unit_bodies(n, side), side);
  if (name == "alone") {
    const double whole = std::cbrt(100.0) * side;
    return flying(unit_bodies(n, whole), 0, whole);
  }
  if (name == "W2")
    return std::make_unique<Stirred>(pile(n), [](std::vector<Body>& bodies, int step) {
      if (step % 4 == 0) reverse(bodies);
    });
  if (name == "W3") {
    // For edges log-uniform in 0.01..10, E[(a + b)^3] = 2 E[a^3] + 6 E[a^2] E[a] = 159.
    const double wide = std::cbrt(159.3) * side / 2;
    const auto edge = static_cast<float>(2 * wide);
    const Aabb ground{{-edge, -edge, -1}, {edge, edge, 0}};
    return flying(bodies_of(n - 1, 3,
                            [&](BoxRandom& r) {
                              Body body = unit_body(r, r.in_cube(wide));
                              const double size = r.decades(0.01, 10);
                              body.half = same(0.5 * size);
                              for (double& v : body.velocity) v *= size;
                              return body;
                            }),
                  0, wide, {&ground, 1});
  }
  if (name == "W4")
    return std::make_unique<Stirred>(unit_bodies(n, 10 * side), [](std::vector<Body>& bodies, int) {
      for (Body& body : bodies) body.velocity = {0, 0, -0.1};
    });
  return nullptr;
}

/// Worlds with sizes over many decades, and clusters; null: another name.
std::unique_ptr<MovingBoxes> hard_places(std::string_view name, std::size_t n) {
  const double side = side_of(n);
  if (name == "decades")
    return flying(bodies_of(n, 5,
                            [&](BoxRandom& r) {
                              Body body = unit_body(r, r.in_cube(20 * side));
                              body.half = same(0.5 * r.decades(1e-4, 1e2));
                              return body;
                            }),
                  0, 20 * side);
  if (name == "clusters")
    return std::make_unique<Stirred>(bodies_of(n, 6,
                                               [&](BoxRandom& r) {
                                                 BoxRandom place(r.next() % 16);
                                                 Point at = place.in_cube(1e5);
                                                 const Point off = r.in_cube(side / std::cbrt(16.0));
                                                 for (std::size_t k = 0; k < 3; ++k) at[k] += off[k];
                                                 return unit_body(r, at);
                                               }),
                                     [](std::vector<Body>& bodies, int step) {
                                       if (step % 8 == 0) reverse(bodies);
                                     });
  return nullptr;
}

/// Worlds with boxes on a line, in a plane, about a point, between walls, or thin; null: another name.
std::unique_ptr<MovingBoxes> flat_places(std::string_view name, std::size_t n) {
  const double side = side_of(n);
  if (name == "line")
    return flying(bodies_of(n, 7,
                            [&](BoxRandom& r) {
                              return Body{{r.uniform(0, 2.0 * static_cast<double>(n)), 5, -3},
                                          same(0.5),
                                          {r.uniform(-0.05, 0.05), 0, 0}};
                            }),
                  0, 2.0 * static_cast<double>(n));
  if (name == "plane") {
    const double wide = 2 * std::sqrt(static_cast<double>(n));
    return flying(bodies_of(n, 8,
                            [&](BoxRandom& r) {
                              return Body{{r.uniform(0, wide), r.uniform(0, wide), 1},
                                          same(0.5),
                                          {r.uniform(-0.05, 0.05), r.uniform(-0.05, 0.05), 0}};
                            }),
                  0, wide);
  }
  if (name == "point")
    return flying(bodies_of(n, 9, [&](BoxRandom& r) { return Body{same(7), same(r.decades(1e-3, 10)), {}}; }), 0, 10);
  if (name == "walls") {
    const auto s = static_cast<float>(side);
    constexpr float big = 1e6f;
    const std::array<Aabb, 6> room{{{{-big, -big, -big}, {0, big, big}},
                                    {{s, -big, -big}, {big, big, big}},
                                    {{-big, -big, -big}, {big, 0, big}},
                                    {{-big, s, -big}, {big, big, big}},
                                    {{-big, -big, -big}, {big, big, 0}},
                                    {{-big, -big, s}, {big, big, big}}}};
    return flying(unit_bodies(n - std::min<std::size_t>(n - 1, 6), side), 0, side, room);
  }
  if (name == "needles")
    return flying(bodies_of(n, 16,
                            [&](BoxRandom& r) {
                              Body body = unit_body(r, r.in_cube(2 * side));
                              body.half = same(0.005);
                              body.half[r.next() % 3] = 15;
                              return body;
                            }),
                  0, 2 * side);
  return nullptr;
}

/// Worlds with motions that are hard for a method; null: another name.
std::unique_ptr<MovingBoxes> hard_motions(std::string_view name, std::size_t n) {
  const double side = side_of(n);
  if (name == "identical")
    return std::make_unique<Stirred>(std::vector<Body>(n, Body{same(3), same(0.5), {0.01, 0, 0}}),
                                     [](std::vector<Body>&, int) {});
  if (name == "far") {
    auto bodies = unit_bodies(n, side);
    for (Body& body : bodies)
      for (double& x : body.centre) x += 1e6;
    return flying(std::move(bodies), 1e6, 1e6 + side);
  }
  if (name == "jumping")
    return std::make_unique<Stirred>(unit_bodies(n, side), [side](std::vector<Body>& bodies, int step) {
      BoxRandom random(static_cast<std::uint64_t>(step));
      for (std::size_t i = static_cast<std::size_t>(step) % 10; i < bodies.size(); i += 10)
        bodies[i].centre = random.in_cube(side);
    });
  if (name == "changing") return std::make_unique<Changing>(unit_bodies(n, side), side);
  if (name == "jolts")
    return std::make_unique<Stirred>(pile(n), [](std::vector<Body>& bodies, int step) {
      if (step % 4 == 0) reverse(bodies);
      if (step % 8 != 0) return;
      BoxRandom random(static_cast<std::uint64_t>(step));
      for (Body& body : bodies)
        for (double& x : body.centre) x += random.uniform(-0.5, 0.5);
    });
  return nullptr;
}

}  // namespace

std::span<const BoxWorkload> box_workloads() { return workloads; }

std::unique_ptr<MovingBoxes> make_moving_boxes(std::string_view name, std::size_t n) {
  for (const auto make : {usual_boxes, hard_places, flat_places, hard_motions})
    if (auto boxes = make(name, n)) return boxes;
  throw std::invalid_argument("no such boxes: " + std::string(name));
}

}  // namespace tandem::bench
