// Contacts kept from step to step, compared with computed ones.
#include "pipeline/kept_batch.h"

#include <oneapi/tbb/global_control.h>

#include <optional>
#include <random>

#include "catch.h"
#include "scene/mesh_generators.h"
#include "tandem/engine/builtin_scenes.h"
#include "tandem/engine/pipeline.h"
#include "tandem/engine/response.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/work_limit.h"

using namespace tandem;

namespace {

class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  double in(double lo, double hi) { return lo + (hi - lo) * (static_cast<double>(random_()) / 4294967296.0); }
  double power_of_ten(double lo, double hi) { return std::pow(10.0, in(lo, hi)); }
  Vec3 vector(double most) { return {in(-most, most), in(-most, most), in(-most, most)}; }
  Vec3 vec_of_length(double lo, double hi) {
    const double length = in(lo, hi);
    return length * vector(1).stableNormalized();
  }
  Quat rotation() { return Quat{in(-1, 1), in(-1, 1), in(-1, 1), in(-1, 1)}.normalized(); }
  Pose pose(double most) {
    const Quat turn = rotation();
    return Pose::from(turn, vector(most));
  }
  Mat3 turn(double angle) { return Eigen::AngleAxisd(angle, vector(1).stableNormalized()).toRotationMatrix(); }

 private:
  std::mt19937 random_;
};

/// The matrix as a rotation to rounding.
Mat3 cleaned(const Mat3& r) { return Quat(r).normalized().toRotationMatrix(); }

std::vector<Shape> convex_shapes() {
  Draw draw(3);
  Convex hull;
  for (int i = 0; i < 20; ++i) hull.vertices.push_back(draw.rotation() * Vec3(0.7, 0, 0));
  return {Box{{1, 0.6, 0.8}}, Cylinder{0.4, 0.9}, Shape(hull), Cone{0.5, 0.8}, Ellipsoid{{0.6, 0.4, 0.3}}};
}

double deepest(const ContactList& list) {
  double most = -1e300;
  for (const Contact& contact : list.contacts) most = std::max(most, contact.depth);
  return most;
}

/// Compares the answer for two bodies, kept or not, with the exact one.
void check_against_exact(const Scene& scene, const ContactList& list, double margin) {
  const NarrowPhase exact({.tolerance = 0, .margin = margin, .solver = {}});
  const Shape &a = scene.shape_of(0), &b = scene.shape_of(1);
  const auto poses = scene.poses();
  const PairAnswer truth = exact.solve(a, poses[0], b, poses[1], Request::distance);
  constexpr double rounding = 1e-9;
  if (list.pairs.empty()) {
    CHECK(truth.signed_distance > margin - rounding);
    return;
  }
  const PairAnswer& answer = list.pairs[0].answer;
  if (std::abs(truth.signed_distance) > rounding) CHECK(answer.collide == truth.collide);
  CHECK(std::abs(answer.signed_distance - truth.signed_distance) <= answer.error_bound + rounding);
  CHECK(std::abs(deepest(list) + truth.signed_distance) <= answer.error_bound + rounding);
  CHECK(answer.normal.norm() == Approx(1));
  // A translation along the normal by that length separates them, or keeps them that far apart.
  Pose moved = poses[1];
  moved.translation += (answer.error_bound + rounding - answer.signed_distance) * answer.normal;
  CHECK(exact.solve(a, poses[0], b, moved, Request::distance).signed_distance > -rounding);
}

}  // namespace

TEST_CASE("kept contacts: distance, depth, normal and verdict are right within the bound that is told") {
  const std::vector<Shape> shapes = convex_shapes();
  const double margin = 0.05;
  std::uint64_t kept = 0, computed = 0;
  double largest_bound = 0;
  for (std::size_t i = 0; i < shapes.size(); ++i)
    for (std::size_t j = i; j < shapes.size(); ++j) {
      CAPTURE(name(shapes[i].kind()), name(shapes[j].kind()));
      Draw draw(static_cast<unsigned>(10 * i + j + 1));
      for (int round = 0; round < 4; ++round) {
        Scene scene;
        Pose at_a = draw.pose(5), at_b = at_a;
        at_b.rotation = draw.rotation().toRotationMatrix();
        at_b.translation += draw.vec_of_length(0.4, 0.9);
        const BodyId a = scene.add_body({.shape = scene.add_shape(shapes[i]), .pose = at_a});
        const BodyId b = scene.add_body({.shape = scene.add_shape(shapes[j]), .pose = at_b});
        Pipeline pipeline({.executor = ExecutorKind::sequential, .answer = {.margin = margin, .keep_contacts = 0.01}});
        for (int step = 0; step < 40; ++step) {
          const StepReport report = pipeline.step(scene);
          kept += report.kept_pairs, computed += report.computed_pairs;
          largest_bound = std::max(largest_bound, report.kept_error_bound);
          check_against_exact(scene, pipeline.contacts(), margin);
          // Both move together, and slightly relative to each other.
          const double little = draw.power_of_ten(-7, -1.7);
          const Mat3 turn = draw.turn(draw.in(0, 1));
          const Vec3 shift = draw.vector(2);
          at_a = {cleaned(turn * at_a.rotation), turn * at_a.translation + shift};
          at_b = {cleaned(turn * at_b.rotation * draw.turn(little)),
                  turn * at_b.translation + shift + draw.vector(little)};
          scene.set_pose(a, at_a);
          scene.set_pose(b, at_b);
        }
      }
    }
  CHECK(kept > 500);
  CHECK(computed > 300);
  CHECK(largest_bound > 1e-3);
  double largest_size = 0;
  for (const Shape& shape : shapes) largest_size = std::max(largest_size, shape.size());
  CHECK(largest_bound <= 0.01 * largest_size);
}

TEST_CASE("kept contacts: answers of bodies at rest stand, and are right within the bound that is told") {
  std::vector<Shape> shapes = convex_shapes();
  shapes.emplace_back(Sphere{0.4});
  shapes.emplace_back(HalfSpace{Vec3(0, 0.6, 0.8), 0.1});
  const double margin = 0.05, tolerance = 1e-2;
  std::uint64_t kept = 0;
  double largest_bound = 0;
  for (std::size_t i = 0; i < shapes.size(); ++i)
    for (std::size_t j = 0; j < convex_shapes().size(); ++j) {
      CAPTURE(name(shapes[i].kind()), name(shapes[j].kind()));
      Draw draw(static_cast<unsigned>(20 * i + j + 1));
      const bool bounded = shapes[i].is_bounded();
      for (int round = 0; round < 4; ++round) {
        Scene scene;
        const Pose at_a = bounded ? draw.pose(5) : Pose{};
        Pose at_b = at_a;
        at_b.rotation = draw.rotation().toRotationMatrix();
        at_b.translation += draw.vec_of_length(0.2, 0.9);
        const BodyId a = scene.add_body({.shape = scene.add_shape(shapes[i]), .pose = at_a, .is_static = !bounded});
        const BodyId b = scene.add_body({.shape = scene.add_shape(shapes[j]), .pose = at_b});
        Pipeline pipeline(
            {.executor = ExecutorKind::sequential, .answer = {.margin = margin, .keep_contacts = tolerance}});
        // Each moves slightly by itself: a body at rest may be off by a thousandth of the tolerance.
        const double little = draw.power_of_ten(-8, -4.3);
        for (int step = 0; step < 20; ++step) {
          const StepReport report = pipeline.step(scene);
          kept += report.kept_pairs;
          largest_bound = std::max(largest_bound, report.kept_error_bound);
          check_against_exact(scene, pipeline.contacts(), margin);
          const auto moved = [&](const Pose& pose) {
            return Pose{cleaned(pose.rotation * draw.turn(draw.in(0, little))), pose.translation + draw.vector(little)};
          };
          if (bounded) scene.set_pose(a, moved(at_a));
          scene.set_pose(b, moved(at_b));
        }
      }
    }
  CHECK(kept > 1500);
  CHECK(largest_bound > 1e-5);
}

TEST_CASE("kept contacts: a drift is not lost however slow it is") {
  Scene scene;
  const ShapeId ball = scene.add_shape(Sphere{1});
  scene.add_body({.shape = ball});
  const BodyId other = scene.add_body({.shape = ball, .pose = Pose::at(1.9, 0, 0)});
  Pipeline pipeline({.answer = {.keep_contacts = 1e-3}});
  const double reach = 1e-3 * 1e-3 * scene.shape_of(0).size();
  std::uint64_t kept = 0, computed = 0;
  for (int step = 0; step < 300; ++step) {
    const double distance = 1.9 - 0.1 * reach * step;
    scene.set_pose(other, Pose::at(distance, 0, 0));
    const StepReport report = pipeline.step(scene);
    kept += report.kept_pairs;
    computed += report.computed_pairs;
    const PairAnswer& answer = pipeline.contacts().pairs.at(0).answer;
    CHECK(std::abs(answer.signed_distance - (distance - 2)) <= answer.error_bound + 1e-12);
    CHECK(answer.error_bound <= 4 * reach * (1 + 1e-9));
    CHECK(answer.error_bound == report.kept_error_bound);
  }
  CHECK(kept > 200);
  CHECK(computed > 20);
}

TEST_CASE("kept contacts: cubes come to rest on what is kept, and then hardly a pair is computed") {
  Scene scene = make_builtin_scene("cubes-on-plane", 120);
  Pipeline keeping(
      {.executor = ExecutorKind::sequential, .answer = {.margin = recommended_margin(scene), .keep_contacts = 1e-3}});
  Response response;
  StepReport report;
  for (int step = 0; step < 420; ++step) {
    report = keeping.step(scene);
    response.step(scene, keeping.contacts());
  }
  std::size_t slow = 0, moving = 0;
  for (std::uint32_t i = 0; i < scene.indices(); ++i) {
    if (scene.is_static()[i] != 0) continue;
    ++moving;
    slow += scene.velocities()[i].norm() < 1e-4 ? 1 : 0;
  }
  CHECK(slow * 10 > moving * 9);
  CHECK(report.kept_pairs > 10 * report.computed_pairs);
  CHECK(report.kept_error_bound <= 1e-3 * scene.shape_of(1).size());
}

TEST_CASE("kept contacts: in a scene verdicts between convex bodies are exact and depths within the bound") {
  Scene scene = make_builtin_scene("cubes-on-plane", 150);
  const double margin = recommended_margin(scene);
  Pipeline keeping({.executor = ExecutorKind::sequential, .answer = {.margin = margin, .keep_contacts = 1e-3}});
  Pipeline exact({.executor = ExecutorKind::sequential, .answer = {.margin = margin}});
  Response response;
  std::uint64_t kept = 0;
  double largest = 0, tolerated = 0;
  for (int step = 0; step < 240; ++step) {
    kept += keeping.step(scene).kept_pairs;
    exact.step(scene);
    const auto &found = keeping.contacts(), &truth = exact.contacts();
    std::vector<Pair> touching, truly;
    for (const PairResult& pair : found.pairs)
      if (pair.answer.collide) touching.push_back({pair.a, pair.b});
    for (const PairResult& pair : truth.pairs)
      if (pair.answer.collide) truly.push_back({pair.a, pair.b});
    REQUIRE(touching == truly);
    for (std::size_t i = 0, j = 0; i < found.pairs.size(); ++i) {
      const PairResult& pair = found.pairs[i];
      while (j < truth.pairs.size() && Pair{truth.pairs[j].a, truth.pairs[j].b} < Pair{pair.a, pair.b}) ++j;
      if (j == truth.pairs.size() || truth.pairs[j].a != pair.a || truth.pairs[j].b != pair.b) continue;
      const double off = std::abs(pair.answer.signed_distance - truth.pairs[j].answer.signed_distance);
      if (off > pair.answer.error_bound + 1e-9) FAIL_CHECK("off by " << off << " of " << pair.answer.error_bound);
      largest = std::max(largest, off);
      tolerated = std::max(tolerated, pair.answer.error_bound);
    }
    response.step(scene, found);
  }
  CHECK(kept > 20000);
  CHECK(largest > 0);
  CHECK(tolerated <= 1e-3 * std::sqrt(3.0));
}

TEST_CASE("kept contacts: verdicts between meshes that hardly touch are exact, and of those apart answers are kept") {
  Scene scene;
  const ShapeId ring = scene.add_shape(Shape(make_torus(1, 0.4, 24, 12)));
  Draw draw(91);
  const Pose at_a{draw.rotation().toRotationMatrix(), draw.vector(1)};
  Pose at_b{draw.rotation().toRotationMatrix(), at_a.translation};
  const Vec3 away = draw.vector(1).normalized();
  scene.add_body({.shape = ring, .pose = at_a});
  const BodyId b = scene.add_body({.shape = ring, .pose = at_b});
  const NarrowPhase exact;
  const Shape& shape = scene.shape_of(0);
  double touching = 0, apart = 3;
  for (int i = 0; i < 50; ++i) {
    at_b.translation = at_a.translation + (touching + apart) / 2 * away;
    const bool collide = exact.solve(shape, at_a, shape, at_b, Request::collide).collide;
    (collide ? touching : apart) = (touching + apart) / 2;
  }
  Pipeline pipeline({.executor = ExecutorKind::sequential, .answer = {.keep_contacts = 1e-2}});
  int kept_touching = 0, kept_apart = 0, changed = 0;
  bool before = false;
  for (int step = 0; step < 400; ++step) {
    at_b.translation = at_a.translation + (touching + 1e-4 * std::sin(0.3 * step) * draw.in(0, 1)) * away;
    scene.set_pose(b, at_b);
    const StepReport report = pipeline.step(scene);
    const PairAnswer truth = exact.solve(shape, at_a, shape, at_b, Request::distance);
    const auto& found = pipeline.contacts().pairs;
    REQUIRE(found.empty() == !truth.collide);
    changed += truth.collide != before ? 1 : 0;
    before = truth.collide;
    if (report.kept_pairs != 0) ++(truth.collide ? kept_touching : kept_apart);
    if (found.empty()) continue;
    CHECK(found[0].answer.collide);
    CHECK(found[0].answer.signed_distance <= 0);
    CHECK(std::abs(found[0].answer.signed_distance - truth.signed_distance) <= found[0].answer.error_bound + 1e-6);
  }
  CHECK(changed > 20);
  CHECK(kept_touching == 0);  // the deepest contact of two meshes may be another one in the next pose
  CHECK(kept_apart > 20);
}

TEST_CASE("kept contacts: depths of meshes in each other are right within the bound that is told, however they jump") {
  Scene scene;
  const ShapeId ring = scene.add_shape(Shape(make_torus(1, 0.4, 24, 12)));
  const ShapeId box = scene.add_shape(Shape(Box{{0.7, 0.9, 1.1}}));
  Draw draw(17);
  std::vector<BodyId> ids;
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < 24; ++i) {
    // Pairs of neighbours, far from the others.
    poses.push_back(
        {draw.rotation().toRotationMatrix(), Vec3(9.0 * static_cast<double>(i / 2), 0, 0) + draw.vector(0.9)});
    ids.push_back(scene.add_body({.shape = i % 4 == 3 ? box : ring, .pose = poses.back()}));
  }
  Pipeline keeping({.executor = ExecutorKind::sequential, .answer = {.keep_contacts = 1e-2}});
  Pipeline exact({.executor = ExecutorKind::sequential});
  std::size_t compared = 0;
  double most = 0;  // the largest change of a depth from one step to the next
  std::vector<double> before(poses.size(), 0);
  for (int step = 0; step < 200; ++step) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      poses[i].translation += draw.vector(2e-4);
      scene.set_pose(ids[i], poses[i]);
    }
    keeping.step(scene);
    exact.step(scene);
    const auto &found = keeping.contacts(), &truth = exact.contacts();
    REQUIRE(found.pairs.size() == truth.pairs.size());
    for (std::size_t i = 0; i < found.pairs.size(); ++i) {
      const PairAnswer &kept = found.pairs[i].answer, &right = truth.pairs[i].answer;
      REQUIRE(found.pairs[i].a == truth.pairs[i].a);
      const double off = std::abs(kept.signed_distance - right.signed_distance);
      if (off > kept.error_bound + 1e-9) FAIL_CHECK("step " << step << ": off by " << off);
      double& last = before[found.pairs[i].a];
      if (last != 0) most = std::max(most, std::abs(right.signed_distance - last));
      last = right.signed_distance;
      ++compared;
    }
  }
  CHECK(compared > 1500);
  CHECK(most > 1e-2);  // there are jumps
}

TEST_CASE("kept contacts: the same bits for every executor and number of threads") {
  const tbb::global_control many(tbb::global_control::max_allowed_parallelism, 8);
  for (const char* builtin : {"cubes-on-plane", "tori-and-cubes", "screws-in-bowl"}) {
    CAPTURE(builtin);
    Scene scene = make_builtin_scene(builtin, 50);
    std::vector<Pipeline> pipelines;
    for (const auto& [kind, threads] : {std::pair{ExecutorKind::sequential, 1}, std::pair{ExecutorKind::barrier, 2},
                                        std::pair{ExecutorKind::threads, 2}, std::pair{ExecutorKind::flowgraph, 1},
                                        std::pair{ExecutorKind::flowgraph, 2}, std::pair{ExecutorKind::flowgraph, 5}}) {
      PipelineOptions options{.executor = kind, .threads = threads, .answer = {.margin = recommended_margin(scene)}};
      options.answer.keep_contacts = 1e-3;
      options.sharing.short_step_ms = 0;
      options.answer.contact_hash = true;
      options.batches.pairs = pipelines.size() % 2 == 0 ? 128 : 7;
      options.broad_phase = pipelines.size() % 3 == 0 ? BroadPhaseKind::brute : BroadPhaseKind::automatic;
      pipelines.emplace_back(options);
    }
    Response response;
    Draw draw(1);
    std::uint64_t kept = 0;
    for (int step = 0; step < 90; ++step) {
      const StepReport first = pipelines.front().step(scene);
      kept += first.kept_pairs;
      for (std::size_t i = 1; i < pipelines.size(); ++i) {
        const StepReport report = pipelines[i].step(scene);
        CAPTURE(step, i);
        REQUIRE(report.contact_hash == first.contact_hash);
        REQUIRE(report.kept_pairs == first.kept_pairs);
        REQUIRE(report.kept_error_bound == first.kept_error_bound);
      }
      // At the end most bodies rest, a few tremble, and one leaves.
      if (step < 60) {
        response.step(scene, pipelines.front().contacts());
        continue;
      }
      for (std::uint32_t i = 0; i < scene.indices(); ++i) {
        if (scene.is_static()[i] != 0 || i % 7 != 0) continue;
        Pose pose = scene.poses()[i];
        pose.translation += draw.vector(i % 2 == 0 ? 1e-8 : 1e-5);
        if (step == 70 && i % 21 == 0) pose.translation.z() += 3;
        scene.move(i, pose, Vec3::Zero(), Vec3::Zero());
      }
    }
    CHECK(kept > 500);
  }
}

namespace {

/// All kinds of bodies in a small room: most rest, some tremble, crawl, jump, appear or leave. Beside it a few balls
/// rest on the ground, and whether they touch it changes.
class CrowdedRoom {
 public:
  static constexpr int in_doubt = 4;
  CrowdedRoom() {
    shapes_ = {scene.add_shape(Box{{1, 0.6, 0.8}}), scene.add_shape(Sphere{0.5}), scene.add_shape(Cylinder{0.4, 0.9}),
               scene.add_shape(Box{Vec3::Constant(0.7)})};
    scene.add_body({.shape = scene.add_shape(HalfSpace{Vec3::UnitZ(), 0}), .is_static = true});
    for (int i = 0; i < 70; ++i) ids_.push_back(add());
    for (int i = 0; i < in_doubt; ++i)
      touching_.push_back(scene.add_body({.shape = shapes_[1], .pose = Pose::at(10 + 2 * i, 0, 0.5)}));
  }
  /// The changes before the next step.
  void go_on(int step) {
    // In some steps almost nothing happens, so that nearly all rest; in others most move.
    for (const BodyId id : touching_) {
      const Vec3 at = scene.pose(id).translation;
      scene.set_pose(id, Pose::at(at.x(), at.y(), 0.5 + draw_.in(-1e-8, 1e-8)));
    }
    const double busy = step % 12 < 4 ? 0 : step % 12 == 11 ? 0.8 : 0.1;
    for (BodyId& id : ids_) {
      if (draw_.in(0, 1) >= busy) {
        if (step % 3 == 0) scene.set_pose(id, scene.pose(id));  // written, but unchanged
        continue;
      }
      Pose pose = scene.pose(id);
      const double what = draw_.in(0, 1);
      if (what < 0.9) {
        const double far = draw_.power_of_ten(-8, -1);
        pose.translation += draw_.vector(far);
        pose.rotation = cleaned(pose.rotation * draw_.turn(draw_.in(0, far)));
        scene.set_pose(id, pose);
      } else if (what < 0.96) {
        scene.set_pose(id, somewhere());
      } else if (step % 12 > 7) {
        scene.remove_body(id);
        id = add();
      }
    }
  }
  Scene scene;

 private:
  Pose somewhere() { return Pose::from(draw_.rotation(), draw_.vector(1.5) + Vec3(0, 0, 1.2)); }
  BodyId add() {
    const auto kind = static_cast<std::size_t>(draw_.in(0, 4));
    return scene.add_body({.shape = shapes_[kind], .pose = somewhere(), .is_static = draw_.in(0, 1) < 0.1});
  }
  Draw draw_{5};
  std::vector<ShapeId> shapes_;
  std::vector<BodyId> ids_, touching_;
};

struct Interruption {};

/// The list is sorted without gaps, and the report agrees with it.
void check_list(const ContactList& list, const StepReport& report) {
  std::uint64_t colliding = 0, touching = 0;
  double max_depth = 0;
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < list.pairs.size(); ++i) {
    const PairResult& pair = list.pairs[i];
    if (i > 0) REQUIRE(Pair{list.pairs[i - 1].a, list.pairs[i - 1].b} < Pair{pair.a, pair.b});
    REQUIRE(pair.first_contact == next);
    next += pair.contact_count;
    colliding += pair.answer.collide ? 1 : 0;
  }
  REQUIRE(next == list.contacts.size());
  for (const Contact& contact : list.contacts) {
    touching += contact.depth < 0 ? 0 : 1;
    max_depth = std::max(max_depth, contact.depth);
  }
  REQUIRE(report.colliding_pairs == colliding);
  REQUIRE(report.contacts == touching);
  REQUIRE(report.gaps == list.contacts.size() - touching);
  REQUIRE(report.max_depth == max_depth);
}

/// Compares kept answers of convex bodies with exact ones.
void check_answers(const ContactList& kept, const ContactList& exact, const StepReport& report) {
  double largest = 0;
  const auto of = [](const PairResult& pair) { return Pair{pair.a, pair.b}; };
  auto at = kept.pairs.begin();
  for (const PairResult& truth : exact.pairs) {
    for (; at != kept.pairs.end() && of(*at) < of(truth); ++at) REQUIRE_FALSE(at->answer.collide);
    const bool there = at != kept.pairs.end() && of(*at) == of(truth);
    if (truth.answer.collide) REQUIRE(there);
    if (!there) continue;
    CAPTURE(truth.a, truth.b);
    REQUIRE(at->answer.collide == truth.answer.collide);
    REQUIRE(std::abs(at->answer.signed_distance - truth.answer.signed_distance) <= at->answer.error_bound + 1e-9);
    largest = std::max(largest, at->answer.error_bound);
    ++at;
  }
  REQUIRE(report.kept_error_bound <= 0.01 * 1.45);     // the largest body
  REQUIRE(largest <= report.kept_error_bound + 1e-9);  // computed ones are off by rounding
}

}  // namespace

TEST_CASE("kept contacts: what changes in its place is what it would be if all pairs were asked for") {
  const tbb::global_control many(tbb::global_control::max_allowed_parallelism, 8);
  CrowdedRoom room;
  std::vector<Pipeline> pipelines;
  bool interrupt = false;
  const auto options = [&](ExecutorKind kind, int threads) {
    PipelineOptions wanted{.executor = kind, .threads = threads, .answer = {.margin = 0.02, .keep_contacts = 0.01}};
    wanted.sharing.short_step_ms = 0;
    wanted.answer.contact_hash = true;
    wanted.batches.pairs = pipelines.size() % 2 == 0 ? 128 : 5;
    wanted.broad_phase = pipelines.size() % 3 == 2 ? BroadPhaseKind::sweep : BroadPhaseKind::automatic;
    return wanted;
  };
  for (const auto& [kind, threads] : {std::pair{ExecutorKind::sequential, 1}, std::pair{ExecutorKind::barrier, 2},
                                      std::pair{ExecutorKind::threads, 3}, std::pair{ExecutorKind::flowgraph, 2},
                                      std::pair{ExecutorKind::flowgraph, 5}, std::pair{ExecutorKind::fused, 2}})
    pipelines.emplace_back(options(kind, threads));
  PipelineOptions ordered = options(ExecutorKind::flowgraph, 3);
  ordered.sharing.form = StepForm::ordered;
  pipelines.emplace_back(ordered);
  // A predicate that may leave out any pair must be called for all pairs.
  PipelineOptions asks_all = options(ExecutorKind::sequential, 1);
  asks_all.predicate = [&](std::span<Pair> pairs) {
    if (interrupt) throw Interruption();
    return pairs.size();
  };
  pipelines.emplace_back(asks_all);
  Pipeline exact({.executor = ExecutorKind::sequential, .answer = {.margin = 0.02}});
  std::uint64_t kept = 0, computed = 0, quiet_steps = 0;
  for (int step = 0; step < 240; ++step) {
    CAPTURE(step);
    if (step % 29 == 28) {  // stopped early
      std::stop_source stop;
      stop.request_stop();
      for (Pipeline& pipeline : pipelines) {
        interrupt = &pipeline == &pipelines.back();
        if (interrupt)
          CHECK_THROWS_AS(pipeline.step(room.scene), Interruption);
        else
          pipeline.step(room.scene, stop.get_token());
        CHECK(pipeline.contacts().pairs.empty());
      }
      interrupt = false;
    }
    const StepReport all = pipelines.back().step(room.scene);
    for (std::size_t i = 0; i + 1 < pipelines.size(); ++i) {
      CAPTURE(i);
      const StepReport report = pipelines[i].step(room.scene);
      REQUIRE(report.contact_hash == all.contact_hash);
      REQUIRE(report.execution.candidate_pairs == all.execution.candidate_pairs);
      REQUIRE(report.kept_pairs == all.kept_pairs);
      REQUIRE(report.computed_pairs == all.computed_pairs);
      REQUIRE(report.kept_error_bound == all.kept_error_bound);
      REQUIRE((report.execution.issues & bit(StepIssue::inexact)) == (all.execution.issues & bit(StepIssue::inexact)));
      check_list(pipelines[i].contacts(), report);
    }
    exact.step(room.scene);
    check_answers(pipelines.front().contacts(), exact.contacts(), all);
    kept += all.kept_pairs;
    computed += all.computed_pairs;
    quiet_steps += all.computed_pairs <= CrowdedRoom::in_doubt ? 1 : 0;
    room.go_on(step);
  }
  CHECK(kept > 20000);
  CHECK(computed > 5000);
  CHECK(quiet_steps > 20);
}

TEST_CASE("kept contacts: a pair of two that rest is found again whoever of them moves, a static body too") {
  for (const bool is_static : {false, true}) {
    Scene scene;
    const ShapeId box = scene.add_shape(Box{Vec3::Constant(1)});
    const BodyId table = scene.add_body({.shape = box, .is_static = is_static});
    const BodyId cup = scene.add_body({.shape = box, .pose = Pose::at(0, 0, 0.95)});
    scene.add_body({.shape = box, .pose = Pose::at(0, 5, 0), .is_static = true});
    scene.add_body({.shape = box, .pose = Pose::at(0, 5, 0.5), .is_static = true});
    Pipeline pipeline({.answer = {.keep_contacts = 1e-3}});
    const auto pairs = [&] {
      const StepReport report = pipeline.step(scene);
      REQUIRE(report.execution.candidate_pairs == report.kept_pairs + report.computed_pairs);
      REQUIRE(report.execution.candidate_pairs == pipeline.contacts().pairs.size());
      return pipeline.contacts().pairs.size();
    };
    for (const BodyId who : {table, cup}) {
      const Pose before = scene.pose(who);
      for (int step = 0; step < 4; ++step) CHECK(pairs() == 1);
      scene.set_pose(who, Pose::at(9, 0, 0));
      for (int step = 0; step < 3; ++step) CHECK(pairs() == 0);
      scene.set_pose(who, before);
      for (int step = 0; step < 3; ++step) CHECK(pairs() == 1);
    }
    const BodyId other = scene.add_body({.shape = box, .pose = Pose::at(0.9, 0, 0.5)});
    for (int step = 0; step < 3; ++step) CHECK(pairs() == 3);
    scene.remove_body(cup);
    for (int step = 0; step < 3; ++step) CHECK(pairs() == 1);
    scene.remove_body(other);
    for (int step = 0; step < 3; ++step) CHECK(pairs() == 0);
  }
}

TEST_CASE("kept contacts: a pair that came to rest with an answer moved into doubt is computed anew") {
  constexpr double gap = 3e-4;
  const Mat3 tilt = Eigen::AngleAxisd(0.7, Vec3::UnitY()).toRotationMatrix();  // so that their boxes overlap
  const auto at = [&](double x, double z) { return Pose{tilt, tilt * Vec3(x, 0, z)}; };
  for (const double distance : {-gap, gap}) {
    CAPTURE(distance);
    Scene scene;
    const ShapeId box = scene.add_shape(Box{Vec3::Constant(1)});
    scene.add_body({.shape = box, .pose = at(0, 0), .is_static = true});
    const BodyId cup = scene.add_body({.shape = box, .pose = at(0, 1 + distance)});
    Pipeline pipeline({.answer = {.keep_contacts = 1e-3}});
    CHECK(pipeline.step(scene).computed_pairs == 1);
    constexpr double sideways = gap - 1e-6;
    scene.set_pose(cup, at(sideways, 1 + distance));
    CHECK(pipeline.step(scene).kept_pairs == 1);
    for (const PairResult& pair : pipeline.contacts().pairs) CHECK(pair.answer.error_bound == Approx(2 * sideways));
    CHECK(pipeline.step(scene).computed_pairs == 1);
    for (int step = 0; step < 3; ++step) {
      CHECK(pipeline.step(scene).kept_pairs == 1);
      CHECK(pipeline.contacts().pairs.size() == (distance < 0 ? 1 : 0));
      for (const PairResult& pair : pipeline.contacts().pairs) {
        CHECK(pair.answer.signed_distance == Approx(distance));
        CHECK(pair.answer.error_bound < 0.02 * sideways);
      }
    }
  }
}

TEST_CASE("kept contacts: pairs that a body had in passing are gone when it has moved on, whichever comes first") {
  for (const bool is_first : {false, true}) {
    Scene scene;
    const ShapeId box = scene.add_shape(Box{Vec3::Constant(1)});
    std::optional<BodyId> visitor;
    const Pose away = Pose::at(-9, 0, 0);
    if (is_first) visitor = scene.add_body({.shape = box, .pose = away});
    constexpr int tables = 8;
    for (int i = 0; i < tables; ++i) {
      scene.add_body({.shape = box, .pose = Pose::at(3 * i, 0, 0)});
      scene.add_body({.shape = box, .pose = Pose::at(3 * i, 0, 0.95)});
    }
    if (!is_first) visitor = scene.add_body({.shape = box, .pose = away});
    Pipeline pipeline({.answer = {.keep_contacts = 1e-3}});
    const auto pairs = [&] {
      const StepReport report = pipeline.step(scene);
      REQUIRE(report.execution.candidate_pairs == pipeline.contacts().pairs.size());
      return pipeline.contacts().pairs.size();
    };
    for (int step = 0; step < 3; ++step) REQUIRE(pairs() == tables);
    for (int i = 0; i < tables; ++i) {
      CAPTURE(is_first, i);
      scene.set_pose(*visitor, Pose::at(3 * i, 0.5, 1.9));
      CHECK(pairs() == tables + 1);
      if (i % 3 == 0) CHECK(pairs() == tables + 1);
    }
    scene.set_pose(*visitor, away);
    CHECK(pairs() == tables);
  }
}

TEST_CASE("kept contacts: nothing is taken over from another shape, another scene or a step that ended early") {
  const auto make = [](double size) {
    Scene scene;
    scene.add_body({.shape = scene.add_shape(Box{Vec3::Constant(1)})});
    scene.add_body({.shape = scene.add_shape(Box{Vec3::Constant(size)}), .pose = Pose::at(0.9, 0.1, 0.2)});
    return scene;
  };
  Scene scene = make(1);
  const Scene other = make(1.05);
  Pipeline pipeline({.answer = {.keep_contacts = 1e-2}});
  const auto depth = [&] { return -pipeline.contacts().pairs.at(0).answer.signed_distance; };
  CHECK(pipeline.step(scene).kept_pairs == 0);
  CHECK(depth() == Approx(0.1));
  CHECK(pipeline.step(scene).kept_pairs == 1);
  CHECK(depth() == Approx(0.1));

  CHECK(pipeline.step(other).kept_pairs == 0);
  CHECK(depth() == Approx(0.125));
  CHECK(pipeline.step(scene).kept_pairs == 0);
  CHECK(depth() == Approx(0.1));

  // Another body with the same index.
  scene.remove_body(scene.id(1));
  scene.add_body({.shape = scene.add_shape(Box{Vec3::Constant(1.1)}), .pose = Pose::at(0.9, 0.1, 0.2)});
  CHECK(pipeline.step(scene).kept_pairs == 0);
  CHECK(depth() == Approx(0.15));

  CHECK(pipeline.step(scene).kept_pairs == 1);
  std::stop_source stop;
  stop.request_stop();
  const StepReport stopped = pipeline.step(scene, stop.get_token());
  CHECK((stopped.execution.issues & bit(StepIssue::ended_early)) != 0);
  CHECK(pipeline.step(scene).kept_pairs == 0);
  CHECK(pipeline.step(scene).kept_pairs == 1);

  // Nor from earlier than the last step.
  const Pose near = scene.poses()[1];
  scene.set_pose(scene.id(1), Pose::at(9, 0, 0));
  pipeline.step(scene);
  scene.set_pose(scene.id(1), near);
  CHECK(pipeline.step(scene).kept_pairs == 0);
}

TEST_CASE("kept contacts: off by default, closed forms at rest only, none for yes or no, odd tolerances are refused") {
  Scene scene;
  const ShapeId ball = scene.add_shape(Sphere{1}), box = scene.add_shape(Box{Vec3::Constant(1)});
  scene.add_body({.shape = ball});
  scene.add_body({.shape = ball, .pose = Pose::at(1.5, 0, 0)});
  Pipeline balls({.answer = {.keep_contacts = 1e-2}});
  balls.step(scene);
  CHECK(balls.step(scene).kept_pairs == 1);
  scene.set_pose(scene.id(1), Pose::at(1.499, 0, 0));
  CHECK(balls.step(scene).kept_pairs == 0);
  scene.add_body({.shape = box, .pose = Pose::at(0, 9, 0)});
  scene.add_body({.shape = box, .pose = Pose::at(0, 9.5, 0)});
  CHECK(balls.step(scene).kept_pairs == 1);
  CHECK(balls.step(scene).kept_pairs == 2);
  scene.set_pose(scene.id(1), Pose::at(1.498, 0, 0));
  scene.set_pose(scene.id(3), Pose::at(0, 9.501, 0));
  CHECK(balls.step(scene).kept_pairs == 1);
  Pipeline standard;
  standard.step(scene);
  CHECK(standard.step(scene).kept_pairs == 0);
  Pipeline verdicts({.answer = {.request = Request::collide, .keep_contacts = 1e-2}});
  verdicts.step(scene);
  CHECK(verdicts.step(scene).kept_pairs == 0);
  Pipeline distances({.answer = {.request = Request::distance, .keep_contacts = 1e-2}});
  distances.step(scene);
  CHECK(distances.step(scene).kept_pairs == 2);
  CHECK(distances.contacts().pairs.at(1).answer.signed_distance == Approx(-0.499));
  CHECK_THROWS_WITH(Pipeline({.answer = {.keep_contacts = 0.2}}),
                    Catch::Matchers::Contains("answer.keep_contacts: 0.2"));
  CHECK_THROWS_WITH(Pipeline({.answer = {.keep_contacts = std::nan("")}}),
                    Catch::Matchers::Contains("answer.keep_contacts"));
}

TEST_CASE("kept contacts: what pairs that come and go leave behind does not add up") {
  Scene scene;
  const ShapeId box = scene.add_shape(Box{Vec3::Constant(1)});
  for (int i = 0; i < 2000; ++i) scene.add_body({.shape = box});
  KeptContacts kept(Request::contacts, 1e-3, 0);
  constexpr std::uint32_t pairs = 50;
  std::size_t most = 0;
  ContactList list;
  std::vector<std::uint8_t> changed;
  for (std::uint32_t step = 0; step < 2000; ++step) {
    kept.begin_step(scene, list, false, {});
    list = {};
    changed.assign(scene.indices(), 1);
    kept.update_rests(0, changed);
    {
      KeptContacts::Batch batch(kept, list.pairs, list.contacts);
      for (std::uint32_t i = 0; i < pairs; ++i) {
        PairResult result{step % 900, 1000 + (step / 900 * 300 + i) % 1000, 0, 0, {}};
        const Pair pair{result.a, result.b};
        REQUIRE(batch.append_valid(std::span(&pair, 1)) == 0);
        REQUIRE_FALSE(batch.extrapolate(pair, result));
        batch.store(result, {});
        batch.record(result, {}, false);
      }
    }
    kept.end_step(list);
    most = std::max(most, kept.entries());
  }
  CHECK(most <= 3 * pairs + 64);
}

TEST_CASE("kept contacts: a ball that spins in its place rests, a cube does not") {
  for (const Shape& shape : {Shape(Sphere{0.5}), Shape(Box{{1, 1, 1}})}) {
    const bool is_ball = shape.kind() == ShapeKind::sphere;
    CAPTURE(name(shape.kind()));
    Scene scene;
    const ShapeId id = scene.add_shape(shape);
    const BodyId spinning = scene.add_body({.shape = id, .pose = Pose::at(0, 0, 0)});
    scene.add_body({.shape = id, .pose = Pose::at(0, 0, 0.9)});
    Pipeline pipeline({.executor = ExecutorKind::sequential, .answer = {.keep_contacts = 1e-3}});
    pipeline.step(scene);
    pipeline.step(scene);
    for (int step = 1; step <= 5; ++step) {
      Pose pose = Pose::at(0, 0, 1e-9 * step);
      pose.rotation = Eigen::AngleAxisd(0.3 * step, Vec3::UnitZ()).toRotationMatrix();
      scene.set_pose(spinning, pose);
      const StepReport report = pipeline.step(scene);
      CHECK(report.computed_pairs == (is_ball ? 0 : 1));
      REQUIRE(pipeline.contacts().pairs.size() == 1);
      const double depth = 0.1 + 1e-9 * step;
      const PairAnswer& answer = pipeline.contacts().pairs[0].answer;
      CHECK(std::abs(answer.signed_distance + depth) <= answer.error_bound + 1e-12);
    }
  }
}

TEST_CASE("kept contacts: where another scene had a body and this one never has, there are no contacts") {
  const auto make = [](std::size_t bodies, bool first_goes) {
    Scene scene;
    const ShapeId ball = scene.add_shape(Sphere{0.5});
    const BodyId first = scene.add_body({.shape = ball});  // all at the origin
    for (std::size_t i = 1; i < bodies; ++i) scene.add_body({.shape = ball});
    if (first_goes) scene.remove_body(first);
    return scene;
  };
  Pipeline pipeline({.executor = ExecutorKind::sequential, .answer = {.keep_contacts = 1e-3}});
  const Scene whole = make(3, false), emptied = make(2, true);
  for (int step = 0; step < 3; ++step) {
    pipeline.step(whole);
    CHECK(pipeline.contacts().pairs.size() == 3);
  }
  for (int step = 0; step < 3; ++step) {
    pipeline.step(emptied);
    CHECK(pipeline.contacts().pairs.empty());
  }
}
