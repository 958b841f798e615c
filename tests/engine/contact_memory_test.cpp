// Begin, persistence and end of contacts, and data kept with them, compared with a model that has bodies with unique
// numbers.
#include "tandem/engine/contact_memory.h"

#include <cstdlib>
#include <map>
#include <set>

#include "catch.h"
#include "narrowphase/random_pairs.h"
#include "tandem/engine/pipeline.h"

using namespace tandem;
using namespace tandem::test;

namespace {

using Names = std::pair<int, int>;  // unique numbers of two bodies

/// Bodies that are added, removed, moved and changed at random.
class Life {
 public:
  explicit Life(unsigned seed) : random_(seed) {
    for (int i = 0; i < 3; ++i) shapes_.push_back(scene_.add_shape(Sphere{0.3 + 0.1 * i}));
    shapes_.push_back(scene_.add_shape(Box{{0.5, 0.6, 0.7}}));
    for (int i = 0; i < 8; ++i) add();
  }

  void change() {
    const int what = static_cast<int>(random_.in(0, 10));
    if (what == 0 && bodies_.size() < 14) return add();
    if (bodies_.empty()) return add();
    const std::size_t which = static_cast<std::size_t>(random_.in(0, static_cast<double>(bodies_.size())));
    const BodyId body = bodies_[which].id;
    if (what == 1 && bodies_.size() > 3) {
      scene_.remove_body(body);
      bodies_.erase(bodies_.begin() + static_cast<std::ptrdiff_t>(which));
      if (random_.in(0, 1) < 0.5) add();  // usually in the same slot
    } else if (what == 2) {
      scene_.set_shape(body, shapes_[static_cast<std::size_t>(random_.in(0, 4))]);
    } else if (what == 3) {
      const std::uint32_t groups = random_.in(0, 1) < 0.8 ? 1 : 2;
      scene_.set_filter(body, groups, random_.in(0, 1) < 0.8 ? ~0u : 2);
    } else if (what == 4) {
      scene_.set_static(body, random_.in(0, 1) < 0.3);
    } else if (what == 5) {
      const ShapeId fresh = scene_.add_shape(Sphere{random_.in(0.1, 0.5)});
      scene_.set_shape(body, fresh);
      own_shapes_.push_back(fresh);
    } else if (what == 6 && !own_shapes_.empty()) {
      for (const Body& b : bodies_)
        if (scene_.shape_id(b.id) == own_shapes_.back()) scene_.set_shape(b.id, shapes_[0]);
      scene_.remove_shape(own_shapes_.back());
      own_shapes_.pop_back();
    } else {
      scene_.set_pose(body, place());
    }
  }

  const Scene& scene() const { return scene_; }
  int name(std::uint32_t index) const {
    for (const Body& b : bodies_)
      if (b.id.index() == index) return b.name;
    return -1;
  }
  /// The touching pairs, by a loop over all.
  std::set<Names> touching() const {
    std::set<Names> found;
    const NarrowPhase narrow;
    for (const Body& p : bodies_)
      for (const Body& q : bodies_) {
        const std::uint32_t i = p.id.index(), j = q.id.index();
        if (i >= j || (scene_.is_static()[i] != 0 && scene_.is_static()[j] != 0)) continue;
        if ((scene_.groups()[i] & scene_.masks()[j]) == 0 || (scene_.groups()[j] & scene_.masks()[i]) == 0) continue;
        if (narrow.solve(scene_.shape_of(i), scene_.pose(p.id), scene_.shape_of(j), scene_.pose(q.id), Request::collide)
                .collide)
          found.insert({p.name, q.name});
      }
    return found;
  }

 private:
  struct Body {
    BodyId id;
    int name;
  };
  Pose place() { return random_pose(random_, 1); }
  void add() {
    const BodyId id = scene_.add_body({.shape = shapes_[static_cast<std::size_t>(random_.in(0, 4))], .pose = place()});
    bodies_.push_back({id, next_++});
  }

  Random random_;
  Scene scene_;
  std::vector<ShapeId> shapes_, own_shapes_;
  std::vector<Body> bodies_;
  int next_ = 0;
};

}  // namespace

TEST_CASE("contact events: a begin and an end for each touch, through all that may happen to bodies") {
  const char* asked = std::getenv("TANDEM_LIFE_STEPS");
  const int steps = asked != nullptr ? std::atoi(asked) : 20000;
  for (const double keep : {0.0, 1e-3}) {
    Life life(11);
    PipelineOptions options;
    options.threads = 1;
    options.answer.keep_contacts = keep;
    Pipeline pipeline(options);
    ContactEvents events;
    PairMap<Names> names;  // the value identifies the pair
    std::map<BodyId, int, decltype([](BodyId a, BodyId b) {
               return std::pair(a.slot_plus_one, a.generation) < std::pair(b.slot_plus_one, b.generation);
             })>
        known;
    std::set<Names> before;
    long began = 0, ended = 0, dropped = 0;
    for (int step = 0; step < steps; ++step) {
      for (int k = step % 3; k >= 0; --k) life.change();
      pipeline.step(life.scene());
      const ContactList& contacts = pipeline.contacts();
      events.update(life.scene(), contacts);
      for (std::uint32_t i = 0; i < life.scene().indices(); ++i)
        if (life.scene().alive(i)) known[life.scene().id(i)] = life.name(i);
      const auto names_of = [&](const BodyPair& pair) { return Names{known.at(pair.a), known.at(pair.b)}; };
      const std::set<Names> now = keep == 0 ? life.touching() : [&] {
        std::set<Names> list;
        for (const PairResult& pair : contacts.pairs)
          if (pair.answer.collide) list.insert({life.name(pair.a), life.name(pair.b)});
        return list;
      }();
      std::set<Names> expected_began, expected_ended, expected_stayed, got_began, got_ended, got_stayed;
      std::set_difference(now.begin(), now.end(), before.begin(), before.end(),
                          std::inserter(expected_began, expected_began.end()));
      std::set_difference(before.begin(), before.end(), now.begin(), now.end(),
                          std::inserter(expected_ended, expected_ended.end()));
      std::set_intersection(before.begin(), before.end(), now.begin(), now.end(),
                            std::inserter(expected_stayed, expected_stayed.end()));
      for (const BodyPair& p : events.began()) got_began.insert(names_of(p));
      for (const BodyPair& p : events.ended()) got_ended.insert(names_of(p));
      for (const BodyPair& p : events.stayed()) got_stayed.insert(names_of(p));
      CAPTURE(step, keep);
      REQUIRE(got_began == expected_began);
      REQUIRE(got_ended == expected_ended);
      REQUIRE(got_stayed == expected_stayed);
      REQUIRE(got_began.size() == events.began().size());
      REQUIRE(got_ended.size() == events.ended().size());
      began += static_cast<long>(got_began.size());
      ended += static_cast<long>(got_ended.size());
      names.update(life.scene(), contacts, [&](const BodyPair& pair, Names value) {
        ++dropped;
        if (value != names_of(pair)) FAIL("a value went to another pair");
      });
      REQUIRE(names.size() == contacts.pairs.size());
      for (std::size_t i = 0; i < contacts.pairs.size(); ++i) {
        const Names own{life.name(contacts.pairs[i].a), life.name(contacts.pairs[i].b)};
        if (before.count(own) != 0 && contacts.pairs[i].answer.collide) REQUIRE(names[i] == own);
        names[i] = own;
        REQUIRE(names.find(body_pair(life.scene(), contacts.pairs[i])) == &names[i]);
      }
      before = now;
    }
    CHECK(began > steps / 4);
    CHECK(ended > steps / 4);
    CHECK(dropped > steps / 4);
    events.end_all();
    CHECK(events.touching().empty());
    CHECK(events.ended().size() == before.size());
  }
}

TEST_CASE("contact map: a point's value goes with its place") {
  Scene scene;
  const ShapeId box = scene.add_shape(Box{{1, 1, 1}});
  const BodyId floor = scene.add_body({.shape = scene.add_shape(Box{{10, 10, 1}}), .is_static = true});
  const BodyId body = scene.add_body({.shape = box, .pose = Pose::at(0, 0, 0.999)});
  Pipeline pipeline({.threads = 1});
  ContactMap<int> springs(0.05);
  const auto step = [&] {
    pipeline.step(scene);
    springs.update(scene, pipeline.contacts());
  };
  step();
  REQUIRE(springs.size() == 4);
  std::vector<Vec3> places;
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(springs[i] == 0);
    springs[i] = static_cast<int>(i) + 1;
    places.push_back(pipeline.contacts().contacts[i].point);
  }
  for (int k = 1; k <= 40; ++k) {  // slides and rotates by small steps: contacts keep their data
    Pose pose = Pose::at(0.01 * k, 0, 0.999);
    pose.rotation = Eigen::AngleAxisd(0.02 * k, Vec3::UnitZ()).toRotationMatrix();
    scene.set_pose(body, pose);
    step();
    REQUIRE(springs.size() == 4);
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec3& corner = places[static_cast<std::size_t>(springs[i] - 1)];
      const Vec3 expected = pose.rotation * Vec3(corner.x(), corner.y(), 0) +
                            Vec3(pose.translation.x(), pose.translation.y(), corner.z());
      CHECK((pipeline.contacts().contacts[i].point - expected).norm() < 1e-9);
    }
  }
  scene.set_pose(body, Pose::at(3, 0, 0.999));  // a jump: no data are kept
  step();
  for (std::size_t i = 0; i < springs.size(); ++i) CHECK(springs[i] == 0);
  springs[0] = 5;
  scene.remove_body(body);
  scene.add_body({.shape = box, .pose = Pose::at(3, 0, 0.999)});  // another body in the same slot
  step();
  for (std::size_t i = 0; i < springs.size(); ++i) CHECK(springs[i] == 0);
  CHECK(floor.index() == 0);
}

TEST_CASE("contacts of another scene are refused, and events and values stay as they were") {
  Scene scene;
  const ShapeId ball = scene.add_shape(Sphere{1});
  for (int i = 0; i < 3; ++i) scene.add_body({.shape = ball, .pose = Pose::at(1.5 * i, 0, 0)});
  Pipeline pipeline({.threads = 1});
  pipeline.step(scene);
  ContactEvents events;
  PairMap<int> pairs;
  ContactMap<int> points(0.1);
  const auto update = [&](const Scene& its) {
    events.update(its, pipeline.contacts());
    pairs.update(its, pipeline.contacts());
    points.update(its, pipeline.contacts());
  };
  update(scene);
  REQUIRE(events.began().size() == 2);
  pairs[1] = points[1] = 7;
  Scene fewer = scene;
  fewer.remove_body(scene.id(2));  // of the second pair
  CHECK_THROWS_AS(events.update(fewer, pipeline.contacts()), std::invalid_argument);
  CHECK_THROWS_AS(pairs.update(fewer, pipeline.contacts()), std::invalid_argument);
  CHECK_THROWS_AS(points.update(fewer, pipeline.contacts()), std::invalid_argument);
  CHECK(events.touching().size() == 2);
  update(scene);
  CHECK(events.began().empty());
  CHECK(events.stayed().size() == 2);
  CHECK(events.ended().empty());
  CHECK(pairs[1] == 7);
  CHECK(points[1] == 7);
}
