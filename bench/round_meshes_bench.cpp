// Spheres, capsules, boxes, cylinders, cones, ellipsoids and hulls against meshes of 6,000 triangles: contacts, beside
// FCL's with all contacts, pair by pair; and steps of a thousand bodies of all kinds.
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>

#include "answer_hash.h"
#include "benches.h"
#include "clocks.h"
#include "narrowphase/fcl_shape.h"
#include "reference/random.h"
#include "round_meshes/meshes.h"
#include "tandem/engine/pipeline.h"
#include "tandem/engine/response.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem::bench {
namespace {

using reference::Random;

struct PairClass {
  std::string_view name;
  double radius;       ///< radius of the convex shape; the mesh's is 1
  double least, most;  ///< range of the depth below first contact, relative to that radius; negative: a distance
  double margin;
};

constexpr double margin = 0.02;
/// For separated pairs, ours gets the margin that FCL answers by a second query, its distance.
constexpr std::array<PairClass, 6> classes{{{"apart", 0.35, -0.06, -0.001, 0},
                                            {"margin", 0.35, -0.06, -0.001, margin},
                                            {"shallow", 0.35, 0.0001, 0.01, 0},
                                            {"sunk", 0.35, 0.05, 0.2, 0},
                                            {"deep", 0.35, 0.5, 1.2, 0},
                                            {"many", 1.2, 0.02, 0.15, 0}}};

struct MeshPair {
  const Shape *mesh, *convex;
  const ::fcl::CollisionGeometryd *fcl_mesh, *fcl_convex;
  Pose at;  ///< pose of the convex shape
};

/// The pose of a convex shape moved along a line through a point near the mesh's centre, to this depth beyond first
/// contact.
Pose placed(const Shape& mesh, const Shape& convex, double depth, Random& random) {
  const NarrowPhase solver;
  for (;;) {
    const Vec3 away = random.direction(), through = random.vec(-0.5, 0.5);
    Pose pose{random.rotation(), Vec3::Zero()};
    const auto touches = [&](double s) {
      pose.translation = through + s * away;
      return solver.solve(mesh, Pose{}, convex, pose, Request::collide).collide;
    };
    double out = 4, in = out;
    while (in > -1 && !touches(in)) out = in, in -= 0.1;
    if (in <= -1) continue;
    for (int i = 0; i < 30; ++i) (touches((in + out) / 2) ? in : out) = (in + out) / 2;
    touches(in - depth);
    return pose;
  }
}

struct MeshContestant {
  Samples time{};
  std::uint64_t hash = hash_start, contacts = 0, touching = 0;
  double worst = 0;

  void add(std::uint64_t word) { bench::add(hash, word); }
};

/// The least of three times, as each does the same work.
template <class Run>
double least_time(Run&& run) {
  double least = std::numeric_limits<double>::infinity(), total = 0;
  constexpr double enough = 2e7;
  for (int i = 0; i < 3 && (i == 0 || total < enough); ++i) {
    const double begin = cpu_ns();
    run();
    const double ns = cpu_ns() - begin;
    least = std::min(least, ns), total += ns;
  }
  return least;
}

void time_ours(const MeshPair& pair, const NarrowPhase& solver, MeshContestant& out, double& ns) {
  std::vector<Contact> contacts;
  PairAnswer answer;
  ns = least_time([&] {
    contacts.clear();
    answer = solver.solve(*pair.mesh, Pose{}, *pair.convex, pair.at, Request::contacts, &contacts);
  });
  out.time.add(ns);
  out.contacts += contacts.size();
  out.touching += answer.collide ? 1u : 0u;
  for (const Contact& c : contacts) {
    for (const double x : {c.point.x(), c.point.y(), c.point.z(), c.normal.x(), c.normal.y(), c.normal.z(), c.depth})
      out.add(std::bit_cast<std::uint64_t>(x + 0.0));
    out.add(c.feature);
  }
}

void time_fcl(const MeshPair& pair, bool gap_too, MeshContestant& out, double& ns) {
  const ::fcl::Transform3d home = ::fcl::Transform3d::Identity(), at = fcl_pose(pair.at);
  std::size_t contacts = 0;
  double gap = 0;
  ns = least_time([&] {
    ::fcl::CollisionResultd result;
    contacts =
        ::fcl::collide(pair.fcl_mesh, home, pair.fcl_convex, at, ::fcl::CollisionRequestd(1'000'000, true), result);
    if (contacts > 0 || !gap_too) return;
    ::fcl::DistanceResultd near;
    gap = ::fcl::distance(pair.fcl_mesh, home, pair.fcl_convex, at, ::fcl::DistanceRequestd(true), near);
  });
  out.time.add(ns);
  out.contacts += contacts;
  out.touching += contacts > 0 ? 1u : 0u;
  out.add(contacts);
  out.add(std::bit_cast<std::uint64_t>(gap + 0.0));
}

nlohmann::json slowest(const Samples& time) {
  return {{"mean_ns", time.mean()}, {"p99_ns", time.quantile(0.99)}, {"max_ns", time.quantile(1)}};
}

struct MeshRace {
  MeshContestant ours, fcl;
  Samples ratio;
};

MeshRace race_class(const NamedShape& kind, const PairClass& c, const std::vector<NamedShape>& meshes,
                    const std::vector<std::shared_ptr<::fcl::CollisionGeometryd>>& fcl_meshes, std::size_t poses) {
  MeshRace race;
  NarrowPhaseOptions options;
  options.margin = c.margin;
  options.mesh_bounds = false;  // as in a step
  const NarrowPhase solver(options);
  const auto fcl_convex = fcl_shape(kind.shape);
  Random random(17);
  for (std::size_t i = 0; i < poses; ++i)
    for (std::size_t m = 0; m < meshes.size(); ++m) {
      const double depth = c.radius * random.in(c.least, c.most);
      const Pose at = placed(meshes[m].shape, kind.shape, depth, random);
      const MeshPair pair{&meshes[m].shape, &kind.shape, fcl_meshes[m].get(), fcl_convex.get(), at};
      double ours = 0, fcl = 0;
      if (i % 2 == 0) time_ours(pair, solver, race.ours, ours);
      time_fcl(pair, c.margin > 0, race.fcl, fcl);
      if (i % 2 != 0) time_ours(pair, solver, race.ours, ours);
      race.ratio.add(fcl / ours);
    }
  return race;
}

void add_rows(const std::string& workload, std::size_t triangles, const MeshRace& race, std::vector<Row>& rows) {
  for (const bool own : {true, false}) {
    const MeshContestant& who = own ? race.ours : race.fcl;
    Row row{"round-meshes", workload,         own ? "tandem" : "FCL, all contacts", 1, triangles, who.time,
            who.hash,       slowest(who.time)};
    row.more["contacts"] = who.contacts;
    row.more["touching"] = who.touching;
    if (own) {
      row.more["fcl_over_tandem_means"] = race.fcl.time.mean() / race.ours.time.mean();
      row.more["fcl_over_tandem_median"] = race.ratio.median();
      row.more["fcl_over_tandem_p10"] = race.ratio.quantile(0.1);
    }
    rows.push_back(std::move(row));
  }
}

void pairs_bench(const Settings& settings, std::vector<Row>& rows) {
  const std::vector<NamedShape> meshes = large_meshes();
  std::vector<std::shared_ptr<::fcl::CollisionGeometryd>> fcl_meshes;
  for (const NamedShape& mesh : meshes) fcl_meshes.push_back(fcl_shape(mesh.shape));
  const std::size_t poses = settings.poses != 0 ? settings.poses : settings.quick ? 5 : 40;
  fmt::print("Contacts with meshes (");
  for (const NamedShape& mesh : meshes) fmt::print("{} {}, ", mesh.name, mesh.shape.triangles().size());
  fmt::print(
      "triangles),\n{} poses each; microseconds of the thread, means, medians and the worst pair.\nratio: FCL's time "
      "over"
      " ours, of sums; then pair by pair the median and p10.\n\n| convex | class | ours | median | worst | FCL | "
      "median |"
      " worst | ratio | pairs | touching, FCL's | contacts, FCL's | hash |\n"
      "|---|---|--:|--:|--:|--:|--:|--:|--:|---|---|---|---|\n",
      poses);
  for (const PairClass& c : classes) {
    const std::vector<NamedShape> kinds = convex_shapes(c.radius);
    for (const NamedShape& kind : kinds) {
      const std::string workload = fmt::format("{} {}", kind.name, c.name);
      const auto is_asked_for = [&](const std::string& asked) { return asked == kind.name || asked == workload; };
      if (!settings.kinds.empty() && std::none_of(settings.kinds.begin(), settings.kinds.end(), is_asked_for)) continue;
      const MeshRace race = race_class(kind, c, meshes, fcl_meshes, poses);
      const Samples &ours = race.ours.time, &fcl = race.fcl.time;
      fmt::print(
          "| {} | {} | {:.1f} | {:.1f} | {:.0f} | {:.1f} | {:.1f} | {:.0f} | {:.2f} | {:.1f} ({:.1f}) | {}, {} | {}, "
          "{} | {} |\n",
          kind.name, c.name, ours.mean() / 1000, ours.median() / 1000, ours.quantile(1) / 1000, fcl.mean() / 1000,
          fcl.median() / 1000, fcl.quantile(1) / 1000, fcl.mean() / ours.mean(), race.ratio.median(),
          race.ratio.quantile(0.1), race.ours.touching, race.fcl.touching, race.ours.contacts, race.fcl.contacts,
          hex(race.ours.hash));
      std::fflush(stdout);
      add_rows(workload, meshes.front().shape.triangles().size(), race, rows);
    }
  }
}

/// Times steps of a scene on one thread, with all contacts computed.
void time_steps(const std::string& workload, Scene scene, int settling, int steps, std::vector<Row>& rows) {
  Pipeline pipeline({.executor = ExecutorKind::sequential, .threads = 1, .answer = {.contact_hash = true}});
  Pipeline guide({.answer = {.margin = recommended_margin(scene)}});
  Response response;
  Samples time;
  std::uint64_t hash = 0;
  StepReport last;
  for (int i = 0; i < settling + steps; ++i) {
    if (i >= settling) {
      const double begin = cpu_ns();
      last = pipeline.step(scene);
      time.add(cpu_ns() - begin);
      hash = std::rotl(hash, 5) ^ last.contact_hash;
    }
    if (settling == 0) continue;
    guide.step(scene);
    response.step(scene, guide.contacts());
  }
  fmt::print("| {} | {} | {:.2f} | {:.2f} | {:.2f} | {} | {} | {} |\n", workload, scene.bodies(), time.median() / 1e6,
             time.quantile(0.1) / 1e6, time.quantile(0.9) / 1e6, last.colliding_pairs, last.contacts, hex(hash));
  Row row{"round-meshes", workload, "tandem", 1, scene.bodies(), std::move(time), hash, {}};
  row.more = slowest(row.time);
  row.more["colliding_pairs"] = last.colliding_pairs;
  row.more["contacts"] = last.contacts;
  rows.push_back(std::move(row));
}

}  // namespace

std::vector<Row> round_meshes_bench(const Settings& settings) {
  std::vector<Row> rows;
  const bool only_steps = settings.kinds.size() == 1 && settings.kinds[0] == "steps";
  if (!only_steps) pairs_bench(settings, rows);
  const std::size_t bodies = settings.bodies != 0 ? settings.bodies : 1000;
  const int steps = settings.steps != 0 ? settings.steps : settings.quick ? 4 : 20;
  fmt::print(
      "\nSteps of bodies of all kinds, an eighth of them meshes of 2,300 to 4,700 triangles; ms of the processor on one"
      " thread, contacts computed.\n\n| scene | bodies | median | p10 | p90 | colliding pairs | contacts | hash |\n"
      "|---|--:|--:|--:|--:|--:|--:|---|\n");
  time_steps("mixed, anywhere in a cube", mixed_scene(bodies), 0, steps, rows);
  time_steps("mixed, piled on a floor", falling_mixed_scene(bodies), 120, steps, rows);
  return rows;
}

}  // namespace tandem::bench
