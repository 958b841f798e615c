// Newton's method on h: within cells of the sphere of directions, along the circles that divide these, and at discs.
#pragma once
#include "round/body_pair.h"

namespace tandem {

/// The smooth pieces of a body whose points support a direction equally.
struct ActivePieces {
  static constexpr int capacity = 4;  ///< those of a face of a box

  int piece[capacity];
  int count = 1;

  void add(const RoundBody& body, int from, int other) {
    if (body.kind() == ShapeKind::box && count == 2) {
      // The whole face: no piece is a diagonal of a box's face.
      const int bit = from ^ other, first = piece[0], second = piece[1];
      piece[2] = first ^ bit, piece[3] = second ^ bit;
      count = 4;
      return;
    }
    if (count == capacity) return;
    piece[count++] = other;
  }
};

/// A descent as in `minimize`, which may miss a piece and end too high: h is the value of its pieces.
class NewtonDescent {
 public:
  NewtonDescent(const RoundPair& pair, const Vec3& start, double below) : pair_(pair), below_(below) {
    this->start(start);
    started_ = at_.h;
  }

  Support run();
  double started() const { return started_; }  ///< h at the start

 private:
  struct Trial {
    Vec3 n;
    double h;
    int body = -1;  ///< the body whose piece `other` replaces `from` at n; -1: none
    int from = 0, other = 0;
  };

  void start(const Vec3& n) {
    at_.n = n;
    for (int b = 0; b < 2; ++b) {
      active_[b].piece[0] = pair_.body[b].support_piece(n);
      active_[b].count = 1;
      at_.point[b] = pair_.body[b].point(active_[b].piece[0], n);
    }
    at_.h = n.dot(at_.point[0] + at_.point[1]);
  }
  void weigh();
  bool at_disc();
  bool step_freely();
  bool step_along(const Circle& circle);
  bool go(const Arc& arc, double t, double slope);
  Trial follow(const Arc& arc, double t) const;
  double small() const { return 16 * epsilon * pair_.scale; }

  const RoundPair& pair_;
  double below_;
  double started_;
  Support at_;
  ActivePieces active_[2];
  Vec3 u_, v_;               // tangents at n
  double zx_ = 0, zy_ = 0;   // the least subgradient of h in these
  bool checked_[2][2] = {};  // discs known not to be a minimum
  int stuck_ = 0;            // steps that were stopped at once: then the subgradient is
                             // followed, then the circle that stops them
  int kicks_ = 0;
  double last_ = infinity;  // |z| of the step before, where
                            // h is within rounding
};

}  // namespace tandem
