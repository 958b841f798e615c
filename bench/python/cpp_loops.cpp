// The same work in C++, timed there, on the objects that Python made: what overhead.py compares with.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <chrono>

#include "arrays.h"
#include "scene_objects.h"
#include "tandem/engine/scene_queries.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace py = pybind11;
using namespace tandem;

namespace {

template <class Work>
double seconds(Work&& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Mean of `repeats` distances, in seconds, and their sum.
py::tuple distances(const Shape& a, const py::object& pose_a, const Shape& b, const py::object& pose_b, int repeats) {
  const Pose at_a = python::pose(pose_a, "pose_a"), at_b = python::pose(pose_b, "pose_b");
  const NarrowPhase narrow_phase;
  double sum = 0;
  const double time = seconds([&] {
    for (int i = 0; i < repeats; ++i) sum += narrow_phase.solve(a, at_a, b, at_b, Request::distance).signed_distance;
  });
  return py::make_tuple(time / repeats, sum);
}

// A batch whose poses are there as C++ has them, in seconds, and how many configurations collide.
py::tuple batch(const python::SharedScene& scene, const std::vector<Shape>& links, const py::object& poses) {
  const auto queries = scene.read([](const Scene& s) { return std::make_unique<SceneQueries>(s); });
  const std::vector<Pose> placed = python::poses(poses, "poses");
  std::vector<Verdict> verdicts(placed.size() / links.size());
  const PairTable none;
  queries->check(links, placed, none, verdicts);
  const double time = seconds([&] { queries->check(links, placed, none, verdicts); });
  return py::make_tuple(time, std::count(verdicts.begin(), verdicts.end(), Verdict::hit));
}

}  // namespace

PYBIND11_MODULE(cpp_loops, module) {
  module.def("distances", &distances);
  module.def("batch", &batch);
}
