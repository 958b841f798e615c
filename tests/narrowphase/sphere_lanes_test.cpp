// Spheres, a pair a lane.
#include <cmath>
#include <deque>
#include <string>
#include <vector>

#include "catch.h"
#include "one_instruction_set.h"
#include "random_pairs.h"
#include "tandem/narrowphase/several_pairs.h"

using namespace tandem;
using namespace tandem::test;

namespace {

struct ToldPair {
  bool is_told = false;
  PairAnswer answer;
  std::vector<Contact> contacts;
};

/// Collects the answer of each pair.
class Answers final : public AnswerSink {
 public:
  Answers(std::size_t pairs, const std::vector<Contact>& all) : told(pairs), all_(all) {}
  PairAnswer& begin(std::size_t pair) override {
    in_order &= pair >= next_;
    next_ = pair + 1;
    first_ = all_.size();
    told[pair].is_told = true;
    return told[pair].answer;
  }
  void end() override {
    told[next_ - 1].contacts.assign(all_.begin() + static_cast<std::ptrdiff_t>(first_), all_.end());
  }

  std::vector<ToldPair> told;
  bool in_order = true;

 private:
  const std::vector<Contact>& all_;
  std::size_t next_ = 0, first_ = 0;
};

bool same_bits(const PairAnswer& x, const PairAnswer& y) {
  return x.collide == y.collide && x.signed_distance == y.signed_distance && x.normal == y.normal &&
         x.point_a == y.point_a && x.point_b == y.point_b && x.status == y.status;
}
bool same_bits(const std::vector<Contact>& x, const std::vector<Contact>& y) {
  return std::equal(x.begin(), x.end(), y.begin(), y.end(), [](const Contact& p, const Contact& q) {
    return p.point == q.point && p.normal == q.normal && p.depth == q.depth && p.feature == q.feature;
  });
}

/// Pairs of spheres, of spheres and half-spaces in both orders, and others between, from deep to separated, many
/// touching to rounding, some concentric or of radius 0.
struct Mixture {
  std::deque<Shape> shapes;
  std::deque<Pose> poses;
  std::deque<PlacedSphere> placed;
  std::vector<PlacedPair> pairs;
  std::vector<PlacedSpheres> spheres;

  explicit Mixture(Random& r, int count) {
    const Shape &ground = shapes.emplace_back(HalfSpace{{0.3, -0.2, 1}, 0.4}),
                &box = shapes.emplace_back(Box{{1, 2, 1}});
    const Pose& at = poses.emplace_back(Pose{r.rotation(), r.vec(-1, 1)});
    for (int i = 0; i < count; ++i) {
      const double ra = i % 37 == 0 ? 0 : r.in(0.1, 2), rb = i % 41 == 0 ? 0 : r.in(0.1, 2);
      const Shape &a = shapes.emplace_back(Sphere{ra}), &b = shapes.emplace_back(Sphere{rb});
      const double size = std::pow(10.0, r.in(-17, 0)), gap = size * (r.in(0, 1) < 0.6 ? -1 : 1);
      const Vec3 heading = r.direction();
      const Pose& pose_a = poses.emplace_back(Pose{r.rotation(), r.vec(-10, 10)});
      const Vec3 between = (i % 43 == 0 ? 0 : ra + rb + gap) * heading;
      Pose& pose_b = poses.emplace_back(Pose{r.rotation(), pose_a.translation + between});
      if (i % 5 == 1 || i % 5 == 2) {
        pose_b.translation += at.translation - pose_b.translation;
        const double distance = NarrowPhase().solve(ground, at, b, pose_b, Request::distance).signed_distance;
        pose_b.translation += (gap - distance) * (at.rotation * ground.normal());
        i % 5 == 1 ? add(ground, at, b, pose_b) : add(b, pose_b, ground, at);
      } else if (i % 5 == 3 && i % 2 == 0) {
        add(box, at, b, pose_b);
      } else {
        add(a, pose_a, b, pose_b);
      }
    }
  }

 private:
  const PlacedSphere* place(const Shape& shape, const Pose& pose) {
    return shape.kind() == ShapeKind::sphere ? &placed.emplace_back(PlacedSphere{pose.translation, shape.radius()})
                                             : nullptr;
  }
  void add(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
    pairs.push_back({&a, &pose_a, &b, &pose_b});
    spheres.push_back({place(a, pose_a), place(b, pose_b)});
  }
};

}  // namespace

TEST_CASE("several spheres at a time have the bits that they have one by one, on each instruction set") {
  Random r(83);
  const Mixture mixture(r, 4000);
  for (const double margin : {0.0, 0.01}) {
    std::vector<ToldPair> own(mixture.pairs.size());
    for (std::size_t i = 0; i < own.size(); ++i) {
      const PlacedPair& p = mixture.pairs[i];
      own[i].answer =
          NarrowPhase({.margin = margin}).solve(*p.a, *p.pose_a, *p.b, *p.pose_b, Request::contacts, &own[i].contacts);
    }
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets())
      for (const bool given : {false, true}) {
        CAPTURE(std::string(hwy::TargetName(target)), margin, given);
        const OneInstructionSet only(target);
        std::vector<Contact> contacts;
        Answers answers(own.size(), contacts);
        SeveralPairs({.margin = margin})
            .solve(mixture.pairs, contacts, answers,
                   given ? std::span(mixture.spheres) : std::span<const PlacedSpheres>());
        std::size_t wrong = 0, told = 0;
        for (std::size_t i = 0; i < own.size(); ++i) {
          const ToldPair& one = answers.told[i];
          if (!own[i].answer.collide && own[i].contacts.empty()) {
            wrong += one.answer.collide || !one.contacts.empty();
          } else {
            ++told;
            wrong += !one.is_told || !same_bits(one.answer, own[i].answer) || !same_bits(one.contacts, own[i].contacts);
          }
        }
        CHECK(wrong == 0);
        CHECK(told > 2000);
        CHECK(answers.in_order);
      }
  }
}

TEST_CASE("spheres that are left out before have no contact, and none is left in that is clearly apart") {
  Random r(84);
  const Mixture mixture(r, 4000);
  const PlacedSphere all{Vec3::Zero(), std::numeric_limits<double>::infinity()};
  for (const double margin : {0.0, 0.01})
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
      const OneInstructionSet only(target);
      const SeveralPairs several({.margin = margin});
      std::size_t left_out = 0;
      for (std::size_t i = 0; i < mixture.spheres.size(); ++i) {
        PlacedSpheres some[] = {mixture.spheres[i], {&all, mixture.spheres[i].b}, {mixture.spheres[i].a, &all}};
        if (some[0].a == nullptr || some[0].b == nullptr) continue;
        const std::uint32_t near = several.near(some);
        CHECK((near & 6u) == 6u);
        CHECK(near < 8);
        const double gap = (some[0].b->centre - some[0].a->centre).norm() - some[0].a->radius - some[0].b->radius;
        if ((near & 1u) == 0) CHECK(gap > margin);
        if (gap > 1.01 * margin + 1e-9) CHECK((near & 1u) == 0);
        left_out += (near & 1u) == 0;
      }
      CHECK(left_out > 50);
    }
}

TEST_CASE("spheres alone are answered up to the first that rounding decides, with the same bits") {
  Random r(85);
  const Mixture mixture(r, 4000);
  std::vector<PlacedSpheres> spheres;
  std::vector<PlacedPair> pairs;
  for (std::size_t i = 0; i < mixture.pairs.size(); ++i) {
    if (mixture.spheres[i].a == nullptr || mixture.spheres[i].b == nullptr) continue;
    spheres.push_back(mixture.spheres[i]);
    pairs.push_back(mixture.pairs[i]);
  }
  struct Result {
    std::uint32_t before = 7;
    PairAnswer answer;
  };
  for (const double margin : {0.0, 0.01})
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
      CAPTURE(std::string(hwy::TargetName(target)), margin);
      const OneInstructionSet only(target);
      const SeveralPairs several({.margin = margin});
      std::size_t wrong = 0, answered = 0, alone = 0;
      const auto solve_alone = [&](std::size_t i, std::vector<Contact>& contacts) {
        const PlacedPair& p = pairs[i];
        return NarrowPhase({.margin = margin}).solve(*p.a, *p.pose_a, *p.b, *p.pose_b, Request::contacts, &contacts);
      };
      for (std::size_t first = 0; first < pairs.size();) {
        const auto some = std::span(spheres).subspan(first, std::min<std::size_t>(67, pairs.size() - first));
        std::vector<Result> results(some.size());
        std::vector<Contact> contacts(some.size());
        std::vector<std::uint32_t> numbers(some.size());
        const SpheresSolved solved =
            several.solve_spheres(some, {&results[0].answer, sizeof(Result), contacts.data(), numbers.data()});
        std::size_t told = 0;
        for (std::size_t k = 0; k < solved.pairs; ++k) {
          std::vector<Contact> own;
          const PairAnswer answer = solve_alone(first + k, own);
          if (own.empty()) continue;
          wrong += told >= solved.answers || numbers[told] != k || results[told].before != 7 ||
                   !same_bits(results[told].answer, answer) || !same_bits({contacts[told]}, own);
          ++told;
        }
        wrong += told != solved.answers;
        answered += told;
        alone += solved.pairs != some.size();
        first += solved.pairs + (solved.pairs != some.size() ? 1 : 0);
      }
      CHECK(wrong == 0);
      if (target != HWY_SVE && target != HWY_SVE2 && target != HWY_RVV) CHECK(answered > 700);
      CHECK(alone > 10);
    }
}

TEST_CASE("several pairs: spheres of another number of pairs are refused") {
  Random r(11);
  const Mixture mixture(r, 40);
  std::vector<Contact> contacts;
  Answers answers(mixture.pairs.size(), contacts);
  const auto some = std::span(mixture.spheres).first(3);
  CHECK_THROWS_AS(SeveralPairs().solve(mixture.pairs, contacts, answers, some), std::invalid_argument);
  CHECK(contacts.empty());
}
