// Detection on ranks, compared with one machine.
#include "tandem/mpi/pipeline.h"

#include <array>
#include <optional>

#include "tandem/mpi/contact_events.h"
#include "world.h"

using namespace tandem;
using mpi::GlobalId;

namespace {

/// A built-in scene on one machine: rank 0 computes, all ranks get the results.
class Reference {
 public:
  explicit Reference(std::string_view name, double keep)
      : scene(make_builtin_scene(name, 40)), margin(recommended_margin(scene)) {
    if (world::rank() == 0) {
      const auto begin = [&] {
        alone_.emplace(PipelineOptions{.executor = ExecutorKind::sequential,
                                       .threads = 1,
                                       .answer = {.margin = margin, .keep_contacts = keep, .contact_hash = true}});
      };
      begin();
      for (int step = 0; step < 25; ++step) {  // until they have fallen onto each other
        alone_->step(scene);
        response_.step(scene, alone_->contacts());
      }
      begin();
    }
    tell_places();
  }
  void detect() {
    std::array<std::uint64_t, 7> told{};
    std::array<double, 2> most{};
    if (world::rank() == 0) {
      report = alone_->step(scene);
      answers = world::gathered(alone_->contacts(), world::all_indices(scene));
      told = {mpi::hash(answers),
              report.execution.candidate_pairs,
              report.colliding_pairs,
              report.contacts,
              report.gaps,
              report.contact_hash,
              report.kept_pairs};
      most = {report.max_depth, report.kept_error_bound};
    }
    MPI_Bcast(told.data(), 7, MPI_UINT64_T, 0, MPI_COMM_WORLD);
    MPI_Bcast(most.data(), 2, MPI_DOUBLE, 0, MPI_COMM_WORLD);
    hash = told[0];
    report.bodies = scene.bodies();
    report.execution.candidate_pairs = told[1];
    report.colliding_pairs = told[2];
    report.contacts = told[3];
    report.gaps = told[4];
    report.contact_hash = told[5];
    report.kept_pairs = told[6];
    report.max_depth = most[0];
    report.kept_error_bound = most[1];
  }
  void respond() {
    if (world::rank() == 0) response_.step(scene, alone_->contacts());
    tell_places();
  }

  Scene scene;
  double margin;
  StepReport report;
  std::uint64_t hash = 0;
  mpi::GatheredContacts answers;  // on rank 0

 private:
  void tell_places() {
    for (std::uint32_t i = 0; i < scene.indices(); ++i) {
      std::array<double, 18> numbers{};
      if (world::rank() == 0) {
        Eigen::Map<Mat3>(numbers.data()) = scene.poses()[i].rotation;
        Eigen::Map<Vec3>(numbers.data() + 9) = scene.poses()[i].translation;
        Eigen::Map<Vec3>(numbers.data() + 12) = scene.velocities()[i];
        Eigen::Map<Vec3>(numbers.data() + 15) = scene.angular_velocities()[i];
      }
      all_.insert(all_.end(), numbers.begin(), numbers.end());
    }
    MPI_Bcast(all_.data(), static_cast<int>(all_.size()), MPI_DOUBLE, 0, MPI_COMM_WORLD);
    for (std::uint32_t i = 0; i < scene.indices(); ++i) {
      const double* const numbers = &all_[18 * i];
      scene.move(i, {Eigen::Map<const Mat3>(numbers), Eigen::Map<const Vec3>(numbers + 9)},
                 Eigen::Map<const Vec3>(numbers + 12), Eigen::Map<const Vec3>(numbers + 15));
    }
    all_.clear();
  }

  std::optional<tandem::Pipeline> alone_;
  Response response_;
  std::vector<double> all_;
};

}  // namespace

namespace {

void compare_with_one(double keep) {
  for (const BuiltinScene& builtin : builtin_scenes()) {
    CAPTURE(builtin.name);
    Reference one(builtin.name, keep);
    Scene& scene = one.scene;
    // For poses of a response: add_body makes them orthonormal, as set_pose does.
    for (std::uint32_t i = 0; i < scene.indices(); ++i) scene.set_pose(scene.id(i), scene.poses()[i]);
    std::vector<std::unique_ptr<mpi::Pipeline>> pipelines;
    for (const int threads : {1, 2}) {
      mpi::Options options = world::options(threads, one.margin);
      options.rank.answer.keep_contacts = keep;
      pipelines.push_back(std::make_unique<mpi::Pipeline>(MPI_COMM_WORLD, options));
      world::add_all(*pipelines.back(), scene);
    }
    std::uint64_t contacts = 0, moved_away = 0, copies = 0, kept = 0;
    for (int step = 0; step < 12; ++step) {
      one.detect();
      for (const auto& pipeline : pipelines) {
        CAPTURE(step, pipeline->ranks());
        if (step % 4 == 2) pipeline->rebalance();
        const mpi::Report report = pipeline->step();
        CHECK(report.contact_hash == one.hash);
        CHECK(report.bodies == one.report.bodies);
        CHECK(report.pairs == one.report.execution.candidate_pairs);
        CHECK(report.colliding_pairs == one.report.colliding_pairs);
        CHECK(report.contacts == one.report.contacts);
        CHECK(report.gaps == one.report.gaps);
        CHECK(report.max_depth == one.report.max_depth);
        CHECK(report.kept_pairs == one.report.kept_pairs);
        CHECK(report.kept_error_bound == one.report.kept_error_bound);
        kept += report.kept_pairs;
        if (step % 5 == 0) {
          const auto all = pipeline->gather(0);
          CHECK((world::rank() != 0 || world::same_bits(all, one.answers)));
          CHECK(pipeline->list_hash(pipeline->share()) == one.report.contact_hash);
        }
        contacts += report.contacts;
        moved_away += report.moved_away;
        copies += report.copies;
      }
      one.respond();
      // Immediately by the owner in even steps, by any rank in odd ones.
      for (const auto& pipeline : pipelines)
        for (std::uint32_t i = 0; i < scene.indices(); ++i) {
          if (scene.is_static()[i] != 0) continue;
          if (step % 2 == 0 && pipeline->has(i)) {
            const std::uint32_t local = pipeline->local(i).index();
            if (pipeline->owns(local))
              pipeline->move(local, scene.poses()[i], scene.velocities()[i], scene.angular_velocities()[i]);
          } else if (step % 2 == 1 &&
                     static_cast<int>(i + static_cast<std::uint32_t>(step)) % world::ranks() == world::rank()) {
            pipeline->set_pose(i, scene.poses()[i]);
          }
        }
      // A pose of a response is not orthonormal to the last bit; set_pose makes it so.
      if (step % 2 == 1)
        for (std::uint32_t i = 0; i < scene.indices(); ++i)
          if (scene.is_static()[i] == 0) scene.set_pose(scene.id(i), scene.poses()[i]);
    }
    // A test on nothing would pass, too.
    if (builtin.name != "falling-apart") CHECK(contacts > 100);
    if (keep > 0 && builtin.name != "falling-apart") CHECK(kept > 10);
    if (world::ranks() > 1) {
      CHECK(moved_away > 5);
      CHECK(copies > 20);
    }
  }
}

}  // namespace

TEST_CASE("every built-in scene: any number of ranks and threads finds what one finds, whoever moves the bodies") {
  compare_with_one(0);
}

TEST_CASE("every built-in scene: kept contacts go with their pairs from rank to rank, the same bits as on one") {
  compare_with_one(0.05);
}

namespace {

/// A changing scene: all ranks draw the same random numbers, and one of them makes each change. `alone`, a pipeline of
/// this rank alone, gets the same changes.
class Life {
 public:
  Life(unsigned seed, mpi::Pipeline& pipeline, mpi::Pipeline* alone = nullptr)
      : random_(seed), pipeline_(pipeline), alone_(alone) {
    shapes_ = {
        Shape(HalfSpace{Vec3::UnitZ(), 0}), Shape(Sphere{0.5}),  Shape(Box{Vec3(1, 0.6, 0.4)}), Shape(Capsule{0.3, 1}),
        Shape(Box{Vec3(12, 1, 0.5)}),       Shape(Sphere{0.05}), Shape(Cylinder{0.4, 1.2})};
    for (const Shape& shape : shapes_) {
      scene_ids_.push_back(pipeline.add_shape(shape));
      if (alone_ != nullptr) alone_->add_shape(shape);
    }
    bodies_[7] = ground();
    doing([&](mpi::Pipeline& to) { to.add_body(7, bodies_[7]); });
  }

  /// Makes some changes.
  void go() {
    for (int i = 0; i < 12; ++i) happen();
    changed_.clear();
  }

  /// The expected contacts of one machine: bodies sorted by their ids.
  mpi::GatheredContacts expected(double margin) const {
    Scene scene;
    std::vector<ShapeId> own;
    for (const Shape& shape : shapes_) own.push_back(scene.add_shape(shape));
    std::vector<GlobalId> ids;
    for (const auto& [id, body] : bodies_) {
      BodyOptions copy = body;
      copy.shape = own[body.shape.index_plus_one - 1];
      scene.add_body(copy);
      ids.push_back(id);
    }
    tandem::Pipeline alone({.executor = ExecutorKind::sequential, .threads = 1, .answer = {.margin = margin}});
    alone.step(scene);
    return world::gathered(alone.contacts(), ids);
  }
  std::size_t bodies() const { return bodies_.size(); }

 private:
  double number(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random_); }
  std::size_t below(std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random_); }
  Pose pose() {
    const Quat q{number(-1, 1), number(-1, 1), number(-1, 1), number(-1, 1)};
    return Pose::from(q, {number(-6, 6), number(-3, 3), number(0, 2)});
  }
  /// By so little that answers are kept, or so much that they are moved along.
  Pose nudged(Pose pose) {
    pose.translation += number(-1, 1) * (below(2) == 0 ? 1e-7 : 1e-4) * Vec3::Ones();
    return pose;
  }
  BodyOptions ground() const { return {.shape = scene_ids_[0], .is_static = true}; }
  template <class Thing>
  void doing(const Thing& thing) {
    if (static_cast<int>(below(static_cast<std::size_t>(world::ranks()))) == world::rank()) thing(pipeline_);
    if (alone_ != nullptr) thing(*alone_);
  }
  /// A body without a change in this step: ranks' changes of one body would come in the order of ranks.
  GlobalId any() {
    for (int tries = 0; tries < 100; ++tries) {
      const auto at = std::next(bodies_.begin(), static_cast<std::ptrdiff_t>(below(bodies_.size())));
      if (at->first != 7 && !changed_[at->first]) {
        changed_[at->first] = true;
        return at->first;
      }
    }
    return 7;
  }
  void happen() {
    const std::size_t what = below(10);
    if (what < 4 || bodies_.size() < 20) {
      BodyOptions body;
      body.shape = scene_ids_[1 + below(scene_ids_.size() - 1)];
      body.pose = pose();
      body.is_static = below(6) == 0;
      const GlobalId id = std::uniform_int_distribution<GlobalId>()(random_);
      changed_[id] = true;
      bodies_[id] = body;
      return doing([&](mpi::Pipeline& to) { to.add_body(id, body); });
    }
    const GlobalId id = any();
    if (id == 7) return;
    BodyOptions& body = bodies_[id];
    if (what < 6) {
      bodies_.erase(id);
      doing([&](mpi::Pipeline& to) { to.remove_body(id); });
    } else if (what < 8) {
      body.pose = what == 7 && alone_ != nullptr ? nudged(body.pose) : pose();
      doing([&](mpi::Pipeline& to) { to.set_pose(id, body.pose); });
    } else if (what < 9) {
      body.shape = scene_ids_[1 + below(scene_ids_.size() - 1)];
      doing([&](mpi::Pipeline& to) { to.set_shape(id, body.shape); });
    } else {
      body.group = 1u << below(2);
      body.mask = below(2) == 0 ? ~0u : 2u;
      body.is_static = below(3) == 0;
      doing([&](mpi::Pipeline& to) {
        to.set_filter(id, body.group, body.mask);
        to.set_static(id, body.is_static);
      });
    }
  }

  std::mt19937_64 random_;
  mpi::Pipeline& pipeline_;
  mpi::Pipeline* alone_;
  std::vector<Shape> shapes_;
  std::vector<ShapeId> scene_ids_;
  std::map<GlobalId, BodyOptions> bodies_;
  std::map<GlobalId, bool> changed_;
};

}  // namespace

TEST_CASE("lives of scenes: bodies come, go, move and change on any rank") {
  const double margin = 0.05;
  for (const int threads : {1, 2}) {
    mpi::Pipeline pipeline(MPI_COMM_WORLD, world::options(threads, margin));
    Life life(41 + static_cast<unsigned>(threads), pipeline);
    std::uint64_t contacts = 0;
    for (int step = 0; step < 15; ++step) {
      CAPTURE(threads, step);
      life.go();
      if (step % 9 == 5) pipeline.rebalance();
      const mpi::Report report = pipeline.step();
      const auto expected = life.expected(margin);
      CHECK(report.bodies == life.bodies());
      CHECK(report.contact_hash == mpi::hash(expected));
      const auto all = pipeline.gather(world::ranks() - 1);
      if (world::rank() == world::ranks() - 1) CHECK(world::same_bits(all, expected));
      contacts += report.contacts;
    }
    CHECK(contacts > 200);
  }
}

TEST_CASE("lives of scenes with kept contacts: what is kept follows bodies that come, go, move and change") {
  const auto events_of = [](const mpi::ContactEvents& events, MPI_Comm communicator) {
    std::array<std::uint64_t, 3> counts{events.began().size(), events.ended().size(), 0};
    for (const mpi::IdPair& pair : events.began()) counts[2] += 3 * pair.a + 5 * pair.b;
    for (const mpi::IdPair& pair : events.ended()) counts[2] += 7 * pair.a + 11 * pair.b;
    MPI_Allreduce(MPI_IN_PLACE, counts.data(), 3, MPI_UINT64_T, MPI_SUM, communicator);
    return counts;
  };
  for (const Request request : {Request::contacts, Request::distance}) {
    mpi::Options options = world::options(2, 0.05);
    options.rank.answer.request = request;
    options.rank.answer.keep_contacts = 0.01;
    mpi::Pipeline pipeline(MPI_COMM_WORLD, options);
    options.rank.threads = 1;
    mpi::Pipeline alone(MPI_COMM_SELF, options);
    mpi::ContactEvents events, events_alone;
    Life life(51, pipeline, &alone);
    std::uint64_t kept = 0;
    for (int step = 0; step < 40; ++step) {
      CAPTURE(step);
      life.go();
      if (step % 3 == 1) pipeline.rebalance();
      const mpi::Report report = pipeline.step(), expected = alone.step();
      CHECK(report.bodies == life.bodies());
      CHECK(report.pairs == expected.pairs);
      CHECK(report.contact_hash == expected.contact_hash);
      CHECK(report.kept_pairs == expected.kept_pairs);
      CHECK(report.kept_error_bound == expected.kept_error_bound);
      const auto all = pipeline.gather(0), of_one = alone.gather(0);
      if (world::rank() == 0) CHECK(world::same_bits(all, of_one));
      events.update(pipeline);
      events_alone.update(alone);
      CHECK(events_of(events, MPI_COMM_WORLD) == events_of(events_alone, MPI_COMM_SELF));
      kept += report.kept_pairs;
    }
    CHECK(kept > 200);
  }
}

TEST_CASE(
    "every owner moves its bodies a little, at times far: copies and owners follow, and little is sent meanwhile") {
  const double margin = 0.02;
  mpi::Pipeline pipeline(MPI_COMM_WORLD, world::options(2, margin));
  Scene scene;
  const Shape shapes[] = {Shape(Sphere{0.5}), Shape(Box{Vec3(1, 0.7, 0.5)}), Shape(HalfSpace{Vec3::UnitZ(), -0.4})};
  for (const Shape& shape : shapes) scene.add_shape(shape);
  for (std::uint32_t i = 0; i < 400; ++i)
    scene.add_body({.shape = {1 + i % 2, 1}, .pose = Pose::at(0.9 * (i % 20), 0.9 * (i / 20), 0)});
  scene.add_body({.shape = {3, 1}, .is_static = true});
  world::add_all(pipeline, scene);
  tandem::Pipeline alone({.executor = ExecutorKind::sequential, .threads = 1, .answer = {.margin = margin}});
  std::mt19937_64 random(11);
  const auto number = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  std::uint64_t sent_when_calm = 0, sent_at_first = 0, moved_away = 0;
  for (int step = 0; step < 40; ++step) {
    CAPTURE(step);
    if (step % 15 == 14) pipeline.rebalance();
    const mpi::Report report = pipeline.step();
    alone.step(scene);
    CHECK(report.contact_hash == mpi::hash(world::gathered(alone.contacts(), world::all_indices(scene))));
    if (step == 0) sent_at_first = report.bytes_sent;
    if (step == 8) sent_when_calm = report.bytes_sent;
    if (step > 8) moved_away += report.moved_away;
    // All move a little; from the tenth step on some move so far that any rank may get them.
    for (std::uint32_t i = 0; i < 400; ++i) {
      Pose pose = scene.poses()[i];
      pose.translation += Vec3{number(-1, 1), number(-1, 1), number(-1, 1)} * 0.002;
      if (step > 8 && random() % 100 == 0) pose.translation = Vec3{number(-2, 20), number(-2, 20), number(0, 1)};
      if (step > 20 && random() % 10 == 0) pose.translation.x() += number(-0.6, 0.6);
      scene.move(i, pose, Vec3::Zero(), Vec3::Zero());
      if (pipeline.has(i) && pipeline.owns(pipeline.local(i).index()))
        pipeline.move(pipeline.local(i).index(), pose, Vec3::Zero(), Vec3::Zero());
    }
  }
  if (world::ranks() == 1) return;
  CHECK(moved_away > 20);
  CHECK(sent_when_calm > 0);
  CHECK(sent_when_calm < sent_at_first);
}

namespace {

/// The message of the error that a step throws on every rank, the same on all; empty: none.
std::string failure(mpi::Pipeline& pipeline) {
  std::string text;
  try {
    pipeline.step();
  } catch (const mpi::StepError& error) {
    text = error.what();
  }
  std::uint64_t hash[2] = {std::hash<std::string>()(text), 0};
  hash[1] = ~hash[0];
  MPI_Allreduce(MPI_IN_PLACE, hash, 2, MPI_UINT64_T, MPI_MAX, MPI_COMM_WORLD);
  CHECK(hash[0] == ~hash[1]);
  return text;
}

}  // namespace

TEST_CASE("a step that fails on one rank fails on all, with one text, and the next one is right") {
  const int last = world::ranks() - 1;
  bool throws = false, keeps_too_many = false;
  mpi::Options options = world::options(2, 0);
  options.rank.predicate = [&](std::span<Pair> pairs) -> std::size_t {
    if (throws && world::rank() == 0) throw std::runtime_error("no more pairs");
    return pairs.size() + (keeps_too_many && world::rank() == 0 ? 1 : 0);
  };
  mpi::Pipeline pipeline(MPI_COMM_WORLD, options);
  const ShapeId sphere = pipeline.add_shape(Shape(Sphere{0.6}));
  if (world::rank() == 0)
    for (GlobalId i = 0; i < 20; ++i)
      pipeline.add_body(i, {.shape = sphere, .pose = Pose::at(static_cast<double>(i), 0, 0)});
  REQUIRE(pipeline.step().colliding_pairs == 19);

  throws = true;
  const std::string thrown = failure(pipeline);
  CHECK(thrown.find("step 1: no more pairs") != std::string::npos);
  CHECK(pipeline.contacts().pairs.empty());
  throws = false;
  keeps_too_many = true;  // the batch has pairs of other ranks behind those that the predicate was given
  CHECK(failure(pipeline).find("step 2: predicate: kept ") != std::string::npos);
  keeps_too_many = false;
  CHECK(pipeline.step().colliding_pairs == 19);

  if (world::rank() == last) pipeline.set_pose(99, {});
  CHECK(failure(pipeline) == "rank " + std::to_string(last) + ", step 4: body 99: does not exist");
  if (world::rank() == last) pipeline.add_body(3, {.shape = sphere});
  CHECK(failure(pipeline).find("body 3: exists already") != std::string::npos);
  pipeline.add_body(50, {.shape = sphere, .pose = Pose::at(0, 50, 0)});  // by all
  if (world::ranks() == 1)
    CHECK(failure(pipeline).empty());
  else
    CHECK(failure(pipeline).find("body 50: was added by another rank, too") != std::string::npos);
  const mpi::Report report = pipeline.step();
  CHECK(report.bodies == 21);
  CHECK(report.colliding_pairs == 19);
  if (world::rank() == 0) {
    pipeline.remove_body(50);
    pipeline.set_pose(50, {});
  }
  CHECK(failure(pipeline).find("body 50: does not exist") != std::string::npos);
  CHECK(pipeline.step().bodies == 20);
  if (world::ranks() > 1) {
    pipeline.add_shape(Shape(Sphere{world::rank() == last ? 1.0 : 2.0}));
    CHECK(failure(pipeline).find("the ranks have different shapes") != std::string::npos);
  }
}

TEST_CASE("ranks whose answer options differ are refused in the first step, none waits for another") {
  if (world::ranks() == 1) return;
  const bool differs = world::rank() == world::ranks() - 1;
  std::vector<AnswerOptions> others(4);
  others[0].keep_contacts = 1e-3;
  others[1].margin = 0.1;
  others[2].request = Request::distance;
  others[3].mesh_margin = true;
  for (const AnswerOptions& other : others) {
    mpi::Options options;
    options.rank = {.threads = 1, .answer = differs ? other : AnswerOptions{}};
    mpi::Pipeline pipeline(MPI_COMM_WORLD, options);
    const ShapeId sphere = pipeline.add_shape(Shape(Sphere{1.0}));
    pipeline.add_body(static_cast<mpi::GlobalId>(world::rank()), {.shape = sphere});
    CHECK(failure(pipeline).find("answer options") != std::string::npos);
  }
}

TEST_CASE("what cannot be is refused where it is said") {
  mpi::Pipeline pipeline(MPI_COMM_WORLD, world::options(1, 0));
  const ShapeId half = pipeline.add_shape(Shape(HalfSpace{Vec3::UnitZ(), 0}));
  const auto text = [](const auto& what) -> std::string {
    try {
      what();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return {};
  };
  CHECK(text([&] { pipeline.add_body(77, {.shape = half}); }) ==
        "body 77: is_static is false, allowed: true, as its shape is a half-space");
  CHECK(text([&] { pipeline.set_pose(78, Pose::at(0, 0, std::nan(""))); }).starts_with("body 78"));
  CHECK(text([&] { pipeline.set_shape(78, {}); }).starts_with("body 78: shape is number 0, allowed: 1 to 1"));
  CHECK(text([&] { (void)pipeline.local(78); }) == "body 78: is not on this rank");
  CHECK(text([&] { pipeline.set_density(79, 0); }) == "body 79: density is 0, allowed: finite, > 0 kg/m^3");
  CHECK(pipeline.step().bodies == 0);
}
