// A program that uses the installed narrow phase.
#include <tandem/narrowphase/narrow_phase.h>

#include <cstdio>

// Distances need only the narrow phase.
int main() {
  const tandem::NarrowPhase narrow_phase;
  const auto answer = narrow_phase.solve(tandem::Sphere{1}, tandem::Pose::at(0, 0, 0), tandem::Box{{2, 2, 2}},
                                         tandem::Pose::at(5, 0, 0), tandem::Request::distance);
  std::printf("distance %g\n", answer.signed_distance);
  return answer.signed_distance == 3 ? 0 : 1;
}
