// A host compiled with its own flags: steps built-in scenes and prints the hash of each step's contacts, as the program
// `tandem run` does with --json.
#include <tandem/engine/builtin_scenes.h>
#include <tandem/engine/pipeline.h>
#include <tandem/engine/response.h>

#include <Eigen/Eigenvalues>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace {

using PrincipalAxes = Eigen::SelfAdjointEigenSolver<tandem::Mat3>;

}  // namespace

// A function that tandem uses, too, as this host's flags might have compiled it: deliberately wrong.
template <>
void Eigen::internal::direct_selfadjoint_eigenvalues<PrincipalAxes, 3, false>::run(PrincipalAxes&,
                                                                                const tandem::Mat3&, int) {
  std::puts("tandem called its host's copy of an inline function");
  std::exit(1);
}

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const std::size_t bodies = std::strtoul(argv[1], nullptr, 10), steps = std::strtoul(argv[2], nullptr, 10);
  for (const tandem::BuiltinScene& builtin : tandem::builtin_scenes()) {
    tandem::Scene scene = tandem::make_builtin_scene(builtin.name, bodies);
    tandem::Pipeline pipeline({.answer = {.margin = tandem::recommended_margin(scene), .contact_hash = true}});
    tandem::Response response;
    for (std::size_t step = 0; step < steps; ++step) {
      const tandem::StepReport report = pipeline.step(scene);
      std::printf("%s %016llx\n", builtin.name.data(), static_cast<unsigned long long>(report.contact_hash));
      response.step(scene, pipeline.contacts());
    }
  }
}
