// Checkpoints on ranks.
#include "tandem/mpi/checkpoint.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "tandem/mpi/response.h"
#include "world.h"

using namespace tandem;

namespace {

constexpr double margin = 0.05;

/// The path of a file shared by all ranks, removed at the end.
class SharedPath {
 public:
  SharedPath() {
    int process = ::getpid();
    MPI_Bcast(&process, 1, MPI_INT, 0, MPI_COMM_WORLD);
    path = (std::filesystem::temp_directory_path() / ("tandem-mpi-test-" + std::to_string(process))).string();
  }
  ~SharedPath() {
    MPI_Barrier(MPI_COMM_WORLD);
    if (world::rank() == 0) std::filesystem::remove(path);
  }
  SharedPath(const SharedPath&) = delete;
  SharedPath& operator=(const SharedPath&) = delete;
  std::string path;
};

/// A scene moved by the response of its ranks.
struct Run {
  Run(MPI_Comm communicator, const Scene& scene, bool bodies)
      : pipeline(communicator, world::options(1, margin)), response(pipeline, {.threads = 1}) {
    for (const Shape& shape : scene.shapes()) pipeline.add_shape(shape);
    for (std::uint32_t i = 0; bodies && i < scene.indices(); ++i)
      if (static_cast<int>(i) % pipeline.ranks() == pipeline.rank()) pipeline.add_body(i, world::options_of(scene, i));
  }
  std::vector<std::uint64_t> go(int steps) {
    std::vector<std::uint64_t> hashes;
    for (int step = 0; step < steps; ++step) {
      const mpi::Report report = pipeline.step();
      hashes.push_back(report.contact_hash);
      hashes.push_back(report.step);
      response.step();
    }
    return hashes;
  }
  mpi::Pipeline pipeline;
  mpi::Response response;
};

std::string refusal(const std::string& path, const Scene& scene) {
  Run run(MPI_COMM_WORLD, scene, false);
  try {
    mpi::Checkpoint::read(run.pipeline, path);
  } catch (const std::invalid_argument& error) {
    CHECK(run.pipeline.step().bodies == 0);
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("a run goes on from a checkpoint on another number of ranks, the same bits") {
  const Scene scene = make_builtin_scene("cubes-on-plane", 25);
  const SharedPath file;
  // Written by all, read by one; then the reverse.
  for (const bool all_write : {true, false}) {
    CAPTURE(all_write);
    std::vector<std::uint64_t> expected, found;
    const auto write = [&](MPI_Comm communicator) {
      Run run(communicator, scene, true);
      run.go(25);
      mpi::Checkpoint::write(run.pipeline, file.path);
      run.response.begin_anew();
      expected = run.go(6);
    };
    const auto read = [&](MPI_Comm communicator) {
      Run run(communicator, scene, false);
      CHECK(mpi::Checkpoint::read(run.pipeline, file.path) == 25);
      found = run.go(6);
    };
    if (all_write)
      write(MPI_COMM_WORLD);
    else if (world::rank() == 0)
      write(MPI_COMM_SELF);
    MPI_Barrier(MPI_COMM_WORLD);
    if (!all_write)
      read(MPI_COMM_WORLD);
    else if (world::rank() == 0)
      read(MPI_COMM_SELF);
    if (world::rank() == 0) CHECK(found == expected);
    MPI_Barrier(MPI_COMM_WORLD);
  }
}

TEST_CASE("a checkpoint that is cut off, altered or of another scene is refused by all ranks") {
  const Scene scene = make_builtin_scene("spheres-on-plane", 20), other = make_builtin_scene("cubes-on-plane", 20);
  const SharedPath file;
  {
    Run run(MPI_COMM_WORLD, scene, true);
    run.go(2);
    mpi::Checkpoint::write(run.pipeline, file.path);
  }
  CHECK(refusal(file.path, scene).empty());
  CHECK(refusal(file.path, other).find("is of a scene with other shapes") != std::string::npos);
  std::string whole;
  if (world::rank() == 0) {
    std::ifstream in(file.path, std::ios::binary);
    whole.assign(std::istreambuf_iterator<char>(in), {});
  }
  const auto altered = [&](const auto& change) {
    MPI_Barrier(MPI_COMM_WORLD);
    if (world::rank() == 0) {
      std::string bytes = whole;
      change(bytes);
      std::ofstream(file.path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    }
    MPI_Barrier(MPI_COMM_WORLD);
    return refusal(file.path, scene);
  };
  const auto has = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  CHECK(has(altered([](std::string& bytes) { bytes.pop_back(); }), "is cut off: it has"));
  CHECK(has(altered([](std::string& bytes) { bytes.resize(40); }), "is cut off, or no checkpoint: it has 40 bytes"));
  CHECK(has(altered([](std::string& bytes) { bytes += 'x'; }), "is altered: it has"));
  CHECK(has(altered([](std::string& bytes) { bytes[0] = 'x'; }), "is no checkpoint"));
  CHECK(has(altered([](std::string& bytes) { bytes[30] ^= 1; }), "its header's checksum is another"));
  CHECK(has(altered([](std::string& bytes) { bytes[bytes.size() / 2] ^= 1; }), "its bodies' checksum is another"));
  CHECK(has(altered([](std::string& bytes) { bytes[bytes.size() - 30] ^= 64; }), "its bodies' checksum is another"));
}
