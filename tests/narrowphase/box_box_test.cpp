// Boxes: distances, contacts, several pairs at once.
#include <algorithm>
#include <cmath>
#include <deque>
#include <string>

#include "catch.h"
#include "one_instruction_set.h"
#include "random_pairs.h"
#include "tandem/narrowphase/several_pairs.h"

using namespace tandem;
using namespace tandem::test;

TEST_CASE("box-box: two edges that cross touch in one point, with the depth between the edges") {
  // Each cube stands on an edge; the two edges cross at a right angle and overlap by 0.02.
  const Mat3 ra = Eigen::AngleAxisd(0.25 * M_PI, Vec3::UnitX()).toRotationMatrix();
  const Mat3 rb = Eigen::AngleAxisd(0.25 * M_PI, Vec3::UnitY()).toRotationMatrix();
  const Shape box(Box{{1, 1, 1}});
  const NarrowPhase n;
  const double reach = std::sqrt(0.5);
  std::vector<Contact> contacts;
  const auto answer =
      n.solve(box, {ra, Vec3::Zero()}, box, {rb, Vec3(0, 0, 2 * reach - 0.02)}, Request::contacts, &contacts);
  CHECK(std::abs(answer.signed_distance + 0.02) < 1e-14);
  CHECK(answer.normal.isApprox(Vec3::UnitZ(), 1e-12));
  REQUIRE(contacts.size() == 1);
  CHECK(contacts[0].point.isApprox(Vec3(0, 0, reach - 0.01), 1e-12));
}

TEST_CASE("box-box: stacked boxes touch in the four corners of the overlap") {
  const NarrowPhase n;
  const Shape big(Box{{4, 4, 1}}), small(Box{{1, 2, 1}});
  for (const double yaw : {0.0, 0.3, 1e-9, 0.5 * M_PI})
    for (const double tilt : {0.0, 1e-9, -1e-6}) {
      const Mat3 r =
          (Eigen::AngleAxisd(yaw, Vec3::UnitZ()) * Eigen::AngleAxisd(tilt, Vec3::UnitX())).toRotationMatrix();
      std::vector<Contact> contacts;
      const auto answer = n.solve(big, Pose{}, small, {r, Vec3(0.2, -0.3, 0.99)}, Request::contacts, &contacts);
      CAPTURE(yaw, tilt);
      CHECK(std::abs(answer.signed_distance + 0.01) < 2e-6);
      REQUIRE(contacts.size() == 4);
      for (const Contact& c : contacts) {
        CHECK(std::abs(c.depth - 0.01) < 2e-6);
        const Vec3 local = r.transpose() * (c.point - Vec3(0.2, -0.3, 0.99));
        CHECK(std::abs(std::abs(local.x()) - 0.5) < 1e-6);
        CHECK(std::abs(std::abs(local.y()) - 1.0) < 1e-6);
      }
      CHECK(std::is_sorted(contacts.begin(), contacts.end(),
                           [](const Contact& x, const Contact& y) { return x.feature < y.feature; }));
    }
}

TEST_CASE("box-box: nearly parallel edges never make depth of nothing") {
  Random r(21);
  const NarrowPhase n;
  const Shape box(Box{{1, 1, 1}});
  for (int i = 0; i < 2000; ++i) {
    const double angle = std::pow(10.0, r.in(-17, -1));
    const Mat3 turn = Eigen::AngleAxisd(angle, r.direction()).toRotationMatrix();
    const Vec3 t = r.vec(-0.3, 0.3);
    const auto answer = n.solve(box, Pose{}, box, {turn, t}, Request::distance);
    // Parallel boxes overlap by 1 - max |t|; a rotation by `angle` changes that by at most about 2 angles.
    CAPTURE(angle, t.transpose());
    CHECK(std::abs(-answer.signed_distance - (1 - t.cwiseAbs().maxCoeff())) < 2 * angle + 1e-14);
    CHECK(n.solve(box, Pose{}, box, {turn, t}, Request::collide).collide);
  }
}

TEST_CASE("box-box: a cube on a cube changes its verdict where it touches, far from the origin too") {
  const NarrowPhase n;
  const Shape box(Box{{1, 1, 1}});
  for (const double far : {0.0, 1e3, 1e6}) {
    const double ulp = 0x1p-30;
    CHECK(n.solve(box, Pose::at(far, far, far), box, Pose::at(far + 1, far, far), Request::collide).collide);
    CHECK_FALSE(
        n.solve(box, Pose::at(far, far, far), box, Pose::at(far + 1 + ulp, far, far), Request::collide).collide);
    CHECK(n.solve(box, Pose::at(far, far, far), box, Pose::at(far + 1 + ulp, far, far), Request::distance)
              .signed_distance == ulp);
  }
}

namespace {

/// Two boxes with a small overlap or gap, as in a pile.
struct CloseBoxes {
  Shape a, b;
  Pose pose_a, pose_b;
};
CloseBoxes close_boxes(Random& r, double least, double most) {
  const auto size = [&r] { return Vec3{std::pow(10.0, r.in(-1, 0.5)), std::pow(10.0, r.in(-1, 0.5)), r.in(0.2, 2)}; };
  CloseBoxes c{Box{size()}, Box{size()}, {r.rotation(), r.vec(-5, 5)}, {r.rotation(), Vec3::Zero()}};
  const Vec3 heading = r.direction();
  const auto gap = [&](double far) {
    c.pose_b.translation = c.pose_a.translation + far * heading;
    return NarrowPhase().solve(c.a, c.pose_a, c.b, c.pose_b, Request::distance).signed_distance;
  };
  const double wanted = r.in(least, most);
  double near = 0, far = 10;
  for (int i = 0; i < 60; ++i) (gap(0.5 * (near + far)) < wanted ? near : far) = 0.5 * (near + far);
  gap(near);
  return c;
}

}  // namespace

TEST_CASE("box-box: where a face of each parts them as much, either order of arguments names the same one") {
  const NarrowPhase n;
  const Shape box(Box{{1, 1, 1}});
  for (const double angle : {0.1, 0.3, -0.4}) {
    // Mirror images of each other.
    const Pose a{Eigen::AngleAxisd(angle, Vec3::UnitZ()).toRotationMatrix(), Vec3(-1, 0, 0)};
    const Pose b{Eigen::AngleAxisd(-angle, Vec3::UnitZ()).toRotationMatrix(), Vec3(1, 0, 0)};
    std::vector<Contact> contacts;
    const PairAnswer there = n.solve(box, a, box, b, Request::contacts, &contacts);
    const PairAnswer back = n.solve(box, b, box, a, Request::contacts, &contacts);
    CHECK(contacts.empty());
    CHECK(there.signed_distance > 0);
    CHECK(there.signed_distance == back.signed_distance);
    CHECK(there.normal.x() > 0.9);
    CHECK(there.normal == -back.normal);
  }
}

TEST_CASE("boxes told apart several at a time are those that the solver finds apart") {
  Random r(77);
  std::vector<CloseBoxes> boxes;
  for (int i = 0; i < 1500; ++i) {
    const double reach = std::pow(10.0, r.in(-13, 0));
    boxes.push_back(close_boxes(r, -reach, reach));
  }
  const Shape ball(Sphere{0.5});
  for (const double margin : {0.0, 1e-9, 0.01}) {
    const NarrowPhase n({.margin = margin});
    std::vector<PlacedPair> pairs;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const CloseBoxes& c = boxes[i];
      pairs.push_back({i % 7 == 3 ? &ball : &c.a, &c.pose_a, &c.b, &c.pose_b});
    }
    std::vector<std::uint8_t> apart(pairs.size(), 2);
    n.mark_apart(pairs, apart);
    int clear = 0, told = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      CAPTURE(margin, i);
      if (pairs[i].a == &ball) {
        CHECK(apart[i] == 0);
        continue;
      }
      const auto answer = n.solve(*pairs[i].a, *pairs[i].pose_a, *pairs[i].b, *pairs[i].pose_b, Request::distance);
      if (answer.signed_distance <= margin) CHECK(apart[i] == 0);
      // Separated along an axis by a fraction of the distance; one in a hundred may be left to the solver.
      if (answer.signed_distance > 4 * margin + 1e-9) ++clear, told += apart[i];
      std::uint8_t alone = 2;
      n.mark_apart({&pairs[i], 1}, {&alone, 1});
      CHECK(alone == apart[i]);
    }
    CHECK(clear > 40);
    CHECK((told == 0 || told > 0.9 * clear));  // 0: a machine without such vectors
  }
}

namespace {

/// Collects answers in order.
struct BoxAnswers final : AnswerSink {
  explicit BoxAnswers(const std::vector<Contact>& all) : contacts(all) {}
  PairAnswer& begin(std::size_t pair) override {
    pairs.push_back(pair);
    first.push_back(contacts.size());
    return answers.emplace_back();
  }
  void end() override { last.push_back(contacts.size()); }

  const std::vector<Contact>& contacts;
  std::vector<std::size_t> pairs, first, last;
  std::deque<PairAnswer> answers;
};

bool same(const PairAnswer& x, const PairAnswer& y) {
  return x.collide == y.collide && x.signed_distance == y.signed_distance && x.normal == y.normal &&
         x.point_a == y.point_a && x.point_b == y.point_b && x.status == y.status;
}
bool same(const Contact& x, const Contact& y) {
  return x.point == y.point && x.normal == y.normal && x.depth == y.depth && x.feature == y.feature;
}

/// A box that lies, stands on an edge or corner, or leans on a plane, by the class.
Pose on_ground(Random& r, const Shape& box, const Shape& ground, int kind) {
  Pose pose;
  if (kind == 0) pose.rotation = Eigen::AngleAxisd(r.in(0, 6), Vec3::UnitZ()).toRotationMatrix();
  if (kind == 1) pose.rotation = Eigen::AngleAxisd(r.in(0, 6), Vec3::UnitX()).toRotationMatrix();
  if (kind == 2) pose.rotation = r.rotation();
  if (kind == 3) pose.rotation = Eigen::AngleAxisd{std::pow(10.0, r.in(-12, -2)), r.direction()}.toRotationMatrix();
  const double height = NarrowPhase().solve(ground, {}, box, pose, Request::distance).signed_distance;
  const double gap = std::pow(10.0, r.in(-12, -0.5));
  pose.translation[2] = gap * (r.in(0, 1) < 0.3 ? 1 : -1) - height;
  return pose;
}

}  // namespace

TEST_CASE("several pairs at a time have the bits that they have one by one, on each instruction set") {
  Random r(79);
  const Shape ground(HalfSpace{{0, 0, 1}, 0}), ball(Sphere{0.5});
  std::vector<CloseBoxes> boxes;
  for (int i = 0; i < 4000; ++i) {
    CloseBoxes c = close_boxes(r, -0.1, 0);
    if (i % 5 == 0) c.pose_b.rotation = c.pose_a.rotation;  // aligned; and nearly so, in one axis and in all
    if (i % 5 == 1)
      c.pose_b.rotation = c.pose_a.rotation * Eigen::AngleAxisd(r.in(0, 6), Vec3::UnitZ()).toRotationMatrix();
    if (i % 5 == 2)
      c.pose_b.rotation =
          c.pose_a.rotation * Eigen::AngleAxisd{std::pow(10.0, r.in(-12, -1)), r.direction()}.toRotationMatrix();
    if (i % 11 == 0) c.b = c.a;
    const PairAnswer far = NarrowPhase().solve(c.a, c.pose_a, c.b, c.pose_b, Request::distance);
    const double gap = std::pow(10.0, r.in(-13, -0.5)), wanted = gap * (r.in(0, 1) < 0.8 ? -1 : 1);
    c.pose_b.translation += (wanted - far.signed_distance) * far.normal;
    if (i % 97 == 0) c.pose_b = c.pose_a;
    if (i % 101 == 0) c.b = c.a, c.pose_b.translation = c.pose_a.translation;
    boxes.push_back(c);
  }
  std::vector<Pose> standing;
  for (std::size_t i = 0; i < boxes.size(); ++i)
    standing.push_back(on_ground(r, boxes[i].a, ground, static_cast<int>(i % 4)));
  const Pose at;
  std::vector<PlacedPair> pairs;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const CloseBoxes& c = boxes[i];
    pairs.push_back({i % 7 == 3 ? &ball : &c.a, &c.pose_a, &c.b, &c.pose_b});
    if (i % 2 == 0) pairs.push_back({&c.b, &c.pose_b, &c.a, &c.pose_a});
    if (i % 3 == 0) pairs.push_back({&ground, &at, &c.a, &standing[i]});
    if (i % 3 == 1) pairs.push_back({&c.a, &standing[i], &ground, &at});
  }
  for (const double margin : {0.0, 0.01}) {
    const NarrowPhase one({.margin = margin});
    struct Own {
      PairAnswer answer;
      std::vector<Contact> contacts;
    };
    std::vector<Own> own(pairs.size());
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const PlacedPair& p = pairs[i];
      own[i].answer = one.solve(*p.a, *p.pose_a, *p.b, *p.pose_b, Request::contacts, &own[i].contacts);
    }
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
      const OneInstructionSet only(target);
      std::vector<Contact> contacts;
      BoxAnswers answers(contacts);
      SeveralPairs({.margin = margin}).solve(pairs, contacts, answers);
      std::size_t at_answer = 0, wrong = 0, told = 0, points[6] = {};
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        const bool given = at_answer < answers.pairs.size() && answers.pairs[at_answer] == i;
        if (!own[i].answer.collide && own[i].contacts.empty()) {
          if (given) wrong += answers.answers[at_answer].collide || answers.last[at_answer] != answers.first[at_answer];
        } else {
          CAPTURE(std::string(hwy::TargetName(target)), margin, i);
          REQUIRE(given);
          ++told;
          ++points[std::min<std::size_t>(own[i].contacts.size(), 5)];
          const auto its =
              std::span(contacts).subspan(answers.first[at_answer], answers.last[at_answer] - answers.first[at_answer]);
          const bool equal = same(answers.answers[at_answer], own[i].answer) &&
                             std::equal(its.begin(), its.end(), own[i].contacts.begin(), own[i].contacts.end(),
                                        [](const Contact& x, const Contact& y) { return same(x, y); });
          wrong += !equal;
        }
        at_answer += given;
      }
      CAPTURE(std::string(hwy::TargetName(target)), margin);
      CHECK(at_answer == answers.pairs.size());
      CHECK(wrong == 0);
      CHECK(told > 3000);
      for (const std::size_t count : {1u, 2u, 3u, 4u}) CHECK(points[count] > 20);
    }
  }
}

TEST_CASE("box-box: one contact point alone is given only where all that has gone in lies over the face") {
  Random r(78);
  const NarrowPhase n;
  int lone = 0, more = 0;
  for (int i = 0; i < 6000; ++i) {
    const CloseBoxes c = close_boxes(r, -0.05, -1e-4);
    std::vector<Contact> contacts;
    const auto answer = n.solve(c.a, c.pose_a, c.b, c.pose_b, Request::contacts, &contacts);
    REQUIRE(!contacts.empty());
    const Vec3 in_a = c.pose_a.rotation.transpose() * answer.normal,
               in_b = c.pose_b.rotation.transpose() * answer.normal;
    const bool of_a = in_a.cwiseAbs().maxCoeff() > 1 - 1e-12, of_b = in_b.cwiseAbs().maxCoeff() > 1 - 1e-12;
    if (of_a == of_b) continue;
    // The face whose normal it is, and the most opposed face of the other box.
    const Pose &pose = of_a ? c.pose_a : c.pose_b, &other = of_a ? c.pose_b : c.pose_a;
    const Vec3 size = (of_a ? c.a : c.b).half_size(), incident = (of_a ? c.b : c.a).half_size();
    Vec3 up = of_a ? in_a : Vec3(-in_b), facing = of_a ? Vec3(-in_b) : in_a;
    int axis, k;
    up.cwiseAbs().maxCoeff(&axis);
    facing.cwiseAbs().maxCoeff(&k);
    const double deepest = -answer.signed_distance;
    constexpr int steps = 20;
    int corners = 0;
    bool all_over = true;
    for (int x = -steps; x <= steps; ++x)
      for (int y = -steps; y <= steps; ++y) {
        Vec3 p = incident;
        p[k] *= facing[k] > 0 ? 1 : -1;
        p[(k + 1) % 3] *= static_cast<double>(x) / steps;
        p[(k + 2) % 3] *= static_cast<double>(y) / steps;
        const Vec3 q = pose.rotation.transpose() * (other * p - pose.translation);
        const double depth = size[axis] - std::copysign(1.0, up[axis]) * q[axis];
        if (depth < 0.02 * deepest) continue;
        corners += std::abs(x) == steps && std::abs(y) == steps;
        for (const int side : {(axis + 1) % 3, (axis + 2) % 3}) all_over &= std::abs(q[side]) < size[side] + 1e-3;
      }
    CAPTURE(i, corners, deepest);
    if (contacts.size() == 1 && corners > 0) {
      ++lone;
      CHECK(corners == 1);
      CHECK(all_over);
      CHECK(std::abs(contacts[0].depth - deepest) < 1e-12);
    } else if (corners == 1 && !all_over) {
      ++more;
    }
  }
  CHECK(lone > 300);
  CHECK(more > 30);
}

TEST_CASE("box-box: contacts along the axis of two edges near a face lie on that face and on the other box") {
  Random r(79);
  const NarrowPhase n;
  int patches = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto size = [&r] { return Vec3{r.in(0.5, 2), r.in(0.5, 2), r.in(0.5, 2)}; };
    const Shape a(Box{size()}), b(Box{size()});
    const Eigen::AngleAxisd tilt{std::pow(10.0, r.in(-4, -1.8)), r.direction()};
    const Mat3 turn = (tilt * Eigen::AngleAxisd(r.in(0, 2 * M_PI), Vec3::UnitZ())).toRotationMatrix();
    const Pose frame{r.rotation(), r.vec(-1, 1)};
    const double reach = 0.6 * (a.half_size()[0] + b.half_size()[0]);
    Pose on_top{turn, Vec3{r.in(-reach, reach), r.in(-reach, reach), 0}};
    on_top.translation[2] = 4;
    on_top.translation[2] -= n.solve(a, Pose{}, b, on_top, Request::distance).signed_distance + r.in(0.001, 0.01);
    const Pose pose_b{frame.rotation * on_top.rotation, frame * on_top.translation};
    std::vector<Contact> contacts;
    const auto answer = n.solve(a, frame, b, pose_b, Request::contacts, &contacts);
    if (!answer.collide) continue;
    const auto cosine = [&](const Pose& pose) {
      return (pose.rotation.transpose() * answer.normal).cwiseAbs().maxCoeff();
    };
    const double facing = std::max(cosine(frame), cosine(pose_b));
    if (facing < 0.9999 || facing > 1 - 1e-12) continue;
    ++patches;
    double deepest = 0;
    for (const Contact& c : contacts) {
      deepest = std::max(deepest, c.depth);
      const Vec3 on_a = c.point + 0.5 * c.depth * c.normal, on_b = c.point - 0.5 * c.depth * c.normal;
      const auto beyond = [](const Shape& box, const Pose& pose, const Vec3& p) -> Vec3 {
        return (pose.rotation.transpose() * (p - pose.translation)).cwiseAbs() - box.half_size();
      };
      // The face's point may lie beside the face by the normal's slant; in a patch, differences of 4e-9 of the size
      // count as equal.
      const auto face = [&](const Vec3& d) { return d.cwiseAbs().minCoeff() < 4e-8; };
      const auto surface = [](const Vec3& d) { return std::abs(d.maxCoeff()) < 4e-8; };
      const Vec3 of_a = beyond(a, frame, on_a), of_b = beyond(b, pose_b, on_b);
      CAPTURE(i, of_a.transpose(), of_b.transpose(), c.depth, facing);
      CHECK(((face(of_a) && surface(of_b)) || (face(of_b) && surface(of_a))));
    }
    CHECK(std::abs(deepest + answer.signed_distance) < 1e-12);
  }
  CHECK(patches > 200);
}

TEST_CASE("boxes flush with each other, rotations off from orthonormal by 1e-10: every answer is finite") {
  Random r(10);
  std::size_t near = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 size_a = r.vec(0.2, 2), size_b = r.vec(0.2, 2);
    Pose a{r.rotation(), Vec3::Zero()}, b = a;
    const int axis = r.below(3);
    Vec3 along = r.vec(-0.5, 0.5);
    along[axis] = (size_a[axis] + size_b[axis]) / 2;
    b.translation = a.rotation * along;
    for (Mat3* m : {&a.rotation, &b.rotation})
      for (int row = 0; row < 3; ++row)
        for (int k = 0; k < 3; ++k) (*m)(row, k) += r.in(-1e-10, 1e-10);
    std::vector<Contact> contacts;
    const NarrowPhase solver(NarrowPhaseOptions{.margin = 0.1});
    for (const Request request : {Request::distance, Request::contacts}) {
      const PairAnswer answer = solver.solve(Shape(Box{size_a}), a, Shape(Box{size_b}), b, request, &contacts);
      CAPTURE(i, answer.signed_distance);
      CHECK(std::abs(answer.normal.norm() - 1) < 1e-8);
      CHECK((answer.point_a.allFinite() && answer.point_b.allFinite()));
      near += std::abs(answer.signed_distance) < 1e-9 ? 1 : 0;
    }
    for (const Contact& c : contacts) CHECK((c.point.allFinite() && c.normal.allFinite()));
  }
  CHECK(near > 3000);
}

TEST_CASE("several pairs: boxes that touch, as rounding decides, are not skipped") {
  Random r(21);
  class Found final : public AnswerSink {
   public:
    PairAnswer& begin(std::size_t) override { return answer; }
    void end() override {}
    PairAnswer answer;
  } found;
  std::size_t touching = 0;
  for (int i = 0; i < 6000; ++i) {
    const Shape a(Box{r.vec(0.2, 2)}), b(Box{r.vec(0.2, 2)});
    const Pose pose_a = random_pose(r, 0.1);
    Pose pose_b = random_pose(r, 2);
    const NarrowPhase solver;
    for (int twice = 0; twice < 2; ++twice) {
      const PairAnswer at = solver.solve(a, pose_a, b, pose_b, Request::distance);
      pose_b.translation -= at.signed_distance * at.normal;
    }
    std::vector<Contact> alone, together;
    const PairAnswer answer = solver.solve(a, pose_a, b, pose_b, Request::contacts, &alone);
    const PlacedPair pair{&a, &pose_a, &b, &pose_b};
    SeveralPairs().solve(std::span(&pair, 1), together, found);
    CAPTURE(i, answer.collide, answer.signed_distance);
    CHECK(together.size() == alone.size());
    touching += answer.collide ? 1 : 0;
  }
  CHECK(touching > 2000);
}
