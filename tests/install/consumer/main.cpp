// A program that uses the installed engine.
#include <tandem/engine/pipeline.h>
#include <tandem/version.h>

#include <cstdio>

static_assert(TANDEM_VERSION_MAJOR == 0 && TANDEM_VERSION_MINOR >= 1);

int main() {
  tandem::Scene scene;
  const auto box = scene.add_shape(tandem::Box{{1, 1, 1}});
  const auto ground = scene.add_shape(tandem::HalfSpace{{0, 0, 1}, 0});
  scene.add_body({.shape = ground, .is_static = true});
  for (int i = 0; i < 10; ++i) scene.add_body({.shape = box, .pose = tandem::Pose::at(0, 0, 0.49 + 0.99 * i)});
  tandem::Pipeline pipeline;
  const tandem::StepReport report = pipeline.step(scene);
  for (const auto& pair : pipeline.contacts().pairs)
    std::printf("%u touches %u at %u points\n", pair.a, pair.b, pair.contact_count);
  return report.colliding_pairs == 10 ? 0 : 1;
}
