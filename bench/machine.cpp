// Describes the machine: processor, memory, compiler and library versions.
#include <fmt/format.h>
#include <oneapi/tbb/version.h>
#include <unistd.h>

#include <CLI/Version.hpp>
#include <Eigen/Core>
#include <fstream>
#include <thread>

#ifdef TANDEM_HAS_BULLET
#include <LinearMath/btScalar.h>
#endif

#include "results.h"

namespace tandem::bench {
namespace {

std::string cpu() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown";
}

}  // namespace

nlohmann::json machine() {
  const auto pages = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
#if defined(__clang__)
  const std::string compiler = "clang " __clang_version__;
#else
  const std::string compiler = "g++ " __VERSION__;
#endif
  return {{"cpu", cpu()},
          {"cores", std::thread::hardware_concurrency()},
          {"memory", fmt::format("{:.0f} GiB", pages / (1 << 30))},
          {"compiler", compiler},
          {"flags", TANDEM_BUILD_TYPE " " TANDEM_CXX_FLAGS},
          {"versions",
           {{"tandem", TANDEM_VERSION},
            {"oneTBB", TBB_runtime_version()},
            {"Eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
            {"FCL", TANDEM_FCL_VERSION},
#ifdef TANDEM_HAS_BULLET
            {"Bullet", fmt::format("{}.{}, {}", BT_BULLET_VERSION / 100, BT_BULLET_VERSION % 100,
                                   sizeof(btScalar) == sizeof(double) ? "double" : "float")},
#endif
            {"libccd", TANDEM_CCD_VERSION}}}};
}

}  // namespace tandem::bench
