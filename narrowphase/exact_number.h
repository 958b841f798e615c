#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace tandem {

/// A real number as a sum of doubles that do not overlap, smallest first: an expansion (Shewchuk, Adaptive precision
/// floating-point arithmetic and fast robust geometric predicates, 1997). Sums and products are exact as long as no
/// intermediate product over- or underflows: for polynomials of degree 6 when the doubles they start from lie in
/// [2^-120, 2^120] or are zero.
class Expansion {
 public:
  Expansion() = default;
  explicit Expansion(double x) {
    if (x != 0) terms_.push_back(x);
  }

  static Expansion product(double x, double y) {
    Expansion e;
    const double high = x * y, low = std::fma(x, y, -high);
    if (low != 0) e.terms_.push_back(low);
    if (high != 0) e.terms_.push_back(high);
    return e;
  }

  int sign() const { return terms_.empty() ? 0 : terms_.back() > 0 ? 1 : -1; }

  friend Expansion operator-(Expansion e) {
    for (double& x : e.terms_) x = -x;
    return e;
  }
  friend Expansion operator+(const Expansion& e, const Expansion& f) {
    Expansion h = sum(e, f);
    h.compress();
    return h;
  }
  friend Expansion operator-(const Expansion& e, const Expansion& f) { return e + -f; }
  friend Expansion operator*(const Expansion& e, const Expansion& f) {
    const Expansion& few = e.terms_.size() < f.terms_.size() ? e : f;
    const Expansion& many = e.terms_.size() < f.terms_.size() ? f : e;
    Expansion h;
    for (const double x : few.terms_) h = sum(h, scaled(many, x));
    h.compress();
    return h;
  }

 private:
  static std::pair<double, double> two_sum(double a, double b) {
    const double x = a + b, bv = x - a, av = x - bv;
    return {x, (a - av) + (b - bv)};
  }
  static std::pair<double, double> fast_two_sum(double large, double small) {
    const double x = large + small;
    return {x, small - (x - large)};
  }
  void push(double x) {
    if (x != 0) terms_.push_back(x);
  }

  // FAST-EXPANSION-SUM with zero elimination.
  static Expansion sum(const Expansion& e, const Expansion& f) {
    if (e.terms_.empty()) return f;
    if (f.terms_.empty()) return e;
    Expansion h;
    std::size_t i = 0, j = 0;
    const auto next = [&] {
      const bool from_e =
          j == f.terms_.size() || (i < e.terms_.size() && std::abs(e.terms_[i]) < std::abs(f.terms_[j]));
      return from_e ? e.terms_[i++] : f.terms_[j++];
    };
    double q = next();
    for (std::size_t left = e.terms_.size() + f.terms_.size() - 1; left > 0; --left) {
      const auto [high, low] = two_sum(q, next());
      h.push(low);
      q = high;
    }
    h.push(q);
    return h;
  }

  // SCALE-EXPANSION with zero elimination.
  static Expansion scaled(const Expansion& e, double b) {
    Expansion h;
    double q = 0;
    for (std::size_t i = 0; i < e.terms_.size(); ++i) {
      const double high = e.terms_[i] * b, low = std::fma(e.terms_[i], b, -high);
      const auto [mid, rest] = two_sum(q, low);
      h.push(rest);
      const auto [top, rest2] = fast_two_sum(high, mid);
      h.push(rest2);
      q = top;
    }
    h.push(q);
    return h;
  }

  // COMPRESS: the largest term becomes the number rounded, the rest as few as may be.
  void compress() {
    const std::size_t n = terms_.size();
    if (n < 2) return;
    double q = terms_[n - 1];
    std::size_t bottom = n - 1;
    for (std::size_t i = n - 1; i-- > 0;) {
      const auto [high, low] = fast_two_sum(q, terms_[i]);
      q = high;
      if (low != 0) {
        terms_[bottom--] = q;
        q = low;
      }
    }
    terms_[bottom] = q;
    std::size_t top = 0;
    for (std::size_t i = bottom + 1; i < n; ++i) {
      const auto [high, low] = fast_two_sum(terms_[i], q);
      q = high;
      if (low != 0) terms_[top++] = low;
    }
    terms_[top++] = q;
    terms_.shrink(q == 0 ? top - 1 : top);
  }

  // Nearly always few; an allocation for each number would cost more than the arithmetic.
  class Terms {
   public:
    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    double* begin() { return far_.empty() ? near_.data() : far_.data(); }
    const double* begin() const { return far_.empty() ? near_.data() : far_.data(); }
    double* end() { return begin() + size_; }
    const double* end() const { return begin() + size_; }
    double& operator[](std::size_t i) { return begin()[i]; }
    double operator[](std::size_t i) const { return begin()[i]; }
    double back() const { return begin()[size_ - 1]; }
    void push_back(double x) {
      if (far_.empty() && size_ == near_.size()) far_.assign(near_.begin(), near_.end());
      if (far_.empty())
        near_[size_] = x;
      else
        far_.push_back(x);
      ++size_;
    }
    void shrink(std::size_t size) {
      size_ = size;
      if (far_.empty()) return;
      if (size <= near_.size()) {
        std::copy_n(far_.begin(), size, near_.begin());
        far_.clear();
      } else {
        far_.resize(size);
      }
    }

   private:
    std::size_t size_ = 0;
    std::array<double, 16> near_{};
    std::vector<double> far_;
  };

  Terms terms_;
};

}  // namespace tandem
