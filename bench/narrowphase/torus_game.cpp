#include <fcl/narrowphase/collision.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <memory>
#include <numbers>

#include "engine/mesh_generators.h"
#include "fcl_shape.h"
#include "narrowphase/mesh_model.h"
#include "player.h"
#include "random.h"

namespace tandem::bench {
namespace {

using TrianglePairs = std::vector<std::array<std::uint32_t, 2>>;

struct PosePair {
  Pose a, b;
};

struct Tori {
  Shape shape;
  std::vector<PosePair> poses;
  std::vector<TrianglePairs> truths;
};

constexpr double ring = 1, tube = 0.4;

Shape torus() {
  Mesh mesh = make_torus(ring, tube, 32, 18);
  mesh.solid = false;
  return Shape(std::move(mesh));
}

/// The pose at which B, coming from afar against `away`, is first found to touch A, within 1e-15.
Pose touching(const Shape& shape, const Pose& a, Pose b, const Vec3& away) {
  const NarrowPhase solver;
  const Vec3 start = a.translation;
  const auto touches = [&](double s) {
    b.translation = start + s * away;
    return solver.solve(shape, a, shape, b, Request::collide).collide;
  };
  double hi = 2 * (ring + tube) + 0.1, lo = hi;
  while (lo > 0 && !touches(lo)) hi = lo, lo -= 0.05;
  for (int i = 0; i < 52; ++i) {
    const double mid = 0.5 * (lo + hi);
    (touches(mid) ? lo : hi) = mid;
  }
  b.translation = start + lo * away;
  return b;
}

/// B placed in a class; sizes are parts of the torus's.
PosePair place(const Shape& shape, std::string_view pair_class, std::uint64_t index) {
  reference::Random r(index * 16 + pair_class.size());
  const double size = shape.size();
  PosePair p{{r.rotation(), r.vec(-1, 1)}, {r.rotation(), Vec3::Zero()}};
  const Vec3 away = r.direction();
  if (pair_class == "deep") {
    p.b.translation = p.a.translation + r.in(0, 0.25) * size * away;
    return p;
  }
  if (pair_class == "hard") {
    const Vec3 axis = p.a.rotation.col(2);
    const auto turn = [&](double part) {
      const double angle = part * 2 * std::numbers::pi;
      return Eigen::AngleAxisd(angle, Vec3::UnitZ()).toRotationMatrix();
    };
    if (r.once_in(2)) p.a.rotation = Mat3::Identity();
    if (r.once_in(3)) p.a.translation = r.in(1e5, 1e6) * r.direction();
    p.b = p.a;
    switch (index % 5) {
      case 0:  // the same pose
        break;
      case 1:  // stacked, flat on flat
        p.b.translation += 2 * tube * axis;
        break;
      case 2:  // turned by a facet
        p.b.rotation = p.a.rotation * turn(1.0 / 32);
        break;
      case 3:  // linked, without touching
        p.b.rotation = p.a.rotation * Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitX()).toRotationMatrix();
        p.b.translation += p.a.rotation.col(0) * ring;
        break;
      default:  // slid along their common plane
        p.b.translation += r.in(0, 0.5) * p.a.rotation.col(0);
    }
    return p;
  }
  p.b = touching(shape, p.a, p.b, away);
  double gap = 0.1;
  if (pair_class == "near") gap = r.sign() * std::min(r.power_of_two(-40, -9), 1e-3);
  if (pair_class == "shallow") gap = -std::min(r.power_of_two(-20, -6), 1e-2);
  p.b.translation += gap * size * away;
  return p;
}

TrianglePairs all_against_all(const std::vector<Shape>& triangles, const PosePair& p) {
  const NarrowPhase solver;
  const auto bounds = [&](const Pose& pose) {
    // Further out than rounding reaches.
    const double slack = 1e-12 * (1 + pose.translation.norm());
    std::vector<Bounds> out;
    for (const Shape& t : triangles) {
      Bounds box = t.bounds(pose);
      box.lo.array() -= slack, box.hi.array() += slack;
      out.push_back(box);
    }
    return out;
  };
  const std::vector<Bounds> of_a = bounds(p.a), of_b = bounds(p.b);
  TrianglePairs out;
  for (std::uint32_t i = 0; i < triangles.size(); ++i)
    for (std::uint32_t j = 0; j < triangles.size(); ++j)
      if ((of_a[i].lo.array() <= of_b[j].hi.array()).all() && (of_b[j].lo.array() <= of_a[i].hi.array()).all() &&
          !solver.intersecting_triangles(triangles[i], p.a, triangles[j], p.b).empty())
        out.push_back({i, j});
  return out;
}

std::shared_ptr<const Tori> make_tori(std::string_view pair_class, std::size_t n) {
  auto tori = std::make_shared<Tori>(Tori{torus(), std::vector<PosePair>(n), std::vector<TrianglePairs>(n)});
  const MeshModel& mesh = tori->shape.mesh();
  std::vector<Shape> triangles;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) triangles.emplace_back(Triangle{mesh.corners(i)});
  tbb::parallel_for(std::size_t{0}, n, [&](std::size_t i) {
    tori->poses[i] = place(tori->shape, pair_class, i);
    tori->truths[i] = all_against_all(triangles, tori->poses[i]);
  });
  return tori;
}

struct Answers {
  std::vector<char> collide;
  std::vector<TrianglePairs> pairs;
};

Accuracy judge(const Tori& tori, const Answers& answers, bool lists) {
  Accuracy out;
  out.hash = 0xcbf29ce484222325u;  // FNV-1a
  const auto add = [&](std::uint64_t word) { out.hash = (out.hash ^ word) * 0x100000001b3u; };
  std::vector<double> errors;
  for (std::size_t i = 0; i < tori.poses.size(); ++i) {
    const TrianglePairs& truth = tori.truths[i];
    double error = (answers.collide[i] != 0) == !truth.empty() ? 0 : 1;
    add(static_cast<std::uint64_t>(answers.collide[i]));
    if (lists) {
      TrianglePairs found = answers.pairs[i], differ;
      std::sort(found.begin(), found.end());
      for (const auto& [a, b] : found) add(std::uint64_t{a} << 32 | b);
      std::set_symmetric_difference(found.begin(), found.end(), truth.begin(), truth.end(), std::back_inserter(differ));
      error = static_cast<double>(differ.size()) / static_cast<double>(std::max<std::size_t>(1, truth.size()));
    }
    if (error > out.error_max) out.error_max = error, out.worst = i;
    out.wrong += error > 0;
    errors.push_back(error);
  }
  std::sort(errors.begin(), errors.end());
  out.error_p50 = errors[errors.size() / 2];
  out.error_p99 = errors[(errors.size() * 99) / 100];
  return out;
}

Player tandem_player(const std::shared_ptr<const Tori>& tori, bool lists) {
  const auto answers = std::make_shared<Answers>();
  answers->collide.resize(tori->poses.size()), answers->pairs.resize(tori->poses.size());
  return {"tandem", [n = tori->poses.size()] { return n; },
          [tori, answers, lists, solver = NarrowPhase()] {
            const Shape& s = tori->shape;
            for (std::size_t i = 0; i < tori->poses.size(); ++i) {
              const PosePair& p = tori->poses[i];
              if (lists) {
                answers->pairs[i] = solver.intersecting_triangles(s, p.a, s, p.b);
                answers->collide[i] = !answers->pairs[i].empty();
              } else {
                answers->collide[i] = solver.solve(s, p.a, s, p.b, Request::collide).collide;
              }
            }
          },
          [tori, answers, lists] { return judge(*tori, *answers, lists); }};
}

Player fcl_player(const std::shared_ptr<const Tori>& tori, bool lists) {
  const auto answers = std::make_shared<Answers>();
  answers->collide.resize(tori->poses.size()), answers->pairs.resize(tori->poses.size());
  const fcl::CollisionRequestd request(lists ? 1'000'000 : 1, false);
  return {"FCL OBBRSS", [n = tori->poses.size()] { return n; },
          [tori, answers, lists, request, model = fcl_shape(tori->shape)] {
            for (std::size_t i = 0; i < tori->poses.size(); ++i) {
              fcl::CollisionResultd result;
              const auto& [a, b] = tori->poses[i];
              fcl::collide(model.get(), fcl_pose(a, a.translation), model.get(), fcl_pose(b, a.translation), request,
                           result);
              answers->collide[i] = result.isCollision();
              if (!lists) continue;
              answers->pairs[i].clear();
              for (std::size_t k = 0; k < result.numContacts(); ++k) {
                const auto& c = result.getContact(k);
                answers->pairs[i].push_back({static_cast<std::uint32_t>(c.b1), static_cast<std::uint32_t>(c.b2)});
              }
            }
          },
          [tori, answers, lists] { return judge(*tori, *answers, lists); }};
}

}  // namespace

std::vector<Game> torus_games(std::string_view pair_class, std::size_t n) {
  const std::shared_ptr<const Tori> tori = make_tori(pair_class, n);
  std::vector<Game> games;
  for (const bool lists : {false, true})
    games.push_back({std::string(torus_kind),
                     std::string(pair_class),
                     lists ? "triangles" : "collide",
                     n,
                     {tandem_player(tori, lists), fcl_player(tori, lists)},
                     {}});
  return games;
}

}  // namespace tandem::bench
