# Builds the fuzz target with clang in WORK and runs it RUNS times, from REPLAY's seeds on: the same inputs each time, as
# long as the code is the same. Says "skipped: " and why where it cannot.
find_program(CLANG NAMES clang++ clang++-14 clang++-15 clang++-16 clang++-17 clang++-18 clang++-19)
if(NOT CLANG)
  message(STATUS "skipped: clang++ is not installed")
  return()
endif()
file(MAKE_DIRECTORY ${WORK})
file(WRITE ${WORK}/probe.cpp "extern \"C\" int LLVMFuzzerTestOneInput(const unsigned char*, unsigned long) { return 0; }\n")
execute_process(COMMAND ${CLANG} -fsanitize=fuzzer ${WORK}/probe.cpp -o ${WORK}/probe
  RESULT_VARIABLE failed OUTPUT_QUIET ERROR_QUIET)
if(failed)
  message(STATUS "skipped: ${CLANG} cannot link -fsanitize=fuzzer (Debian: libclang-rt-dev)")
  return()
endif()

# Kernels for one instruction set: on all of them the answers are the same bits, which another test shows.
execute_process(COMMAND ${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${CLANG}
    -DCMAKE_BUILD_TYPE=None "-DCMAKE_CXX_FLAGS=-O1 -g0 -DHWY_COMPILE_ONLY_STATIC" -DTANDEM_FUZZ=ON -DTANDEM_BUILD_PROGRAMS=OFF
  OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --build ${WORK}/build --target pair_fuzz --parallel 1
  COMMAND_ERROR_IS_FATAL ANY)
file(REMOVE_RECURSE ${WORK}/seeds)
file(MAKE_DIRECTORY ${WORK}/seeds)
execute_process(COMMAND ${REPLAY} --seeds ${WORK}/seeds COMMAND_ERROR_IS_FATAL ANY)
# By name: a folder's own order differs from machine to machine.
file(GLOB seeds ${WORK}/seeds/*)
list(SORT seeds)
list(JOIN seeds "," seeds)
# Without compared values: pointers are among them, and differ from run to run.
execute_process(COMMAND ${WORK}/build/bin/pair_fuzz -seed=1 -runs=${RUNS} -use_cmp=0 -max_total_time=300 -max_len=400
    -timeout=60 -rss_limit_mb=1024 -artifact_prefix=${WORK}/ -seed_inputs=${seeds}
  COMMAND_ERROR_IS_FATAL ANY)
