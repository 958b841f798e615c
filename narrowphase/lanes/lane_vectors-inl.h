// Vectors in space with one number per lane. Included by kernels once per target, within its namespace: no guard.
HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if !HWY_HAVE_SCALABLE

using D = hn::ScalableTag<double>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;

constexpr std::size_t lanes = hn::MaxLanes(D());

HWY_INLINE V number(double x) { return hn::Set(D(), x); }

template <std::size_t rows, std::size_t columns>
HWY_INLINE void load(const double (&from)[rows][columns], std::size_t at, V* out) {
  for (std::size_t k = 0; k < rows; ++k) out[k] = hn::Load(D(), from[k] + at);
}
/// 0 in invalid columns.
template <std::size_t rows, std::size_t columns>
HWY_INLINE void load(const double (&from)[rows][columns], std::size_t at, M valid, V* out) {
  for (std::size_t k = 0; k < rows; ++k) out[k] = hn::MaskedLoad(valid, D(), from[k] + at);
}
template <std::size_t columns>
HWY_INLINE void store(const V* from, std::size_t at, double (&to)[3][columns]) {
  for (std::size_t k = 0; k < 3; ++k) hn::Store(from[k], D(), to[k] + at);
}

// Loads two numbers of every second lane's; of the first lane's alone where there are no more than two.
HWY_INLINE V load_twos(const double* const* from, std::size_t offset) {
#if HWY_MAX_BYTES <= 16
  return hn::LoadU(D(), from[0] + offset);
#else
  const auto two = [&](std::size_t i) HWY_ATTR { return hn::LoadU(hn::FixedTag<double, 2>(), from[i] + offset); };
  const hn::FixedTag<double, 4> four;
#if HWY_MAX_BYTES == 32
  return hn::Combine(four, two(2), two(0));
#else
  return hn::Combine(D(), hn::Combine(four, two(6), two(4)), hn::Combine(four, two(2), two(0)));
#endif
#endif
}

/// Loads consecutive numbers, for each lane from its own address, into one vector per number; `first` gives a lane's
/// address.
template <std::size_t numbers, typename First>
HWY_INLINE void load_transposed(First first, V (&out)[numbers]) {
  static_assert(numbers % 2 == 0);
  const double* from[lanes];
  for (std::size_t i = 0; i < lanes; ++i) from[i] = first(i);
#if HWY_MAX_BYTES == 8
  for (std::size_t k = 0; k < numbers; ++k) out[k] = hn::LoadU(D(), from[0] + k);
#else
  for (std::size_t k = 0; k < numbers; k += 2) {
    const V even = load_twos(from, k), odd = load_twos(from + 1, k);
    out[k] = hn::InterleaveLower(D(), even, odd);
    out[k + 1] = hn::InterleaveUpper(D(), even, odd);
  }
#endif
}

/// Stores four numbers of each pair side by side, pair after pair.
template <std::size_t most>
HWY_INLINE void store_in_turn(V x0, V x1, V x2, V x3, std::size_t at, double (&to)[most][4]) {
  hn::StoreInterleaved4(x0, x1, x2, x3, D(), to[at]);
}
/// The bits of whole numbers.
HWY_INLINE V whole_bits(V x) { return hn::BitCast(D(), hn::ConvertTo(hn::RebindToSigned<D>(), x)); }

// Sums of three products in the order of Eigen's scalar code for vectors and matrices, the last two products first: the
// same bits. Never fused.
HWY_INLINE V sum_of_products(V p0, V q0, V p1, V q1, V p2, V q2) {
  return hn::Add(hn::Mul(p0, q0), hn::Add(hn::Mul(p1, q1), hn::Mul(p2, q2)));
}
HWY_INLINE V dot(const V* u, const V* v) { return sum_of_products(u[0], v[0], u[1], v[1], u[2], v[2]); }
HWY_INLINE void subtract(const V* x, const V* y, V* out) {
  for (int k = 0; k < 3; ++k) out[k] = hn::Sub(x[k], y[k]);
}
HWY_INLINE void cross(const V* x, const V* y, V* out) {
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    out[k] = hn::Sub(hn::Mul(x[i], y[j]), hn::Mul(x[j], y[i]));
  }
}

/// Rotation (its columns) times v.
HWY_INLINE void turn(const V* columns, const V* v, V* out) {
  for (int k = 0; k < 3; ++k) out[k] = sum_of_products(columns[k], v[0], columns[3 + k], v[1], columns[6 + k], v[2]);
}
/// Pose (columns, then the translation) times v.
HWY_INLINE void place(const V* pose, const V* v, V* out) {
  turn(pose, v, out);
  for (int k = 0; k < 3; ++k) out[k] = hn::Add(out[k], pose[9 + k]);
}

/// One of three axes per lane, and selection of the value for it, for the next or for the last axis.
struct Choice {
  M first, second;
  explicit HWY_INLINE Choice(V index) : first(hn::Eq(index, number(0))), second(hn::Eq(index, number(1))) {}
  HWY_INLINE V of(V x0, V x1, V x2) const { return hn::IfThenElse(first, x0, hn::IfThenElse(second, x1, x2)); }
  HWY_INLINE V own(const V* x) const { return of(x[0], x[1], x[2]); }
  HWY_INLINE V next(const V* x) const { return of(x[1], x[2], x[0]); }
  HWY_INLINE V last(const V* x) const { return of(x[2], x[0], x[1]); }
  // The column of the lane's axis of a matrix given by columns.
  HWY_INLINE void own_column(const V* m, V* out) const {
    for (int k = 0; k < 3; ++k) out[k] = of(m[k], m[3 + k], m[6 + k]);
  }
  HWY_INLINE void next_column(const V* m, V* out) const {
    for (int k = 0; k < 3; ++k) out[k] = of(m[3 + k], m[6 + k], m[k]);
  }
  HWY_INLINE void last_column(const V* m, V* out) const {
    for (int k = 0; k < 3; ++k) out[k] = of(m[6 + k], m[k], m[3 + k]);
  }
};

#endif

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
