// How far a matrix is from a rotation.
#pragma once
#include "tandem/narrowphase/pose.h"

namespace tandem {

/// The largest entry of r^T r - 1: 0 where the columns are orthonormal.
inline double skewness(const Mat3& r) { return (r.transpose() * r - Mat3::Identity()).cwiseAbs().maxCoeff(); }

}  // namespace tandem
