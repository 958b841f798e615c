# Installs a build to a folder, and builds and runs a small consumer against it by find_package, and against the
# source tree by add_subdirectory. Variables: BUILD, SOURCE, WORK, GENERATOR, MODE (package or subdirectory), CXX.
function(step)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE status OUTPUT_VARIABLE out ERROR_VARIABLE out)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "failed: ${ARGV}\n${out}")
  endif()
endfunction()

set(work ${WORK}/${MODE})
file(REMOVE_RECURSE ${work})
if(MODE STREQUAL package)
  step(${CMAKE_COMMAND} --install ${BUILD} --prefix ${work}/prefix)
  set(where -DCMAKE_PREFIX_PATH=${work}/prefix)
else()
  # All of tandem is built anew, in a host that asks for a unity build of all, and by clang where it is there: a host may
  # have it. It takes minutes, so the fuzz targets, which need clang, are built with it. Kernels for one instruction set
  # are enough: on all of them the answers are the same bits, which another test shows. Without FCL and libccd, to see
  # that it can be.
  include(${SOURCE}/tests/clang.cmake)
  set(where -DTANDEM_SOURCE=${SOURCE} -DTANDEM_PEER_SOLVERS=OFF -DTANDEM_PRECOMPILE_HEADERS=ON -DCMAKE_UNITY_BUILD=ON)
  string(APPEND CXX_FLAGS " -DHWY_COMPILE_ONLY_STATIC")
  if(CLANG)
    set(CXX ${CLANG})
  endif()
  if(CLANG_FUZZES)
    list(APPEND where -DTANDEM_FUZZ=ON)
    string(APPEND CXX_FLAGS " -O1")
  endif()
endif()
step(${CMAKE_COMMAND} -S ${SOURCE}/tests/install/consumer -B ${work}/build -G ${GENERATOR} ${where}
     -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_CXX_FLAGS=${CXX_FLAGS})
step(${CMAKE_COMMAND} --build ${work}/build)
step(${work}/build/consumer)
step(${work}/build/distance)
if(MODE STREQUAL subdirectory)
  execute_process(COMMAND ldd ${work}/build/distance OUTPUT_VARIABLE libraries)
  if(libraries MATCHES "libfcl|libccd")
    message(FATAL_ERROR "without its peer solvers tandem still links:\n${libraries}")
  endif()
endif()
if(EXISTS ${work}/build/from_fcl)  # where the adapter is built
  step(${work}/build/from_fcl)
endif()
