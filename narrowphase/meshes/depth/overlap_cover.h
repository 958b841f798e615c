// A proof that two meshes overlap after every translation shorter than some length: boxes of translations, each inside
// a ball of translations after which a ball in A and a ball in B still overlap.
#pragma once
#include <cstddef>
#include <functional>
#include <queue>
#include <vector>

#include "meshes/depth/inner_balls.h"
#include "meshes/depth/shared_places.h"
#include "tolerances.h"

namespace tandem {

/// B moves; A's translation is zero.
class OverlapCover {
 public:
  /// The two overlapping bodies, as functions.
  struct Bodies {
    /// Some points that B, translated, shares with A; none: they are separated.
    std::function<std::vector<SharedPlace>(const Vec3& move)> shared_places;
    /// Given a translation that separates: the length of the shortest known one.
    std::function<double(const Vec3& move)> shorten;
  };

  OverlapCover(const DepthField& a, const DepthField& b, double length, Bodies bodies);

  /// Examines boxes of translations until none shorter than the fraction `part` of the shortest known separating
  /// translation is open, or `most` were examined.
  void search(double part, std::size_t most);

  double certain() const { return certain_; }  ///< no shorter translation separates
  std::size_t boxes() const { return examined_; }

 private:
  /// The translations after which a ball about `of_a` in A and one about `of_b` in B overlap: a ball about `middle`.
  struct Proof {
    Vec3 of_a = Vec3::Zero(), of_b = Vec3::Zero();  ///< without translation
    double in_a = 0, in_b = 0;
    Vec3 inward_a = Vec3::Zero(), inward_b = Vec3::Zero();  ///< at these points, as in DepthAt

    Vec3 inward() const { return inward_a + inward_b; }
    Vec3 middle() const { return of_a - of_b; }
    double radius() const { return in_a + in_b; }
    double at(const Vec3& move) const { return radius() - (move - middle()).norm(); }
  };
  /// A cube of translations.
  struct Cell {
    double nearest;  ///< length of its shortest translation
    std::size_t number;
    Vec3 middle;
    double half;
    std::size_t proof;  ///< its parent's, a good start
    bool operator<(const Cell& o) const { return nearest != o.nearest ? nearest > o.nearest : number > o.number; }
  };

  double raise_certain();
  bool pop(Cell& cell);
  void push(const Vec3& middle, double half, std::size_t proof);
  bool covers(const Proof& proof, const Cell& cell) const;
  Proof best_known(const Vec3& move, std::size_t first) const;
  /// With both balls about one point.
  Proof prove_near(const Vec3& p, const Vec3& move) const;
  /// The best proof near a point that ascent finds; ends when `enough` returns true.
  Proof climb(const SharedPlace& from, const Vec3& move, double step,
              const std::function<bool(const Proof&)>& enough) const;
  Proof search_proof(Proof best, const Vec3& move, const Cell& cell);
  Proof prove_anywhere(const Vec3& move, const Cell& cell, const Proof& known) const;
  void leave(const Vec3& move, Proof proof);
  void grow(Proof& proof, const Cell& cell) const;

  const DepthField &a_, &b_;
  const Bodies bodies_;
  double length_;      ///< of the shortest known translation that separates
  double least_half_;  ///< of the cubes that are examined before smaller ones
  double wanted_ = 0;  ///< longer translations need no proof
  double certain_ = 0;
  std::vector<Ball> balls_a_, balls_b_;
  std::vector<Proof> proofs_;
  std::priority_queue<Cell> large_, small_;  ///< open ones, by `least_half_`
  std::size_t examined_ = 0, numbered_ = 0, searched_on_at_ = 0;
};

}  // namespace tandem
