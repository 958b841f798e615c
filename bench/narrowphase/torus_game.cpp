// The game of two torus meshes.
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>

#include "engine/scene/mesh_generators.h"
#include "fcl_shape.h"
#include "player.h"
#include "random.h"
#include "reference.h"
#include "shapes/mesh_model.h"
#include "shapes/shape_insides.h"

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

constexpr double ring = 1, tube_radius = 0.4;

Shape torus() {
  Mesh mesh = make_torus(ring, tube_radius, 32, 18);
  mesh.solid = false;
  return Shape(std::move(mesh));
}

/// The pose at which B, coming from far in the direction opposite to `away`, first touches A, within 1e-15.
Pose touching(const Shape& shape, const Pose& a, Pose b, const Vec3& away) {
  const NarrowPhase solver;
  const Vec3 start = a.translation;
  const auto touches = [&](double s) {
    b.translation = start + s * away;
    return solver.solve(shape, a, shape, b, Request::collide).collide;
  };
  double hi = 2 * (ring + tube_radius) + 0.1, lo = hi;
  while (lo > 0 && !touches(lo)) hi = lo, lo -= 0.05;
  for (int i = 0; i < 52; ++i) {
    const double mid = 0.5 * (lo + hi);
    (touches(mid) ? lo : hi) = mid;
  }
  b.translation = start + lo * away;
  return b;
}

/// Places B according to a class; lengths relative to the torus's size.
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
        p.b.translation += 2 * tube_radius * axis;
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
    // Beyond the reach of rounding.
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

std::vector<Shape> triangles_of(const MeshModel& mesh) {
  std::vector<Shape> triangles;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) triangles.emplace_back(Triangle{mesh.corners(i)});
  return triangles;
}

std::shared_ptr<const Tori> make_tori(std::string_view pair_class, std::size_t n) {
  auto tori = std::make_shared<Tori>(Tori{torus(), std::vector<PosePair>(n), std::vector<TrianglePairs>(n)});
  const std::vector<Shape> triangles = triangles_of(mesh_of(tori->shape));
  tbb::parallel_for(std::size_t{0}, n, [&](std::size_t i) {
    tori->poses[i] = place(tori->shape, pair_class, i);
    tori->truths[i] = all_against_all(triangles, tori->poses[i]);
  });
  return tori;
}

/// The separated pairs, and their distances.
struct TorusGaps {
  Shape shape;
  std::vector<PosePair> poses;
  std::vector<double> truths;
};

/// The least distance over all pairs of triangles, by the reference, except for pairs that a plane across one of a few
/// directions shows to be farther apart than others.
double all_distances(const MeshModel& mesh, const std::vector<Shape>& triangles, const PosePair& p) {
  const auto placed = [&](std::uint32_t t, const Pose& pose) {
    std::array<Vec3, 3> corners = mesh.corners(t);
    for (Vec3& c : corners) c = pose.rotation * c + (pose.translation - p.a.translation);
    return corners;
  };
  struct Pair {
    double least;
    std::uint32_t i, j;
  };
  std::vector<Pair> pairs;
  double most = 1e300;  // an upper bound so far
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    const auto a = placed(i, p.a);
    const Vec3 middle_a = (a[0] + a[1] + a[2]) / 3, normal_a = (a[1] - a[0]).cross(a[2] - a[0]).normalized();
    for (std::uint32_t j = 0; j < triangles.size(); ++j) {
      const auto b = placed(j, p.b);
      const Vec3 between = (b[0] + b[1] + b[2]) / 3 - middle_a;
      most = std::min(most, between.norm());
      const Vec3 normal_b = (b[1] - b[0]).cross(b[2] - b[0]).normalized();
      double least = 0;
      for (const Vec3& d : {Vec3(between.normalized()), normal_a, Vec3(-normal_a), normal_b, Vec3(-normal_b)})
        least = std::max(least, std::min({d.dot(b[0]), d.dot(b[1]), d.dot(b[2])}) -
                                    std::max({d.dot(a[0]), d.dot(a[1]), d.dot(a[2])}));
      if (least <= most) pairs.push_back({least - 1e-9, i, j});
    }
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& x, const Pair& y) { return x.least < y.least; });
  for (const Pair& pair : pairs) {
    if (pair.least >= most) break;
    most = std::min(most, reference::signed_distance(triangles[pair.i], p.a, triangles[pair.j], p.b).signed_distance);
  }
  return most;
}

std::shared_ptr<const TorusGaps> make_gaps(const Tori& tori) {
  auto gaps = std::make_shared<TorusGaps>(TorusGaps{tori.shape, {}, {}});
  for (std::size_t i = 0; i < tori.poses.size(); ++i)
    if (tori.truths[i].empty()) gaps->poses.push_back(tori.poses[i]);
  gaps->truths.resize(gaps->poses.size());
  const MeshModel& mesh = mesh_of(tori.shape);
  const std::vector<Shape> triangles = triangles_of(mesh);
  tbb::parallel_for(std::size_t{0}, gaps->poses.size(),
                    [&](std::size_t i) { gaps->truths[i] = all_distances(mesh, triangles, gaps->poses[i]); });
  return gaps;
}

struct Answers {
  std::vector<char> collide;
  std::vector<TrianglePairs> pairs;
};

Accuracy judge(const Tori& tori, const Answers& answers, bool lists) {
  Accuracy out;
  std::vector<double> errors;
  for (std::size_t i = 0; i < tori.poses.size(); ++i) {
    const TrianglePairs& truth = tori.truths[i];
    double error = (answers.collide[i] != 0) == !truth.empty() ? 0 : 1;
    out.add_to_hash(static_cast<std::uint64_t>(answers.collide[i]));
    if (lists) {
      TrianglePairs found = answers.pairs[i], differ;
      std::sort(found.begin(), found.end());
      for (const auto& [a, b] : found) out.add_to_hash(std::uint64_t{a} << 32 | b);
      std::set_symmetric_difference(found.begin(), found.end(), truth.begin(), truth.end(), std::back_inserter(differ));
      error = static_cast<double>(differ.size()) / static_cast<double>(std::max<std::size_t>(1, truth.size()));
    }
    if (error > out.error_max) out.error_max = error, out.worst = i;
    out.wrong += error > 0;
    errors.push_back(error);
  }
  out.set_errors(std::move(errors));
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

/// Distances as a contestant measures them.
Player distance_player(const std::string& name, const std::shared_ptr<const TorusGaps>& gaps,
                       const std::function<double(const PosePair&)>& distance) {
  const auto answers = std::make_shared<std::vector<double>>(gaps->poses.size());
  return {name, [n = gaps->poses.size()] { return n; },
          [gaps, answers, distance] {
            for (std::size_t i = 0; i < gaps->poses.size(); ++i) (*answers)[i] = distance(gaps->poses[i]);
          },
          [gaps, answers] {
            Accuracy out;
            std::vector<double> errors;
            for (std::size_t i = 0; i < answers->size(); ++i) {
              const double found = (*answers)[i], error = std::abs(found - gaps->truths[i]) / gaps->shape.size();
              out.add_to_hash(std::bit_cast<std::uint64_t>(found));
              out.failed += !std::isfinite(found);
              out.wrong += !(found > 0);
              if (error > out.error_max) out.error_max = error, out.worst = i;
              errors.push_back(error);
            }
            out.set_errors(std::move(errors));
            return out;
          }};
}

Game distance_game(std::string_view pair_class, const Tori& tori) {
  const std::shared_ptr<const TorusGaps> gaps = make_gaps(tori);
  const auto with_fcl = [&](const std::string& name, const std::shared_ptr<fcl::CollisionGeometryd>& model) {
    return distance_player(name, gaps, [model](const PosePair& p) {
      fcl::DistanceResultd result;
      return fcl::distance(model.get(), fcl_pose(p.a, p.a.translation), model.get(), fcl_pose(p.b, p.a.translation),
                           fcl::DistanceRequestd(true), result);
    });
  };
  return {std::string(torus_kind),
          std::string(pair_class),
          "distance",
          gaps->poses.size(),
          {distance_player("tandem", gaps,
                           [gaps, solver = NarrowPhase()](const PosePair& p) {
                             return solver.solve(gaps->shape, p.a, gaps->shape, p.b, Request::distance).signed_distance;
                           }),
           with_fcl("FCL OBBRSS", fcl_shape(gaps->shape)), with_fcl("FCL RSS", fcl_spheres_shape(gaps->shape))},
          {}};
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
  const bool some_are_apart =
      std::any_of(tori->truths.begin(), tori->truths.end(), [](const TrianglePairs& t) { return t.empty(); });
  if (some_are_apart && (pair_class == "separated" || pair_class == "near"))
    games.push_back(distance_game(pair_class, *tori));
  return games;
}

}  // namespace tandem::bench
