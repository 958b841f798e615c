// The command `tandem scenes`.
#include <memory>
#include <sstream>

#include "commands.h"
#include "formats/scene_json.h"
#include "option_text.h"
#include "tandem/engine/builtin_scenes.h"

namespace tandem {
namespace {

struct Options {
  std::string scene, write, bodies = "0", seed = "1";
};

int list(DescriptorBuffer& out) {
  std::ostringstream text;
  for (const BuiltinScene& scene : builtin_scenes()) {
    text << std::left;
    text.width(20);
    text << scene.name << std::right;
    text.width(8);
    text << scene.bodies << " bodies  " << scene.description << '\n';
  }
  out.append(text.str());
  return 0;
}

int write(const Options& options) {
  const std::uint64_t bodies = whole_option("--bodies", options.bodies, 0, 1'000'000);
  const std::uint64_t seed = whole_option("--seed", options.seed, 0, UINT64_MAX);
  const Scene scene = make_builtin_scene(options.scene, bodies, seed);
  OutputFile file("--write", options.write);
  JsonWriter text;
  write_scene(text, scene);
  file.append(text.text());
  file.append("\n");
  file.commit();
  return 0;
}

}  // namespace

void add_scenes_command(CLI::App& program, DescriptorBuffer& out, int& status) {
  CLI::App* command = program.add_subcommand("scenes", "list the built-in scenes, or write one as a scene file");
  const auto options = std::make_shared<Options>();
  command->add_option("SCENE", options->scene, "a built-in scene, with --write")->type_name("");
  command->add_option("--write", options->write, "write SCENE as a scene file to this FILE")->type_name("FILE");
  command->add_option("--bodies", options->bodies, "number of bodies of SCENE; 0: the paper's")
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--seed", options->seed, "seed of SCENE's random numbers")->type_name("N")->capture_default_str();
  command->callback([options, &out, &status] {
    if (options->scene.empty() != options->write.empty())
      refuse_option(options->scene.empty() ? "SCENE" : "--write", "", "both SCENE and --write FILE, or neither");
    status = options->scene.empty() ? list(out) : write(*options);
  });
}

}  // namespace tandem
